//! The manifest of the compiled shaders, `manifest.toml` beside them.

use crate::error::ManifestError;
use crate::files::{read_text, wrong};
use crate::project::Project;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// The manifest's file name.
pub const MANIFEST_FILE: &str = "manifest.toml";

/// The compilers of the modules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Toolchain {
    /// Output of `rustc --version` of the nightly.
    pub rustc: String,
    /// Version of rust-gpu (spirv-builder and its backend).
    pub rust_gpu: String,
    /// Version of Relievo, whose builder made the modules.
    pub builder: String,
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
    /// Source, as a path or as a part of a file, to SHA-256.
    pub sources: BTreeMap<String, String>,
}

impl Manifest {
    /// Reads the manifest of a project.
    ///
    /// # Errors
    /// [`ManifestError::NotBuilt`] if there is none, and others if it cannot be read.
    pub fn load(project: &Project) -> Result<Manifest, ManifestError> {
        let path = project.shader_folder().join(MANIFEST_FILE);
        if !path.exists() {
            return Err(ManifestError::NotBuilt { path });
        }
        toml::from_str(&read_text(&path)?).map_err(|error| {
            wrong(
                &path,
                format!("{error}\nwrite the file anew with `cargo relievo build`"),
            )
        })
    }

    /// Returns the file's text.
    pub fn to_text(&self) -> String {
        let body = toml::to_string_pretty(self).expect("a manifest of strings is valid TOML");
        format!(
            "# Written by `cargo relievo build` with the modules beside it. Do not edit.\n{body}"
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
