//! Contents and formats of pictures on a GPU.

use crate::prepare::PreparedLighting;
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

/// A pass over the whole picture, after the G-buffer is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Pass {
    /// Colours.
    Shade,
    /// Colours and shares of neighbours.
    ShadeEdges,
    /// Both anew, where the mean of a pattern is seen.
    Mean,
}

impl Pass {
    /// All of them.
    pub(super) const ALL: [Pass; 3] = [Pass::Shade, Pass::ShadeEdges, Pass::Mean];

    /// Returns the passes that `lighting` needs. The last one writes target 0, the one before it the
    /// target after the G-buffer.
    pub(crate) fn of(lighting: &PreparedLighting) -> &'static [Pass] {
        if !lighting.has_smooth_edges {
            &[Pass::Shade]
        } else if lighting.has_charts() {
            &[Pass::ShadeEdges, Pass::Mean]
        } else {
            &[Pass::ShadeEdges]
        }
    }

    /// Returns the fragment shader.
    pub(crate) fn fragment(self) -> &'static str {
        match self {
            Pass::Shade => "shade",
            Pass::ShadeEdges => "shade_edges",
            Pass::Mean => "mean",
        }
    }

    /// Returns the targets that it reads.
    pub(super) fn reads(self) -> Range<usize> {
        let hits = Drawing::Surface.targets();
        match self {
            Pass::Shade | Pass::ShadeEdges => hits,
            Pass::Mean => hits.start..hits.end + 1,
        }
    }

    /// Returns the target that it writes, as the last pass or before it.
    pub(super) fn writes(is_last: bool) -> usize {
        match is_last {
            true => 0,
            false => Drawing::Surface.targets().end,
        }
    }

    /// Returns how many targets `lighting` needs.
    pub(super) fn targets(lighting: &PreparedLighting) -> usize {
        let reads = Pass::of(lighting).iter();
        reads.map(|pass| pass.reads().end).max().unwrap_or(0)
    }
}
