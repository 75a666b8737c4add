//! Scenes whose files lie in memory.

use super::{Assets, prepare, prepare_with};
use crate::mesh::MeshData;
use crate::render::{CpuRenderer, Renderer};
use crate::scene::{Scene, SceneObject, Shape, Technique, Tier};
use crate::shape_map::{Pattern, PatternOptions, Storage, bake};
use crate::{Files, Limits};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The words of the scene's picture, in a small size, with small shadow maps.
pub(crate) fn words(scene: Scene) -> Vec<[u32; 4]> {
    words_with(scene, &mut Assets::default())
}

/// As [`words`], reusing unchanged `assets`.
pub(crate) fn words_with(mut scene: Scene, assets: &mut Assets) -> Vec<[u32; 4]> {
    scene.size = [80, 60];
    scene.supersampling = 1;
    for light in &mut scene.lights {
        light.shadow_size = 64;
    }
    let prepared = prepare_with(&scene, assets, &|_| ());
    let prepared = prepared.unwrap_or_else(|error| panic!("{error}"));
    let mut renderer = CpuRenderer::new(&prepared);
    renderer.color(&prepared.frame).unwrap().words
}

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets")
}

fn bytes(path: impl AsRef<Path>) -> Arc<[u8]> {
    std::fs::read(path).unwrap().into()
}

