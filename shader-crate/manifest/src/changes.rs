//! What has changed since the modules were built.

use crate::error::ManifestError;
use crate::files::{entries, read};
use crate::manifest::{Manifest, digest};
use crate::project::Project;
use crate::sources::source_digests;
use crate::toolchain::VERSION;
use std::collections::BTreeMap;

/// Returns what has changed since the modules of a project were built: a line for each
/// source and module. Empty if the modules are those of the sources.
///
/// # Errors
/// [`ManifestError`] if there is no manifest, or a file cannot be read.
pub fn changes(project: &Project) -> Result<Vec<String>, ManifestError> {
    let manifest = Manifest::load(project)?;
    let mut changes = Vec::new();
    if manifest.toolchain.builder != VERSION {
        changes.push(format!(
            "the builder: version {} made the modules, and this is {VERSION}",
            manifest.toolchain.builder
        ));
    }
    changes.extend(changed_sources(
        &manifest.sources,
        &source_digests(project)?,
    ));
    changes.extend(changed_modules(
        &manifest,
        &module_files(project, &manifest)?,
    ));
    Ok(changes)
}

/// Returns the differences between the sources of a manifest and `actual` ones.
pub fn changed_sources(
    manifest: &BTreeMap<String, String>,
    actual: &BTreeMap<String, String>,
) -> Vec<String> {
    let mut changes = Vec::new();
    for (name, digest) in actual {
        match manifest.get(name) {
            None => changes.push(format!("{name}: new since the shaders were compiled")),
            Some(known) if known != digest => {
                changes.push(format!("{name}: changed since the shaders were compiled"));
            }
            Some(_) => {}
        }
    }
    for name in manifest.keys() {
        if !actual.contains_key(name) {
            changes.push(format!("{name}: gone since the shaders were compiled"));
        }
    }
    changes
}

/// Returns the differences between the modules of a manifest and `files` (name and bytes).
pub fn changed_modules(manifest: &Manifest, files: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
    let mut changes = Vec::new();
    for (name, module) in &manifest.modules {
        match files.get(name) {
            None => changes.push(format!("{name}: missing")),
            Some(bytes) if bytes.len() as u64 != module.bytes => changes.push(format!(
                "{name}: {} bytes, but {} in the manifest",
                bytes.len(),
                module.bytes
            )),
            Some(bytes) if digest(bytes) != module.sha256 => {
                changes.push(format!("{name}: not the compiled module"));
            }
            Some(_) => {}
        }
    }
    for name in files.keys() {
        if !manifest.modules.contains_key(name) {
            changes.push(format!("{name}: not in the manifest"));
        }
    }
    changes
}

/// Returns the files in the folders of a manifest's modules.
///
/// # Errors
/// [`ManifestError::File`] if a file cannot be read.
pub fn module_files(
    project: &Project,
    manifest: &Manifest,
) -> Result<BTreeMap<String, Vec<u8>>, ManifestError> {
    let mut files = BTreeMap::new();
    for name in manifest.folders.keys() {
        let folder = project.shader_folder().join(name);
        // A missing folder is missing modules.
        if folder.is_dir() {
            for path in entries(&folder)? {
                let file = path.file_name().unwrap_or_default().to_string_lossy();
                files.insert(format!("{name}/{file}"), read(&path)?);
            }
        }
    }
    Ok(files)
}
