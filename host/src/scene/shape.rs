//! The pattern of an object, as a scene names it.

use crate::shape_map::Lettering;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::path::{Path, PathBuf};

/// The pattern of an object.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// An image, a drawing (SVG), or a baked shape map.
    File(PathBuf),
    /// Letters.
    Text(Lettering),
}

impl Shape {
    /// The file that it names, if any: the pattern's or the font's.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Shape::File(path) => Some(path),
            Shape::Text(lettering) => lettering.font.as_deref(),
        }
    }

    /// The file's name without its folder, or the text in quotes.
    pub fn label(&self) -> String {
        match self {
            Shape::File(path) => path
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            Shape::Text(_) => self.to_string(),
        }
    }
}

/// As messages name it: the file, or the text in quotes.
impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::File(path) => path.display().fmt(f),
            Shape::Text(lettering) => write!(f, "{:?}", lettering.text),
        }
    }
}

/// The table of a text.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TextTable {
    text: String,
    font: Option<PathBuf>,
    #[serde(default = "default_margin")]
    margin: f64,
}

fn default_margin() -> f64 {
    Lettering::DEFAULT_MARGIN
}

/// With paths as they are written.
impl<'de> Deserialize<'de> for Shape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ShapeVisitor;

        impl<'de> Visitor<'de> for ShapeVisitor {
            type Value = Shape;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a pattern: the path of a file, or { text = \"…\" }")
            }

            fn visit_str<E: Error>(self, path: &str) -> Result<Shape, E> {
                Ok(Shape::File(path.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Shape, A::Error> {
                let TextTable { text, font, margin } =
                    TextTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Shape::Text(Lettering { text, font, margin }))
            }
        }

        deserializer.deserialize_any(ShapeVisitor)
    }
}
