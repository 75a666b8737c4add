//! The table of scene keys. Reading, writing and checking of scenes, the
//! viewer's sliders and the reference page (docs/scene.md) follow from it: a new
//! key is one entry here, and the field that it sets.
//!
//! ```
//! use relievo::scene::{SceneObject, keys};
//!
//! let key = keys::find(keys::OBJECT, "tolerance").unwrap();
//! assert_eq!(key.range, Some((1e-4, 16.0)));
//! let mut object = SceneObject::default();
//! assert!(key.set_number(&mut object, 0.5));
//! assert_eq!(object.tolerance, 0.5);
//! ```

use super::instances::FAR;
use super::key::key;
pub use super::key::{Key, Slider, find};
pub use super::object_keys::{
    BUDGETS, LARGEST_STEPS, LAYER, LAYER_MATERIAL, MATERIAL, OBJECT, TOLERANCES,
};
use super::value::Field;
use super::{
    Camera, Color, Coordinates, Environment, Interpolation, LightKind, LightSource,
    PhysicalMaterial, Scene, Shape, Tone, Track,
};
use crate::shape_map::Lettering;
use std::path::PathBuf;

/// Largest width or height of a picture, pixels.
pub const LARGEST_PICTURE_SIDE: u32 = 16_384;

/// Range of frame rates, frames per second.
pub const FRAME_RATES: (f64, f64) = (1e-3, 1e3);

/// Creates the entry of a field of the camera, which a scene may lack.
macro_rules! camera_key {
    ($name:literal, $field:ident, $doc:literal) => {
        Key::<Scene>::new(
            $name,
            $doc,
            <[f64; 3]>::kind,
            |scene| scene.camera.and_then(|camera| camera.$field.to_toml()),
            |scene, value| match <[f64; 3]>::from_toml(value) {
                Some(value) => {
                    let camera = scene.camera.get_or_insert(Camera::new([0.0; 3], [0.0; 3]));
                    camera.$field = value;
                    true
                }
                None => false,
            },
        )
        .range(-FAR, FAR)
        .unit("world units")
    };
}

/// Keys of the table `[image]`.
pub static IMAGE: &[Key<Scene>] = &[
    key!(Scene, "size", size: [u32; 2], "Width and height of the picture.")
        .range(1.0, LARGEST_PICTURE_SIDE as f64)
        .unit("pixels")
        .always_written(),
    Key::new(
        "supersample",
        "Draws four samples a pixel.",
        bool::kind,
        |scene: &Scene| (scene.supersampling > 1).to_toml(),
        |scene, value| match bool::from_toml(value) {
            Some(is_on) => {
                scene.supersampling = if is_on { 2 } else { 1 };
                true
            }
            None => false,
        },
    ),
    key!(Scene, "smooth_edges", smooth_edges: bool, "Blends pixels at edges with their neighbours, in a scene with materials, lights or an environment: better edges at one sample a pixel, and with `supersample` still better."),
    key!(Scene, "background", background: Color, "Colour where no object is.").range(0.0, 1.0),
    key!(Scene, "transparent", development.is_transparent: bool, "Makes the background transparent, for compositing."),
    key!(Scene, "exposure", development.exposure: f64, "Exposure: each stop doubles the light of the objects.")
        .range(-32.0, 32.0)
        .unit("stops")
        .slider("Exposure", -4.0, 4.0),
    key!(Scene, "tone", development.tone: Tone, "Tone curve of the objects: `agx` lets bright light fade to white, `clip` cuts it off."),
    key!(Scene, "frame_rate", frame_rate: f64, "Frames per second of a sequence ([animation](#animation)).")
        .range(FRAME_RATES.0, FRAME_RATES.1)
        .unit("1/s"),
];

/// Keys of the table `[camera]`.
pub static CAMERA: &[Key<Scene>] = &[
    camera_key!(
        "eye",
        eye,
        "Position of the eye. Without it, the whole scene is shown from its front, right and above."
    ),
    camera_key!(
        "target",
        target,
        "Point in the centre of the picture; needs `eye`."
    )
    .default("`[0, 0, 0]`"),
    camera_key!("up", up, "Up direction, not along the view; needs `eye`.")
        .default("`[0, 1, 0]`")
        .unit(""),
    key!(Scene, "orbit", orbit: f64, "Angle by which the eye is turned around the target about the up direction.")
        .range(-FAR, FAR)
        .unit("°"),
    key!(Scene, "fov", field_of_view: f64, "Vertical field of view.")
        .range(0.01, 179.0)
        .unit("°")
        .slider("Field of view", 5.0, 120.0),
];

