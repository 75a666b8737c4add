//! Writes the files of `shared/src` into one file, twice: with the target's
//! own division and root (`native`), and with those of the exact shaders
//! (`corrected`); every float operation is a call of `crate::operations`.

mod rewriter;

use quote::{format_ident, quote};
use rewriter::Rewriter;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit_mut::VisitMut;

/// A list of functions for shaders, which needs crates that this one has no use for.
const SKIPPED: &str = "kernels";

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

/// All modules of `sources` as the module `name`.
fn tree(sources: &Path, name: &str, corrected: bool) -> Result<String, Box<dyn Error>> {
    let mut items = Vec::new();
    for item in rewritten(sources, "lib.rs", name, corrected)?.items {
        match item {
            syn::Item::Mod(module) if module.content.is_none() => {
                if module.ident == SKIPPED {
                    continue;
                }
                let file = format!("{}.rs", module.ident);
                let content = rewritten(sources, &file, name, corrected)?.items;
                let syn::ItemMod {
                    attrs, vis, ident, ..
                } = module;
                items.push(quote! { #(#attrs)* #vis mod #ident { #(#content)* } });
            }
            item => items.push(quote! { #item }),
        }
    }
    let doc = format!("The modules of relievo-shared, rewritten: the tree `{name}`.");
    let name = format_ident!("{name}");
    Ok(quote! {
        #[doc = #doc]
        #[allow(missing_docs, unused_parens, clippy::all)]
        pub mod #name { #(#items)* }
    }
    .to_string())
}

/// One file of `sources`, rewritten.
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
