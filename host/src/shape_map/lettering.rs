//! Text as patterns.

use super::error::ShapeMapError;
use super::fonts::{BUILT_IN, read_font};
use super::input::check_size;
use super::pattern::{Pattern, PatternOptions};
use super::raster::{paint, sides};
use crate::Files;
use resvg::tiny_skia::Transform;
use resvg::usvg::fontdb::Database;
use resvg::usvg::{FontResolver, Group, Node, Options, Tree};
use skrifa::{FontRef, MetadataProvider};
use std::path::{Path, PathBuf};

/// Font size, in units of the drawing.
const SIZE: f64 = 100.0;
/// Distance between lines, in units of the drawing.
const LINE: f64 = 1.2 * SIZE;
/// Maximum number of characters that a message lists.
const LISTED: usize = 16;

/// A text whose letters are a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct Lettering {
    /// The text; it may have several lines.
    pub text: String,
    /// The font file; `None` is the built-in font.
    pub font: Option<PathBuf>,
    /// Free margin on each side, in line heights.
    pub margin: f64,
}

impl Lettering {
    /// Default margin, in line heights.
    pub const DEFAULT_MARGIN: f64 = 0.2;

    /// Creates a text in the built-in font with the default margin.
    pub fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            font: None,
            margin: Self::DEFAULT_MARGIN,
        }
    }
}

impl Pattern {
    /// Draws the lines of `lettering`, centred, black on white, and thresholds
    /// the result; the longer side has [`raster`](PatternOptions::raster)
    /// pixels. The font is read from `files`.
    ///
    /// # Errors
    /// [`ShapeMapError::Font`] and [`ShapeMapError::Read`] for a font that
    /// cannot be read, [`ShapeMapError::Text`] if characters are missing in it
    /// or nothing is visible, [`ShapeMapError::TooLarge`].
    ///
    /// # Examples
    /// ```
    /// use relievo::Files;
    /// use relievo::shape_map::{Lettering, Pattern, PatternOptions};
    ///
    /// let options = PatternOptions { raster: 256, ..PatternOptions::default() };
    /// let pattern = Pattern::from_text(&Lettering::new("Aa"), &Files::Disk, &options)?;
    /// assert_eq!(pattern.width().max(pattern.height()), 256);
    /// assert!(pattern.solid().contains(&true));
    /// # Ok::<(), relievo::shape_map::ShapeMapError>(())
    /// ```
    pub fn from_text(
        lettering: &Lettering,
        files: &Files,
        options: &PatternOptions,
    ) -> Result<Pattern, ShapeMapError> {
        let wrong = |problem: String| ShapeMapError::Text {
            text: lettering.text.clone(),
            problem,
        };
        let mut fonts = Database::new();
        fonts.load_font_data(read_font(files, lettering.font.as_deref())?.into_owned());
        let no_font = || ShapeMapError::Font {
            path: lettering.font.clone().unwrap_or_else(|| BUILT_IN.into()),
        };
        let font = fonts
            .faces()
            .next()
            .map(|face| face.id)
            .ok_or_else(no_font)?;
        let missing = fonts.with_face_data(font, |data, index| {
            let font = FontRef::from_index(data, index).ok()?;
            let charmap = font.charmap();
            let mut missing: Vec<char> = Vec::new();
            for line in lettering.text.lines() {
                let lacks =
                    |c: &char| c.is_control() || (!c.is_whitespace() && charmap.map(*c).is_none());
                missing.extend(line.chars().filter(lacks));
            }
            missing.sort_unstable();
            missing.dedup();
            Some(missing)
        });
        let missing = missing.flatten().ok_or_else(no_font)?;
        if !missing.is_empty() {
            let shown: Vec<String> = missing.iter().take(LISTED).map(shown).collect();
            let more = if missing.len() > LISTED { ", …" } else { "" };
            let font = lettering.font.as_ref();
            let font = font.map_or("the built-in font".into(), |path| path.to_string_lossy());
            return Err(wrong(format!(
                "{font} has no {}{more}; leave them out, or name a font that has them",
                shown.join(", ")
            )));
        }

        let resolver = FontResolver {
            select_font: Box::new(move |_, _| Some(font)),
            select_fallback: Box::new(|_, _, _| None),
        };
        let drawing = Options {
            font_resolver: resolver,
            fontdb: fonts.into(),
            ..Options::default()
        };
        let tree = Tree::from_str(&svg(&lettering.text), &drawing).map_err(|error| {
            wrong(format!(
                "{error}; leave out characters that are not letters"
            ))
        })?;
        let [left, top, right, bottom] = ink(tree.root());
        let border = lettering.margin * LINE;
        let ink = [right - left, bottom - top];
        let size = ink.map(|side| side + 2.0 * border);
        // Without visible letters the box is infinite.
        if !ink.iter().all(|side| *side > 0.0 && side.is_finite()) {
            return Err(wrong("it has no visible letters; write some".to_string()));
        }
        let [width, height] = sides(size, options.raster);
        let path = lettering.font.as_deref().unwrap_or(Path::new(BUILT_IN));
        check_size(path, width, height, options.max_pixels)?;
        let scale = [f64::from(width) / size[0], f64::from(height) / size[1]];
        let transform = Transform::from_translate((border - left) as f32, (border - top) as f32)
            .post_scale(scale[0] as f32, scale[1] as f32);
        let picture = paint(&tree, [width, height], transform).map_err(wrong)?;
        Ok(Pattern::threshold(picture.into(), options))
    }
}

