//! Writing scene files.

use super::file::default_name;
use super::{
    Color, DEFAULT_BACKGROUND, DEFAULT_FIELD_OF_VIEW, DEFAULT_THRESHOLD, DEFAULT_TOLERANCE,
    Lettering, Light, MapOptions, Material, Scene, SceneObject, Search, Shape, Tier,
};
use crate::files::{normal, relative};
use crate::shape_map::Storage;
use serde::{Serialize, Serializer};
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct SceneFile {
    image: ImageTable,
    camera: Option<CameraTable>,
    light: Option<LightTable>,
    object: Vec<ObjectTable>,
}

#[derive(Serialize)]
struct ImageTable {
    size: [u32; 2],
    supersample: Option<bool>,
    background: Option<Color>,
}

#[derive(Serialize, Default, PartialEq)]
struct CameraTable {
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov: Option<f64>,
}

#[derive(Serialize, Default, PartialEq)]
struct LightTable {
    direction: Option<[f64; 3]>,
    color: Option<Color>,
    intensity: Option<f64>,
    ambient: Option<Color>,
}

#[derive(Serialize)]
struct ObjectTable {
    name: Option<String>,
    mesh: String,
    shape: ShapeValue,
    raster: Option<u32>,
    repeat: Option<[f64; 2]>,
    depth: Option<f64>,
    technique: Option<&'static str>,
    extension: Option<f64>,
    bevel: Option<f64>,
    chamfer: Option<f64>,
    error_px: Option<f64>,
    tier: Option<&'static str>,
    tolerance: Option<f64>,
    clamp_depth: Option<bool>,
    slack: Option<f64>,
    steps: Option<u32>,
    bisections: Option<u32>,
    map_bits: Option<u32>,
    map_reduction: Option<u32>,
    cut_out: Option<bool>,
    self_shadow: Option<bool>,
    projection: Option<&'static str>,
    threshold: Option<u8>,
    invert: Option<bool>,
    scale: Option<f64>,
    rotate: Option<[f64; 3]>,
    translate: Option<[f64; 3]>,
    material: Option<MaterialTable>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ShapeValue {
    File(String),
    Text {
        text: String,
        font: Option<String>,
        margin: Option<f64>,
    },
}

#[derive(Serialize, Default, PartialEq)]
struct MaterialTable {
    cap: Option<Color>,
    wall: Option<Color>,
    bevel: Option<Color>,
    floor: Option<Color>,
    specular: Option<f64>,
    shininess: Option<u32>,
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [red, green, blue] = self.0.map(|channel| (channel * 255.0).round() as u32);
        let hex = red << 16 | green << 8 | blue;
        if Color::from_hex(hex) == *self {
            serializer.serialize_str(&format!("#{hex:06x}"))
        } else {
            self.0.serialize(serializer)
        }
    }
}

/// `value`, unless it is what a scene that says nothing means.
fn unless<T: PartialEq>(value: T, default: T) -> Option<T> {
    (value != default).then_some(value)
}

/// `table`, unless all its keys are left out.
fn filled<T: Default + PartialEq>(table: T) -> Option<T> {
    unless(table, T::default())
}

/// See [`Scene::to_toml`].
pub(super) fn to_toml(scene: &Scene, folder: &Path) -> String {
    let default = Light::default();
    let light = &scene.light;
    let file = SceneFile {
        image: ImageTable {
            size: scene.size,
            supersample: unless(scene.supersampling > 1, false),
            background: unless(scene.background, DEFAULT_BACKGROUND),
        },
        camera: filled(CameraTable {
            eye: scene.camera.map(|camera| camera.eye),
            target: scene.camera.map(|camera| camera.target),
            up: scene.camera.map(|camera| camera.up),
            fov: unless(scene.field_of_view, DEFAULT_FIELD_OF_VIEW),
        }),
        light: filled(LightTable {
            direction: unless(light.direction, default.direction),
            color: unless(light.color, default.color),
            intensity: unless(light.intensity, default.intensity),
            ambient: unless(light.ambient, default.ambient),
        }),
        object: scene
            .objects
            .iter()
            .map(|object| table(object, folder))
            .collect(),
    };
    toml::to_string(&file).expect("numbers, strings and tables of them become TOML")
}

