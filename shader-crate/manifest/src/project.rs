//! The shader crates of a project, as its `Cargo.toml` names them.
//!
//! ```toml
//! [package.metadata.relievo]       # or [workspace.metadata.relievo]
//! shaders = "shaders"              # folder of the modules and of manifest.toml
//! also = ["data/table.rs"]         # further files, or folders of .rs files, that decide the modules
//! crates = [                       # by default the package itself
//!     { path = "shader", name = "kernels", about = "functions to compare" },
//! ]
//! ```

use crate::error::ManifestError;
use crate::files::{canonical, read_toml, real, wrong};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// A crate of shaders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderCrate {
    /// The folder of its `Cargo.toml`.
    pub folder: PathBuf,
    /// The same as the project names it.
    pub path: String,
    /// What the folders of its modules begin with.
    pub name: String,
    /// Purpose of its modules.
    pub about: String,
}

/// A project with shaders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Project {
    /// The `Cargo.toml` with the section.
    pub manifest_path: PathBuf,
    /// Its folder.
    pub root: PathBuf,
    /// The folder of the modules and of their manifest, from the root.
    pub shaders: String,
    /// Further files and folders that decide the modules, from the root.
    pub also: Vec<String>,
    /// The shader crates.
    pub crates: Vec<ShaderCrate>,
    /// The section as text, the same for every order of its keys.
    pub section: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Section {
    shaders: Option<String>,
    #[serde(default)]
    also: Vec<String>,
    crates: Option<Vec<CrateSection>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CrateSection {
    path: String,
    name: String,
    about: Option<String>,
}

/// What to add where there is no section.
const MISSING: &str = "it has no section [package.metadata.relievo] or [workspace.metadata.relievo]; add one, such as\n    [package.metadata.relievo]\n    shaders = \"shaders\"";

/// Returns the section and its name.
fn section(manifest: &toml::Table) -> Result<Option<(&'static str, &toml::Value)>, String> {
    let of = |part: &str| manifest.get(part)?.get("metadata")?.get("relievo");
    match (of("package"), of("workspace")) {
        (Some(_), Some(_)) => Err(
            "it has both [package.metadata.relievo] and [workspace.metadata.relievo]; remove one"
                .to_string(),
        ),
        (Some(value), None) => Ok(Some(("package.metadata.relievo", value))),
        (None, Some(value)) => Ok(Some(("workspace.metadata.relievo", value))),
        (None, None) => Ok(None),
    }
}

/// Returns whether a path stays below the folder that it starts from.
fn is_below(path: &str) -> bool {
    let mut parts = Path::new(path).components();
    !path.is_empty()
        && !path.contains('\\')
        && parts.all(|part| matches!(part, Component::Normal(_)))
}

impl Project {
    /// Reads the project of the `Cargo.toml` at `manifest_path`.
    ///
    /// # Errors
    /// [`ManifestError`] if the file cannot be read, has no section, or a wrong one.
    pub fn load(manifest_path: &Path) -> Result<Project, ManifestError> {
        let manifest_path = real(manifest_path)?;
        let manifest = read_toml(&manifest_path)?;
        let fail = |message: String| wrong(&manifest_path, message);
        let (title, value) = section(&manifest)
            .map_err(fail)?
            .ok_or_else(|| fail(MISSING.to_string()))?;
        let fail = |message: String| fail(format!("[{title}]: {message}"));
        let read: Section = value
            .clone()
            .try_into()
            .map_err(|error: toml::de::Error| fail(error.message().to_string()))?;

        let shaders = read.shaders.unwrap_or_else(|| "shaders".to_string());
        for (key, path) in [("shaders", &shaders)]
            .into_iter()
            .chain(read.also.iter().map(|path| ("also", path)))
        {
            if !is_below(path) {
                return Err(fail(format!(
                    "{key}: {path:?} is not a path below the folder of this file; write one with '/' and without '..'"
                )));
            }
        }
        let root = manifest_path
            .parent()
            .unwrap_or(Path::new(""))
            .to_path_buf();
        let crates = match read.crates {
            Some(crates) => crates,
            None => vec![the_package(&manifest).ok_or_else(|| {
                fail("crates: it is missing, and this workspace is not a package itself; name the shader crates, such as crates = [{ path = \"shader\", name = \"shader\" }]".to_string())
            })?],
        };
        if crates.is_empty() {
            return Err(fail(
                "crates: it is empty; name a crate, or leave it out".to_string(),
            ));
        }
        let mut names = BTreeSet::new();
        let mut found = Vec::new();
        for CrateSection { path, name, about } in crates {
            let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-".contains(letter);
            if name.is_empty() || !name.chars().all(is_plain) {
                return Err(fail(format!(
                    "crates: {name:?} is not a name of letters, digits, '_' and '-'"
                )));
            }
            // Folders are the same in upper and lower case on some systems.
            if !names.insert(name.to_lowercase()) {
                return Err(fail(format!(
                    "crates: two have the name {name:?}; their folders would be the same"
                )));
            }
            let folder = root.join(&path);
            if Path::new(&path).is_absolute() || !folder.join("Cargo.toml").is_file() {
                return Err(fail(format!(
                    "crates: there is no {path}/Cargo.toml; write the crate's path from the folder of this file"
                )));
            }
            found.push(ShaderCrate {
                folder: real(&folder)?,
                about: about.unwrap_or_else(|| name.clone()),
                path,
                name,
            });
        }
        Ok(Project {
            shaders,
            also: read.also,
            crates: found,
            section: canonical(value),
            root,
            manifest_path,
        })
    }

    /// Finds the project of a folder: the first `Cargo.toml` with a section, in the folder
    /// or above it.
    ///
    /// # Errors
    /// [`ManifestError`] if there is none, or it cannot be read.
    pub fn find(folder: &Path) -> Result<Project, ManifestError> {
        let folder = real(folder)?;
        for above in folder.ancestors() {
            let manifest_path = above.join("Cargo.toml");
            if manifest_path.is_file() {
                let manifest = read_toml(&manifest_path)?;
                if !matches!(section(&manifest), Ok(None)) {
                    return Project::load(&manifest_path);
                }
            }
        }
        let message = "no Cargo.toml here or above has a section [package.metadata.relievo]; add one, name the file with --manifest-path, or make a project with `cargo relievo new`";
        Err(wrong(&folder, message))
    }

    /// Returns the folder of the modules and of their manifest.
    pub fn shader_folder(&self) -> PathBuf {
        self.root.join(&self.shaders)
    }
}

/// Returns the package of a `Cargo.toml` as a shader crate.
fn the_package(manifest: &toml::Table) -> Option<CrateSection> {
    let package = manifest.get("package")?.get("name")?.as_str()?;
    Some(CrateSection {
        path: ".".to_string(),
        name: package.replace('-', "_"),
        about: None,
    })
}
