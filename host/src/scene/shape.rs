//! Patterns of objects.

use crate::shape_map::{Lettering, Pattern};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The pattern of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// An image, an SVG drawing, or a baked shape map.
    File(PathBuf),
    /// A text.
    Text(Lettering),
    /// Pixels. Not written to scene files.
    Pattern(Arc<Pattern>),
    /// The text of an SVG document.
    Drawing(Arc<str>),
}

impl Shape {
    /// Creates the pattern of a text in the built-in font.
    pub fn text(text: impl Into<String>) -> Shape {
        Shape::Text(Lettering::new(text))
    }

    /// Creates the pattern of an SVG document.
    pub fn svg(document: &str) -> Shape {
        Shape::Drawing(document.into())
    }

    /// Returns the path of the file that it names, if any: the pattern's or the font's.
    pub fn file(&self) -> Option<&Path> {
        self.named_file().map(|(_, path)| path)
    }

    /// Returns the key and the path of the file that it names, if any.
    pub(super) fn named_file(&self) -> Option<(&'static str, &Path)> {
        match self {
            Shape::File(path) => Some(("shape", path)),
            Shape::Text(lettering) => Some(("shape.font", lettering.font.as_deref()?)),
            Shape::Pattern(_) | Shape::Drawing(_) => None,
        }
    }

    /// As [`Shape::named_file`], for another path to be set.
    pub(super) fn named_file_mut(&mut self) -> Option<(&'static str, &mut PathBuf)> {
        match self {
            Shape::File(path) => Some(("shape", path)),
            Shape::Text(lettering) => Some(("shape.font", lettering.font.as_mut()?)),
            Shape::Pattern(_) | Shape::Drawing(_) => None,
        }
    }

    /// Returns the file's name without its folder, or as [`Shape`] is displayed.
    pub fn label(&self) -> String {
        match self {
            Shape::File(path) => path
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            _ => self.to_string(),
        }
    }
}

/// Writes the path, or the text in quotes.
impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::File(path) => path.display().fmt(f),
            Shape::Text(lettering) => write!(f, "{:?}", lettering.text),
            Shape::Pattern(pattern) => {
                write!(
                    f,
                    "a pattern of {} × {} pixels",
                    pattern.width(),
                    pattern.height()
                )
            }
            Shape::Drawing(_) => f.write_str("an SVG document"),
        }
    }
}

impl From<&str> for Shape {
    fn from(path: &str) -> Shape {
        Shape::File(path.into())
    }
}

impl From<PathBuf> for Shape {
    fn from(path: PathBuf) -> Shape {
        Shape::File(path)
    }
}

impl From<Lettering> for Shape {
    fn from(lettering: Lettering) -> Shape {
        Shape::Text(lettering)
    }
}

impl From<Pattern> for Shape {
    fn from(pattern: Pattern) -> Shape {
        Shape::Pattern(Arc::new(pattern))
    }
}
