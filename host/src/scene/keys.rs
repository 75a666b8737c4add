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

use super::carving::Carving;
use super::instances::{FAR, SCALES};
use super::value::{Field, number, one_of};
use super::{
    Camera, Color, Coordinates, Environment, Instances, Interpolation, Layer, LightKind,
    LightSource, PhysicalMaterial, Scene, SceneObject, Search, Shape, Technique, Tier, Tone, Track,
};
use crate::mesh::{MeshSource, Projection};
use crate::shape_map::{LARGEST_RASTER, Lettering, SMALLEST_RASTER, Storage};
use std::path::PathBuf;
use toml::Value;

/// Largest width or height of a picture, pixels.
pub const LARGEST_PICTURE_SIDE: u32 = 16_384;
/// Largest number of steps of the linear search.
pub const LARGEST_STEPS: u32 = 65_536;
/// Range of error budgets, pixels.
pub const BUDGETS: (f64, f64) = (0.01, 100.0);
/// Range of tolerances, pixels.
pub const TOLERANCES: (f64, f64) = (1e-4, 16.0);

/// Range of frame rates, frames per second.
pub const FRAME_RATES: (f64, f64) = (1e-3, 1e3);

/// A key of scene files that sets a field of `T`.
pub struct Key<T: 'static> {
    /// Name, without that of the table.
    pub name: &'static str,
    /// Description, Markdown.
    pub doc: &'static str,
    /// Unit of the numbers; may be empty.
    pub unit: &'static str,
    /// Lowest and highest number allowed.
    pub range: Option<(f64, f64)>,
    /// Slider in the viewer.
    pub slider: Option<Slider>,
    /// Whether a file has to have the key.
    pub(super) is_required: bool,
    /// Whether the key is written even where it has its default.
    pub(super) is_always_written: bool,
    /// Whether an error budget chooses the value.
    pub(super) is_planned: bool,
    default: &'static str,
    applies: fn(&T) -> Result<(), &'static str>,
    kind: fn() -> String,
    get: fn(&T) -> Option<Value>,
    set: fn(&mut T, Option<&Value>) -> bool,
}

/// The slider of a key in the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slider {
    /// Label.
    pub label: &'static str,
    /// Lowest and highest value of the slider; more may be typed.
    pub range: (f64, f64),
    /// Whether the scale is logarithmic.
    pub is_logarithmic: bool,
}

/// Creates the entry of a field: the type that it belongs to, name of the key,
/// field, type of the field, description.
macro_rules! key {
    ($owner:ty, $name:literal, $($field:ident).+: $type:ty, $doc:literal) => {
        Key::<$owner>::new(
            $name,
            $doc,
            <$type>::kind,
            |owner| owner.$($field).+.to_toml(),
            |owner, value| match <$type>::from_toml(value) {
                Some(value) => {
                    owner.$($field).+ = value;
                    true
                }
                None => false,
            },
        )
    };
}

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

/// Creates the entry of a key that objects and layers have.
macro_rules! carving_key {
    ($owner:ty, "shape") => {
        key!($owner, "shape", shape: Shape, "PNG, JPEG, WebP, TIFF or other image, an SVG, a map made by `relievo bake`, or the table of a text or of a drawing (below). Dark pixels are extruded.")
            .required()
    };
    ($owner:ty, "technique") => {
        Key::<$owner>::new(
            "technique",
            "How geometry is made of the pattern ([techniques](#techniques)).",
            technique_kind::<$owner>,
            |owner| owner.technique().to_toml(),
            |owner, value| match Technique::from_toml(value) {
                Some(technique) if <$owner>::allows(technique) => {
                    owner.set_technique(technique);
                    true
                }
                _ => false,
            },
        )
        .default("the simplest with the parameters given")
    };
    ($owner:ty, "extension") => {
        key!($owner, "extension", extrusion.extension: f64, "Extension e: growth of the pattern at every depth.")
            .range(-1.0, 2.0)
            .unit("widths")
            .default("the technique's")
            .slider("Extension e", -0.2, 0.3)
    };
    ($owner:ty, "bevel") => {
        key!($owner, "bevel", extrusion.bevel: f64, "Bevel b: growth of the pattern per unit of depth, down to the chamfer's end.")
            .range(0.0, 10.0)
            .unit("widths/depth")
            .default("the technique's")
            .slider("Bevel b", 0.0, 0.5)
    };
    ($owner:ty, "chamfer") => {
        key!($owner, "chamfer", extrusion.chamfer: f64, "Chamfer c: part of the depth where the growth ends.")
            .range(0.0, 1.0)
            .unit("of the depth")
            .default("the technique's")
            .slider("Chamfer c", 0.0, 1.0)
    };
    ($owner:ty, "terraces") => {
        key!($owner, "terraces", extrusion.parts: u32, "Number of terraces.").range(1.0, 64.0).default("the technique's").slider("Terraces", 1.0, 16.0)
    };
    ($owner:ty, "threshold") => {
        key!($owner, "threshold", threshold: u8, "Luma below which a pixel is pattern.")
            .range(1.0, 255.0)
            .logarithmic_slider("Threshold", 1.0, 255.0)
    };
    ($owner:ty, "invert") => {
        key!($owner, "invert", invert: bool, "Makes the light pixels the pattern.")
    };
}

