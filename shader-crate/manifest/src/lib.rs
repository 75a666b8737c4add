//! The manifest of the compiled shaders, `assets/shaders/manifest.toml`.
//!
//! Compiled shaders are committed, so that users need neither rust-gpu nor its nightly.
//! The manifest lists the toolchain and SHA-256 digests: of every source file, of the
//! parts of the workspace's manifest and lock file that the sources depend on, and of
//! each module. The builder writes it; a test compares it with the sources.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Where the modules and their manifest lie, from the repository's root.
pub const SHADER_FOLDER: &str = "assets/shaders";
/// The manifest's file name.
pub const MANIFEST_FILE: &str = "manifest.toml";

/// Files and folders (searched for `.rs`) whose bytes decide the modules.
const SOURCES: [&str; 15] = [
    "shared/Cargo.toml",
    "shared/exact/Cargo.toml",
    "shared/exact/src",
    "shared/kernel/Cargo.toml",
    "shared/kernel/src",
    "shared/src",
    "shader-crate/Cargo.toml",
    "shader-crate/src",
    "shader-crate/kernels/Cargo.toml",
    "shader-crate/kernels/src",
    "shader-crate/manifest/src",
    "shader-crate/builder/Cargo.toml",
    "shader-crate/builder/Cargo.lock",
    "shader-crate/builder/rust-toolchain.toml",
    "shader-crate/builder/src",
];
/// The package whose dependencies are looked up in the lock file: it has those
/// of both shader crates.
const SHADER_PACKAGE: &str = "relievo-kernel-shader";

/// Errors of reading the manifest or the sources.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A TOML file has unexpected content.
    #[error("{path}: {message}")]
    Content {
        /// Which file.
        path: PathBuf,
        /// Why.
        message: String,
    },
}

/// The compilers of the modules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Toolchain {
    /// Output of `rustc --version` of the nightly.
    pub rustc: String,
    /// Version of rust-gpu (spirv-builder and its backend).
    pub rust_gpu: String,
    /// The SPIR-V target.
    pub target: String,
}

/// One compiled module: an entry point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Module {
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Size of the file, bytes.
    pub bytes: u64,
}

/// The compiled shaders and their sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The compilers.
    pub toolchain: Toolchain,
    /// Purpose of the modules of each folder in the shader folder, and how they were
    /// made.
    pub folders: BTreeMap<String, String>,
    /// The file of each module, from the shader folder.
    pub modules: BTreeMap<String, Module>,
    /// Source, as a path from the root or as a part of a file, to SHA-256.
    pub sources: BTreeMap<String, String>,
}

impl Manifest {
    /// Reads the manifest of the repository at `root`.
    pub fn load(root: &Path) -> Result<Manifest, ManifestError> {
        let path = root.join(SHADER_FOLDER).join(MANIFEST_FILE);
        toml::from_str(&read_text(&path)?).map_err(|error| ManifestError::Content {
            path,
            message: error.to_string(),
        })
    }

    /// Returns the file's text.
    pub fn to_text(&self) -> String {
        let body = toml::to_string_pretty(self).expect("a manifest of strings is valid TOML");
        format!(
            "# Written by shader-crate/builder with the modules beside it. Do not edit.\n{body}"
        )
    }
}

/// Returns the SHA-256 of `bytes`, hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Returns digests of everything that determines the modules, in the repository at `root`.
pub fn source_digests(root: &Path) -> Result<BTreeMap<String, String>, ManifestError> {
    let mut files = BTreeSet::new();
    for source in SOURCES {
        collect(root, source, &mut files)?;
    }
    let mut digests = BTreeMap::new();
    for file in files {
        let bytes = read(&root.join(&file))?;
        digests.insert(file, digest(&bytes));
    }
    let dependencies = locked_dependencies(root)?;
    digests.insert(
        format!("Cargo.lock: packages that {SHADER_PACKAGE} needs"),
        digest(dependencies.lines.join("\n").as_bytes()),
    );
    digests.insert(
        format!("Cargo.toml: what {SHADER_PACKAGE} inherits"),
        digest(inherited(root, &dependencies.names)?.as_bytes()),
    );
    Ok(digests)
}

