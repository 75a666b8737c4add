//! The fast tier: along the local quadric of the surface, with facet depth
//! (section 4).

use super::over_triangle::{OverTriangle, TriangleEntry, march_over};
use super::{Found, Ray};
use crate::arithmetic::{
    SMALLEST, abs, clamp, div, floor, kept, kept3, max, min, normalize_or, sqrt, zero_below,
};
use crate::exit::Exit;
use crate::layout::{TIER_FAST, Triangle};
use crate::path::{FLAT, QuadraticPath};
use crate::shape_map::Texels;
use crate::surface::Surface;
use crate::{FAR, Real, Vec2, Vec3};

/// The fast tier; and the planar one, for objects whose tier is known only when
/// they are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Quadric;

impl OverTriangle for Quadric {
    #[inline]
    fn is_curved(ray: &Ray<'_>) -> bool {
        ray.object.tier == TIER_FAST
    }

    #[inline]
    fn asks_for_exits() -> bool {
        true
    }

    #[inline]
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        _: &Triangle,
        texels: &T,
        entry: &TriangleEntry,
    ) -> Found<Real> {
        march_over(ray, texels, entry)
    }
}

/// Maximum of half the curvature times the depth. Beyond, the shell comes near to the
/// centre of curvature, where the series for a smaller depth is better.
const MOST_WARP: Real = 0.25;

/// Parts of the direction below this (2⁻²⁴) count as 0: no product of theirs may be
/// denormal.
pub(crate) const LEAST_ANGLE: Real = 5.960_464_5e-8;
/// Curvatures times the depth, and lengths over the depth, below this (2⁻³⁴) count as 0
/// likewise.
pub(crate) const LEAST_BEND: Real = 5.820_766e-11;
/// Scale (2²⁰) of two small numbers whose squares are divided. It changes no bit of the quotient,
/// and keeps the squares in the range of the value contract.
const RAISED: Real = 1_048_576.0;

/// Least length of a path up to its exit, as a share of the exit's distance from the
/// eye: less is a rounding error.
const SHORTEST: Real = 1e-6;
/// Least distance of a floor from the plane that touches the cap at the exit, as a share of
/// the local depth there. Where the mesh is convex, the distance is at least that depth.
const LEAST_BELOW_EXIT: Real = 0.95;
/// Halvings that find the floor on a path up to its exit.
const HALVINGS: u32 = 16;

impl QuadraticPath {
    /// Returns the path of the ray along the unit vector `direction`, which hits the
    /// facet under `surface` at distance `facet_t`, through a shell of depth
    /// `depth` > 0 (object units). `tier` is a `TIER_` constant.
    #[inline]
    pub fn new(
        surface: &Surface,
        direction: Vec3,
        facet_t: Real,
        depth: Real,
        tier: u32,
    ) -> QuadraticPath {
        if tier == TIER_FAST {
            QuadraticPath::bent(surface, direction, facet_t, depth)
        } else {
            QuadraticPath::straight(surface, direction, facet_t, depth)
        }
    }

