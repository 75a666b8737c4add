//! The library's error: what failed, and whose fault it is.

use crate::export::ExportError;
use crate::mesh::MeshError;
use crate::render::RenderError;
use crate::scene::SceneError;
use crate::shape_map::ShapeMapError;
use relievo_bitwise::DeviceError;
use std::path::PathBuf;

/// Everything that can go wrong between a scene file and a picture.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A pattern or a shape map.
    #[error(transparent)]
    ShapeMap(#[from] ShapeMapError),
    /// An object asks for what its assets cannot give.
    #[error("{scene}: object {name:?}: {problem}")]
    Object {
        /// The scene file.
        scene: PathBuf,
        /// The object.
        name: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A scene asks for more memory than it may have.
    #[error(
        "{scene}: {what} would take {needed} bytes beside {taken} for the rest, more than the limit of {limit}; make it smaller, or raise the limit (--max-memory)"
    )]
    Limit {
        /// The scene file.
        scene: PathBuf,
        /// What does not fit.
        what: String,
        /// How much it needs, bytes.
        needed: u64,
        /// How much the rest of the scene takes, bytes.
        taken: u64,
        /// How much there may be in all, bytes.
        limit: u64,
    },
    /// A renderer.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An object could not be exported.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A file could not be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of measurements, or the folder of them, does not fit what is asked.
    #[error("{path}: {problem}")]
    Measurements {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A picture could not be encoded.
    #[error("cannot encode {path}: {message}")]
    Encode {
        /// The file it was meant for.
        path: PathBuf,
        /// Why.
        message: String,
    },
}

impl From<DeviceError> for Error {
    fn from(error: DeviceError) -> Error {
        Error::Render(error.into())
    }
}

impl Error {
    /// Whether the machine is at fault (no adapter, out of memory, disk full),
    /// and not the input.
    pub fn is_machine(&self) -> bool {
        match self {
            Error::Render(error) => !matches!(error, RenderError::TimeLimit { .. }),
            Error::Write { source, .. } => matches!(
                source.kind(),
                std::io::ErrorKind::StorageFull
                    | std::io::ErrorKind::QuotaExceeded
                    | std::io::ErrorKind::FileTooLarge
                    | std::io::ErrorKind::OutOfMemory
            ),
            _ => false,
        }
    }
}
