//! The library's error, of all modules together.
//!
//! ```
//! use relievo::Error;
//! use relievo::scene::Scene;
//!
//! let error = Error::from(Scene::load("none.toml".as_ref()).unwrap_err());
//! assert!(!error.is_machine());
//! assert!(error.to_string().contains("none.toml"));
//! ```

#[cfg(feature = "export")]
use crate::export::ExportError;
use crate::file::WriteError;
use crate::limits::LimitError;
use crate::mesh::MeshError;
use crate::render::RenderError;
use crate::scene::SceneError;
use crate::shape_map::ShapeMapError;
#[cfg(feature = "gpu")]
use relievo_bitwise::DeviceError;
use std::path::PathBuf;

/// Failure between a scene file and a picture.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene file cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A mesh cannot be loaded.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A pattern or a shape map cannot be loaded.
    #[error(transparent)]
    ShapeMap(#[from] ShapeMapError),
    /// The parameters of an object do not fit its mesh or pattern.
    #[error("{scene}: object {name:?}: {problem}")]
    Object {
        /// The scene file.
        scene: PathBuf,
        /// The object.
        name: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A scene would exceed its memory limit.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A renderer failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An object could not be exported.
    #[cfg(feature = "export")]
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
    /// A file or folder of measurements does not fit the request.
    #[error("{path}: {problem}")]
    Measurements {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A file could not be encoded.
    #[error("cannot encode {path}: {message}")]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        message: String,
    },
}

impl From<WriteError> for Error {
    fn from(WriteError { path, source }: WriteError) -> Error {
        Error::Write { path, source }
    }
}

#[cfg(feature = "gpu")]
impl From<DeviceError> for Error {
    fn from(error: DeviceError) -> Error {
        Error::Render(error.into())
    }
}

impl Error {
    /// Returns whether the machine is the cause (no adapter, out of memory, disk
    /// full), not the input.
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