/// Adds the file `path`, or the `.rs` files below the folder `path`.
fn collect(root: &Path, path: &str, files: &mut BTreeSet<String>) -> Result<(), ManifestError> {
    let full = root.join(path);
    if !full.is_dir() {
        files.insert(path.to_string());
        return Ok(());
    }
    let entries = std::fs::read_dir(&full).map_err(|source| ManifestError::File {
        path: full.clone(),
        source,
    })?;
    for entry in entries {
        let entry = entry.map_err(|source| ManifestError::File {
            path: full.clone(),
            source,
        })?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let below = format!("{path}/{name}");
        // Unit tests do not decide the modules.
        let is_source = name.ends_with(".rs") && name != "tests.rs";
        if entry.path().is_dir() || is_source {
            collect(root, &below, files)?;
        }
    }
    Ok(())
}

struct Dependencies {
    names: BTreeSet<String>,
    lines: Vec<String>,
}

/// Returns the shader package's dependencies, direct and indirect, from the lock file.
fn locked_dependencies(root: &Path) -> Result<Dependencies, ManifestError> {
    let path = root.join("Cargo.lock");
    let lock = read_toml(&path)?;
    let text = |package: &toml::Table, key: &str| {
        package
            .get(key)
            .and_then(|value| value.as_str())
            .unwrap_or_default()
            .to_string()
    };
    let packages: Vec<&toml::Table> = lock
        .get("package")
        .and_then(|packages| packages.as_array())
        .into_iter()
        .flatten()
        .filter_map(|package| package.as_table())
        .collect();
    let mut waiting = vec![SHADER_PACKAGE.to_string()];
    let mut seen = BTreeSet::new();
    let mut lines = BTreeSet::new();
    while let Some(wanted) = waiting.pop() {
        if !seen.insert(wanted.clone()) {
            continue;
        }
        // An entry is "name", or "name version" where the name is not unique.
        let mut parts = wanted.split(' ');
        let (name, version) = (parts.next().unwrap_or_default(), parts.next());
        let package = packages
            .iter()
            .find(|package| {
                text(package, "name") == name
                    && version.is_none_or(|version| text(package, "version") == version)
            })
            .ok_or_else(|| ManifestError::Content {
                path: path.clone(),
                message: format!("no package '{wanted}'; run cargo metadata to renew the file"),
            })?;
        lines.insert(format!(
            "{} {} {}",
            name,
            text(package, "version"),
            text(package, "checksum")
        ));
        let below = package
            .get("dependencies")
            .and_then(|dependencies| dependencies.as_array());
        for dependency in below.into_iter().flatten() {
            waiting.extend(dependency.as_str().map(str::to_string));
        }
    }
    let names = lines
        .iter()
        .filter_map(|line| line.split(' ').next().map(str::to_string))
        .collect();
    Ok(Dependencies {
        names,
        lines: lines.into_iter().collect(),
    })
}

/// The parts of the root manifest that the shader's packages inherit.
fn inherited(root: &Path, names: &BTreeSet<String>) -> Result<String, ManifestError> {
    let manifest = read_toml(&root.join("Cargo.toml"))?;
    let workspace = manifest.get("workspace").and_then(|value| value.as_table());
    let edition = workspace
        .and_then(|workspace| workspace.get("package"))
        .and_then(|package| package.get("edition"));
    let dependencies = workspace
        .and_then(|workspace| workspace.get("dependencies"))
        .and_then(|dependencies| dependencies.as_table());
    let mut lines = vec![format!("edition {edition:?}")];
    for (name, value) in dependencies.into_iter().flatten() {
        if names.contains(name) {
            lines.push(format!("{name} {value}"));
        }
    }
    lines.push(format!(
        "profile {:?}",
        manifest.get("profile").and_then(|p| p.get("release"))
    ));
    Ok(lines.join("\n"))
}

fn read(path: &Path) -> Result<Vec<u8>, ManifestError> {
    std::fs::read(path).map_err(|source| ManifestError::File {
        path: path.to_path_buf(),
        source,
    })
}

fn read_text(path: &Path) -> Result<String, ManifestError> {
    std::fs::read_to_string(path).map_err(|source| ManifestError::File {
        path: path.to_path_buf(),
        source,
    })
}

fn read_toml(path: &Path) -> Result<toml::Table, ManifestError> {
    read_text(path)?
        .parse()
        .map_err(|error: toml::de::Error| ManifestError::Content {
            path: path.to_path_buf(),
            message: error.to_string(),
        })
}
