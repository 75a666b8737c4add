//! Copies the files of `shared/src`, with those of `shared/exact/src` as their module
//! `exact`, into one file, three times: with the target's own division and square root
//! (`native`), with those of the exact shaders (`corrected`), and with those of the exact
//! shaders for devices that fuse sums (`fused`). Every float operation becomes a call of
//! `crate::operations`.

mod rewriter;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use rewriter::{Package, Rewriter};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit_mut::VisitMut;

/// Lists for shaders, which are macros or need other crates.
const SKIPPED: [&str; 3] = ["kernels", "shaders", "techniques"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build");
    let native = tree("native", &[])?;
    let corrected = tree("corrected", &["corrected"])?;
    let fused = tree("fused", &["corrected", "fused"])?;
    let output = PathBuf::from(std::env::var("OUT_DIR")?).join("trees.rs");
    fs::write(output, native + &corrected + &fused)?;
    Ok(())
}

/// Returns all modules of both packages, with these features, as the module `name`.
fn tree(name: &str, features: &[&str]) -> Result<String, Box<dyn Error>> {
    let folder = Path::new(&std::env::var("CARGO_MANIFEST_DIR")?).join("..");
    let modules = |package, sources: &str| {
        let sources = folder.join(sources);
        println!("cargo::rerun-if-changed={}", sources.display());
        let tree = Tree {
            sources,
            rewriter: Rewriter::new(package, name, features),
        };
        tree.items("lib.rs", "")
    };
    let shared = modules(Package::Shared, "src")?;
    let exact = modules(Package::Exact, "exact/src")?;
    let doc = format!("The modules of relievo-shared, rewritten: the tree `{name}`.");
    let name = format_ident!("{name}");
    Ok(quote! {
        #[doc = #doc]
        #[allow(missing_docs, unused_imports, unused_parens, clippy::all)]
        pub mod #name {
            #shared
            /// The modules of relievo-exact.
            pub mod exact { #exact }
        }
    }
    .to_string())
}

/// The sources of a package, and how they are rewritten.
struct Tree<'a> {
    sources: PathBuf,
    rewriter: Rewriter<'a>,
}

impl Tree<'_> {
    /// Returns the items of `file`, with its modules, which lie in `folder`, inline. Both
    /// are relative to the sources.
    fn items(&self, file: &str, folder: &str) -> Result<TokenStream, Box<dyn Error>> {
        let mut items = TokenStream::new();
        for item in self.rewritten(file)?.items {
            match item {
                syn::Item::Mod(module) if module.content.is_none() => {
                    if SKIPPED.iter().any(|name| module.ident == name) {
                        continue;
                    }
                    let below = format!("{folder}{}", module.ident);
                    let mut file = format!("{below}.rs");
                    if !self.sources.join(&file).exists() {
                        file = format!("{below}/mod.rs");
                    }
                    let content = self.items(&file, &format!("{below}/"))?;
                    let syn::ItemMod {
                        attrs, vis, ident, ..
                    } = module;
                    items.extend(quote! { #(#attrs)* #vis mod #ident { #content } });
                }
                item => items.extend(quote! { #item }),
            }
        }
        Ok(items)
    }

    /// Returns one file, rewritten.
    fn rewritten(&self, file: &str) -> Result<syn::File, Box<dyn Error>> {
        let path = self.sources.join(file);
        let text =
            fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut parsed =
            syn::parse_file(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut rewriter = self.rewriter.of_file(file);
        rewriter.visit_file_mut(&mut parsed);
        match rewriter.error {
            Some(error) => Err(error.into()),
            None => Ok(parsed),
        }
    }
}