    /// The bent ray over a quadric; arguments as for [`QuadraticPath::new`]:
    /// equations (12) and (14), with the cross term and
    /// the facet depth of section 4.
    #[inline]
    pub fn bent(surface: &Surface, direction: Vec3, facet_t: Real, depth: Real) -> QuadraticPath {
        let v_x = zero_below(direction.dot(surface.tangent), LEAST_ANGLE);
        let v_y = zero_below(direction.dot(surface.bitangent), LEAST_ANGLE);
        let v_z = zero_below(-direction.dot(surface.normal), LEAST_ANGLE);
        let velocity = Vec2::new(
            direction.dot(surface.gradient_u),
            direction.dot(surface.gradient_v),
        );
        // S_z Q V, and S_z q = V · S_z Q V.
        let quadric = surface.quadric * depth;
        let turn = Vec2::new(
            zero_below(quadric.x * v_x + 0.5 * quadric.y * v_y, LEAST_BEND),
            zero_below(0.5 * quadric.y * v_x + quadric.z * v_y, LEAST_BEND),
        );
        let q = kept(turn.x * v_x + turn.y * v_y);
        let tangential = v_x * v_x + v_y * v_y;

        // ½ k S_z; less than S_z |Q V|² / q where the ray nearly follows a straight line
        // of a saddle.
        let (raised, raised_q) = (turn * RAISED, q * RAISED);
        let squared = raised.dot(raised);
        let least = max(raised_q * raised_q, tangential * squared * 0.0625);
        let half_bend = if least > SMALLEST {
            clamp(div(squared, least) * q, -MOST_WARP, MOST_WARP)
        } else {
            0.0
        };
        let floor_depth = depth * (1.0 - half_bend);
        let inverse_depth = div(1.0, floor_depth);
        // 1 / S_z.
        let per_depth = (1.0 - half_bend) * inverse_depth;
        let q = (q + half_bend * (v_z * v_z)) * per_depth;
        let q = zero_below(q, FLAT);

        // A facet deeper than the quadric reaches: its depth is ignored.
        let facet_depth = zero_below(surface.facet_depth, LEAST_BEND * depth);
        let radicand = v_z * v_z + 4.0 * q * facet_depth;
        let facet_depth = if radicand < 0.0 { 0.0 } else { facet_depth };
        let radicand = if radicand < 0.0 { v_z * v_z } else { radicand };
        let slope = sqrt(radicand);

        // 2 Q V, limited like the depth.
        let reach = 16.0 * turn.dot(turn);
        let share = if reach > tangential {
            div(tangential, reach)
        } else {
            1.0
        };
        let shift = turn * (2.0 * share * per_depth);
        let shift_in_space = surface.tangent * shift.x + surface.bitangent * shift.y;
        let shift_in_space = kept3(shift_in_space);
        let uv_shift = Vec2::new(
            kept(shift_in_space.dot(surface.gradient_u)),
            kept(shift_in_space.dot(surface.gradient_v)),
        );
        let from_facet = velocity + uv_shift * facet_depth;
        let uv_bend = uv_shift * v_z + surface.uv_bend;

        // The root where the ray goes down, in the form without cancellation.
        let sum = v_z + slope;
        let (enters, numerator, denominator) = if v_z < 0.0 && (q > 0.0 || (q < 0.0 && sum > FLAT))
        {
            (true, 0.5 * (v_z - slope), q)
        } else if sum > FLAT {
            (true, -2.0 * facet_depth, sum)
        } else {
            // Along the cap (v_z = 0): enters here. Away from it: never.
            (v_z >= 0.0, 0.0, 1.0)
        };
        let entry = div(numerator, denominator);

        let exit = if q > 0.0 { div(slope, q) } else { FAR };
        let floor_radicand = slope * slope - 4.0 * q * floor_depth;
        let floor_sum = slope + sqrt(floor_radicand);
        let floor = if floor_radicand >= 0.0 && floor_sum > FLAT {
            div(2.0 * floor_depth, floor_sum)
        } else {
            FAR
        };
        let entry_t = facet_t + entry;
        let end = min(exit, floor);
        // A ray that follows the cap for ever can hit nothing but the cap.
        let endless = end >= FAR;
        let end = if endless { 0.0 } else { end };

        // The second order is limited to the first: beyond, the series does not
        // converge.
        let reach = max(abs(entry), end);
        let first = abs(from_facet.x) + abs(from_facet.y);
        let second = (abs(uv_bend.x) + abs(uv_bend.y)) * reach;
        let uv_bend = if reach > 1e9 {
            Vec2::ZERO
        } else if second > first {
            uv_bend * div(first, second)
        } else {
            uv_bend
        };
        QuadraticPath {
            enters,
            entry_t,
            entry_from_facet: entry,
            entry_uv: surface.uv + (from_facet + uv_bend * entry) * entry,
            velocity: from_facet + uv_bend * (2.0 * entry),
            uv_bend,
            slope,
            bend: q,
            twist: 0.0,
            steepest: if q < 0.0 {
                slope - 2.0 * q * end
            } else {
                slope
            },
            inverse_depth,
            // Parabola through both ends of the true curve with its slope at the
            // floor, to second order.
            warp: half_bend * (1.0 + half_bend),
            // The foot is limited likewise.
            foot_bend: if (abs(shift.x) + abs(shift.y)) * abs(v_z) * reach > 4.0 {
                Vec2::ZERO
            } else {
                shift * v_z
            },
            start: max(-entry_t, 0.0),
            end,
            ends_on_floor: !endless && floor <= exit,
            is_bent: true,
        }
    }

