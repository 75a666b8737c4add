//! Presets: what makes bricks, an engraving or a perforated sheet of an object. They are
//! the objects of `presets.toml`.

use super::patterns::DRAWINGS;
use relievo::mesh::Mesh;
use relievo::scene::{Scene, SceneObject, Shape};
use relievo::{Files, Limits};
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// The objects, as a scene file.
const TABLE: &str = include_str!("presets.toml");
/// The mesh that they name.
const MESH: &str = "mesh";

/// Returns the presets; their names are for the user.
pub fn presets() -> &'static [SceneObject] {
    static PRESETS: OnceLock<Vec<SceneObject>> = OnceLock::new();
    PRESETS.get_or_init(|| read().expect("a test reads the table"))
}

fn read() -> Result<Vec<SceneObject>, relievo::scene::SceneError> {
    let drawings = DRAWINGS.map(|(name, document)| (format!("{name}.svg"), document));
    let files = drawings
        .iter()
        .map(|(name, document)| (name.as_str(), *document))
        .chain([(MESH, "")])
        .map(|(name, text)| (name.into(), Arc::from(text.as_bytes())));
    let path = Path::new("presets.toml");
    let mut scene = Scene::parse_with(TABLE, path, &Limits::default(), Files::memory(files))?;
    for object in &mut scene.objects {
        // Scenes hold a drawing itself, and need no file then.
        let layers = object.layers.iter_mut().map(|layer| &mut layer.shape);
        for shape in std::iter::once(&mut object.shape).chain(layers) {
            let label = shape.label();
            if let Some((_, document)) = drawings.iter().find(|(name, _)| *name == label) {
                *shape = Shape::svg(document);
            }
        }
    }
    Ok(scene.objects)
}

/// Sets pattern, technique, colours and depth of `object` to those of `preset`. `mesh`,
/// if it is known, gives the size.
pub fn apply(preset: &SceneObject, object: &mut SceneObject, mesh: Option<&Mesh>) {
    let preset = preset.clone();
    object.shape = preset.shape;
    object.raster = preset.raster;
    object.map = preset.map;
    object.threshold = preset.threshold;
    object.invert = preset.invert;
    object.extrusion = preset.extrusion;
    object.search = preset.search;
    object.raised = preset.raised;
    object.cut_out = preset.cut_out;
    object.self_shadow = preset.self_shadow;
    object.material = preset.material;
    object.finish = preset.finish;
    object.layers = preset.layers;
    let size = mesh.map_or(1.0, |mesh| mesh.bounds.diagonal());
    object.depth = preset.depth.map(|depth| size * depth);
    let unit = mesh.map_or([size; 2], |mesh| {
        lengths(mesh).map(|unit| unit.unwrap_or(size))
    });
    object.repeat = [0, 1].map(|axis| (preset.repeat[axis] * unit[axis] / size).round().max(1.0));
    object.tidy();
}

/// Returns the mean lengths of a unit of u and of v on `mesh`, object units; `None` where
/// the texture coordinates have no area.
fn lengths(mesh: &Mesh) -> [Option<f64>; 2] {
    let mut area = 0.0;
    let mut slopes = [0.0; 2];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.corners.map(|corner| corner.position);
        let weight = (b - a).cross(c - a).length();
        area += weight;
        for corner in &triangle.corners {
            slopes[0] += weight * corner.gradient_u.length() / 3.0;
            slopes[1] += weight * corner.gradient_v.length() / 3.0;
        }
    }
    slopes.map(|slope| (slope > 0.0).then(|| area / slope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo::prepare::prepare;
    use relievo::render::{ColorWords, CpuRenderer, Renderer};
    use relievo::shape_map::{Pattern, PatternOptions};

    fn scene() -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/torus.toml");
        let mut scene = Scene::load(&path).unwrap();
        scene.size = [96, 72];
        scene
    }

    fn colors(scene: &Scene) -> ColorWords {
        let prepared = prepare(scene, &|_| ()).unwrap();
        CpuRenderer::new(&prepared).color(&prepared.frame).unwrap()
    }

    #[test]
    fn each_preset_draws_what_its_saved_scene_draws() {
        let plain = scene();
        let mesh = prepare(&plain, &|_| ()).unwrap().objects[0].mesh.clone();
        let mut pictures = vec![colors(&plain)];
        for preset in presets() {
            let mut scene = plain.clone();
            apply(preset, &mut scene.objects[0], Some(&mesh));
            scene.check().unwrap();
            let picture = colors(&scene);
            assert!(!pictures.contains(&picture), "{}", preset.name);
            let folder = plain.path.parent().unwrap();
            let text = scene.to_toml(folder);
            let again = Scene::parse(&text, &folder.join("again.toml")).unwrap();
            assert_eq!(again.objects, scene.objects, "{text}");
            assert!(colors(&again) == picture, "{text}");
            pictures.push(picture);
        }
        assert!(pictures.len() > 3);
    }

    #[test]
    fn the_repeats_keep_the_sides_of_the_pattern() {
        for preset in presets() {
            let options = PatternOptions {
                raster: preset.raster.unwrap_or(512),
                ..PatternOptions::default()
            };
            let pattern = match &preset.shape {
                Shape::Drawing(document) => Pattern::from_svg(document, &options).unwrap(),
                Shape::Text(text) => Pattern::from_text(text, &Files::Disk, &options).unwrap(),
                other => panic!("{other} needs a file"),
            };
            let [u, v] = preset.repeat;
            let sides = f64::from(pattern.width()) / f64::from(pattern.height());
            assert!(
                (v / u / sides - 1.0).abs() < 0.03,
                "{}: {sides}",
                preset.name
            );
        }
    }

    #[test]
    fn a_preset_fits_the_size_of_the_mesh() {
        let mut large = scene();
        let mut objects = [1.0, 10.0].map(|scale| {
            large.objects[0].scale = scale;
            let mesh = prepare(&large, &|_| ()).unwrap().objects[0].mesh.clone();
            let mut object = large.objects[0].clone();
            apply(&presets()[0], &mut object, Some(&mesh));
            object
        });
        let [depth, deep] = objects.each_ref().map(|object| object.depth.unwrap());
        assert!((deep / depth - 10.0).abs() < 1e-3, "{depth} {deep}");
        assert_eq!(objects[0].repeat, objects[1].repeat);
        assert!(objects[0].repeat[0] > 8.0, "{:?}", objects[0].repeat);
        // What a mesh is, and where, is not the preset's.
        objects[1].scale = 1.0;
        objects[1].depth = objects[0].depth;
        assert_eq!(objects[0], objects[1]);
    }
}
