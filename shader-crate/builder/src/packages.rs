//! The packages of a shader crate: which file belongs to which, and which file may divide.

use anyhow::{Context, Result};
use cargo_metadata::MetadataCommand;
use std::path::{Path, PathBuf};

/// Files that may contain the device's division and square root: packages, and the file
/// beside the package's `lib.rs`.
const NATIVE: [(&str, &str); 2] = [
    // Their results are corrected.
    ("relievo-exact", "native.rs"),
    // They are measured before a device is trusted.
    ("relievo-kernel", "canary.rs"),
];

struct Package {
    name: String,
    version: String,
    folder: PathBuf,
    /// Whether it comes from a folder and not from a registry.
    local: bool,
}

/// The packages that a shader crate is compiled from.
pub struct Packages {
    /// The folder that relative paths start from.
    root: PathBuf,
    all: Vec<Package>,
    /// The files that may contain the device's division and square root.
    native: Vec<PathBuf>,
}

impl Packages {
    /// Asks cargo for the packages of the crate in `folder`.
    pub fn of(folder: &Path) -> Result<Packages> {
        let metadata = MetadataCommand::new()
            .current_dir(folder)
            .exec()
            .with_context(|| format!("cargo metadata of {}", folder.display()))?;
        let mut packages = Packages {
            root: real(metadata.workspace_root.as_std_path()),
            all: Vec::new(),
            native: Vec::new(),
        };
        for package in metadata.packages {
            let library = package.targets.iter().find(|target| target.is_lib());
            let sources = library.and_then(|target| target.src_path.parent());
            for (name, file) in NATIVE {
                let file = sources
                    .filter(|_| package.name.as_str() == name)
                    .map(|s| s.join(file));
                packages
                    .native
                    .extend(file.map(|file| real(file.as_std_path())));
            }
            let manifest = real(package.manifest_path.as_std_path());
            packages.all.push(Package {
                name: package.name.to_string(),
                version: package.version.to_string(),
                folder: manifest.parent().context("a manifest has a folder")?.into(),
                local: package.source.is_none(),
            });
        }
        Ok(packages)
    }

    /// Returns whether a file, as rustc names it, may contain the device's division and
    /// square root.
    pub fn may_divide(&self, file: &str) -> bool {
        self.native.contains(&self.resolve(file))
    }

    /// Returns whether a file is the user's: not of a registry, and not of the compiler.
    pub fn is_local(&self, file: &str) -> bool {
        self.package(&self.resolve(file))
            .is_some_and(|package| package.local)
    }

    /// Returns a path to show: relative to the workspace, or after the name of a package.
    pub fn describe(&self, file: &str) -> String {
        let path = self.resolve(file);
        if let Ok(below) = path.strip_prefix(&self.root) {
            return below.display().to_string();
        }
        if let Some(package) = self.package(&path) {
            let below = path.strip_prefix(&package.folder).unwrap_or(&path);
            return format!("{} {}, {}", package.name, package.version, below.display());
        }
        match file.split_once("/rust/library/") {
            Some((_, below)) => below.to_string(),
            None => file.to_string(),
        }
    }

    /// Returns the innermost package that a file lies in.
    fn package(&self, path: &Path) -> Option<&Package> {
        self.all
            .iter()
            .filter(|package| path.starts_with(&package.folder))
            .max_by_key(|package| package.folder.components().count())
    }

    /// rustc runs in the workspace, and names files below it by relative paths.
    fn resolve(&self, file: &str) -> PathBuf {
        real(&self.root.join(file))
    }
}

/// Returns the path without links, if it exists.
fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    impl Packages {
        /// Returns a package of which `native` may divide, without asking cargo.
        pub fn with_native(native: &str) -> Packages {
            Packages {
                root: PathBuf::from("/none"),
                all: vec![Package {
                    name: "shaders".to_string(),
                    version: "0.1.0".to_string(),
                    folder: PathBuf::from("/none"),
                    local: true,
                }],
                native: vec![PathBuf::from("/none").join(native)],
            }
        }
    }

    /// The folder of the repository's own shaders.
    const SHADERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

    #[test]
    fn one_file_of_a_package_may_divide_and_others_of_its_name_may_not() {
        let packages = Packages::of(&Path::new(SHADERS).join("kernels")).unwrap();
        let correcting = |file: &&PathBuf| file.ends_with("native.rs") && file.exists();
        assert!(packages.native.iter().any(|file| correcting(&file)));
        let canaries = packages.native.iter().filter(|f| f.ends_with("canary.rs"));
        assert_eq!(canaries.count(), 1, "{:?}", packages.native);
        for file in &packages.native {
            let absolute = file.to_str().unwrap();
            let relative = packages.describe(absolute);
            assert!(Path::new(&relative).is_relative(), "{relative}");
            assert!(packages.may_divide(absolute) && packages.may_divide(&relative));
            assert!(!packages.may_divide(file.with_file_name("lib.rs").to_str().unwrap()));
        }
        for other in ["native.rs", "src/native.rs", "shader-crate/src/native.rs"] {
            assert!(!packages.may_divide(other), "{other}");
        }
    }

    #[test]
    fn paths_are_shown_without_the_machine() {
        let packages = Packages::of(Path::new(SHADERS)).unwrap();
        assert_eq!(
            packages.describe("shader-crate/src/lib.rs"),
            "shader-crate/src/lib.rs"
        );
        assert!(packages.is_local("shader-crate/src/lib.rs"));
        let glam = packages.all.iter().find(|p| p.name == "glam").unwrap();
        let file = glam.folder.join("src/f32/vec3.rs");
        let file = file.to_str().unwrap();
        let shown = format!("glam {}, src/f32/vec3.rs", glam.version);
        assert_eq!(packages.describe(file), shown);
        assert!(!packages.is_local(file));
        assert_eq!(
            packages.describe("/a/lib/rustlib/src/rust/library/core/src/ops/arith.rs"),
            "core/src/ops/arith.rs"
        );
    }
}
