//! Shape maps in PNG files: grayscale codes of 8 or 16 bits, or 8-bit RGBA.

use super::super::error::ShapeMapError;
use super::super::input::{Input, check_size};
use super::super::limits::MAX_PIXELS;
use super::super::map::ShapeMap;
use super::super::storage::File;
use super::description::{KEYWORD, description, parse};
use crate::Error;
use png::{BitDepth, ColorType, EncodingError};
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;

/// Writes a map whose texels are pixels of `color` and `depth`.
pub(super) fn write(
    map: &ShapeMap,
    color: ColorType,
    depth: BitDepth,
    path: &Path,
    output: impl Write,
) -> Result<(), Error> {
    let failed = |error| match error {
        EncodingError::IoError(source) => Error::Write {
            path: path.to_path_buf(),
            source,
        },
        error => Error::Encode {
            path: path.to_path_buf(),
            message: error.to_string(),
        },
    };
    let mut encoder = png::Encoder::new(output, map.width(), map.height());
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder
        .add_text_chunk(KEYWORD.to_string(), description(map))
        .map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    writer
        .write_image_data(&texel_bytes(map, depth))
        .map_err(failed)?;
    writer.finish().map_err(failed)
}

/// Returns the texels in the byte order of a PNG. A word is four bytes there
/// too; samples of 16 bits are big-endian.
fn texel_bytes(map: &ShapeMap, depth: BitDepth) -> Vec<u8> {
    let words = map.words().iter();
    let mut bytes: Vec<u8> = words
        .flat_map(|word| swapped(word.to_le_bytes(), depth))
        .collect();
    let texels = map.width() as usize * map.height() as usize;
    bytes.truncate(texels * map.storage().bits() as usize / 8);
    bytes
}

/// Swaps the bytes of samples of 16 bits.
fn swapped([a, b, c, d]: [u8; 4], depth: BitDepth) -> [u8; 4] {
    match depth {
        BitDepth::Sixteen => [b, a, d, c],
        _ => [a, b, c, d],
    }
}

/// Reads a map of at most `max_pixels` texels; `path` is named in errors only.
pub(super) fn read(
    input: &mut dyn Input,
    path: &Path,
    max_pixels: u64,
) -> Result<ShapeMap, ShapeMapError> {
    let decode_error = |source: png::DecodingError| ShapeMapError::DecodeShapeMap {
        path: path.to_path_buf(),
        source: source.into(),
    };
    let invalid = |reason| ShapeMapError::InvalidShapeMap {
        path: path.to_path_buf(),
        reason,
    };
    let mut decoder = decoder(input);
    let header = decoder.read_header_info().map_err(decode_error)?;
    let (width, height) = (header.width, header.height);
    check_size(path, width, height, max_pixels)?;

    let mut reader = decoder.read_info().map_err(decode_error)?;
    let Some(text) = text(reader.info()) else {
        return Err(ShapeMapError::NotAShapeMap {
            path: path.to_path_buf(),
        });
    };
    let (storage, coding) = parse(text).map_err(invalid)?;
    let (color, depth) = (reader.info().color_type, reader.info().bit_depth);
    if storage.form().file != File::Png(color, depth) {
        return Err(invalid(format!(
            "{color:?} pixels of depth {depth:?} do not hold {storage}"
        )));
    }
    // The size has been checked, so the buffer size is known.
    let mut bytes = vec![0; reader.output_buffer_size().unwrap_or_default()];
    reader.next_frame(&mut bytes).map_err(decode_error)?;
    // Reads to the end to detect truncated files.
    reader.finish().map_err(decode_error)?;
    let words = bytes
        .par_chunks(4)
        .map(|bytes| {
            let mut word = [0; 4];
            word[..bytes.len()].copy_from_slice(bytes);
            u32::from_le_bytes(swapped(word, depth))
        })
        .collect();
    Ok(ShapeMap::new([width, height], storage, coding, words))
}

/// Returns whether the file is a PNG with a description.
pub(super) fn is_described(input: &mut dyn Input) -> bool {
    let reader = decoder(input).read_info();
    reader.is_ok_and(|reader| text(reader.info()).is_some())
}

fn decoder(input: &mut dyn Input) -> png::Decoder<&mut dyn Input> {
    // Limits the decoder's memory for chunks and one row.
    let bytes = usize::try_from(4 * MAX_PIXELS + (64 << 20)).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(input, png::Limits { bytes });
    // A compressed profile may inflate to the whole limit.
    decoder.set_ignore_iccp_chunk(true);
    decoder
}

fn text<'a>(info: &'a png::Info<'_>) -> Option<&'a str> {
    let chunks = &info.uncompressed_latin1_text;
    let chunk = chunks.iter().find(|chunk| chunk.keyword == KEYWORD)?;
    Some(&chunk.text)
}
