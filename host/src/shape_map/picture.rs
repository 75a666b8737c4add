//! Pictures of materials and environments: images, and OpenEXR.

use super::error::ShapeMapError;
use super::input::{Input, check_size, open_within};
use super::pattern::decode_image;
use crate::Files;
use exr::block::reader::Reader;
use exr::image::pixel_vec::PixelVec;
use exr::prelude::{ReadChannels, ReadLayers};
use image::error::{DecodingError, ImageFormatHint};
use image::{DynamicImage, ImageError, Rgba32FImage};
use std::io::BufRead;
use std::path::Path;

/// First bytes of an OpenEXR file.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Reads an image, or the colours of an OpenEXR file, of at most `max_pixels` pixels.
///
/// # Errors
/// As for [`Pattern::load`](super::Pattern::load).
pub(crate) fn load_picture(
    files: &Files,
    path: &Path,
    max_pixels: u64,
) -> Result<DynamicImage, ShapeMapError> {
    let mut input = open_within(files, path, max_pixels)?;
    let read_error = |source| ShapeMapError::Read {
        path: path.to_path_buf(),
        source,
    };
    let is_exr = input.fill_buf().map_err(read_error)?.starts_with(&EXR);
    if is_exr {
        decode_exr(&mut input, path, max_pixels)
    } else {
        decode_image(&mut input, path, max_pixels)
    }
}

fn decode_exr(
    input: &mut dyn Input,
    path: &Path,
    max_pixels: u64,
) -> Result<DynamicImage, ShapeMapError> {
    let decode_error = |source: exr::error::Error| ShapeMapError::DecodeImage {
        path: path.to_path_buf(),
        source: Box::new(ImageError::Decoding(DecodingError::new(
            ImageFormatHint::Name("OpenEXR".to_string()),
            source,
        ))),
    };
    let reader = Reader::read_from_buffered(input, false).map_err(decode_error)?;
    for header in reader.headers() {
        let [width, height] = [header.layer_size.x(), header.layer_size.y()];
        check_size(path, width as u32, height as u32, max_pixels)?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            PixelVec::<(f32, f32, f32, f32)>::constructor,
            PixelVec::set_pixel,
        )
        .first_valid_layer()
        .all_attributes()
        .from_chunks(reader)
        .map_err(decode_error)?;
    let pixels = image.layer_data.channel_data.pixels;
    let [width, height] = [pixels.resolution.x(), pixels.resolution.y()].map(|side| side as u32);
    let channels = pixels.pixels.into_iter();
    let channels = channels.flat_map(|(r, g, b, a)| [r, g, b, a]).collect();
    let image = Rgba32FImage::from_raw(width, height, channels);
    Ok(image.expect("four channels a pixel").into())
}
