//! The public API of the published crates, as `docs/api/CRATE.txt`: every `pub` item
//! in Rust, without bodies and documentation. Run with `RELIEVO_UPDATE_GOLDEN=1` to
//! accept the API as it is now.
//!
//! Items in private modules are listed too, since they may be re-exported.

use relievo_tests::root;
use std::fs;
use std::path::Path;
use syn::{Attribute, Fields, ImplItem, Item, TraitItem, Visibility};

/// The published crates and their `lib.rs`.
const CRATES: [(&str, &str); 10] = [
    ("relievo", "host/src/lib.rs"),
    ("relievo-bitwise", "host/bitwise/src/lib.rs"),
    ("relievo-exact", "shared/exact/src/lib.rs"),
    ("relievo-kernel", "shared/kernel/src/lib.rs"),
    ("relievo-kernel-macros", "shared/kernel/macros/src/lib.rs"),
    ("relievo-shaders", "assets/shaders/lib.rs"),
    ("relievo-shared", "shared/src/lib.rs"),
    ("relievo-test", "host/test/src/lib.rs"),
    ("relievo-translate", "host/translate/src/lib.rs"),
    ("relievo-viewer", "host/viewer/src/lib.rs"),
    // relievo-shared-f64 has the sources of relievo-shared.
];

/// Attributes that belong to the API.
const ATTRIBUTES: [&str; 7] = [
    "cfg",
    "deprecated",
    "derive",
    "macro_export",
    "must_use",
    "non_exhaustive",
    "repr",
];

fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

fn is_test(attributes: &[Attribute]) -> bool {
    let is_test = |attribute: &Attribute| match &attribute.meta {
        syn::Meta::List(list) => {
            list.path.is_ident("cfg") && list.tokens.to_string().starts_with("test")
        }
        _ => false,
    };
    attributes.iter().any(is_test)
}

fn keep_attributes(attributes: &mut Vec<Attribute>) {
    attributes.retain(|attribute| {
        ATTRIBUTES
            .iter()
            .any(|name| attribute.path().is_ident(name))
    });
}

/// Keeps public fields. Private ones become `_`.
fn keep_fields(fields: &mut Fields) {
    for field in fields.iter_mut() {
        keep_attributes(&mut field.attrs);
        if !is_public(&field.vis) {
            field.ty = syn::parse_quote!(_);
        }
    }
    if let Fields::Named(fields) = fields {
        let all = std::mem::take(&mut fields.named);
        let (public, private): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|field| is_public(&field.vis));
        fields.named.extend(public);
        if !private.is_empty() {
            let field: syn::FieldsNamed = syn::parse_quote!({ _private: _ });
            fields.named.extend(field.named);
        }
    }
}

