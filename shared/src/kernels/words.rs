//! Arguments and results of kernels as words.

use super::array;
use crate::layout::Corner;
use crate::march::March;
use crate::path::{Path, QuadraticPath};
use crate::surface::Surface;
use crate::{Vec2, Vec3};
use relievo_kernel::{FromWords, Sink, Source, ToWords};

/// Takes a vector as a layout stores it.
#[inline]
fn read_array<S: Source>(source: &mut S) -> [f32; 3] {
    array(Vec3::read(source))
}

impl FromWords for Corner {
    const WORDS: u32 = 20;
    #[inline]
    fn read<S: Source>(source: &mut S) -> Corner {
        let position = read_array(source);
        let normal = read_array(source);
        let tangent = read_array(source);
        let uv = Vec2::read(source);
        let quadric = read_array(source);
        let gradient_u = read_array(source);
        let gradient_v = read_array(source);
        Corner {
            position,
            normal,
            tangent,
            uv: [uv.x, uv.y],
            quadric,
            gradient_u,
            gradient_v,
        }
    }
}

impl FromWords for Surface {
    const WORDS: u32 = 23;
    #[inline]
    fn read<S: Source>(source: &mut S) -> Surface {
        let normal = Vec3::read(source);
        let tangent = Vec3::read(source);
        let bitangent = Vec3::read(source);
        let quadric = Vec3::read(source);
        let uv = Vec2::read(source);
        let gradient_u = Vec3::read(source);
        let gradient_v = Vec3::read(source);
        let uv_bend = Vec2::read(source);
        let facet_depth = f32::read(source);
        Surface {
            normal,
            tangent,
            bitangent,
            quadric,
            uv,
            gradient_u,
            gradient_v,
            uv_bend,
            facet_depth,
        }
    }
}

impl ToWords for Surface {
    const WORDS: u32 = 23;
    #[inline]
    fn write<S: Sink>(self, sink: &mut S) {
        self.normal.write(sink);
        self.tangent.write(sink);
        self.bitangent.write(sink);
        self.quadric.write(sink);
        self.uv.write(sink);
        self.gradient_u.write(sink);
        self.gradient_v.write(sink);
        self.uv_bend.write(sink);
        self.facet_depth.write(sink);
    }
}

impl ToWords for March {
    const WORDS: u32 = 6;
    #[inline]
    fn write<S: Sink>(self, sink: &mut S) {
        self.end.write(sink);
        self.s.write(sink);
        self.uv.write(sink);
        self.depth_fraction.write(sink);
        self.steps.write(sink);
    }
}

/// A path as a result.
pub struct PathWords(pub(super) QuadraticPath);

impl ToWords for PathWords {
    const WORDS: u32 = 16;
    #[inline]
    fn write<S: Sink>(self, sink: &mut S) {
        let path = self.0;
        path.enters.write(sink);
        path.entry_t.write(sink);
        path.entry_from_facet.write(sink);
        path.entry_uv.write(sink);
        path.velocity.write(sink);
        path.uv_bend.write(sink);
        path.slope.write(sink);
        path.bend.write(sink);
        path.inverse_depth.write(sink);
        path.warp.write(sink);
        path.start().write(sink);
        path.end().write(sink);
        path.ends_on_floor().write(sink);
    }
}
