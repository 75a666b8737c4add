//! The packages that shader crates are compiled from, as far as they lie in folders: path
//! dependencies, direct and indirect.

use crate::error::ManifestError;
use crate::files::{failed, read_toml, real};
use crate::project::Project;
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A package in a folder.
#[derive(Clone, Debug)]
pub struct Package {
    pub name: String,
    pub folder: PathBuf,
    /// The root of its workspace.
    pub workspace: PathBuf,
    /// The file of its library, if it has one.
    pub library: Option<PathBuf>,
    /// The file of its build script, if it has one.
    pub build_script: Option<PathBuf>,
    /// Names of the packages that it needs for a build, not for its tests.
    pub needs: BTreeSet<String>,
    /// Folders of those that lie in folders.
    below: Vec<PathBuf>,
}

/// Packages by their folders.
#[derive(Default)]
pub struct Packages {
    /// Those that the shader crates need, and these themselves.
    pub needed: BTreeMap<PathBuf, Package>,
    /// Those that cargo has described.
    known: BTreeMap<PathBuf, Package>,
}

impl Packages {
    /// Finds the packages that the crates in `folders` are compiled from.
    pub fn of<'a>(folders: impl Iterator<Item = &'a Path>) -> Result<Packages, ManifestError> {
        let mut packages = Packages::default();
        let mut waiting = Vec::new();
        for folder in folders {
            let folder = real(folder)?;
            packages.ask(&folder)?;
            waiting.extend(patches(&packages.known[&folder].workspace)?);
            waiting.push(folder);
        }
        while let Some(folder) = waiting.pop() {
            let folder = real(&folder)?;
            if !packages.needed.contains_key(&folder) {
                packages.ask(&folder)?;
                let package = packages.known[&folder].clone();
                waiting.extend(package.below.iter().cloned());
                packages.needed.insert(folder, package);
            }
        }
        Ok(packages)
    }

    /// Asks cargo for the package in `folder`, and so for those of its workspace.
    fn ask(&mut self, folder: &Path) -> Result<(), ManifestError> {
        if self.known.contains_key(folder) {
            return Ok(());
        }
        let path = folder.join("Cargo.toml");
        let metadata = describe(&path)?;
        let workspace = real(metadata.workspace_root.as_std_path())?;
        for package in metadata.packages {
            let manifest_path = real(package.manifest_path.as_std_path())?;
            let folder = manifest_path.parent().unwrap_or(Path::new(""));
            let dependencies = package
                .dependencies
                .iter()
                .filter(|dependency| dependency.kind != DependencyKind::Development);
            let target = |is_wanted: fn(&cargo_metadata::Target) -> bool| {
                let target = package.targets.iter().find(|target| is_wanted(target))?;
                Some(target.src_path.as_std_path().to_path_buf())
            };
            let found = Package {
                name: package.name.to_string(),
                folder: folder.to_path_buf(),
                workspace: workspace.clone(),
                library: target(|target| {
                    // The kinds of a library: lib, rlib, dylib, cdylib, staticlib, proc-macro.
                    target.kind.iter().any(|kind| {
                        let kind = kind.to_string();
                        kind.ends_with("lib") || kind == "proc-macro"
                    })
                }),
                build_script: target(cargo_metadata::Target::is_custom_build),
                needs: dependencies.clone().map(|d| d.name.clone()).collect(),
                below: dependencies
                    .filter_map(|dependency| dependency.path.as_ref())
                    .map(|path| path.as_std_path().to_path_buf())
                    .collect(),
            };
            self.known.insert(folder.to_path_buf(), found);
        }
        if self.known.contains_key(folder) {
            Ok(())
        } else {
            let message = "cargo does not find a package here";
            Err(refused(&path, message.to_string()))
        }
    }
}

/// Returns the folder where cargo puts what it builds of a project.
///
/// # Errors
/// [`ManifestError::Cargo`] if cargo cannot read the project.
pub fn target_folder(project: &Project) -> Result<PathBuf, ManifestError> {
    let metadata = describe(&project.manifest_path)?;
    Ok(metadata.target_directory.into_std_path_buf())
}

/// Asks cargo for the packages of a workspace. Nothing is downloaded.
fn describe(manifest_path: &Path) -> Result<Metadata, ManifestError> {
    let mut command = MetadataCommand::new();
    let metadata = command.manifest_path(manifest_path).no_deps().exec();
    metadata.map_err(|error| refused(manifest_path, error.to_string()))
}

fn refused(manifest_path: &Path, message: String) -> ManifestError {
    ManifestError::Cargo {
        path: manifest_path.to_path_buf(),
        message,
    }
}

/// Returns the folders that a workspace puts in the place of other packages.
fn patches(workspace: &Path) -> Result<Vec<PathBuf>, ManifestError> {
    let path = workspace.join("Cargo.toml");
    let manifest = read_toml(&path)?;
    let mut folders = Vec::new();
    let patch = manifest.get("patch").and_then(toml::Value::as_table);
    for source in patch.into_iter().flat_map(|patch| patch.values()) {
        for replaced in source.as_table().into_iter().flat_map(|s| s.values()) {
            if let Some(folder) = replaced.get("path").and_then(toml::Value::as_str) {
                let folder = workspace.join(folder);
                folders.push(folder.canonicalize().map_err(failed(&folder))?);
            }
        }
    }
    Ok(folders)
}
