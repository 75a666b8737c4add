//! Helpers of the cross-crate tests.

pub mod torus_oracle;

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
