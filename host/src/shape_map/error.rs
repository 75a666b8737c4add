//! The error of this module.

use std::path::PathBuf;

/// What can go wrong between an image file and a shape map.
///
/// The message names the file and the way out; the cause below it, where there
/// is one, is given by [`source`](std::error::Error::source).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeMapError {
    /// The file cannot be opened or read.
    #[error("cannot read `{}`: check that the file exists and may be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },

    /// A folder was given in place of a file.
    #[error("`{}` is a folder: give an image file", path.display())]
    Directory {
        /// The folder.
        path: PathBuf,
    },

    /// The file is not an image, damaged, or of a format that is not supported.
    #[error(
        "cannot decode `{}` as an image: give an undamaged PNG, JPEG, BMP, GIF, TGA, TIFF, WebP, PNM, QOI or SVG file",
        path.display()
    )]
    DecodeImage {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        source: Box<image::ImageError>,
    },

    /// An SVG file cannot be drawn.
    #[error("cannot draw `{}`: {problem}", path.display())]
    Drawing {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what to do.
        problem: String,
    },

    /// Text cannot be drawn.
    #[error("cannot write the text {text:?}: {problem}")]
    Text {
        /// The text.
        text: String,
        /// What is wrong, and what to do.
        problem: String,
    },

    /// A file is not a font, or too large for one.
    #[error("`{}` is not a font: give a TrueType or OpenType file of at most 64 MiB", path.display())]
    Font {
        /// The file.
        path: PathBuf,
    },

    /// The image has more pixels than allowed.
    #[error(
        "`{}` has {width} × {height} pixels, more than the limit of {max_pixels} in all: scale the image down{}",
        path.display(),
        if *max_pixels < super::MAX_PIXELS { " or raise the limit (--max-pixels, --max-memory)" } else { "" }
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

    /// The file has more bytes than an image of the allowed size.
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

    /// A pattern was asked for in a size that cannot be made.
    #[error(
        "a pattern cannot have {width} × {height} pixels: use at least 1 × 1 and at most {} in all",
        super::MAX_PIXELS
    )]
    InvalidSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },

    /// A scale for the paper's form that leaves no distances.
    #[error("the scale {scale} cannot be used: give one above 0 and up to 1")]
    InvalidScale {
        /// The scale, f.
        scale: f32,
    },

    /// The file's name does not fit the form of the map.
    #[error(
        "cannot keep a shape map of the form {storage} in `{}`: give the file the extension .{} (r8, r16 and rgba8 are kept in .png files, r32f in .exr)",
        path.display(),
        storage.extension()
    )]
    WrongExtension {
        /// The file that was to be written.
        path: PathBuf,
        /// The form of the map.
        storage: super::Storage,
    },

    /// The shape map is neither a PNG nor an OpenEXR file, or damaged.
    #[error("cannot decode `{}` as a shape map: bake it again from its pattern", path.display())]
    DecodeShapeMap {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },

    /// An image without the description that a baked map carries.
    #[error("`{}` is an image but not a baked shape map: bake it, or load it as a pattern", path.display())]
    NotAShapeMap {
        /// The file.
        path: PathBuf,
    },

    /// A shape map whose description is wrong or does not match its pixels.
    #[error("`{}` is not a valid shape map ({reason}): bake it again from its pattern", path.display())]
    InvalidShapeMap {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}