/// Keys of a table `[[object]]`. Those that change the defaults of others come
/// before them.
pub static OBJECT: &[Key<SceneObject>] = &[
    key!(SceneObject, "name", name: String, "Name in messages and in the viewer.")
        .default("the mesh file's"),
    key!(SceneObject, "mesh", mesh: MeshSource, "Wavefront OBJ, or glTF 2.0 (`.gltf`, `.glb`), also compressed by Draco or meshoptimizer: the triangles of its default scene.")
        .required(),
    key!(SceneObject, "parts", parts: Vec<String>, "Names of the materials of the mesh file (`usemtl` of OBJ, materials of glTF) whose triangles are drawn, so that each part of a mesh may have its own pattern ([parts](#parts)).")
        .default("all"),
    carving_key!(SceneObject, "shape"),
    key!(SceneObject, "raster", raster: Option<u32>, "Pixels of the longer side of a pattern that is an SVG or a text.")
        .range(SMALLEST_RASTER as f64, LARGEST_RASTER as f64)
        .default("512")
        .logarithmic_slider("Pixels of the longer side", SMALLEST_RASTER as f64, 4096.0),
    key!(SceneObject, "repeat", repeat: [f64; 2], "Repeats of the pattern along u and v.")
        .range(1e-3, 1e5)
        .slider("Repeats along", 1.0, 64.0),
    key!(SceneObject, "depth", depth: Option<f64>, "Depth of the floor below the surface; less where the mesh is too thin or too curved ([The carved object](object.md)).")
        .range(1e-9, 1e9)
        .unit("world units")
        .default("4 % of the mesh's diagonal"),
    carving_key!(SceneObject, "technique"),
    carving_key!(SceneObject, "extension"),
    carving_key!(SceneObject, "bevel"),
    carving_key!(SceneObject, "chamfer"),
    carving_key!(SceneObject, "terraces"),
    key!(SceneObject, "error_px", budget: Option<f64>, "[Error budget](index.md#error-budgets): the planner finds the cheapest tier, tolerance, slack, steps and map that keep it. Excludes their keys, and `relief`.")
        .range(BUDGETS.0, BUDGETS.1)
        .unit("px")
        .when(|object| match object.search {
            Search::Extrusion => Ok(()),
            Search::Relief => Err("cannot be kept by relief mapping; use another technique"),
        })
        .logarithmic_slider("Error", BUDGETS.0, BUDGETS.1),
    Key::new(
        "tier",
        "Model of the surface along a ray: `fast` bends the ray, `accurate` follows it through curved prisms without holes, `planar` does not bend it (no silhouettes), `paper` is the paper's algorithms as printed, mistakes included.",
        Tier::kind,
        |object: &SceneObject| object.tier.to_toml(),
        |object, value| match Tier::from_toml(value) {
            Some(tier) => {
                object.tier = tier;
                object.set_default_effort();
                true
            }
            None => false,
        },
    )
    .planned(),
    key!(SceneObject, "tolerance", tolerance: f64, "Largest distance between a ray and its approximation, in the accurate tier.")
        .range(TOLERANCES.0, TOLERANCES.1)
        .unit("px")
        .when(is_accurate)
        .planned()
        .logarithmic_slider("Tolerance", TOLERANCES.0, TOLERANCES.1),
    key!(SceneObject, "slack", slack: f64, "Distance before the hit at which a search may end: saves the last and smallest steps. Not for the tier `paper` and `relief`.")
        .range(0.0, 16.0)
        .unit("px")
        .when(|object| {
            if object.tier == Tier::Paper || object.search == Search::Relief {
                Err("has no meaning for the paper's search and for relief mapping; leave it out")
            } else {
                Ok(())
            }
        })
        .planned()
        .slider("Slack", 0.0, 4.0),
    key!(SceneObject, "steps", steps: u32, "Largest number of steps of the linear search.")
        .range(1.0, LARGEST_STEPS as f64)
        .default("96; 256 for `accurate`, 25 for `paper` and `relief`")
        .planned()
        .logarithmic_slider("Steps", 1.0, 4096.0),
    key!(SceneObject, "bisections", bisections: u32, "Largest number of bisections after it.")
        .range(0.0, 64.0)
        .default("8; 10 for `accurate`, 5 for `paper` and `relief`")
        .planned()
        .logarithmic_slider("Bisections", 0.0, 24.0),
    key!(SceneObject, "map_bits", map.storage: Storage, "Bits of a texel of the shape map that is made of a plain pattern.")
        .planned(),
    key!(SceneObject, "map_reduction", map.reduction: u32, "Pixels of the pattern along each side of a texel; a power of two.")
        .range(1.0, 4096.0)
        .planned(),
    key!(SceneObject, "raised", raised: bool, "Lets columns rise from the mesh, which is their floor; needs `depth`."),
    key!(SceneObject, "cut_out", cut_out: bool, "Leaves out the floor: only the columns remain."),
    key!(SceneObject, "self_shadow", self_shadow: bool, "Lets columns cast shadows on the object they stand on; shadow maps do so where a scene is lit physically."),
    key!(SceneObject, "projection", projection: Option<Projection>, "Texture coordinates in place of the mesh's own.")
        .default("the mesh's own"),
    key!(SceneObject, "crease_angle", crease_angle: f64, "Largest angle between two triangles whose edge is smooth, where the mesh has no normals.")
        .range(0.0, 180.0)
        .unit("°")
        .slider("Crease angle", 0.0, 180.0),
    carving_key!(SceneObject, "threshold"),
    carving_key!(SceneObject, "invert"),
    key!(SceneObject, "scale", scale: f64, "Uniform scale, before rotation.")
        .range(SCALES.0, SCALES.1)
        .logarithmic_slider("Scale", 0.01, 100.0),
    key!(SceneObject, "rotate", rotate: [f64; 3], "Rotation about x, then y, then z.")
        .range(-FAR, FAR)
        .unit("°")
        .slider("Rotation about", -180.0, 180.0),
    key!(SceneObject, "translate", translate: [f64; 3], "Translation, last.")
        .range(-FAR, FAR)
        .unit("world units"),
    key!(SceneObject, "instances", instances: Option<Instances>, "Copies of the object ([instances](#instances)): a list, a grid, or a CSV file.")
        .default("the object once"),
];

