//! Scenes whose files lie in memory.

use super::prepare;
use crate::render::{CpuRenderer, Renderer};
use crate::scene::Scene;
use crate::shape_map::{Pattern, PatternOptions, Storage, bake};
use crate::{Files, Limits};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The words of the scene's picture, in a small size.
pub(crate) fn words(mut scene: Scene) -> Vec<[u32; 4]> {
    scene.size = [80, 60];
    scene.supersampling = 1;
    let prepared = prepare(&scene, &|_| ()).unwrap_or_else(|error| panic!("{error}"));
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
