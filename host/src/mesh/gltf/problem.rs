//! Errors of the glTF reader.

/// The problem and the remedy. The caller adds the file.
pub(super) struct Problem(pub(super) String);

impl<T: Into<String>> From<T> for Problem {
    fn from(text: T) -> Problem {
        Problem(text.into())
    }
}