/// Keys of a table `[[object.layer]]`.
pub static LAYER: &[Key<Layer>] = &[
    carving_key!(Layer, "shape"),
    key!(Layer, "top", top: f64, "Depth of its caps, less than `bottom`; 0 is the surface.")
        .range(0.0, 1.0)
        .unit("of the depth"),
    key!(Layer, "bottom", bottom: f64, "Depth where it ends; 1 is the floor.")
        .range(0.0, 1.0)
        .unit("of the depth"),
    carving_key!(Layer, "technique"),
    carving_key!(Layer, "extension"),
    carving_key!(Layer, "bevel"),
    carving_key!(Layer, "chamfer"),
    carving_key!(Layer, "terraces"),
    carving_key!(Layer, "threshold"),
    carving_key!(Layer, "invert"),
];

/// Creates the entry of a part of an object or a layer: a colour, or the name of a material.
macro_rules! part_key {
    ($owner:ty, $name:literal, $part:ident, $doc:literal) => {
        Key::<$owner>::new(
            $name,
            $doc,
            || format!("{}, the name of a material, or \"@mesh\"", Color::kind()),
            |owner| match &owner.finish.$part {
                Some(name) => name.to_toml(),
                None => owner.material.$part.to_toml(),
            },
            |owner, value| {
                if let Some(color) = Color::from_toml(value) {
                    owner.material.$part = color;
                    owner.finish.$part = None;
                    return true;
                }
                let name = String::from_toml(value).filter(|name| !name.starts_with('#'));
                let is_name = name.is_some();
                owner.finish.$part = name.or(owner.finish.$part.take());
                is_name
            },
        )
        .range(0.0, 1.0)
    };
}

