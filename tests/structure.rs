//! The structure of the sources: no circle of files within a crate, and no file
//! of more than 600 lines of code.
//!
//! A file uses another if it names an item that is defined there, through
//! re-exports, too. A module may use its own submodules while these use it: such
//! uses do not count, and neither do tests.

use relievo_tests::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use syn::visit::{self, Visit};
use syn::{Attribute, Item, UseTree};

/// The crates: name and folder of `lib.rs` or `main.rs`.
const CRATES: [(&str, &str); 17] = [
    ("relievo", "host/src"),
    ("relievo_bitwise", "host/bitwise/src"),
    ("relievo_compiled", "host/compiled/src"),
    ("relievo_page", "host/page/src"),
    ("relievo_program", "host/program/src"),
    ("relievo_studies", "host/studies/src"),
    ("relievo_viewer", "host/viewer/src"),
    ("relievo_shared", "shared/src"),
    ("relievo_exact", "shared/exact/src"),
    ("relievo_kernel", "shared/kernel/src"),
    ("relievo_kernel_macros", "shared/kernel/macros/src"),
    ("relievo_translate", "host/translate/src"),
    ("relievo_test", "host/test/src"),
    ("relievo_shader_manifest", "shader-crate/manifest/src"),
    ("relievo_shader_builder", "shader-crate/builder/src"),
    ("cargo_relievo", "shader-crate/command/src"),
    ("generator", "assets/generator/src"),
];

const MOST_LINES: usize = 600;

/// Segments of a path of names.
type Names = Vec<String>;

/// A file of a crate.
#[derive(Default)]
struct File {
    /// Names of its items.
    items: BTreeSet<String>,
    /// Imported paths, the name of each in this file, and whether it is
    /// re-exported.
    imports: Vec<(Names, String, bool)>,
    /// Paths in its code.
    paths: BTreeSet<Names>,
    lines: usize,
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => {
            list.path.is_ident("cfg") && list.tokens.to_string().starts_with("test")
        }
        _ => false,
    })
}

impl File {
    fn import(&mut self, tree: &UseTree, before: &[String], is_public: bool) {
        let with = |name: String| [before, &[name]].concat();
        match tree {
            UseTree::Path(path) => {
                self.import(&path.tree, &with(path.ident.to_string()), is_public);
            }
            UseTree::Name(name) if name.ident == "self" => {
                if let Some(last) = before.last() {
                    let import = (before.to_vec(), last.clone(), is_public);
                    self.imports.push(import);
                }
            }
            UseTree::Name(name) => {
                let name = name.ident.to_string();
                self.imports.push((with(name.clone()), name, is_public));
            }
            UseTree::Rename(rename) => {
                let import = with(rename.ident.to_string());
                self.imports
                    .push((import, rename.rename.to_string(), is_public));
            }
            UseTree::Glob(_) => {
                self.imports
                    .push((with("*".to_string()), "*".to_string(), is_public));
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.import(tree, before, is_public);
                }
            }
        }
    }
}

