//! Arbitrary output variables (AOV): what each pixel hits, as one OpenEXR file.
//!
//! ```
//! use relievo::aov::save_exr;
//! use relievo::prepare::prepare;
//! use relievo::render::{CpuRenderer, Renderer};
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! image.size = [40, 30]
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let words = CpuRenderer::new(&prepared).geometry(&prepared.frame)?;
//! let folder = tempfile::tempdir().unwrap();
//! let view = prepared.view();
//! save_exr(&folder.path().join("aov.exr"), &words, &scene, &prepared, &view, None)?;
//! # Ok::<(), relievo::Error>(())
//! ```

use crate::Error;
use crate::file::write_bytes;
use crate::motion::Moment;
use crate::prepare::{PreparedScene, View};
use crate::render::{GeometryWords, Hit, Hits};
use crate::scene::Scene;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, WritableImage,
};
use std::path::Path;

/// Estimated bytes per pixel: eight words, the object, and four bytes per channel twice, since
/// the encoded file is held too.
pub const PIXEL_BYTES: u64 = 36 + 8 * CHANNELS.len() as u64;
/// Estimated bytes per pixel of motion vectors.
pub const MOTION_BYTES: u64 = 8 + 8 * MOTION.len() as u64;

/// Channels of motion vectors.
const MOTION: [&str; 2] = ["motion.x", "motion.y"];

/// A channel of the file.
struct Channel {
    name: &'static str,
    value: Value,
}

/// Value of a channel for a hit; a miss is 0.
enum Value {
    Float(fn(Hit<'_, '_>) -> f32),
    Integer(fn(Hit<'_, '_>) -> u32),
}

/// All channels; a new one is one line.
#[rustfmt::skip]
const CHANNELS: &[Channel] = &[
    Channel { name: "t", value: Value::Float(|hit| hit.t()) },
    Channel { name: "u", value: Value::Float(|hit| hit.uv()[0]) },
    Channel { name: "v", value: Value::Float(|hit| hit.uv()[1]) },
    Channel { name: "delta", value: Value::Float(|hit| hit.delta()) },
    Channel { name: "class", value: Value::Integer(|hit| hit.class().code()) },
    Channel { name: "N.x", value: Value::Float(|hit| hit.normal()[0]) },
    Channel { name: "N.y", value: Value::Float(|hit| hit.normal()[1]) },
    Channel { name: "N.z", value: Value::Float(|hit| hit.normal()[2]) },
    Channel { name: "object", value: Value::Integer(|hit| hit.prepared().map_or(0, |object| 1 + object.number as u32)) },
    Channel { name: "instance", value: Value::Integer(|hit| hit.prepared().map_or(0, |object| 1 + object.instance as u32)) },
];