/// Creates the table of the parts of an object or a layer, and further entries.
macro_rules! part_keys {
    ($owner:ty $(, $more:expr)*) => {
        &[
            part_key!($owner, "cap", cap, "The mesh surface on the pattern: a colour, the name of a `[[material]]`, or `@mesh` for the materials of the mesh file ([parts](#parts))."),
            part_key!($owner, "wall", wall, "Upright walls, likewise."),
            part_key!($owner, "bevel", bevel, "Bevels and chamfers, likewise."),
            $($more),*
        ]
    };
}

/// Keys of the table `[object.material]`.
pub static MATERIAL: &[Key<SceneObject>] = part_keys!(
    SceneObject,
    part_key!(SceneObject, "floor", floor, "The floor between the columns, likewise."),
    key!(SceneObject, "specular", material.specular: f64, "Strength of the highlight of colours, in scenes that are not lit physically.")
        .range(0.0, 1.0)
        .slider("Highlight", 0.0, 1.0),
    key!(SceneObject, "shininess", material.shininess: u32, "Exponent of the highlight of a colour.")
        .range(1.0, 127.0)
        .logarithmic_slider("Shininess", 1.0, 127.0)
);

/// Keys of the table `[object.layer.material]`.
pub static LAYER_MATERIAL: &[Key<Layer>] = part_keys!(Layer);

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

/// Lists the techniques that `T` may have.
fn technique_kind<T: Carving>() -> String {
    let all = Technique::ALL
        .into_iter()
        .filter(|technique| T::allows(*technique));
    one_of(all.map(|technique| format!("{:?}", technique.name())))
}

/// Tolerance and clamping exist in the accurate tier.
fn is_accurate(object: &SceneObject) -> Result<(), &'static str> {
    match object.tier {
        Tier::Accurate => Ok(()),
        _ => Err("has no meaning in this tier; write tier = \"accurate\""),
    }
}

