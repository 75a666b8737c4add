//! Contents and formats of pictures on a GPU.

use super::shaders::EntryPoints;

/// Stores the bits of f32 unchanged: integers are not filtered, blended or
/// rounded.
pub(super) const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Content of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Colours: one target.
    Color,
    /// Hits: two targets.
    Geometry,
}

impl Content {
    /// Returns the number of targets.
    pub fn targets(self) -> usize {
        match self {
            Content::Color => 1,
            Content::Geometry => 2,
        }
    }

    /// Returns the fragment shader of an object.
    pub(super) fn fragment(self, of: &EntryPoints) -> &'static str {
        match self {
            Content::Color => of.color,
            Content::Geometry => of.geometry,
        }
    }
}
