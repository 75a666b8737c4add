//! The default scene.

use relievo::scene::{Scene, SceneError};
use relievo::{Files, Limits};
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

/// Parses the default scene.
pub fn scene() -> Result<Scene, SceneError> {
    let files = FILES.map(|(name, bytes)| (PathBuf::from(name), Arc::from(bytes)));
    // A separate folder would be missing where the scene is saved.
    let text = SCENE.replace("../", "");
    Scene::parse_with(
        &text,
        Path::new("torus.toml"),
        &limits(),
        Files::memory(files),
    )
}
