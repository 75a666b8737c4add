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
        "cannot decode `{}` as an image: give an undamaged PNG, JPEG, BMP, GIF, TGA, TIFF, WebP, PNM or QOI file",
        path.display()
    )]
    DecodeImage {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        source: Box<image::ImageError>,
    },

    /// The image has more pixels than allowed.
    #[error(
        "`{}` has {width} × {height} pixels, more than the limit of {max_pixels} in all: scale the image down{}",
        path.display(),
        if *max_pixels < super::MAX_PIXELS { " or raise the limit" } else { "" }
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

    /// The storage has no place in a PNG.
    #[error("cannot write `{}`: a PNG holds at most 16 bits per texel, so bake with 16-bit storage", path.display())]
    StorageNotInPng {
        /// The file that was to be written.
        path: PathBuf,
    },

    /// The file cannot be written.
    #[error("cannot write `{}`: check that its folder exists, may be written and has space", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },

    /// The shape map is not a PNG, or damaged.
    #[error("cannot decode `{}` as a shape map PNG: bake it again from its pattern", path.display())]
    DecodeShapeMap {
        /// The file.
        path: PathBuf,
        /// The decoder's reason.
        source: png::DecodingError,
    },

    /// A PNG without the description that a baked map carries.
    #[error("`{}` is a PNG but not a baked shape map: bake it, or load it as a pattern", path.display())]
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
