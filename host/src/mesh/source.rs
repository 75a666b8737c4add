//! The source of a mesh: a file, or data made in code.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::data::MeshData;

/// The source of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// A Wavefront OBJ or glTF 2.0 file.
    File(PathBuf),
    /// Vertices and triangles.
    Data(Arc<MeshData>),
}

impl MeshSource {
    /// Returns the path, if the source is a file.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Data(_) => None,
        }
    }

    /// Returns the file name without folder and extension, or the data's name.
    pub fn label(&self) -> String {
        match self {
            Self::File(path) => path
                .file_stem()
                .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
            Self::Data(data) => data.name.clone(),
        }
    }
}

/// Writes the path, or the data's name.
impl fmt::Display for MeshSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => path.display().fmt(f),
            Self::Data(data) => data.name.fmt(f),
        }
    }
}

impl From<PathBuf> for MeshSource {
    fn from(path: PathBuf) -> Self {
        Self::File(path)
    }
}

impl From<&str> for MeshSource {
    fn from(path: &str) -> Self {
        Self::File(path.into())
    }
}

impl From<MeshData> for MeshSource {
    fn from(data: MeshData) -> Self {
        Self::Data(Arc::new(data))
    }
}