    /// Returns the path of a ray that leaves the mesh at `exit`, if that lies behind the
    /// facet at distance `facet_t` and `self` contradicts it: `self` ends on the cap, or on
    /// a floor that lies above the floor at the exit.
    ///
    /// Between the entry and the exit, at distance L, the depth is the cubic that has the
    /// slopes R and R_b at the two ends, x = s / L:
    ///
    /// d = L x (1 − x) (R (1 − x) + R_b x).
    ///
    /// Over a sphere it is the parabola of the quadric. The second derivative of the
    /// texture coordinates is the one that leads to those of the exit.
    #[inline]
    pub fn until(self, exit: &Exit, facet_t: Real) -> QuadraticPath {
        let to_facet = exit.t - self.entry_t;
        // The mirror image of the entry, with the same bend.
        let radicand = exit.slope * exit.slope + 4.0 * self.bend * exit.facet_depth;
        let sum = exit.slope + sqrt(max(radicand, 0.0));
        let from_facet = if radicand > 0.0 && sum > FLAT {
            div(2.0 * exit.facet_depth, sum)
        } else {
            0.0
        };
        let last_slope = sqrt(if radicand < 0.0 {
            exit.slope * exit.slope
        } else {
            radicand
        });
        let length = to_facet + from_facet;
        let is_known = exit.t > facet_t && to_facet > 0.0 && length > SHORTEST * exit.t;
        let below_exit = last_slope * (length - self.end);
        let is_above = below_exit < LEAST_BELOW_EXIT * exit.depth;
        let contradicts = self.end > 0.0 && (!self.ends_on_floor || is_above);
        if !is_known || !contradicts {
            return self;
        }
        let inverse = div(1.0, length);
        let bend = (2.0 * self.slope - last_slope) * inverse;
        let twist = (last_slope - self.slope) * (inverse * inverse);
        let depth = |s: Real| s * (self.slope - (bend + twist * s) * s) * self.inverse_depth;

        // The deepest point, a root of the derivative in the form without cancellation.
        let root = sqrt(max(
            self.slope * (self.slope - last_slope) + last_slope * last_slope,
            0.0,
        ));
        let excess = 2.0 * self.slope - last_slope;
        let (numerator, denominator) = if excess >= 0.0 && excess + root > FLAT {
            (self.slope, excess + root)
        } else if excess < 0.0 {
            (root - excess, 3.0 * (last_slope - self.slope))
        } else {
            (0.5, 1.0)
        };
        let deepest = div(numerator, denominator);
        let ends_on_floor = depth(deepest * length) >= 1.0;
        // The depth grows up to there.
        let mut before = 0.0;
        let mut end = if ends_on_floor {
            deepest * length
        } else {
            length
        };
        let mut halvings = if ends_on_floor { 0 } else { HALVINGS };
        while halvings < HALVINGS {
            let middle = 0.5 * (before + end);
            if depth(middle) >= 1.0 {
                end = middle;
            } else {
                before = middle;
            }
            halvings += 1;
        }

        let missing =
            exit.uv - self.entry_uv - (self.velocity + self.uv_bend * to_facet) * to_facet;
        let missing = Vec2::new(
            missing.x - floor(missing.x + 0.5),
            missing.y - floor(missing.y + 0.5),
        );
        // Texture coordinates that hardly change before the facet say nothing.
        let at = div(1.0, max(to_facet, 0.5 * length));
        QuadraticPath {
            bend,
            twist,
            steepest: max(self.slope, last_slope),
            uv_bend: self.uv_bend + missing * (at * at),
            end,
            ends_on_floor,
            ..self
        }
    }

    /// Returns the unit normal of the smooth surface below the point at `s`: the
    /// gradient of the quadric (section 9).
    #[inline]
    pub fn surface_normal(&self, surface: &Surface, direction: Vec3, s: Real) -> Vec3 {
        if !self.is_bent {
            return surface.normal;
        }
        let from_facet = self.entry_from_facet + s;
        let x = direction.dot(surface.tangent) + self.foot_bend.x * from_facet;
        let y = direction.dot(surface.bitangent) + self.foot_bend.y * from_facet;
        let (x, y) = (kept(from_facet * x), kept(from_facet * y));
        let quadric = surface.quadric;
        let raw = surface.normal
            + surface.tangent * (2.0 * quadric.x * x + quadric.y * y)
            + surface.bitangent * (quadric.y * x + 2.0 * quadric.z * y);
        normalize_or(kept3(raw), surface.normal)
    }
}
