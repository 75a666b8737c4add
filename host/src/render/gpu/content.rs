//! Contents and formats of pictures on a GPU.

use crate::shaders::EntryPoints;
use std::ops::Range;

/// Stores the bits of f32 unchanged: integers are not filtered, blended or
/// rounded.
pub(super) const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Content of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Colours.
    Color,
    /// Hits.
    Geometry,
}

impl Content {
    /// Returns the targets that the picture is in.
    pub fn targets(self) -> Range<usize> {
        self.drawing(false).targets()
    }

    /// Returns what objects are drawn as for it, in a scene that is lit physically or not.
    pub(super) fn drawing(self, is_lit: bool) -> Drawing {
        match self {
            Content::Color if is_lit => Drawing::Surface,
            Content::Color => Drawing::Color,
            Content::Geometry => Drawing::Geometry,
        }
    }
}

/// What objects are drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drawing {
    /// Their colours: one target.
    Color,
    /// Their hits: two targets.
    Geometry,
    /// The G-buffer: two targets beside that of the colours.
    Surface,
    /// Depths alone: no target.
    Depth,
}

impl Drawing {
    /// Returns the targets that it is drawn to.
    pub(super) fn targets(self) -> Range<usize> {
        match self {
            Drawing::Color => 0..1,
            Drawing::Geometry => 0..2,
            Drawing::Surface => 1..3,
            Drawing::Depth => 0..0,
        }
    }

    /// Returns the fragment shader of an object.
    pub(super) fn fragment(self, of: &EntryPoints) -> &'static str {
        match self {
            Drawing::Color => of.color,
            Drawing::Geometry => of.geometry,
            Drawing::Surface | Drawing::Depth => of.surface,
        }
    }
}