/// Keys of the table `[light]`.
pub static LIGHT: &[Key<Scene>] = &[
    key!(Scene, "direction", light.direction: [f64; 3], "Direction towards the light, of any length but zero.").range(-FAR, FAR),
    key!(Scene, "color", light.color: Color, "Colour of the directional light.").range(0.0, 1.0),
    key!(Scene, "intensity", light.intensity: f64, "Factor of the directional light.")
        .range(0.0, 1000.0)
        .slider("Intensity", 0.0, 4.0),
    key!(Scene, "ambient", light.ambient: Color, "Colour of the ambient light.").range(0.0, 1.0),
];

/// Keys of a table `[[light]]`.
pub static LIGHTS: &[Key<LightSource>] = &[
    key!(LightSource, "name", name: String, "Name, for tracks: `light.NAME.intensity` ([animation](#animation))."),
    key!(LightSource, "type", kind: LightKind, "What kind of light."),
    key!(LightSource, "color", color: Color, "Its colour.").range(0.0, 1.0),
    key!(LightSource, "intensity", intensity: f64, "Brightness of a white matte surface that faces it; of a point or spot light, at a distance of 1 world unit.")
        .range(0.0, 1e9),
    key!(LightSource, "direction", direction: [f64; 3], "Direction towards a directional light, of any length but zero.").range(-FAR, FAR),
    key!(LightSource, "position", position: [f64; 3], "Position of a point or spot light.")
        .range(-FAR, FAR)
        .unit("world units"),
    key!(LightSource, "target", target: [f64; 3], "Point that a spot light shines at.")
        .range(-FAR, FAR)
        .unit("world units"),
    key!(LightSource, "range", range: Option<f64>, "Distance beyond which a point or spot light is dark.")
        .range(1e-3, 1e9)
        .unit("world units")
        .default("without end"),
    key!(LightSource, "inner_angle", inner_angle: f64, "Angle from the axis of a spot light within which it is as bright as on the axis.")
        .range(0.0, 89.0)
        .unit("°"),
    key!(LightSource, "outer_angle", outer_angle: f64, "Angle from the axis outside of which it is dark.")
        .range(0.1, 89.0)
        .unit("°"),
    key!(LightSource, "shadows", casts_shadows: bool, "Lets all objects cast shadows on all objects."),
    key!(LightSource, "shadow_size", shadow_size: u32, "Width and height of its shadow map, a multiple of 64; a point light has six.")
        .range(64.0, 8192.0)
        .unit("texels"),
];

/// Keys of the table `[environment]`.
pub static ENVIRONMENT: &[Key<Environment>] = &[
    key!(Environment, "image", image: Option<PathBuf>, "Picture of all directions, OpenEXR (`.exr`), Radiance (`.hdr`) or any other image: longitude along its width, with −z in the middle and +x right of it, latitude along its height.")
        .default("even light"),
    key!(Environment, "color", color: Color, "Factor of its light.").range(0.0, 1.0),
    key!(Environment, "intensity", intensity: f64, "Factor of its light.").range(0.0, 1e6),
    key!(Environment, "turn", turn: f64, "Angle by which the picture is turned about the y axis, counter-clockwise seen from above.")
        .range(-FAR, FAR)
        .unit("°"),
    key!(Environment, "occlusion", occlusion: f64, "How much carvings keep its light from their grounds and walls: 1 as the distance map says, 0 not at all.").range(0.0, 1.0),
    key!(Environment, "visible", is_visible: bool, "Shows it where no object is, in place of the background, exposed as the objects are."),
];

