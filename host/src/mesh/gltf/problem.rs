//! Errors of the glTF reader.

use std::path::Path;

use gltf::json::Value;

use super::super::error::MeshError;

/// The problem and the remedy. The caller adds the file.
pub(super) struct Problem(pub(super) String);

impl<T: Into<String>> From<T> for Problem {
    fn from(text: T) -> Problem {
        Problem(text.into())
    }
}

/// Why the content of a buffer cannot be used.
pub(super) enum BufferError {
    Problem(Problem),
    TooLarge,
}

impl BufferError {
    /// Returns the error of the mesh at `path`, which may have `limit` bytes.
    pub fn of_mesh(self, path: &Path, limit: u64) -> MeshError {
        let path = path.to_owned();
        match self {
            BufferError::Problem(Problem(problem)) => MeshError::Invalid { path, problem },
            BufferError::TooLarge => MeshError::TooLarge { path, limit },
        }
    }
}

impl<T: Into<Problem>> From<T> for BufferError {
    fn from(problem: T) -> BufferError {
        BufferError::Problem(problem.into())
    }
}

/// Returns the whole number `key` of an extension's object; `None` if it is not there.
pub(super) fn whole_number(object: &Value, key: &str) -> Result<Option<usize>, Problem> {
    let Some(value) = object.get(key) else {
        return Ok(None);
    };
    let number = value.as_u64().and_then(|number| number.try_into().ok());
    let number = number.ok_or_else(|| format!("{key} is {value}, no whole number"))?;
    Ok(Some(number))
}
