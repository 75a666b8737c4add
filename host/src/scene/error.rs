//! Errors of reading and checking scenes.

use std::path::PathBuf;

/// An error in a scene: a file that cannot be read, or a value that is not allowed.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene file {path}: {source}; check the path and its permissions")]
    Read {
        /// The scene file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The path does not name a text file of a sensible size.
    #[error("{path} is not a scene file: {problem}")]
    NotAScene {
        /// The path.
        path: PathBuf,
        /// What is wrong and the remedy.
        problem: String,
    },
    /// The file is not TOML, or has no object.
    #[error("{path}: {message}")]
    Syntax {
        /// The scene file.
        path: PathBuf,
        /// Line, column, the text there and what is wrong.
        message: String,
    },
    /// A key of a scene file is unknown, missing, or has a value that is not allowed.
    #[error("{path}, line {line}, column {column}: {key} {problem}")]
    Value {
        /// The scene file.
        path: PathBuf,
        /// Line of the value, from 1.
        line: usize,
        /// Column of the value, from 1.
        column: usize,
        /// Key with its tables, such as `camera.fov` or `object 1: depth`.
        key: String,
        /// What is wrong and the remedy.
        problem: String,
    },
    /// A field of a scene that was made or changed in code has a value that is not allowed.
    #[error("{path}: {key} {problem}")]
    Invalid {
        /// Path of the scene.
        path: PathBuf,
        /// Key of the field, as in [`SceneError::Value`].
        key: String,
        /// What is wrong and the remedy.
        problem: String,
    },
}
