//! Patterns as assets.

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use relievo::shape_map::{self, DEFAULT_RASTER, PatternOptions, ShapeMapError};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A binary image that repeats in both directions.
///
/// `assets.load("bricks.png")` loads one from an image or from an SVG drawing. In code, it is
/// made from pixels, from a function or from a drawing by [`relievo::shape_map::Pattern`].
#[derive(Asset, TypePath, Clone, Debug)]
pub struct Pattern(pub Arc<shape_map::Pattern>);

impl From<shape_map::Pattern> for Pattern {
    fn from(pattern: shape_map::Pattern) -> Pattern {
        Pattern(Arc::new(pattern))
    }
}

/// How an image becomes a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PatternSettings {
    /// Luma below which a pixel is pattern.
    pub threshold: u8,
    /// Whether the light pixels are the pattern.
    pub invert: bool,
    /// Pixels of the longer side of a drawing.
    pub raster: u32,
}

impl Default for PatternSettings {
    fn default() -> PatternSettings {
        let options = PatternOptions::default();
        PatternSettings {
            threshold: options.threshold,
            invert: options.invert,
            raster: DEFAULT_RASTER,
        }
    }
}

/// A file that is no pattern.
#[derive(Debug)]
pub enum PatternError {
    /// It cannot be read.
    Read(std::io::Error),
    /// It is neither an image nor a drawing, or too large.
    Decode(ShapeMapError),
}

impl std::fmt::Display for PatternError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PatternError::Read(error) => error.fmt(f),
            PatternError::Decode(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for PatternError {}

/// Loads a [`Pattern`] from an image or an SVG drawing.
#[derive(Default, TypePath)]
pub struct PatternLoader;

impl AssetLoader for PatternLoader {
    type Asset = Pattern;
    type Settings = PatternSettings;
    type Error = PatternError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &PatternSettings,
        context: &mut LoadContext<'_>,
    ) -> Result<Pattern, PatternError> {
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .await
            .map_err(PatternError::Read)?;
        let options = PatternOptions {
            threshold: settings.threshold,
            invert: settings.invert,
            raster: settings.raster,
            ..PatternOptions::default()
        };
        let path = context.path().path().to_path_buf();
        let pattern = shape_map::Pattern::from_bytes(&bytes, &path, &options);
        pattern.map(Pattern::from).map_err(PatternError::Decode)
    }

    fn extensions(&self) -> &[&str] {
        &[
            "png", "jpg", "jpeg", "bmp", "gif", "tga", "tif", "tiff", "webp", "pbm", "pgm", "ppm",
            "qoi", "svg",
        ]
    }
}

pub(crate) struct PatternPlugin;

impl Plugin for PatternPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<Pattern>()
            .init_asset_loader::<PatternLoader>();
    }
}