fn table(object: &SceneObject, folder: &Path) -> ObjectTable {
    let technique = Technique::of(object);
    // A budget decides the rest of how an object is searched.
    let plain = object.budget.is_none();
    let is_accurate = plain && object.tier == Tier::Accurate;
    let has_slack = object.search == Search::Extrusion && object.tier != Tier::Paper;
    let (steps, bisections) = match object.search {
        Search::Relief => Tier::Paper.default_effort(),
        Search::Extrusion => object.tier.default_effort(),
    };
    let MapOptions { storage, reduction } = object.map;
    let bits = |storage| match storage {
        Storage::R8 => 8,
        Storage::R32F => 32,
        // The paper's form is made by baking only.
        Storage::R16 | Storage::Rgba8 => 16,
    };
    let default_map = MapOptions::default();
    ObjectTable {
        name: unless(object.name.clone(), default_name(&object.mesh)),
        mesh: name(&object.mesh, folder),
        shape: match &object.shape {
            Shape::File(path) => ShapeValue::File(name(path, folder)),
            Shape::Text(Lettering { text, font, margin }) => ShapeValue::Text {
                text: text.clone(),
                font: font.as_ref().map(|path| name(path, folder)),
                margin: unless(*margin, Lettering::DEFAULT_MARGIN),
            },
        },
        raster: object.raster,
        repeat: unless(object.repeat, [1.0; 2]),
        depth: object.depth,
        technique: technique.name,
        extension: technique.extension.then_some(object.extrusion.extension),
        bevel: technique.bevel.then_some(object.extrusion.bevel),
        chamfer: technique.chamfer.then_some(object.extrusion.chamfer),
        error_px: object.budget,
        tier: (plain && object.tier != Tier::Fast).then(|| object.tier.name()),
        tolerance: unless(object.tolerance, DEFAULT_TOLERANCE).filter(|_| is_accurate),
        clamp_depth: unless(object.clamp_depth, false).filter(|_| is_accurate),
        slack: unless(object.slack, 0.0).filter(|_| plain && has_slack),
        steps: unless(object.steps, steps).filter(|_| plain),
        bisections: unless(object.bisections, bisections).filter(|_| plain),
        map_bits: unless(bits(storage), bits(default_map.storage)).filter(|_| plain),
        map_reduction: unless(reduction, default_map.reduction).filter(|_| plain),
        cut_out: unless(object.cut_out, false),
        self_shadow: unless(object.self_shadow, false),
        projection: object.projection.map(|projection| projection.name()),
        threshold: unless(object.threshold, DEFAULT_THRESHOLD),
        invert: unless(object.invert, false),
        scale: unless(object.scale, 1.0),
        rotate: unless(object.rotate, [0.0; 3]),
        translate: unless(object.translate, [0.0; 3]),
        material: material(&object.material),
    }
}

fn material(given: &Material) -> Option<MaterialTable> {
    let default = Material::default();
    filled(MaterialTable {
        cap: unless(given.cap, default.cap),
        wall: unless(given.wall, default.wall),
        bevel: unless(given.bevel, default.bevel),
        floor: unless(given.floor, default.floor),
        specular: unless(given.specular, default.specular),
        shininess: unless(given.shininess, default.shininess),
    })
}

/// The technique that has an object's parameters, and which of them are written.
struct Technique {
    name: Option<&'static str>,
    extension: bool,
    bevel: bool,
    chamfer: bool,
}

impl Technique {
    fn of(object: &SceneObject) -> Technique {
        let extrusion = object.extrusion;
        let (name, count) = match object.search {
            Search::Relief => ("relief", 3),
            Search::Extrusion if extrusion.chamfer != 1.0 => ("chamfered", 3),
            Search::Extrusion if extrusion.bevel != 0.0 => ("beveled", 2),
            Search::Extrusion if extrusion.extension != 0.0 => ("outward", 1),
            Search::Extrusion => ("basic", 0),
        };
        Technique {
            name: (count > 0).then_some(name),
            extension: count > 0,
            bevel: count > 1,
            chamfer: count > 2,
        }
    }
}

/// How a scene file in `folder` names `path`, with `/` between folders.
fn name(path: &Path, folder: &Path) -> String {
    if let Ok(below) = path.strip_prefix(folder)
        && below.is_relative()
    {
        // As it is: a folder may be a link, and `..` lead elsewhere then.
        let parts = below.components().map(|part| part.as_os_str());
        let parts: Vec<_> = parts.map(|part| part.to_string_lossy()).collect();
        return parts.join("/");
    }
    let whole = |path: &Path| -> Option<PathBuf> {
        // From where the program runs there may be no way down to a folder.
        let path = std::path::absolute(path).ok()?;
        let root = path.components().next()?;
        Some(Path::new(root.as_os_str()).join(normal(&path)))
    };
    match (whole(folder), whole(path)) {
        (Some(folder), Some(path)) => relative(&folder, &path),
        // Without a disk every name starts at one root.
        _ => relative(
            &Path::new("/").join(normal(folder)),
            &Path::new("/").join(normal(path)),
        ),
    }
}

#[cfg(test)]
mod tests;