impl<'ast> Visit<'ast> for File {
    fn visit_item(&mut self, item: &'ast Item) {
        let (attributes, name) = match item {
            Item::Const(item) => (&item.attrs, Some(&item.ident)),
            Item::Enum(item) => (&item.attrs, Some(&item.ident)),
            Item::Fn(item) => (&item.attrs, Some(&item.sig.ident)),
            Item::Macro(item) => (&item.attrs, item.ident.as_ref()),
            Item::Mod(item) => (&item.attrs, None),
            Item::Static(item) => (&item.attrs, Some(&item.ident)),
            Item::Struct(item) => (&item.attrs, Some(&item.ident)),
            Item::Trait(item) => (&item.attrs, Some(&item.ident)),
            Item::Type(item) => (&item.attrs, Some(&item.ident)),
            Item::Use(item) => {
                if !is_test(&item.attrs) {
                    let is_public = !matches!(item.vis, syn::Visibility::Inherited);
                    self.import(&item.tree, &[], is_public);
                }
                return;
            }
            Item::Impl(item) => (&item.attrs, None),
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            self.items.extend(name.map(ToString::to_string));
            visit::visit_item(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments = path.segments.iter();
        self.paths
            .insert(segments.map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }
}

/// Lines of `text` without blank ones, comments and the tests at its end.
fn lines_of_code(text: &str) -> usize {
    let lines = text.lines().map(str::trim);
    lines
        .take_while(|line| *line != "#[cfg(test)]" && !line.starts_with("#[cfg(all(test"))
        .filter(|line| !line.is_empty() && !line.starts_with("//"))
        .count()
}

/// The files of a crate by their module paths.
struct Crate {
    name: &'static str,
    files: BTreeMap<Names, File>,
}

impl Crate {
    fn read(name: &'static str, folder: &Path) -> Crate {
        let mut files = BTreeMap::new();
        let mut folders = vec![folder.to_path_buf()];
        while let Some(next) = folders.pop() {
            for entry in fs::read_dir(next).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                if path.extension().is_none_or(|extension| extension != "rs") {
                    continue;
                }
                let place = path.strip_prefix(folder).unwrap().with_extension("");
                let mut module: Names = place
                    .iter()
                    .map(|part| part.to_str().unwrap().to_string())
                    .collect();
                let last = module.last().unwrap().as_str();
                if last == "tests" {
                    continue;
                }
                if last == "mod"
                    || ["lib", "main"]
                        .map(|root| vec![root.to_string()])
                        .contains(&module)
                {
                    module.pop();
                }
                let text = fs::read_to_string(&path).unwrap();
                let mut file = File {
                    lines: lines_of_code(&text),
                    ..File::default()
                };
                file.visit_file(&syn::parse_file(&text).unwrap());
                files.insert(module, file);
            }
        }
        Crate { name, files }
    }

    /// The file that defines `path`, seen from the file `from`; `None` for items of
    /// other crates.
    fn resolve(&self, from: &[String], path: &[String], depth: u32) -> Option<Names> {
        let (first, mut rest) = path.split_first()?;
        let mut module = from.to_vec();
        if depth > 20 {
            return None;
        }
        match first.as_str() {
            "crate" => module.clear(),
            name if name == self.name => module.clear(),
            "self" => {}
            "super" => {
                module.pop();
                while rest.first().is_some_and(|name| name == "super") {
                    module.pop();
                    rest = &rest[1..];
                }
            }
            _ => {
                let child = [from, &path[..1]].concat();
                if !self.files.contains_key(&child) {
                    let known = self.files[from]
                        .imports
                        .iter()
                        .find(|(_, name, _)| name == first);
                    let (import, ..) = known?;
                    return self.resolve(from, &[import, rest].concat(), depth + 1);
                }
                rest = path;
            }
        }
        while let Some((name, after)) = rest.split_first() {
            let child = [&module[..], std::slice::from_ref(name)].concat();
            if self.files.contains_key(&child) {
                (module, rest) = (child, after);
                continue;
            }
            let file = self.files.get(&module)?;
            if file.items.contains(name) || name == "*" {
                return Some(module);
            }
            let known = file.imports.iter().find(|(_, known, _)| known == name);
            return match known {
                Some((import, ..)) => self.resolve(&module, &[import, after].concat(), depth + 1),
                None => Some(module),
            };
        }
        Some(module)
    }

    /// The files that `module` uses, but for its own submodules.
    fn uses(&self, module: &[String]) -> BTreeSet<Names> {
        let file = &self.files[module];
        let imports = file.imports.iter().filter(|(_, _, is_public)| !is_public);
        let imports = imports.map(|(path, ..)| path);
        // An imported module is used where a path goes on into it.
        let is_module = |path: &&Names| {
            let names = |skip: usize| path[skip..].to_vec();
            match path[0].as_str() {
                "crate" => self.files.contains_key(&names(1)),
                "super" => {
                    let up = path.iter().take_while(|name| *name == "super").count();
                    let parent = &module[..module.len().saturating_sub(up)];
                    self.files.contains_key(&[parent, &path[up..]].concat())
                }
                _ => self.files.contains_key(&[module, &path[..]].concat()),
            }
        };
        let long = file.paths.iter().filter(|path| path.len() > 1);
        imports
            .filter(|path| !is_module(path))
            .chain(long)
            .filter_map(|path| self.resolve(module, path, 0))
            .filter(|used| !used.starts_with(module))
            .collect()
    }

    /// The files on dependency cycles, each with those that it uses on the same cycle.
    fn circles(&self) -> Vec<String> {
        let uses: BTreeMap<Names, BTreeSet<Names>> = self
            .files
            .keys()
            .map(|module| (module.clone(), self.uses(module)))
            .collect();
        let reaches = |from: &Names, to: &Names| {
            let mut reached = BTreeSet::from([from]);
            let mut next = vec![from];
            while let Some(module) = next.pop() {
                next.extend(uses[module].iter().filter(|used| reached.insert(used)));
            }
            reached.contains(to)
        };
        let name = |module: &Names| format!("{}::{}", self.name, module.join("::"));
        let mut found = Vec::new();
        for (module, used) in &uses {
            let back: Vec<String> = used
                .iter()
                .filter(|used| reaches(used, module))
                .map(name)
                .collect();
            if !back.is_empty() {
                found.push(format!("{} uses {}", name(module), back.join(", ")));
            }
        }
        found
    }
}

fn crates() -> impl Iterator<Item = Crate> {
    CRATES
        .into_iter()
        .map(|(name, folder)| Crate::read(name, &root().join(folder)))
}

#[test]
fn no_files_use_each_other() {
    let circles: Vec<String> = crates().flat_map(|sources| sources.circles()).collect();
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn no_file_is_too_long() {
    let mut long = Vec::new();
    for sources in crates() {
        let files = sources.files.iter();
        for (module, file) in files.filter(|(_, file)| file.lines > MOST_LINES) {
            let (name, path) = (sources.name, module.join("::"));
            long.push(format!("{name}::{path} has {} lines of code", file.lines));
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}
