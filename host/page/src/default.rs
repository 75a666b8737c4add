//! The default scene, and the scene of an address.

use relievo::scene::{Scene, SceneError};
use relievo::{Files, Limits};
use relievo_viewer::link::decode;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Names and contents of embedded files.
const FILES: [(&str, &[u8]); 2] = [
    (
        "meshes/torus.obj",
        include_bytes!("../../../assets/meshes/torus.obj"),
    ),
    (
        "patterns/discs.png",
        include_bytes!("../../../assets/patterns/discs.png"),
    ),
];
const SCENE: &str = include_str!("../../../assets/scenes/torus.toml");

/// Limits of a page: a tab has at most 4 GiB, often less.
fn limits() -> Limits {
    Limits {
        triangles: 1 << 20,
        pixels: 1 << 24,
        memory: 1 << 30,
        ..Limits::default()
    }
}

/// Returns the files of the default scene, which links do not carry.
pub fn files() -> Files {
    Files::memory(FILES.map(|(name, bytes)| (PathBuf::from(name), Arc::from(bytes))))
}

/// Returns the scene of the fragment of an address. If it has none, or none that can be
/// read, this is the default scene, with a message in the latter case.
pub fn scene_of(fragment: &str) -> Result<(Scene, Option<String>), SceneError> {
    let default = scene()?;
    Ok(match decode(fragment, &default) {
        None => (default, None),
        Some(Ok(scene)) => (scene, None),
        Some(Err(problem)) => (default, Some(problem)),
    })
}

/// Parses the default scene.
fn scene() -> Result<Scene, SceneError> {
    // A separate folder would be missing where the scene is saved.
    let text = SCENE.replace("../", "");
    Scene::parse_with(&text, Path::new("torus.toml"), &limits(), files())
}
