//! Reads files, with errors that name them.

use crate::error::ManifestError;
use std::path::{Path, PathBuf};

/// Returns an error of the file at `path`.
pub fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> ManifestError {
    |reason| ManifestError::File {
        path: path.to_path_buf(),
        reason,
    }
}

/// Returns an error about the content of the file at `path`.
pub fn wrong(path: &Path, message: impl Into<String>) -> ManifestError {
    ManifestError::Content {
        path: path.to_path_buf(),
        message: message.into(),
    }
}

pub fn read(path: &Path) -> Result<Vec<u8>, ManifestError> {
    std::fs::read(path).map_err(failed(path))
}

pub fn read_text(path: &Path) -> Result<String, ManifestError> {
    std::fs::read_to_string(path).map_err(failed(path))
}

pub fn read_toml(path: &Path) -> Result<toml::Table, ManifestError> {
    read_text(path)?
        .parse()
        .map_err(|error: toml::de::Error| wrong(path, error.to_string()))
}

/// Returns a path without links.
pub fn real(path: &Path) -> Result<PathBuf, ManifestError> {
    path.canonicalize().map_err(failed(path))
}

/// Returns the entries of a folder in order.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>, ManifestError> {
    let entries = std::fs::read_dir(folder).map_err(failed(folder))?;
    let mut paths = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<PathBuf>, _>>()
        .map_err(failed(folder))?;
    paths.sort();
    Ok(paths)
}

/// Returns a value as text that does not depend on the order of its keys in the file.
pub fn canonical(value: &toml::Value) -> String {
    match value {
        toml::Value::Table(table) => {
            let mut keys: Vec<&String> = table.keys().collect();
            keys.sort();
            let inner = keys
                .into_iter()
                .map(|key| format!("{key:?} = {}", canonical(&table[key])));
            format!("{{ {} }}", inner.collect::<Vec<_>>().join(", "))
        }
        toml::Value::Array(array) => {
            let inner = array.iter().map(canonical);
            format!("[{}]", inner.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}
