//! Shape maps in OpenEXR files: one channel of 32-bit floats.

use super::super::error::ShapeMapError;
use super::super::input::{Input, check_size};
use super::super::map::ShapeMap;
use super::super::storage::File;
use super::description::{KEYWORD, description, parse};
use crate::Error;
use exr::block::reader::Reader;
use exr::meta::attribute::{AttributeValue, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels,
    ReadLayers, Vec2, WritableImage,
};
use std::io::{Seek, Write};
use std::path::Path;

/// Name of the only channel. Unit: texels.
const CHANNEL: &str = "distance";
const NOT_THE_CHANNEL: &str = "not one channel \"distance\" of 32-bit floats";

/// Writes a map of floats, ZIP compressed (without loss).
pub(super) fn write(map: &ShapeMap, path: &Path, output: impl Write + Seek) -> Result<(), Error> {
    let distances = map.words().iter().map(|&word| f32::from_bits(word));
    let channel = AnyChannel::new(CHANNEL, FlatSamples::F32(distances.collect()));
    let mut attributes = LayerAttributes::named("relievo");
    attributes.other.insert(
        Text::from(KEYWORD),
        AttributeValue::Text(Text::from(description(map).as_str())),
    );
    let layer = Layer::new(
        (map.width() as usize, map.height() as usize),
        attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort([channel].into_iter().collect()),
    );
    Image::from_layer(layer)
        .write()
        .to_buffered(output)
        .map_err(|error| match error {
            exr::error::Error::Io(source) => Error::Write {
                path: path.to_path_buf(),
                source,
            },
            error => Error::Encode {
                path: path.to_path_buf(),
                message: error.to_string(),
            },
        })
}

/// Reads a map of at most `max_pixels` texels; `path` is named in errors only.
pub(super) fn read(
    input: &mut dyn Input,
    path: &Path,
    max_pixels: u64,
) -> Result<ShapeMap, ShapeMapError> {
    let decode_error = |source: exr::error::Error| ShapeMapError::DecodeShapeMap {
        path: path.to_path_buf(),
        source: source.into(),
    };
    let invalid = |reason| ShapeMapError::InvalidShapeMap {
        path: path.to_path_buf(),
        reason,
    };
    // Reads the headers only.
    let reader = Reader::read_from_buffered(input, false).map_err(decode_error)?;
    let [header] = reader.headers() else {
        return Err(invalid(format!("{} layers", reader.headers().len())));
    };
    // OpenEXR's own limit on sizes is below 2³¹.
    let [width, height] = [header.layer_size.x(), header.layer_size.y()].map(|side| side as u32);
    check_size(path, width, height, max_pixels)?;
    let Some(text) = text(header) else {
        return Err(ShapeMapError::NotAShapeMap {
            path: path.to_path_buf(),
        });
    };
    let (storage, coding) = parse(&text).map_err(invalid)?;
    if storage.form().file != File::Exr {
        return Err(invalid(format!("an OpenEXR file does not hold {storage}")));
    }
    check_header(header).map_err(|reason| invalid(reason.to_string()))?;

    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_chunks(reader)
        .map_err(decode_error)?;
    let [channel] = &image.layer_data.channel_data.list[..] else {
        return Err(invalid(NOT_THE_CHANNEL.to_string()));
    };
    let FlatSamples::F32(distances) = &channel.sample_data else {
        return Err(invalid(NOT_THE_CHANNEL.to_string()));
    };
    let words = distances
        .iter()
        .map(|distance| distance.to_bits())
        .collect();
    Ok(ShapeMap::new([width, height], storage, coding, words))
}

/// Returns whether the file is an OpenEXR file with a description.
pub(super) fn is_described(input: &mut dyn Input) -> bool {
    let reader = Reader::read_from_buffered(input, false);
    reader.is_ok_and(|reader| matches!(reader.headers(), [header] if text(header).is_some()))
}

/// Checks that the pixels are as [`write`] makes them; any lossless compression
/// is accepted.
fn check_header(header: &Header) -> Result<(), &'static str> {
    let [channel] = &header.channels.list[..] else {
        return Err(NOT_THE_CHANNEL);
    };
    if channel.name.to_string() != CHANNEL
        || channel.sample_type != SampleType::F32
        || channel.sampling != Vec2(1, 1)
    {
        return Err(NOT_THE_CHANNEL);
    }
    if header.deep || header.blocks.has_tiles() {
        return Err("not in scan lines");
    }
    if !header.compression.is_lossless_for(SampleType::F32) {
        return Err("compressed with loss");
    }
    Ok(())
}

fn text(header: &Header) -> Option<String> {
    match header.own_attributes.other.get(&Text::from(KEYWORD)) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    }
}
