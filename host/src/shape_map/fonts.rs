//! Fonts: the built-in one, and those in files.

use super::error::ShapeMapError;
use crate::Files;
use epaint_default_fonts::HACK_REGULAR;
use resvg::usvg::fontdb::Database;
use skrifa::FontRef;
use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::Path;

/// Name of the built-in font.
pub(super) const BUILT_IN: &str = "Hack";
/// Maximum size of a font file, in bytes.
const LARGEST_FONT: u64 = 64 << 20;

/// Adds the built-in font and selects it for every generic family.
pub(super) fn add_built_in(fonts: &mut Database) {
    fonts.load_font_data(HACK_REGULAR.to_vec());
    fonts.set_serif_family(BUILT_IN);
    fonts.set_sans_serif_family(BUILT_IN);
    fonts.set_monospace_family(BUILT_IN);
    fonts.set_cursive_family(BUILT_IN);
    fonts.set_fantasy_family(BUILT_IN);
}

/// Reads the bytes of the font at `path`; `None` is the built-in font.
///
/// # Errors
/// [`ShapeMapError::Font`], [`ShapeMapError::Read`].
pub(super) fn read_font<'a>(
    files: &'a Files,
    path: Option<&Path>,
) -> Result<Cow<'a, [u8]>, ShapeMapError> {
    let Some(path) = path else {
        return Ok(Cow::Borrowed(HACK_REGULAR));
    };
    let bytes = files.read(path, LARGEST_FONT).map_err(|source| {
        let path = path.to_path_buf();
        if source.kind() == ErrorKind::FileTooLarge {
            ShapeMapError::Font { path }
        } else {
            ShapeMapError::Read { path, source }
        }
    })?;
    // The font database only logs fonts that it cannot read.
    FontRef::from_index(&bytes, 0).map_err(|_| ShapeMapError::Font {
        path: path.to_path_buf(),
    })?;
    Ok(bytes)
}