/// Returns the key of this name.
pub fn find<T>(keys: &'static [Key<T>], name: &str) -> Option<&'static Key<T>> {
    keys.iter().find(|key| key.name == name)
}

impl<T> Key<T> {
    const fn new(
        name: &'static str,
        doc: &'static str,
        kind: fn() -> String,
        get: fn(&T) -> Option<Value>,
        set: fn(&mut T, Option<&Value>) -> bool,
    ) -> Key<T> {
        Key {
            name,
            doc,
            unit: "",
            range: None,
            slider: None,
            is_required: false,
            is_always_written: false,
            is_planned: false,
            default: "",
            applies: |_| Ok(()),
            kind,
            get,
            set,
        }
    }

    /// Limits every number of the value.
    const fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Describes a default that is not the field's.
    const fn default(mut self, default: &'static str) -> Self {
        self.default = default;
        self
    }

    /// Makes the key an error where `applies` returns one.
    const fn when(mut self, applies: fn(&T) -> Result<(), &'static str>) -> Self {
        self.applies = applies;
        self
    }

    /// Marks a value that an error budget chooses.
    const fn planned(mut self) -> Self {
        self.is_planned = true;
        self
    }

    const fn required(mut self) -> Self {
        self.is_required = true;
        self.always_written()
    }

    /// Writes the key even where it has its default.
    const fn always_written(mut self) -> Self {
        self.is_always_written = true;
        self
    }

    const fn slider(mut self, label: &'static str, low: f64, high: f64) -> Self {
        self.slider = Some(Slider {
            label,
            range: (low, high),
            is_logarithmic: false,
        });
        self
    }

    const fn logarithmic_slider(mut self, label: &'static str, low: f64, high: f64) -> Self {
        self.slider = Some(Slider {
            label,
            range: (low, high),
            is_logarithmic: true,
        });
        self
    }

    /// Returns the default in words, Markdown.
    pub(super) fn default_text(&self, default: &T) -> String {
        if !self.default.is_empty() {
            return self.default.to_string();
        }
        (self.get)(default).map_or_else(String::new, |value| format!("`{value}`"))
    }

    /// Returns the type in words.
    pub(super) fn kind(&self) -> String {
        (self.kind)()
    }

    /// Returns the value of the field; `None` where a file leaves the key out.
    pub(super) fn get(&self, owner: &T) -> Option<Value> {
        (self.get)(owner)
    }

    /// Sets the field; returns `false` where the value has another type, and
    /// sets nothing.
    pub(super) fn set(&self, owner: &mut T, value: &Value) -> bool {
        (self.set)(owner, Some(value))
    }

    /// Copies the field of `from`.
    pub(super) fn copy(&self, owner: &mut T, from: &T) {
        (self.set)(owner, (self.get)(from).as_ref());
    }

    /// Returns an error where the key has no meaning for `owner`.
    pub(super) fn applies(&self, owner: &T) -> Result<(), &'static str> {
        (self.applies)(owner)
    }

    /// Returns whether numbers are whole.
    pub fn is_whole(&self) -> bool {
        self.kind() == u32::kind()
    }

    /// Returns the value, if it is a number.
    pub fn number(&self, owner: &T) -> Option<f64> {
        number(&self.get(owner)?)
    }

    /// Sets a number, rounded where whole numbers are expected; returns `false`
    /// where the key does not hold a number, or the number is out of range.
    pub fn set_number(&self, owner: &mut T, value: f64) -> bool {
        if self
            .range
            .is_some_and(|(low, high)| !(low..=high).contains(&value))
        {
            return false;
        }
        let value = match self.is_whole() {
            true => Value::Integer(value.round() as i64),
            false => Value::Float(value),
        };
        self.set(owner, &value)
    }

    /// Checks the numbers of a value.
    pub(super) fn check(&self, value: &Value) -> Result<(), String> {
        let Some((low, high)) = self.range else {
            return Ok(());
        };
        let is_in = |value: &Value| number(value).is_none_or(|x| (low..=high).contains(&x));
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let (low, high) = (bound(low), bound(high));
        match value {
            Value::Array(parts) if !parts.iter().all(is_in) => {
                let shown = shown(value);
                if low == format!("-{high}") {
                    Err(format!(
                        "is {shown}; its numbers are finite and at most {high}"
                    ))
                } else {
                    Err(format!(
                        "is {shown}; its numbers go from {low} to {high}{unit}"
                    ))
                }
            }
            Value::Array(_) => Ok(()),
            value if is_in(value) => Ok(()),
            value => Err(format!(
                "is {}; it goes from {low} to {high}{unit}",
                shown(value)
            )),
        }
    }

    /// Returns the problem with a value of the wrong type.
    pub(super) fn expected(&self, value: &Value) -> String {
        let range = match self.range {
            Some((low, high)) if self.is_number() => {
                format!(" from {} to {}", bound(low), bound(high))
            }
            _ => String::new(),
        };
        format!("is {}; expected {}{range}", shown(value), self.kind())
    }

    /// Returns whether the type is a single number.
    fn is_number(&self) -> bool {
        self.is_whole() || self.kind() == f64::kind()
    }
}

/// Formats a bound of a range.
pub(super) fn bound(x: f64) -> String {
    match x.abs() {
        y if y != 0.0 && !(1e-4..1e6).contains(&y) => format!("{x:e}"),
        _ => x.to_string(),
    }
}

/// Largest number of characters of a value in a message.
const SHOWN: usize = 80;

/// Formats a value for a message.
fn shown(value: &Value) -> String {
    match value {
        Value::Table(_) => "a table".to_string(),
        value => {
            let text = value.to_string();
            match text.char_indices().nth(SHOWN) {
                Some((end, _)) => format!("{}…", &text[..end]),
                None => text,
            }
        }
    }
}