/// Reduces an item to its API; `None` if it has none. `folder` is where the files of
/// the modules in it are.
fn reduce(mut item: Item, folder: &Path) -> Option<Item> {
    let empty: syn::Block = syn::parse_quote!({});
    let attributes = match &mut item {
        Item::Const(item) => {
            *item.expr = syn::parse_quote!(_);
            is_public(&item.vis).then_some(&mut item.attrs)
        }
        Item::Enum(item) => {
            for variant in &mut item.variants {
                keep_attributes(&mut variant.attrs);
                variant
                    .fields
                    .iter_mut()
                    .for_each(|field| field.attrs.clear());
            }
            is_public(&item.vis).then_some(&mut item.attrs)
        }
        Item::Fn(item) => {
            *item.block = empty;
            is_public(&item.vis).then_some(&mut item.attrs)
        }
        Item::Impl(item) => {
            let is_trait = item.trait_.is_some();
            item.items.retain_mut(|item| match item {
                ImplItem::Const(item) => {
                    item.expr = syn::parse_quote!(_);
                    keep_attributes(&mut item.attrs);
                    is_public(&item.vis)
                }
                ImplItem::Fn(item) => {
                    item.block = empty.clone();
                    keep_attributes(&mut item.attrs);
                    is_public(&item.vis)
                }
                ImplItem::Type(_) => is_trait,
                _ => false,
            });
            (is_trait || !item.items.is_empty()).then_some(&mut item.attrs)
        }
        Item::Macro(item) => {
            let exported = item.attrs.iter().any(|a| a.path().is_ident("macro_export"));
            // Other macros may make public items.
            let makes = item.ident.is_none() && item.mac.tokens.to_string().contains("pub ");
            if exported {
                item.mac.tokens = syn::parse_quote!(() => {});
            }
            (exported || makes).then_some(&mut item.attrs)
        }
        Item::Mod(item) => {
            if is_test(&item.attrs) {
                return None;
            }
            let name = item.ident.to_string();
            let items = match item.content.take() {
                Some((_, items)) => reduce_all(items, &folder.join(&name)),
                None => {
                    let file = folder.join(format!("{name}.rs"));
                    let file = if file.exists() {
                        file
                    } else {
                        folder.join(&name).join("mod.rs")
                    };
                    module(&file, &folder.join(&name))
                }
            };
            let is_empty = items.is_empty();
            item.content = Some((Default::default(), items));
            item.semi = None;
            (!is_empty).then_some(&mut item.attrs)
        }
        Item::Static(item) => {
            *item.expr = syn::parse_quote!(_);
            is_public(&item.vis).then_some(&mut item.attrs)
        }
        Item::Struct(item) => {
            keep_fields(&mut item.fields);
            is_public(&item.vis).then_some(&mut item.attrs)
        }
        Item::Trait(item) => {
            for item in &mut item.items {
                match item {
                    TraitItem::Const(item) => keep_attributes(&mut item.attrs),
                    TraitItem::Fn(item) => {
                        keep_attributes(&mut item.attrs);
                        if let Some(block) = &mut item.default {
                            *block = empty.clone();
                        }
                    }
                    TraitItem::Type(item) => keep_attributes(&mut item.attrs),
                    _ => {}
                }
            }
            is_public(&item.vis).then_some(&mut item.attrs)
        }
        Item::Type(item) => is_public(&item.vis).then_some(&mut item.attrs),
        Item::Use(item) => is_public(&item.vis).then_some(&mut item.attrs),
        _ => None,
    };
    keep_attributes(attributes?);
    Some(item)
}

fn reduce_all(items: Vec<Item>, folder: &Path) -> Vec<Item> {
    let items = items.into_iter();
    items.filter_map(|item| reduce(item, folder)).collect()
}

/// Returns the API of the module in `file`, whose submodules are in `folder`.
fn module(file: &Path, folder: &Path) -> Vec<Item> {
    let text =
        fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    reduce_all(syn::parse_file(&text).unwrap().items, folder)
}

#[test]
fn the_public_api_is_listed() {
    let mut changed = Vec::new();
    for (name, file) in CRATES {
        let file = root().join(file);
        let items = module(&file, file.parent().unwrap());
        let now = prettyplease::unparse(&syn::File {
            shebang: None,
            attrs: Vec::new(),
            items,
        });
        let list = format!("docs/api/{name}.txt");
        let path = root().join(&list);
        if std::env::var_os("RELIEVO_UPDATE_GOLDEN").is_some() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, &now).unwrap();
        }
        // Checkouts on Windows may have other line ends.
        let listed = fs::read_to_string(&path)
            .unwrap_or_default()
            .replace("\r\n", "\n");
        let line = now.lines().zip(listed.lines()).position(|(a, b)| a != b);
        if now != listed {
            changed.push(format!("{list}: from line {} on", line.unwrap_or(0) + 1));
        }
    }
    assert!(
        changed.is_empty(),
        "the public API is not what is listed; if that is meant, accept it with \
         RELIEVO_UPDATE_GOLDEN=1 and say it in the changelog:\n{}",
        changed.join("\n")
    );
}