/// Writes the picture `words` of `prepared` in `view` as OpenEXR, with
/// camera, scene and version in the metadata.
///
/// The channels are `t` (distance along the ray, world units), `u`, `v` (texture
/// coordinates within one repeat, v down), `delta` (depth fraction), `class` (0
/// miss, 1 cap, 2 wall, 3 bevel, 4 floor), `N.x`, `N.y`, `N.z` (unit normal,
/// world axes), `object` (its number in the scene, from 1) and `instance` (that of the
/// object, from 1). With the moment `before`, `motion.x` and `motion.y` are how many pixels to
/// the right and down the point has moved since then. All are 0 for a miss.
///
/// # Errors
/// [`Error::Write`] or [`Error::Encode`].
///
/// # Panics
/// If `words` and `view` differ in size.
pub fn save_exr(
    path: &Path,
    words: &GeometryWords,
    scene: &Scene,
    prepared: &PreparedScene,
    view: &View,
    before: Option<&Moment>,
) -> Result<(), Error> {
    let hits = Hits::new(prepared, &view.frame, words);
    let channels = CHANNELS.iter().map(|Channel { name, value }| {
        let samples = match value {
            Value::Float(value) => {
                let values = hits.pixels().map(|hit| hit.map_or(0.0, value));
                FlatSamples::F32(values.collect())
            }
            Value::Integer(value) => {
                let values = hits.pixels().map(|hit| hit.map_or(0, value));
                FlatSamples::U32(values.collect())
            }
        };
        AnyChannel::new(*name, samples)
    });
    let mut list: SmallVec<[AnyChannel<FlatSamples>; 4]> = channels.collect();
    if let Some(before) = before {
        let motion = before.motion(prepared);
        let vectors = hits.pixels().map(|hit| hit.map_or([0.0; 2], &motion));
        let vectors: Vec<[f32; 2]> = vectors.collect();
        for (axis, name) in MOTION.into_iter().enumerate() {
            let values = vectors.iter().map(|vector| vector[axis]);
            list.push(AnyChannel::new(name, FlatSamples::F32(values.collect())));
        }
    }

    let mut attributes = LayerAttributes::named("relievo");
    attributes.software_name = Some(Text::from(concat!("relievo ", env!("CARGO_PKG_VERSION"))));
    let camera = &view.camera;
    let vector = |v: [f64; 3]| AttributeValue::FloatVec3((v[0] as f32, v[1] as f32, v[2] as f32));
    attributes.other.extend([
        (Text::from("relievo.camera.eye"), vector(camera.eye)),
        (Text::from("relievo.camera.target"), vector(camera.target)),
        (Text::from("relievo.camera.up"), vector(camera.up)),
        (
            Text::from("relievo.camera.fov"),
            AttributeValue::F32(scene.field_of_view as f32),
        ),
        (
            Text::from("relievo.scene"),
            AttributeValue::Text(latin(&scene.text)),
        ),
    ]);
    let layer = Layer::new(
        (words.width as usize, words.height as usize),
        attributes,
        // In order: the same picture gives the same bytes.
        Encoding {
            line_order: LineOrder::Increasing,
            ..Encoding::FAST_LOSSLESS
        },
        AnyChannels::sort(list),
    );
    // Encoded in memory, since the encoder seeks and files are written whole.
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| Error::Encode {
            path: path.to_path_buf(),
            message: error.to_string(),
        })?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(write_bytes(path, &bytes)?)
}

/// Sorts the attributes in the header of a file of one part, so that the same picture gives the same
/// bytes: the encoder writes them in a random order.
fn sort_attributes(bytes: &mut [u8]) {
    /// Bytes of the magic number and of the version.
    const START: usize = 8;
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut rest = bytes.get(START..).unwrap_or_default();
    // Name and type, each with a 0 at its end; the length of the value; the value.
    while let [first, ..] = rest
        && *first != 0
    {
        let mut texts = rest.splitn(3, |byte| *byte == 0);
        let names: usize = texts.by_ref().take(2).map(|text| text.len() + 1).sum();
        let Some(length) = rest.get(names..).and_then(|rest| rest.first_chunk::<4>()) else {
            return;
        };
        let end = names + 4 + u32::from_le_bytes(*length) as usize;
        let Some((attribute, after)) = rest.split_at_checked(end) else {
            return;
        };
        attributes.push(attribute.to_vec());
        rest = after;
    }
    attributes.sort();
    let sorted = attributes.concat();
    bytes[START..START + sorted.len()].copy_from_slice(&sorted);
}

/// Converts to Latin-1, the encoding of OpenEXR text, with other characters as
/// `\u{…}`.
fn latin(text: &str) -> Text {
    Text::new_or_none(text).unwrap_or_else(|| {
        let escaped: String = text
            .chars()
            .flat_map(|c| {
                let plain = c.is_ascii().then_some(c);
                let escaped = (!c.is_ascii()).then(|| c.escape_unicode());
                plain.into_iter().chain(escaped.into_iter().flatten())
            })
            .collect();
        Text::from(escaped.as_str())
    })
}
