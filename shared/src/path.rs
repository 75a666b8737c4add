//! The ray inside the shell, in texture coordinates and depth, as a function of
//! the distance s.
//!
//! [`Path`] is the interface of a ray to the searches. [`QuadraticPath`] is the path
//! of the tiers that draw triangles; `model::flat` and `model::quadric` make it.

use crate::arithmetic::abs;
use crate::layout::vec3;
use crate::surface::Surface;
use crate::{Real, Vec2, Vec3};

/// A ray inside the shell between the cap and the floor. `s` is the distance,
/// in object units, from where the ray enters the shell.
pub trait Path {
    /// Texture coordinates at `s`, repeats.
    fn uv(&self, s: Real) -> Vec2;
    /// Depth fraction δ at `s`: 0 at the cap, 1 at the floor.
    fn depth_fraction(&self, s: Real) -> Real;
    /// Derivative of the texture coordinates by s at s = 0 and at the end, repeats per
    /// object unit; linear in between.
    fn uv_rates(&self) -> (Vec2, Vec2);
    /// Whether both derivatives are the same, which saves computations.
    fn is_even(&self) -> bool;
    /// An upper bound of dδ/ds on the path, 1 / object units, ≥ 0.
    fn depth_rate(&self) -> Real;
    /// s where the march begins: 0, or the eye's if it is inside the shell.
    fn start(&self) -> Real;
    /// s where the ray leaves the shell.
    fn end(&self) -> Real;
    /// Whether it leaves through the floor; else through the cap, a silhouette.
    fn ends_on_floor(&self) -> bool;
}

/// The straight ray over a flat surface or the bent ray over a quadric.
///
/// The depth below the quadric, measured along the normal at the facet, is
/// δ0 + V_z s − q s², which is accurate only while the depth is small against the
/// radius of curvature (section 4). Here the depth d is measured along the normal
/// through the point: over a sphere or a cylinder of curvature k,
///
/// d − ½ k d² = δ0 + V_z s − (q + ½ k V_z²) s²,
///
/// a parabola, and exact; over any quadric Q, k = 2 |Q V|² / q makes it accurate to
/// third order. The foot of that normal is at V s + 2 d Q V s, and ∇u changes on the
/// way there, so that texture coordinates are of second order in s.
///
/// s counts from where the ray enters the shell, not from the facet, which lies δ0
/// below the smooth surface. This removes δ0 from every formula: with
/// R = √(V_z² + 4 q δ0),
/// δ0 + V_z s − q s² = (s − s0) (R − q (s − s0)).
#[derive(Clone, Copy, Debug)]
pub struct QuadraticPath {
    /// Whether the ray enters the shell at all.
    pub enters: bool,
    /// Distance from the eye to the entry, object units; negative where the eye is inside the shell.
    pub entry_t: Real,
    /// Distance from the facet to the entry along the ray, object units.
    pub entry_from_facet: Real,
    /// Texture coordinates at the entry.
    pub entry_uv: Vec2,
    /// Change of the texture coordinates at the entry, repeats per object unit.
    pub velocity: Vec2,
    /// Half their second derivative, repeats per square object unit.
    pub uv_bend: Vec2,
    /// R: dd/ds at the entry, ≥ 0.
    pub slope: Real,
    /// q + ½ k V_z²: bend of the ray, 1 / object units, > 0 where the surface
    /// falls away.
    pub bend: Real,
    /// Cubic term: d − ½ k d² = s (R − (bend + twist s) s), 1 / square object units; 0
    /// unless the mesh says where the ray leaves.
    pub twist: Real,
    /// The largest derivative of that by s, ≥ 0.
    pub(crate) steepest: Real,
    /// Factor that makes d − ½ k d² 1 at the floor, 1 / object units.
    pub inverse_depth: Real,
    /// About ½ k S_z: the difference between δ and d − ½ k d².
    pub warp: Real,
    /// Displacement of the foot of the normal in the surface's frame, per square of the
    /// distance from the facet, 1 / object units.
    pub(crate) foot_bend: Vec2,
    pub(crate) start: Real,
    pub(crate) end: Real,
    pub(crate) ends_on_floor: bool,
    /// Whether `bend`, `uv_bend` and `warp` may be other than 0.
    pub(crate) is_bent: bool,
}

/// Curvatures below this are treated as zero: their reciprocals would leave the
/// range of the value contract.
pub(crate) const FLAT: Real = 1e-18;

impl Path for QuadraticPath {
    #[inline]
    fn uv(&self, s: Real) -> Vec2 {
        self.entry_uv + (self.velocity + self.uv_bend * s) * s
    }

    #[inline]
    fn depth_fraction(&self, s: Real) -> Real {
        if self.is_bent {
            let even = s * (self.slope - (self.bend + self.twist * s) * s) * self.inverse_depth;
            even * (1.0 - self.warp * (1.0 - even))
        } else {
            s * self.slope * self.inverse_depth
        }
    }

    #[inline]
    fn uv_rates(&self) -> (Vec2, Vec2) {
        let last = self.velocity + self.uv_bend * (2.0 * self.end);
        (self.velocity, last)
    }

    #[inline]
    fn is_even(&self) -> bool {
        !self.is_bent
    }

    #[inline]
    fn depth_rate(&self) -> Real {
        self.steepest * self.inverse_depth * (1.0 + abs(self.warp))
    }

    #[inline]
    fn start(&self) -> Real {
        self.start
    }

    #[inline]
    fn end(&self) -> Real {
        self.end
    }

    #[inline]
    fn ends_on_floor(&self) -> bool {
        self.ends_on_floor
    }
}

/// Returns the surface over an ideal quadric patch, for tests of this and other crates:
/// `normal` = z, tangent = x, `quadric` = (xx, xy, yy), uv = (x, y).
pub fn test_surface(quadric: [Real; 3], facet_depth: Real) -> Surface {
    Surface {
        normal: Vec3::Z,
        tangent: Vec3::X,
        bitangent: Vec3::Y,
        quadric: vec3(quadric),
        uv: Vec2::ZERO,
        gradient_u: Vec3::X,
        gradient_v: Vec3::Y,
        uv_bend: Vec2::ZERO,
        facet_depth,
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References are computed in f64, by the standard library.
mod tests;
