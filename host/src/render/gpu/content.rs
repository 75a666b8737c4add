//! What pictures on a GPU hold, and in which formats.

use super::shaders::EntryPoints;

/// Bits of f32 in, bits of f32 out: nothing is filtered, blended or rounded.
pub(super) const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Colours: one target.
    Color,
    /// What is hit: two targets.
    Geometry,
}

impl Content {
    /// How many targets are drawn to.
    pub fn targets(self) -> usize {
        match self {
            Content::Color => 1,
            Content::Geometry => 2,
        }
    }

    /// The fragment shader of an object.
    pub(super) fn fragment(self, of: &EntryPoints) -> &'static str {
        match self {
            Content::Color => of.color,
            Content::Geometry => of.geometry,
        }
    }
}
