//! What shading reads of files and patterns, kept for the next scene.

use super::super::memo::{Memo, Same};
use super::cells::Cells;
use super::chart::Charted;
use super::environment::Surroundings;
use super::pictures::{Encoding, Levels};
use crate::shape_map::ShapeMap;
use std::path::PathBuf;

/// What is baked of files and patterns, each once for a scene and those after it.
#[derive(Default)]
pub(in super::super) struct Bakes {
    /// By file and meaning.
    pub(super) pictures: Memo<(PathBuf, Encoding), Levels>,
    /// By map.
    pub(super) cells: Memo<Same<ShapeMap>, Cells>,
    /// By map, and by the distance that the pattern reaches to, texels.
    pub(super) charts: Memo<(Same<ShapeMap>, f32), Charted>,
    /// By file and degrees that it is turned by; `None` is even light.
    pub(super) environments: Memo<Option<(PathBuf, f64)>, Surroundings>,
}

impl Bakes {
    /// Returns them for the next scene, without those that this one did not use.
    pub(in super::super) fn for_next(self) -> Bakes {
        Bakes {
            pictures: self.pictures.for_next(),
            cells: self.cells.for_next(),
            charts: self.charts.for_next(),
            environments: self.environments.for_next(),
        }
    }
}
