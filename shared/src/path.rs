//! Where the ray is: in texture coordinates and in depth, at a distance s.
//!
//! A tier is a path. The march asks a path for nothing but what [`Path`] says,
//! so that a new model of the surface is one new path.

use crate::arithmetic::{div, max, min, sqrt};
use crate::layout::{TIER_PLANAR, vec3};
use crate::surface::Surface;
use crate::{FAR, Real, Vec2, Vec3};

/// A ray inside the shell between the cap and the floor. `s` is the distance,
/// in object units, from where the ray enters the shell.
pub trait Path {
    /// Texture coordinates at `s`, repeats.
    fn uv(&self, s: Real) -> Vec2;
    /// Depth fraction δ at `s`: 0 at the cap, 1 at the floor.
    fn depth_fraction(&self, s: Real) -> Real;
    /// Change of the texture coordinates, repeats per object unit (an upper bound of each).
    fn uv_rate(&self) -> Vec2;
    /// An upper bound of dδ/ds on the path, 1 / object units, ≥ 0.
    fn depth_rate(&self) -> Real;
    /// Where the march begins: 0, or the eye where it is inside the shell.
    fn start(&self) -> Real;
    /// Where the ray leaves the shell.
    fn end(&self) -> Real;
    /// Whether it leaves through the floor (else through the cap: silhouette).
    fn ends_on_floor(&self) -> bool;
}

/// The straight ray over a flat surface and the bent ray over a quadric are one
/// formula: δ S_z = s (slope − q s), with q = 0 for the planar tier.
///
/// Section 4 counts s from the facet, which lies δ0 below the smooth surface;
/// counting it from where the ray enters the shell instead removes δ0 from
/// every formula: with R = √(V_z² + 4 q δ0),
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
    /// m: change of the texture coordinates, repeats per object unit.
    pub velocity: Vec2,
    /// R: depth gained per unit of s at the entry, ≥ 0.
    pub slope: Real,
    /// q: bend of the ray, 1 / object units, > 0 where the surface falls away.
    pub bend: Real,
    /// 1 / S_z.
    inverse_depth: Real,
    start: Real,
    end: Real,
    ends_on_floor: bool,
}

/// Below this a curvature is none: its reciprocal would leave the range of
/// values that keep their meaning in f32.
const FLAT: Real = 1e-18;

impl QuadraticPath {
    /// The path of the ray along the unit vector `direction`, which meets the
    /// facet under `surface` at distance `facet_t`, through a shell of depth
    /// `depth` > 0 (object units). Equations (12) and (14), with the cross term
    /// and the facet depth of section 4; `tier` is a `TIER_` constant.
    #[inline]
    pub fn new(
        surface: &Surface,
        direction: Vec3,
        facet_t: Real,
        depth: Real,
        tier: u32,
    ) -> QuadraticPath {
        let v_x = direction.dot(surface.tangent);
        let v_y = direction.dot(surface.bitangent);
        let v_z = -direction.dot(surface.normal);
        let velocity = Vec2::new(
            direction.dot(surface.gradient_u),
            direction.dot(surface.gradient_v),
        );
        let planar = tier == TIER_PLANAR;
        let quadric = surface.quadric;
        let q = if planar {
            0.0
        } else {
            quadric.x * v_x * v_x + quadric.y * v_x * v_y + quadric.z * v_y * v_y
        };
        let q = if q < FLAT && q > -FLAT { 0.0 } else { q };
        let facet_depth = if planar { 0.0 } else { surface.facet_depth };
        // The quadric does not reach down to a facet so deep: forget the depth.
        let radicand = v_z * v_z + 4.0 * q * facet_depth;
        let facet_depth = if radicand < 0.0 { 0.0 } else { facet_depth };
        let radicand = if radicand < 0.0 { v_z * v_z } else { radicand };
        let slope = sqrt(radicand);

        // The root at which the ray goes down, by the form that does not cancel.
        let sum = v_z + slope;
        let facing_away = q > 0.0 && v_z < 0.0;
        let (enters, entry) = if facing_away {
            (true, div(0.5 * (v_z - slope), q))
        } else if sum > FLAT {
            (true, div(-2.0 * facet_depth, sum))
        } else {
            // Along the cap (v_z = 0): enters here. Away from it: never.
            (v_z >= 0.0, 0.0)
        };

        let exit = if q > 0.0 { div(slope, q) } else { FAR };
        let floor_radicand = slope * slope - 4.0 * q * depth;
        let floor_sum = slope + sqrt(floor_radicand);
        let floor = if floor_radicand >= 0.0 && floor_sum > FLAT {
            div(2.0 * depth, floor_sum)
        } else {
            FAR
        };
        let entry_t = facet_t + entry;
        let end = min(exit, floor);
        // A ray that runs along the cap for ever can hit nothing but the cap.
        let endless = end >= FAR;
        QuadraticPath {
            enters,
            entry_t,
            entry_from_facet: entry,
            entry_uv: surface.uv + velocity * entry,
            velocity,
            slope,
            bend: q,
            inverse_depth: div(1.0, depth),
            start: max(-entry_t, 0.0),
            end: if endless { 0.0 } else { end },
            ends_on_floor: !endless && floor <= exit,
        }
    }

    /// Unit normal of the smooth surface below the point at `s` (section 9):
    /// the gradient of the quadric there.
    #[inline]
    pub fn surface_normal(&self, surface: &Surface, direction: Vec3, s: Real, tier: u32) -> Vec3 {
        if tier == TIER_PLANAR {
            return surface.normal;
        }
        let from_facet = self.entry_from_facet + s;
        let x = from_facet * direction.dot(surface.tangent);
        let y = from_facet * direction.dot(surface.bitangent);
        let quadric = surface.quadric;
        let raw = surface.normal
            + surface.tangent * (2.0 * quadric.x * x + quadric.y * y)
            + surface.bitangent * (quadric.y * x + 2.0 * quadric.z * y);
        crate::arithmetic::normalize_or(raw, surface.normal)
    }
}

impl Path for QuadraticPath {
    #[inline]
    fn uv(&self, s: Real) -> Vec2 {
        self.entry_uv + self.velocity * s
    }

    #[inline]
    fn depth_fraction(&self, s: Real) -> Real {
        s * (self.slope - self.bend * s) * self.inverse_depth
    }

    #[inline]
    fn uv_rate(&self) -> Vec2 {
        self.velocity
    }

    #[inline]
    fn depth_rate(&self) -> Real {
        // The ray is steepest where it enters, or, on a concave surface, where it ends.
        let steepest = if self.bend < 0.0 {
            self.slope - 2.0 * self.bend * self.end
        } else {
            self.slope
        };
        steepest * self.inverse_depth
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

/// The surface over an ideal quadric patch, for tests of this crate and others:
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
        facet_depth,
    }
}
