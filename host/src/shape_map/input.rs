//! What all image files that are read have in common: opening and size limits.
//! What is read after that is any source of bytes, a file or memory.

use super::ShapeMapError;
use crate::Files;
use crate::files::Opened;
use std::io::{BufRead, Seek};
use std::path::Path;

/// The bytes of an image file.
pub(super) trait Input: BufRead + Seek {}

impl<T: BufRead + Seek> Input for T {}

/// The number of pixels above which an image is refused unless the caller
/// raises the limit: 2²⁸, a square of 16,384.
pub const DEFAULT_MAX_PIXELS: u64 = 1 << 28;

/// The number of pixels that no limit can be raised above: 2³⁰. Up to here
/// squared distances fit the integers used, and byte offsets fit 32 bits.
pub const MAX_PIXELS: u64 = 1 << 30;

/// Opens a file for reading and tells a folder, a pipe and a device from a file.
pub(super) fn open(files: &Files, path: &Path) -> Result<Opened, ShapeMapError> {
    // Asked first: some systems refuse to open a folder with a misleading reason.
    if files.is_folder(path) {
        return Err(ShapeMapError::Directory {
            path: path.to_path_buf(),
        });
    }
    files.open(path).map_err(|source| ShapeMapError::Read {
        path: path.to_path_buf(),
        source,
    })
}

/// As [`open`], but refuses a file with more bytes than any image of
/// `max_pixels` has: some decoders read all of it before they tell the size.
pub(super) fn open_within(
    files: &Files,
    path: &Path,
    max_pixels: u64,
) -> Result<Opened, ShapeMapError> {
    let input = open(files, path)?;
    let limit = decoded_bytes(max_pixels.min(MAX_PIXELS));
    if input.length > limit {
        return Err(ShapeMapError::FileTooLarge {
            path: path.to_path_buf(),
            length: input.length,
            limit,
        });
    }
    Ok(input)
}

/// Bytes that an image may take while it is decoded: four channels of 32 bits
/// are the largest pixel, and the rest is for buffers.
pub(super) fn decoded_bytes(pixels: u64) -> u64 {
    16 * pixels + (64 << 20)
}

/// Refuses an image without pixels or with more than `max_pixels` of them
/// ([`MAX_PIXELS`] at most).
pub(super) fn check_size(
    path: &Path,
    width: u32,
    height: u32,
    max_pixels: u64,
) -> Result<(), ShapeMapError> {
    let pixels = u64::from(width) * u64::from(height);
    let max_pixels = max_pixels.min(MAX_PIXELS);
    if pixels == 0 {
        return Err(ShapeMapError::EmptyImage {
            path: path.to_path_buf(),
            width,
            height,
        });
    }
    if pixels > max_pixels {
        return Err(ShapeMapError::TooLarge {
            path: path.to_path_buf(),
            width,
            height,
            max_pixels,
        });
    }
    Ok(())
}
