//! What all image files that are read have in common: opening and size limits.
//! What is read after that is any source of bytes, a file or memory.

use super::ShapeMapError;
use crate::file::open_regular;
use std::fs::File;
use std::io::{BufRead, BufReader, Seek};
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
pub(super) fn open(path: &Path) -> Result<BufReader<File>, ShapeMapError> {
    let read_error = |source| ShapeMapError::Read {
        path: path.to_path_buf(),
        source,
    };
    // Asked first: some systems refuse to open a folder with a misleading reason.
    if std::fs::metadata(path).map_err(read_error)?.is_dir() {
        return Err(ShapeMapError::Directory {
            path: path.to_path_buf(),
        });
    }
    Ok(BufReader::new(open_regular(path).map_err(read_error)?))
}

/// As [`open`], but refuses a file with more bytes than any image of
/// `max_pixels` has: some decoders read all of it before they tell the size.
pub(super) fn open_within(path: &Path, max_pixels: u64) -> Result<BufReader<File>, ShapeMapError> {
    let read_error = |source| ShapeMapError::Read {
        path: path.to_path_buf(),
        source,
    };
    let input = open(path)?;
    let length = input.get_ref().metadata().map_err(read_error)?.len();
    let limit = decoded_bytes(max_pixels.min(MAX_PIXELS));
    if length > limit {
        return Err(ShapeMapError::FileTooLarge {
            path: path.to_path_buf(),
            length,
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
