//! Opens image files and checks size limits. Readers take any source of bytes.

use super::error::ShapeMapError;
use super::limits::MAX_PIXELS;
use crate::Files;
use crate::files::Opened;
use std::io::{BufRead, Read, Seek};
use std::path::Path;

/// The bytes of an image file. Readers take `&mut dyn Input`, so that the large decoders are
/// compiled for one type.
pub(super) trait Input: BufRead + Seek {}

impl<T: BufRead + Seek> Input for T {}

/// Opens a regular file for reading; folders, pipes and devices are errors.
pub(super) fn open(files: &Files, path: &Path) -> Result<Opened, ShapeMapError> {
    // Checked first, as the error of some systems is misleading.
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

/// Like [`open`], but refuses files with more bytes than any image of
/// `max_pixels`, since some decoders read the whole file before its size.
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

/// Returns the first `length` bytes of `input`, or all if there are fewer, and rewinds it. `path`
/// is named in errors only.
pub(super) fn beginning(
    input: &mut dyn Input,
    path: &Path,
    length: u64,
) -> Result<Vec<u8>, ShapeMapError> {
    let mut start = Vec::new();
    (&mut *input)
        .take(length)
        .read_to_end(&mut start)
        .and_then(|_| input.rewind())
        .map_err(|source| ShapeMapError::Read {
            path: path.to_path_buf(),
            source,
        })?;
    Ok(start)
}

/// Returns the memory limit for decoding, in bytes: 16 per pixel (four channels
/// of 32 bits), and 64 MiB for buffers.
pub(super) fn decoded_bytes(pixels: u64) -> u64 {
    16 * pixels + (64 << 20)
}

/// Checks that an image has at least one and at most `max_pixels` pixels
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
