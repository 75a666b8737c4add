//! The error of patterns and shape maps.

use std::path::PathBuf;

/// An error of reading or writing patterns and shape maps.
///
/// The message names the file and the remedy;
/// [`source`](std::error::Error::source) is the cause, if there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeMapError {
    /// The file cannot be opened or read.
    #[error("cannot read `{}`: check that the file exists and may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason of the operating system.
        source: std::io::Error,
    },

    /// The path names a folder.
    #[error("`{}` is a folder: give an image file", path.display())]
    Directory {
        /// The folder.
        path: PathBuf,
    },

    /// The file is not an image, damaged, or in an unsupported format.
    #[error(
        "cannot decode `{}` as an image: give an undamaged PNG, JPEG, BMP, GIF, TGA, TIFF, WebP, PNM, QOI or SVG file",
        path.display()
    )]
    DecodeImage {
        /// The file.
        path: PathBuf,
        /// The reason of the decoder.
        source: Box<image::ImageError>,
    },

    /// An SVG file cannot be drawn.
    #[error("cannot draw `{}`: {problem}", path.display())]
    Drawing {
        /// The file.
        path: PathBuf,
        /// The problem and the remedy.
        problem: String,
    },

    /// Text cannot be drawn.
    #[error("cannot write the text {text:?}: {problem}")]
    Text {
        /// The text.
        text: String,
        /// The problem and the remedy.
        problem: String,
    },

    /// The file is not a font, or too large.
    #[error("`{}` is not a font: give a TrueType or OpenType file of at most 64 MiB", path.display())]
    Font {
        /// The file.
        path: PathBuf,
    },

    /// The image has more pixels than allowed.
    #[error(
        "`{}` has {width} × {height} pixels, more than the limit of {max_pixels} in all: scale the image down{}",
        path.display(),
        if *max_pixels < super::limits::MAX_PIXELS { " or raise the limit (--max-pixels, --max-memory)" } else { "" }
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// The largest number of pixels allowed.
        max_pixels: u64,
    },

    /// The file has more bytes than any image of the allowed size.
    #[error(
        "`{}` has {length} bytes, and the limit is {limit}: scale the image down or raise the limit (--max-pixels, --max-memory)",
        path.display()
    )]
    FileTooLarge {
        /// The file.
        path: PathBuf,
        /// Its length in bytes.
        length: u64,
        /// The largest number of bytes allowed.
        limit: u64,
    },

    /// The image has no pixels.
    #[error("`{}` has no pixels ({width} × {height}): give an image of at least 1 × 1", path.display())]
    EmptyImage {
        /// The file.
        path: PathBuf,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },

    /// The size of a pattern is out of range.
    #[error(
        "a pattern cannot have {width} × {height} pixels: use at least 1 × 1 and at most {} in all",
        super::limits::MAX_PIXELS
    )]
    InvalidSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },

    /// The number of pixels does not match the size of the pattern.
    #[error(
        "a pattern of {width} × {height} cannot have {count} pixels: give width · height values"
    )]
    PixelCount {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Number of pixels given.
        count: usize,
    },

    /// The scale of [`Encoding::rgba8`](super::Encoding::rgba8) is out of range.
    #[error("the scale {scale} is out of range: give one above 0 and up to 1")]
    InvalidScale {
        /// The scale, f.
        scale: f32,
    },

    /// The extension of the file does not fit the form of the map.
    #[error(
        "cannot save a shape map of the form {storage} in `{}`: give the file the extension .{extension}",
        path.display()
    )]
    WrongExtension {
        /// The file to be written.
        path: PathBuf,
        /// Name of the form of the map.
        storage: &'static str,
        /// The extension for this form.
        extension: &'static str,
    },

    /// The shape map is neither a PNG nor an OpenEXR file, or it is damaged.
    #[error("cannot decode `{}` as a shape map: bake it again from its pattern", path.display())]
    DecodeShapeMap {
        /// The file.
        path: PathBuf,
        /// The reason of the decoder.
        source: Box<dyn std::error::Error + Send + Sync>,
    },

    /// The image has no description, as baked maps have.
    #[error("`{}` is an image but not a baked shape map: bake it, or load it as a pattern", path.display())]
    NotAShapeMap {
        /// The file.
        path: PathBuf,
    },

    /// The description of the shape map is invalid or does not match its pixels.
    #[error("`{}` is not a valid shape map ({reason}): bake it again from its pattern", path.display())]
    InvalidShapeMap {
        /// The file.
        path: PathBuf,
        /// The problem.
        reason: String,
    },
}
