//! Keys of objects and of their layers, which have some in common.

use super::instances::{FAR, SCALES};
use super::key::{Key, key};
use super::value::{Field, one_of};
use super::{Color, Instances, Layer, SceneObject, Search, Shape, Technique, Tier};
use crate::mesh::{MeshSource, Projection};
use crate::shape_map::{LARGEST_RASTER, SMALLEST_RASTER, Storage};

/// Largest number of steps of the linear search.
pub const LARGEST_STEPS: u32 = 65_536;
/// Range of error budgets, pixels.
pub const BUDGETS: (f64, f64) = (0.01, 100.0);
/// Range of tolerances, pixels.
pub const TOLERANCES: (f64, f64) = (1e-4, 16.0);

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
    ($owner:ty, "pieces") => {
        key!($owner, "pieces", pieces: Option<[u32; 2]>, "Keeps one part of the pattern's connected pieces, which are dealt at random: `[1, 3]` is the first of three parts. Layers of the other parts may differ in height, technique and material ([pieces](#pieces)).")
            .range(1.0, 64.0)
            .default("all pieces")
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
    carving_key!(SceneObject, "pieces"),
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
    carving_key!(Layer, "pieces"),
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

/// An object or a layer: a pattern, a technique and materials, under the same keys.
pub(super) trait Carving: Sized + 'static {
    /// Returns its keys.
    fn keys() -> &'static [Key<Self>];

    /// Returns the keys of its table `material`.
    fn material_keys() -> &'static [Key<Self>];

    /// Returns whether it may have this technique.
    fn allows(technique: Technique) -> bool;

    /// Returns its technique.
    fn carved_by(&self) -> Technique;

    /// Sets its technique, and what depends on it to its defaults.
    fn carve_by(&mut self, technique: Technique);

    /// Returns its pattern.
    fn shape(&self) -> &Shape;

    /// Returns which part of the pattern's pieces it keeps, of how many.
    fn pieces(&self) -> Option<[u32; 2]>;

    /// Sets its pattern.
    fn set_shape(&mut self, shape: Shape);
}

macro_rules! carving {
    ($owner:ty, $keys:ident, $material_keys:ident, $allows:expr) => {
        impl Carving for $owner {
            fn keys() -> &'static [Key<Self>] {
                $keys
            }
            fn material_keys() -> &'static [Key<Self>] {
                $material_keys
            }
            fn allows(technique: Technique) -> bool {
                $allows(technique)
            }
            fn carved_by(&self) -> Technique {
                self.technique()
            }
            fn carve_by(&mut self, technique: Technique) {
                self.set_technique(technique);
            }
            fn shape(&self) -> &Shape {
                &self.shape
            }
            fn pieces(&self) -> Option<[u32; 2]> {
                self.pieces
            }
            fn set_shape(&mut self, shape: Shape) {
                self.shape = shape;
            }
        }
    };
}

carving!(SceneObject, OBJECT, MATERIAL, |_| true);
carving!(Layer, LAYER, LAYER_MATERIAL, |technique: Technique| {
    technique.search() == Search::Extrusion
});
