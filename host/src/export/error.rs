//! Errors of an export.

use relievo_translate::Target;

/// An error of an export.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// There is no such object.
    #[error("the scene has no object {name:?}; name one of {known} (--object)")]
    NoObject {
        /// The wanted name.
        name: String,
        /// The names of the scene's objects.
        known: String,
    },
    /// A shader cannot be translated to a language.
    #[error(
        "object {object:?}: the shader {shader} cannot be written as {target}: {message}; leave {target} out of --target"
    )]
    Shader {
        /// The object.
        object: String,
        /// The shader.
        shader: &'static str,
        /// The language.
        target: Target,
        /// The reason.
        message: String,
    },
    /// Names or bindings that not every language takes.
    #[error("{message}")]
    Interface {
        /// The reason and the remedy.
        message: String,
    },
    /// The mesh cannot be written as a file.
    #[error("object {object:?}: its mesh cannot be written as glTF: {message}")]
    Mesh {
        /// The object.
        object: String,
        /// The reason and the remedy.
        message: String,
    },
    /// The shape map cannot be written as a file.
    #[error("object {object:?}: its shape map cannot be written: {message}")]
    Map {
        /// The object.
        object: String,
        /// The reason.
        message: String,
    },
}