/// Keys of a table `[[material]]`.
pub static MATERIALS: &[Key<PhysicalMaterial>] = &[
    key!(PhysicalMaterial, "name", name: String, "Name by which objects name it; it does not begin with `#` or `@`.").required(),
    key!(PhysicalMaterial, "base_color", base_color: Color, "Colour of a dielectric, or what a metal reflects.").range(0.0, 1.0),
    key!(PhysicalMaterial, "metallic", metallic: f64, "0 for a dielectric, 1 for a metal.").range(0.0, 1.0),
    key!(PhysicalMaterial, "roughness", roughness: f64, "Perceptual roughness: 0 for a mirror, 1 for chalk.").range(0.0, 1.0),
    key!(PhysicalMaterial, "emission", emission: Color, "Colour of the light that it sends out.").range(0.0, 1.0),
    key!(PhysicalMaterial, "emission_strength", emission_strength: f64, "Factor of that light.").range(0.0, 1e6),
    key!(PhysicalMaterial, "base_color_image", base_color_image: Option<PathBuf>, "Picture of factors of the base colour.").default("none"),
    key!(PhysicalMaterial, "metallic_roughness_image", metallic_roughness_image: Option<PathBuf>, "Picture of factors of roughness (green) and metallic (blue).").default("none"),
    key!(PhysicalMaterial, "normal_image", normal_image: Option<PathBuf>, "Picture of normals; green points up.").default("none"),
    key!(PhysicalMaterial, "normal_scale", normal_scale: f64, "Factor of the slopes of that picture.").range(-10.0, 10.0),
    key!(PhysicalMaterial, "emission_image", emission_image: Option<PathBuf>, "Picture of factors of the emission.").default("none"),
    key!(PhysicalMaterial, "coordinates", coordinates: Coordinates, "What pictures follow: the repeats of the pattern, or the texture coordinates of the mesh. On walls and bevels they follow the outline and the depth, or with `mesh-everywhere` the mesh, as pictures of an unwrapped mesh have to."),
    key!(PhysicalMaterial, "tiles", tiles: [f64; 2], "Repeats of the pictures per repeat of the pattern, or of the mesh's coordinates.").range(1e-4, 1e4),
    key!(PhysicalMaterial, "shade_variation", shade_variation: f64, "Largest change of the base colour from cell to cell of the pattern: each connected piece, such as a brick, is one.")
        .range(0.0, 1.0)
        .unit("of the colour"),
    key!(PhysicalMaterial, "shift_pictures", shifts: bool, "Shifts the pictures from cell to cell."),
    key!(PhysicalMaterial, "turn_pictures", turns: bool, "Turns the pictures by quarters from cell to cell."),
];

/// Keys of the table `shape` of an object whose pattern is a text.
pub static TEXT: &[Key<Lettering>] = &[
    key!(Lettering, "text", text: String, "The text, with `\\n` between lines.").required(),
    key!(Lettering, "font", font: Option<PathBuf>, "Font file.").default("built in"),
    key!(Lettering, "margin", margin: f64, "Free margin on each side.")
        .range(0.0, 10.0)
        .unit("line heights"),
];

/// Keys of the table `shape` of an object whose pattern is a drawing in the scene file itself.
pub static DRAWING: &[Key<Shape>] = &[Key::new(
    "svg",
    "The text of an SVG document.",
    String::kind,
    |shape: &Shape| match shape {
        Shape::Drawing(document) => document.to_string().to_toml(),
        _ => None,
    },
    |shape, value| match String::from_toml(value) {
        Some(document) => {
            *shape = Shape::svg(&document);
            true
        }
        None => false,
    },
)
.required()];

/// Keys of a table `[[animate]]`.
pub static TRACK: &[Key<Track>] = &[
    key!(Track, "key", key: String, "The key whose value changes, with its table: `camera.eye`, `light.intensity`, `object.NAME.depth`, `object.NAME.material.cap`, `light.NAME.intensity`, `environment.turn`, `material.NAME.roughness`.")
        .required(),
    key!(Track, "times", times: Vec<f64>, "Times of the key frames, each later than the one before.")
        .unit("s")
        .required(),
    key!(Track, "values", values: Vec<Vec<f64>>, "The values at these times.").required(),
    key!(Track, "interpolation", interpolation: Interpolation, "What is between two key frames: a line, a smooth curve through all of them, or the value of the earlier one."),
];
