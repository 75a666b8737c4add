//! Shape maps in PNG files: grayscale codes of 8 or 16 bits, or 8-bit RGBA.

use super::super::input::{Input, MAX_PIXELS, check_size};
use super::super::{ShapeMap, ShapeMapError, Storage};
use super::{KEYWORD, description, parse};
use crate::Error;
use png::{BitDepth, ColorType, EncodingError};
use std::io::Write;
use std::path::Path;

/// The pixels that hold a storage, if a PNG has such.
fn pixels(storage: Storage) -> Option<(ColorType, BitDepth)> {
    match storage {
        Storage::R8 => Some((ColorType::Grayscale, BitDepth::Eight)),
        Storage::R16 => Some((ColorType::Grayscale, BitDepth::Sixteen)),
        Storage::Rgba8 => Some((ColorType::Rgba, BitDepth::Eight)),
        Storage::R32F => None,
    }
}

/// Writes a map of 8, 16 or 4 × 8 bits.
pub(super) fn write(map: &ShapeMap, path: &Path, output: impl Write) -> Result<(), Error> {
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
    let (color, depth) = pixels(map.storage()).ok_or_else(|| ShapeMapError::WrongExtension {
        path: path.to_path_buf(),
        storage: map.storage(),
    })?;
    let mut encoder = png::Encoder::new(output, map.width(), map.height());
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder
        .add_text_chunk(KEYWORD.to_string(), description(map))
        .map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&texel_bytes(map)).map_err(failed)?;
    writer.finish().map_err(failed)
}

/// The texels in the order of a PNG.
fn texel_bytes(map: &ShapeMap) -> Vec<u8> {
    let bytes = map.storage().bits() as usize / 8;
    let count = map.width() as usize * map.height() as usize;
    let mut texels = Vec::with_capacity(count * bytes);
    for texel in (0..count).map(|index| map.texel_at(index)) {
        match map.storage() {
            // R comes first, and has the lowest bits.
            Storage::Rgba8 => texels.extend_from_slice(&texel.to_le_bytes()),
            _ => texels.extend_from_slice(&texel.to_be_bytes()[4 - bytes..]),
        }
    }
    texels
}

/// Reads a map of at most `max_pixels` texels; `path` is named in errors only.
pub(super) fn read(
    input: impl Input,
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
    let coding = parse(text).map_err(invalid)?;
    let (color, depth) = (reader.info().color_type, reader.info().bit_depth);
    if pixels(coding.storage) != Some((color, depth)) {
        return Err(invalid(format!(
            "{color:?} pixels of depth {depth:?} do not hold {}",
            coding.storage
        )));
    }
    // The size has been checked, so there always is a buffer size.
    let mut bytes = vec![0; reader.output_buffer_size().unwrap_or_default()];
    reader.next_frame(&mut bytes).map_err(decode_error)?;
    // Reads on to the end, so that a cut file is noticed.
    reader.finish().map_err(decode_error)?;
    match coding.storage {
        Storage::Rgba8 => {
            let (texels, _) = bytes.as_chunks::<4>();
            if let Some([.., alpha]) = texels.iter().find(|[.., a]| ![0, 255].contains(a)) {
                return Err(invalid(format!("an alpha of {alpha}, neither 0 nor 255")));
            }
            Ok(ShapeMap::pack(
                width,
                height,
                coding,
                texels,
                u32::from_le_bytes,
            ))
        }
        Storage::R16 => {
            let (texels, _) = bytes.as_chunks();
            Ok(ShapeMap::pack(width, height, coding, texels, |texel| {
                u16::from_be_bytes(texel).into()
            }))
        }
        Storage::R8 | Storage::R32F => Ok(ShapeMap::pack(width, height, coding, &bytes, u32::from)),
    }
}

/// Whether there is a description; a file that is no PNG has none.
pub(super) fn is_described(input: impl Input) -> bool {
    let reader = decoder(input).read_info();
    reader.is_ok_and(|reader| text(reader.info()).is_some())
}

fn decoder<R: Input>(input: R) -> png::Decoder<R> {
    // The limit is on what the decoder sets aside for chunks and for one row.
    let bytes = usize::try_from(4 * MAX_PIXELS + (64 << 20)).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(input, png::Limits { bytes });
    // A profile is compressed, and may inflate to all of that.
    decoder.set_ignore_iccp_chunk(true);
    decoder
}

fn text<'a>(info: &'a png::Info<'_>) -> Option<&'a str> {
    let chunks = &info.uncompressed_latin1_text;
    let chunk = chunks.iter().find(|chunk| chunk.keyword == KEYWORD)?;
    Some(&chunk.text)
}