#[test]
fn from_memory_as_from_the_disk() {
    let assets = assets();
    let on_disk = Scene::load(&assets.join("scenes/torus.toml")).unwrap();
    let files = ["meshes/torus.obj", "patterns/discs.png"];
    let files = Files::memory(files.map(|name| (name.into(), bytes(assets.join(name)))));
    let path = Path::new("scenes/torus.toml");
    assert!(!path.exists(), "what is not in memory would be found");
    let in_memory =
        Scene::parse_with(&on_disk.text, path, &Limits::default(), files.clone()).unwrap();
    let wanted = words(on_disk);
    assert!(words(in_memory) == wanted);

    let text = "[[object]]\nmesh = '../meshes/torus.obj'\nshape = 'none.png'\n";
    let error = Scene::parse_with(text, path, &Limits::default(), files).unwrap_err();
    for part in ["line 3", "scenes/none.png", "patterns/discs.png"] {
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn a_baked_map_from_memory() {
    let assets = assets();
    let folder = tempfile::tempdir().unwrap();
    let pattern = assets.join("patterns/letters.png");
    let pattern = Pattern::load(pattern, &PatternOptions::default()).unwrap();
    let map = folder.path().join("map.png");
    bake(&pattern, Storage::R8, &|_| ()).save(&map).unwrap();
    let mesh = assets.join("meshes/plane.obj");
    let text = |mesh: &Path, map: &Path| format!("[[object]]\nmesh = {mesh:?}\nshape = {map:?}\n");
    let on_disk = Scene::parse(&text(&mesh, &map), Path::new("")).unwrap();
    let names = [Path::new("a.obj"), Path::new("b/c.png")];
    let files = [(names[0], mesh.as_path()), (names[1], map.as_path())];
    let files = files.map(|(name, path)| (name.to_path_buf(), bytes(path)));
    let in_memory = Scene::parse_with(
        &text(names[0], names[1]),
        Path::new(""),
        &Limits::default(),
        Files::memory(files),
    );
    assert!(words(in_memory.unwrap()) == words(on_disk));
}

#[test]
fn drawings_and_text_are_patterns_and_images_have_no_raster() {
    let assets = assets();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 1 1'><circle cx='.5' cy='.5' r='.4'/></svg>";
    let files = Files::memory([
        ("a.obj".into(), bytes(assets.join("meshes/plane.obj"))),
        ("a.png".into(), bytes(assets.join("patterns/discs.png"))),
        ("a.svg".into(), Arc::from(svg.as_bytes())),
    ]);
    let scene = |shape: &str| {
        let text = format!("[[object]]\nmesh = 'a.obj'\nshape = {shape}\n");
        Scene::parse_with(&text, Path::new(""), &Limits::default(), files.clone()).unwrap()
    };
    for shape in ["'a.svg'\nraster = 64", "{ text = 'AB' }\nraster = 64"] {
        let words = words(scene(shape));
        // Caps, and floor between them.
        assert!(words.iter().any(|word| word[3] == 1) && words.iter().any(|word| word[3] == 4));
    }
    let refused = scene("'a.png'\nraster = 64");
    let error = prepare(&refused, &|_| ()).err().unwrap().to_string();
    assert!(
        error.contains("a.png") && error.contains("map_reduction"),
        "{error}"
    );
}

#[test]
fn a_budget_needs_a_plan() {
    let text =
        "[[object]]\nmesh = '../meshes/plane.obj'\nshape = '../patterns/discs.png'\nerror_px = 1\n";
    let scene = Scene::parse(text, &assets().join("scenes/a.toml")).unwrap();
    let error = prepare(&scene, &|_| ()).err().unwrap().to_string();
    assert!(error.contains("budget::plan"), "{error}");
}

/// A square with texture coordinates.
fn square() -> MeshData {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let positions = corners.map(|[x, y]| [x, y, 0.0]);
    MeshData::new("square", positions, [[0, 1, 2], [0, 2, 3]]).with_uvs(corners)
}

#[test]
fn scenes_are_made_in_code() {
    let pattern = Pattern::from_fn(32, 32, |x, y| x < 16 && y < 16).unwrap();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='2' height='1'>
        <circle cx='1' cy='0.5' r='0.4'/></svg>";
    let shapes = [pattern.into(), Shape::text("A"), Shape::svg(svg)];
    let objects = shapes.map(|shape| SceneObject::new(square(), shape).depth(0.1).repeat(2, 3));
    let scene = objects.into_iter().fold(Scene::default(), Scene::object);
    let prepared = prepare(&scene, &|_| ()).unwrap();
    assert_eq!(prepared.triangle_count(), 6);
    assert_eq!(prepared.objects[0].name, "square");
    let widths = prepared.objects.iter().map(|object| object.map.width());
    assert_eq!(widths.max(), Some(512));
}

/// Values out of range are errors also where no file was read.
#[test]
fn wrong_values_are_not_drawn() {
    let object = || SceneObject::new(square(), Shape::text("A"));
    let scene = |object| Scene::default().object(object);
    for (scene, parts) in [
        (
            scene(object().depth(f64::NAN)),
            ["object 1: depth is nan", "from 1e-9 to 1e9"],
        ),
        (
            scene(object().depth(-1.0)),
            ["object 1: depth is -1", "from 1e-9 to 1e9"],
        ),
        (
            scene(object().steps(0)),
            ["object 1: steps is 0", "from 1 to 65536"],
        ),
        (
            scene(object().repeat(0, 6)),
            ["object 1: repeat is [0.0, 6.0]", "from 0.001 to"],
        ),
        (
            scene(object()).field_of_view(400.0),
            ["camera.fov is 400", "from 0.01 to 179"],
        ),
        (
            scene(object()).size(0, 0),
            ["image.size is [0, 0]", "from 1 to 16384"],
        ),
        (
            scene(object().scale(f64::INFINITY)),
            ["object 1: scale is inf", "from 1e-9"],
        ),
        (
            scene(SceneObject::new("", "a.png")),
            ["object 1: mesh is empty", "name a file"],
        ),
        (
            scene(SceneObject::new(square(), Shape::text(" "))),
            ["shape.text", "no letters"],
        ),
        (
            scene(
                object()
                    .with_technique(Technique::Relief)
                    .tier(Tier::Accurate),
            ),
            ["object 1: tier", "no relief mapping"],
        ),
        (Scene::default(), ["object is missing", "add one"]),
    ] {
        let Err(error) = prepare(&scene, &|_| ()) else {
            panic!("{parts:?} is accepted");
        };
        let message = error.to_string();
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    }
}
