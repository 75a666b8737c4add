//! Helpers of the cross-crate tests.

use relievo::render::gpu::{Adapter, adapters};
use std::path::{Path, PathBuf};

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("tests/ lies in the repository")
        .to_path_buf()
}

/// A file of `assets/`.
pub fn asset(path: &str) -> PathBuf {
    root().join("assets").join(path)
}

/// Every scene of `assets/scenes`, sorted.
///
/// # Panics
/// If there are none.
pub fn scenes() -> Vec<PathBuf> {
    let mut scenes: Vec<PathBuf> = std::fs::read_dir(asset("scenes"))
        .expect("assets/scenes is a folder")
        .map(|entry| entry.expect("a folder can be listed").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    scenes.sort();
    assert!(!scenes.is_empty());
    scenes
}

/// Every GPU adapter of this machine.
///
/// # Panics
/// If there are none.
pub fn every_adapter() -> Vec<Adapter> {
    let all = adapters();
    assert!(
        !all.is_empty(),
        "no GPU adapter: install a Vulkan driver (tests/run does it where it may)"
    );
    all
}
