//! Copies the files of `shared/src` into one file, twice: with the target's own division
//! and square root (`native`), and with those of the exact shaders (`corrected`). Every
//! float operation becomes a call of `crate::operations`.

mod rewriter;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use rewriter::Rewriter;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit_mut::VisitMut;

/// Lists for shaders, which are macros or need other crates.
const SKIPPED: [&str; 3] = ["kernels", "shaders", "techniques"];

fn main() -> Result<(), Box<dyn Error>> {
    let sources = Path::new(&std::env::var("CARGO_MANIFEST_DIR")?).join("../src");
    println!("cargo::rerun-if-changed={}", sources.display());
    println!("cargo::rerun-if-changed=build");
    let native = tree(&sources, "native", false)?;
    let corrected = tree(&sources, "corrected", true)?;
    let output = PathBuf::from(std::env::var("OUT_DIR")?).join("trees.rs");
    fs::write(output, native + &corrected)?;
    Ok(())
}

/// Returns all modules of `sources` as the module `name`.
fn tree(sources: &Path, name: &str, corrected: bool) -> Result<String, Box<dyn Error>> {
    let items = items(sources, "lib.rs", "", name, corrected)?;
    let doc = format!("The modules of relievo-shared, rewritten: the tree `{name}`.");
    let name = format_ident!("{name}");
    Ok(quote! {
        #[doc = #doc]
        #[allow(missing_docs, unused_parens, clippy::all)]
        pub mod #name { #items }
    }
    .to_string())
}

/// Returns the items of `file`, with its modules, which lie in `folder`, inline.
/// Both are relative to `sources`.
fn items(
    sources: &Path,
    file: &str,
    folder: &str,
    tree: &str,
    corrected: bool,
) -> Result<TokenStream, Box<dyn Error>> {
    let mut items = TokenStream::new();
    for item in rewritten(sources, file, tree, corrected)?.items {
        match item {
            syn::Item::Mod(module) if module.content.is_none() => {
                if SKIPPED.iter().any(|name| module.ident == name) {
                    continue;
                }
                let below = format!("{folder}{}", module.ident);
                let mut file = format!("{below}.rs");
                if !sources.join(&file).exists() {
                    file = format!("{below}/mod.rs");
                }
                let content = self::items(sources, &file, &format!("{below}/"), tree, corrected)?;
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

/// Returns one file of `sources`, rewritten.
fn rewritten(
    sources: &Path,
    file: &str,
    tree: &str,
    corrected: bool,
) -> Result<syn::File, Box<dyn Error>> {
    let path = sources.join(file);
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut parsed =
        syn::parse_file(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut rewriter = Rewriter::new(file, tree, corrected);
    rewriter.visit_file_mut(&mut parsed);
    match rewriter.error {
        Some(error) => Err(error.into()),
        None => Ok(parsed),
    }
}
