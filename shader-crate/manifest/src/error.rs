//! Errors of reading a project, its manifest or its sources.

use std::path::PathBuf;

/// An error of reading a project, its manifest or its sources.
#[derive(Debug, thiserror::Error)]
pub enum ManifestError {
    /// A file could not be read or written.
    #[error("{path}: {reason}")]
    File {
        /// Which file.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// A file has unexpected content.
    #[error("{path}: {message}")]
    Content {
        /// Which file.
        path: PathBuf,
        /// Why, and the way out.
        message: String,
    },
    /// The modules were never built.
    #[error("{path}: there is no such file; build the shaders with `cargo relievo build`")]
    NotBuilt {
        /// The manifest's path.
        path: PathBuf,
    },
    /// Cargo could not read a package.
    #[error("{path}: {message}")]
    Cargo {
        /// The `Cargo.toml`.
        path: PathBuf,
        /// Cargo's message.
        message: String,
    },
}
