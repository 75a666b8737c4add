//! Names of exported files.

use super::target::Stage;
use crate::shape_map::Storage;
use relievo_translate::Target;

/// Name of the file with the arguments of an indirect draw.
pub(super) const DRAW_FILE: &str = "draw.bin";

/// An exported shader.
pub(super) struct ShaderFile {
    pub(super) file: String,
    pub(super) target: Target,
    pub(super) stage: Stage,
    pub(super) entry_point: String,
}

/// Returns the name of the shape map's file.
pub(super) fn map_file(storage: Storage) -> String {
    format!("shape_map.{}", storage.extension())
}