/// Returns left, top, right and bottom of all outlines. (The bounding box of a
/// text node has the height of the font's lines.)
fn ink(group: &Group) -> [f64; 4] {
    let mut sides = [f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY];
    for node in group.children() {
        let [left, top, right, bottom] = match node {
            Node::Group(group) => ink(group),
            Node::Text(text) => ink(text.flattened()),
            Node::Path(path) => {
                let bounds = path.abs_bounding_box();
                [bounds.left(), bounds.top(), bounds.right(), bounds.bottom()].map(f64::from)
            }
            Node::Image(_) => continue,
        };
        sides = [
            sides[0].min(left),
            sides[1].min(top),
            sides[2].max(right),
            sides[3].max(bottom),
        ];
    }
    sides
}

/// Formats a character for a message.
fn shown(c: &char) -> String {
    if c.is_control() {
        format!("U+{:04X}", u32::from(*c))
    } else {
        format!("{c:?} (U+{:04X})", u32::from(*c))
    }
}

/// Returns an SVG document with the lines of `text`, centred at x = 0.
fn svg(text: &str) -> String {
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='1' height='1' font-size='{SIZE}' text-anchor='middle'>"
    );
    for (line, text) in text.lines().enumerate() {
        let y = LINE * line as f64;
        svg += &format!("<text y='{y}' xml:space='preserve'>");
        for c in text.chars() {
            match c {
                '<' => svg += "&lt;",
                '&' => svg += "&amp;",
                c => svg.push(c),
            }
        }
        svg += "</text>";
    }
    svg + "</svg>"
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn write(text: &str, font: Option<&str>, margin: f64, raster: u32) -> Result<Pattern, String> {
        let font_bytes: [&[u8]; 2] = [epaint_default_fonts::UBUNTU_LIGHT, b"no font"];
        let files = ["f.ttf", "bad.ttf"].into_iter().zip(font_bytes);
        let files = Files::memory(files.map(|(name, bytes)| (name.into(), Arc::from(bytes))));
        let lettering = Lettering {
            text: text.to_string(),
            font: font.map(PathBuf::from),
            margin,
        };
        let options = PatternOptions {
            raster,
            ..PatternOptions::default()
        };
        Pattern::from_text(&lettering, &files, &options).map_err(|error| error.to_string())
    }

    #[test]
    fn the_pattern_has_the_shape_of_the_text() {
        let letters = write("HHH", None, 0.2, 256).unwrap();
        assert_eq!(letters.width(), 256);
        assert!(
            (90..200).contains(&letters.height()),
            "{}",
            letters.height()
        );
        let tall = write("H\nH\nH", None, 0.2, 256).unwrap();
        assert!(
            tall.height() == 256 && tall.width() < 100,
            "{}",
            tall.width()
        );
        // Without a margin letters reach each side; with one the border is free.
        let is_free = |pattern: &Pattern| {
            (0..pattern.width()).all(|x| !pattern.is_solid(x, 0))
                && (0..pattern.height()).all(|y| !pattern.is_solid(0, y))
        };
        assert!(is_free(&letters) && is_free(&tall));
        assert!(!is_free(&write("HHH", None, 0.0, 256).unwrap()));
        let share = |pattern: &Pattern| {
            let solid = pattern.solid().iter().filter(|solid| **solid).count();
            solid as f64 / pattern.solid().len() as f64
        };
        assert!((0.1..0.6).contains(&share(&letters)), "{}", share(&letters));
        // Another font, and what XML would take for its own.
        let other = write("HHH", Some("f.ttf"), 0.2, 256).unwrap();
        assert_ne!(other, letters);
        assert!(share(&write("<&>\"'", None, 0.0, 256).unwrap()) > 0.02);
    }

    #[test]
    fn what_cannot_be_written_is_told() {
        for (text, font, part) in [
            (
                "A漢字B漢",
                None,
                "the built-in font has no '字' (U+5B57), '漢'",
            ),
            ("A漢", Some("f.ttf"), "f.ttf has no"),
            ("A\tB\u{1}", None, "U+0001, U+0009"),
            ("\u{a0}", None, "no visible letters"),
            ("A", Some("bad.ttf"), "not a font"),
            ("A", Some("none.ttf"), "none.ttf"),
        ] {
            let error = write(text, font, 0.2, 64).unwrap_err();
            assert!(error.contains(part), "{text:?}: {error}");
        }
    }
}
