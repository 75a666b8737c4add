//! Arbitrary output variables: what was hit, as one OpenEXR file.

use crate::Error;
use crate::file::write_bytes;
use crate::prepare::PreparedScene;
use crate::render::GeometryWords;
use crate::scene::Scene;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use std::path::Path;

/// Bytes that a pixel is estimated to take: as words, as channels, and encoded.
pub const PIXEL_BYTES: u64 = 96;

/// Writes the channels `t` (distance along the ray, world units), `u`, `v`
/// (texture coordinates within one repeat, v down), `delta` (depth fraction),
/// `class` (0 miss, 1 cap, 2 wall, 3 bevel, 4 floor) and `N.x`, `N.y`, `N.z`
/// (unit normal, world axes), all 0 where nothing was hit; camera, scene and
/// version in the metadata.
///
/// # Errors
/// [`Error::Write`] or [`Error::Encode`].
pub fn save_exr(
    path: &Path,
    words: &GeometryWords,
    scene: &Scene,
    prepared: &PreparedScene,
) -> Result<(), Error> {
    let float = |f: &dyn Fn(usize) -> u32| {
        FlatSamples::F32(
            (0..words.place.len())
                .map(|i| f32::from_bits(f(i)))
                .collect(),
        )
    };
    let channels = [
        ("t", float(&|i| words.place[i][0])),
        ("u", float(&|i| words.place[i][1])),
        ("v", float(&|i| words.place[i][2])),
        ("delta", float(&|i| words.place[i][3])),
        (
            "class",
            FlatSamples::U32((0..words.surface.len()).map(|i| words.class(i)).collect()),
        ),
        ("N.x", float(&|i| words.surface[i][1])),
        ("N.y", float(&|i| words.surface[i][2])),
        ("N.z", float(&|i| words.surface[i][3])),
    ];
    let list = channels
        .into_iter()
        .map(|(name, samples)| AnyChannel::new(name, samples))
        .collect();

    let mut attributes = LayerAttributes::named("relievo");
    attributes.software_name = Some(Text::from(concat!("relievo ", env!("CARGO_PKG_VERSION"))));
    let camera = &prepared.camera;
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
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(list),
    );
    // Rendered in memory first: the encoder seeks, and the file appears whole.
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| Error::Encode {
            path: path.to_path_buf(),
            message: error.to_string(),
        })?;
    write_bytes(path, bytes.get_ref())
}

/// OpenEXR text is Latin-1: other characters are written as `\u{…}`.
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
