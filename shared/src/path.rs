//! Where the ray is: in texture coordinates and in depth, at a distance s.
//!
//! A tier is a path. The march asks a path for nothing but what [`Path`] says,
//! so that a new model of the surface is one new path.

use crate::arithmetic::{abs, clamp, div, max, min, sqrt};
use crate::layout::{TIER_FAST, vec3};
use crate::surface::Surface;
use crate::{FAR, Real, Vec2, Vec3};

/// A ray inside the shell between the cap and the floor. `s` is the distance,
/// in object units, from where the ray enters the shell.
pub trait Path {
    /// Texture coordinates at `s`, repeats.
    fn uv(&self, s: Real) -> Vec2;
    /// Depth fraction δ at `s`: 0 at the cap, 1 at the floor.
    fn depth_fraction(&self, s: Real) -> Real;
    /// Change of the texture coordinates at s = 0 and at the end, repeats per
    /// object unit; in between it changes evenly.
    fn uv_rates(&self) -> (Vec2, Vec2);
    /// Whether these are the same: nothing is computed of what does not change.
    fn is_even(&self) -> bool;
    /// An upper bound of dδ/ds on the path, 1 / object units, ≥ 0.
    fn depth_rate(&self) -> Real;
    /// Where the march begins: 0, or the eye where it is inside the shell.
    fn start(&self) -> Real;
    /// Where the ray leaves the shell.
    fn end(&self) -> Real;
    /// Whether it leaves through the floor (else through the cap: silhouette).
    fn ends_on_floor(&self) -> bool;
}

/// The straight ray over a flat surface or the bent ray over a quadric.
///
/// Section 4 measures the depth below the quadric along the normal at the facet,
/// δ0 + V_z s − q s², and takes the texture coordinates from right above. Both
/// are right to the order that matters only while the depth is small against the
/// radius of curvature. Here the depth d is that along the normal below which
/// the point lies: over a sphere or a cylinder of curvature k,
///
/// d − ½ k d² = δ0 + V_z s − (q + ½ k V_z²) s²,
///
/// still a parabola, and exact; over any quadric Q the choice k = 2 |Q V|² / q
/// makes it right to third order. That normal stands at V s + 2 d Q V s, and
/// ∇u changes on the way there, which makes texture coordinates of second order.
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
    /// Change of the texture coordinates at the entry, repeats per object unit.
    pub velocity: Vec2,
    /// Half their second derivative, repeats per square object unit.
    pub uv_bend: Vec2,
    /// R: depth gained per unit of s at the entry, ≥ 0.
    pub slope: Real,
    /// q + ½ k V_z²: bend of the ray, 1 / object units, > 0 where the surface
    /// falls away.
    pub bend: Real,
    /// What d − ½ k d² has to be multiplied with to be 1 at the floor, 1 / object units.
    pub inverse_depth: Real,
    /// About ½ k S_z: by how much δ lags behind d − ½ k d².
    pub warp: Real,
    /// By how much the foot of the normal moves on, in the surface's frame, for
    /// the square of the distance from the facet.
    foot_bend: Vec2,
    start: Real,
    end: Real,
    ends_on_floor: bool,
    /// Whether `bend`, `uv_bend` and `warp` may be other than 0.
    is_bent: bool,
}

/// Half the curvature times the depth, at most: beyond, the shell comes near to
/// the centre of curvature, and the series for a smaller depth are better.
const MOST_WARP: Real = 0.25;

/// Below this a curvature is none: its reciprocal would leave the range of
/// values that keep their meaning in f32.
const FLAT: Real = 1e-18;

impl QuadraticPath {
    /// The path of the ray along the unit vector `direction`, which meets the
    /// facet under `surface` at distance `facet_t`, through a shell of depth
    /// `depth` > 0 (object units); `tier` is a `TIER_` constant.
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

    /// The ray over a flat surface.
    #[inline]
    fn straight(surface: &Surface, direction: Vec3, facet_t: Real, depth: Real) -> QuadraticPath {
        let v_z = -direction.dot(surface.normal);
        let slope = abs(v_z);
        let goes_down = slope > FLAT;
        QuadraticPath {
            // Along the cap it enters here, away from it never.
            enters: v_z >= 0.0,
            entry_t: facet_t,
            entry_from_facet: 0.0,
            entry_uv: surface.uv,
            velocity: Vec2::new(
                direction.dot(surface.gradient_u),
                direction.dot(surface.gradient_v),
            ),
            uv_bend: Vec2::ZERO,
            slope,
            bend: 0.0,
            inverse_depth: div(1.0, depth),
            warp: 0.0,
            foot_bend: Vec2::ZERO,
            start: max(-facet_t, 0.0),
            // A ray that runs along the cap for ever can hit nothing but the cap.
            end: if goes_down { div(depth, slope) } else { 0.0 },
            ends_on_floor: goes_down,
            is_bent: false,
        }
    }

    /// The ray over a quadric: equations (12) and (14), with the cross term and
    /// the facet depth of section 4.
    #[inline]
    fn bent(surface: &Surface, direction: Vec3, facet_t: Real, depth: Real) -> QuadraticPath {
        let v_x = direction.dot(surface.tangent);
        let v_y = direction.dot(surface.bitangent);
        let v_z = -direction.dot(surface.normal);
        let velocity = Vec2::new(
            direction.dot(surface.gradient_u),
            direction.dot(surface.gradient_v),
        );
        let quadric = surface.quadric;
        // Q V, and q = V · Q V.
        let turn = Vec2::new(
            quadric.x * v_x + 0.5 * quadric.y * v_y,
            0.5 * quadric.y * v_x + quadric.z * v_y,
        );
        let q = turn.x * v_x + turn.y * v_y;
        let turn_squared = turn.dot(turn);
        let tangential = v_x * v_x + v_y * v_y;

        // ½ k S_z, with less than |Q V|² / q where the ray nearly follows one of
        // the lines in which a saddle is straight.
        let least = max(q * q, tangential * turn_squared * 0.0625);
        let half_bend = if least > FLAT * FLAT {
            clamp(
                div(turn_squared, least) * (q * depth),
                -MOST_WARP,
                MOST_WARP,
            )
        } else {
            0.0
        };
        let floor_depth = depth * (1.0 - half_bend);
        let inverse_depth = div(1.0, floor_depth);
        let half_curvature = half_bend * (1.0 - half_bend) * inverse_depth;
        let q = q + half_curvature * (v_z * v_z);
        let q = if q < FLAT && q > -FLAT { 0.0 } else { q };

        // The quadric does not reach down to a facet so deep: forget the depth.
        let radicand = v_z * v_z + 4.0 * q * surface.facet_depth;
        let facet_depth = if radicand < 0.0 {
            0.0
        } else {
            surface.facet_depth
        };
        let radicand = if radicand < 0.0 { v_z * v_z } else { radicand };
        let slope = sqrt(radicand);

        // 2 Q V, with as little of the curvature as for the depth.
        let reach = 16.0 * (depth * depth) * turn_squared;
        let share = if reach > tangential {
            div(tangential, reach)
        } else {
            1.0
        };
        let shift = turn * (2.0 * share);
        let shift_in_space = surface.tangent * shift.x + surface.bitangent * shift.y;
        let uv_shift = Vec2::new(
            shift_in_space.dot(surface.gradient_u),
            shift_in_space.dot(surface.gradient_v),
        );
        let from_facet = velocity + uv_shift * facet_depth;
        let uv_bend = uv_shift * v_z + surface.uv_bend;

        // The root at which the ray goes down, by the form that does not cancel.
        let sum = v_z + slope;
        let (enters, entry) = if v_z < 0.0 && (q > 0.0 || (q < 0.0 && sum > FLAT)) {
            (true, div(0.5 * (v_z - slope), q))
        } else if sum > FLAT {
            (true, div(-2.0 * facet_depth, sum))
        } else {
            // Along the cap (v_z = 0): enters here. Away from it: never.
            (v_z >= 0.0, 0.0)
        };

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
        // A ray that runs along the cap for ever can hit nothing but the cap.
        let endless = end >= FAR;
        let end = if endless { 0.0 } else { end };

        // The second order stays below the first: where it does not, a series
        // is of no use.
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
            inverse_depth,
            // The parabola through both ends of the true curve with its slope at
            // the floor, to second order.
            warp: half_bend * (1.0 + half_bend),
            // Nor does the foot run ahead of the ray.
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

    /// Unit normal of the smooth surface below the point at `s` (section 9):
    /// the gradient of the quadric there.
    #[inline]
    pub fn surface_normal(&self, surface: &Surface, direction: Vec3, s: Real, tier: u32) -> Vec3 {
        if tier != TIER_FAST {
            return surface.normal;
        }
        let from_facet = self.entry_from_facet + s;
        let x = from_facet * (direction.dot(surface.tangent) + self.foot_bend.x * from_facet);
        let y = from_facet * (direction.dot(surface.bitangent) + self.foot_bend.y * from_facet);
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
        self.entry_uv + (self.velocity + self.uv_bend * s) * s
    }

    #[inline]
    fn depth_fraction(&self, s: Real) -> Real {
        if self.is_bent {
            let even = s * (self.slope - self.bend * s) * self.inverse_depth;
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
        // The ray is steepest where it enters, or, on a concave surface, where it ends.
        let steepest = if self.bend < 0.0 {
            self.slope - 2.0 * self.bend * self.end
        } else {
            self.slope
        };
        steepest * self.inverse_depth * (1.0 + abs(self.warp))
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
        uv_bend: Vec2::ZERO,
        facet_depth,
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References are computed in f64, by the standard library.
mod tests {
    use super::*;
    use crate::layout::TIER_PLANAR;
    use crate::shape_map::tests::Random;

    /// A ray over a quadric patch: the inputs of section 4, in f64.
    #[derive(Clone, Copy, Debug)]
    struct Ray {
        quadric: [f64; 3],
        facet_depth: f64,
        direction: [f64; 3],
        facet_t: f64,
        depth: f64,
    }

    impl Ray {
        /// Any curvature, depth and direction; the unit of length spans six
        /// orders of magnitude, and zeros are frequent.
        fn random(random: &mut Random) -> Ray {
            let unit = random.magnitude(1e-3, 1e3);
            let curvature = random.choose(&[0.0, 1e-9, 1e-3, 0.3, 3.0]) / unit;
            let entry = |random: &mut Random| curvature * random.within(-1.0, 1.0);
            let z = random.choose(&[0.0, 1e-4, 0.1, 1.0]) * random.within(-1.0, 1.0);
            let angle = random.within(0.0, std::f64::consts::TAU);
            let tangential = (1.0 - z * z).sqrt();
            Ray {
                quadric: [entry(random), entry(random), entry(random)],
                facet_depth: random.choose(&[0.0, 1e-4, 0.1]) * random.within(-1.0, 1.0) * unit,
                direction: [tangential * angle.cos(), tangential * angle.sin(), -z],
                facet_t: random.within(-1.0, 10.0) * unit,
                depth: random.magnitude(1e-3, 1.0) * unit,
            }
            .narrowed()
        }

        /// Rounded to f32, so that both sides start from the same numbers.
        fn narrowed(self) -> Ray {
            let narrow = |x: f64| f64::from(x as f32);
            Ray {
                quadric: self.quadric.map(narrow),
                facet_depth: narrow(self.facet_depth),
                direction: self.direction.map(narrow),
                facet_t: narrow(self.facet_t),
                depth: narrow(self.depth),
            }
        }

        fn path(&self, tier: u32) -> QuadraticPath {
            QuadraticPath::new(
                &test_surface(self.quadric.map(|q| q as f32), self.facet_depth as f32),
                vec3(self.direction.map(|x| x as f32)),
                self.facet_t as f32,
                self.depth as f32,
                tier,
            )
        }

        fn v_z(&self) -> f64 {
            -self.direction[2]
        }

        /// Q V.
        fn turn(&self) -> [f64; 2] {
            let ([xx, xy, yy], [x, y, _]) = (self.quadric, self.direction);
            [xx * x + 0.5 * xy * y, 0.5 * xy * x + yy * y]
        }

        /// q of section 4.
        fn section_q(&self) -> f64 {
            self.turn()[0] * self.direction[0] + self.turn()[1] * self.direction[1]
        }

        /// |V|² along the surface.
        fn tangential(&self) -> f64 {
            self.direction[0].powi(2) + self.direction[1].powi(2)
        }

        /// ½ k S_z.
        fn half_bend(&self) -> f64 {
            let [x, y] = self.turn();
            let turn_squared = x * x + y * y;
            let least = (self.section_q().powi(2)).max(self.tangential() * turn_squared / 16.0);
            if least <= 1e-36 {
                return 0.0;
            }
            (turn_squared / least * self.section_q() * self.depth).clamp(-0.25, 0.25)
        }

        /// q + ½ k V_z².
        fn q(&self) -> f64 {
            self.section_q() + self.half_bend() / self.depth * self.v_z().powi(2)
        }

        /// By how much the texture coordinates bend: 2 Q V, where that is small.
        fn shift(&self) -> [f64; 2] {
            let [x, y] = self.turn();
            let reach = 16.0 * self.depth.powi(2) * (x * x + y * y);
            let share = if reach > self.tangential() {
                self.tangential() / reach
            } else {
                1.0
            };
            [2.0 * share * x, 2.0 * share * y]
        }

        /// δ where d − ½ k d² is `even`.
        fn fraction_of(&self, even: f64) -> f64 {
            let half_bend = self.half_bend();
            let even = even / (self.depth * (1.0 - half_bend));
            even * (1.0 - half_bend * (1.0 + half_bend) * (1.0 - even))
        }

        fn radicand(&self) -> f64 {
            self.v_z().powi(2) + 4.0 * self.q() * self.facet_depth
        }

        /// R.
        fn root(&self) -> f64 {
            if self.radicand() < 0.0 {
                self.v_z().abs()
            } else {
                self.radicand().sqrt()
            }
        }

        /// Not away from a flat or hollow cap, which never comes back.
        fn enters(&self) -> bool {
            self.q() > 0.0 || self.v_z() + self.root() > 0.0
        }

        /// δ0 as it counts: none where the quadric does not reach the facet.
        fn counted_facet_depth(&self) -> f64 {
            if self.radicand() < 0.0 {
                0.0
            } else {
                self.facet_depth
            }
        }

        /// d − ½ k d² at the distance `s` from the facet.
        fn depth_at(&self, s: f64) -> f64 {
            self.counted_facet_depth() + s * (self.v_z() - self.q() * s)
        }

        /// The size of the terms of [`Ray::depth_at`], which rounding is relative to.
        fn scale_at(&self, s: f64) -> f64 {
            self.facet_depth.abs() + (self.v_z() * s).abs() + (self.q() * s * s).abs()
        }

        /// Where one rounding decides between two answers, or where q or V_z + R
        /// is the difference of larger numbers, f32 cannot agree with f64.
        fn well_conditioned(&self) -> bool {
            let terms = self.v_z().powi(2) + (4.0 * self.q() * self.facet_depth).abs();
            let [x, y, _] = self.direction.map(f64::abs);
            let q_terms = self.quadric[0].abs() * x * x
                + self.quadric[1].abs() * x * y
                + self.quadric[2].abs() * y * y;
            (self.radicand().abs() > 1e-3 * terms || terms == 0.0)
                && self.section_q().abs() >= 0.1 * q_terms
                && (q_terms == 0.0 || self.section_q().abs() > 1e-15)
                && (self.q() == 0.0 || self.q().abs() > 1e-15)
                && (self.q() >= 0.0
                    || self.v_z() + self.root() > 0.1 * self.root()
                    || !self.enters())
        }
    }

    fn well_conditioned(seed: u64) -> impl Iterator<Item = Ray> {
        let mut random = Random(seed);
        (0..100_000)
            .map(move |_| Ray::random(&mut random))
            .filter(Ray::well_conditioned)
    }

    #[test]
    fn depth_and_texture_coordinates_follow_section_4() {
        let (mut entering, mut to_floor, mut to_cap) = (0, 0, 0);
        for ray in well_conditioned(1) {
            let path = ray.path(TIER_FAST);
            let v_z = ray.v_z();
            if path.slope > 0.0 {
                assert_eq!(path.enters, ray.enters(), "{ray:?}");
            }
            // Along a flat cap the depth stays δ0: `grazing_rays` looks at these.
            let along = v_z == 0.0 && ray.q() == 0.0;
            if !path.enters || along {
                continue;
            }
            entering += 1;
            let entry = f64::from(path.entry_from_facet);
            // The cap is where the ray enters.
            let scale = ray.scale_at(entry);
            assert!(
                ray.depth_at(entry).abs() <= 4e-6 * scale,
                "{ray:?} {path:?}"
            );
            let entry_t = f64::from(path.entry_t);
            assert!(
                (entry_t - ray.facet_t - entry).abs() <= 1e-6 * (ray.facet_t.abs() + entry.abs())
            );
            // There it goes down, not up.
            assert!(path.slope >= 0.0);

            let end = f64::from(path.end());
            for fraction in [0.1, 0.5, 0.9, 1.0] {
                let s = end * fraction;
                let from_facet = entry + s;
                let expected = ray.fraction_of(ray.depth_at(from_facet));
                let scale = (ray.scale_at(from_facet) + ray.scale_at(entry)) / ray.depth;
                let found = f64::from(path.depth_fraction(s as f32));
                assert!(
                    (found - expected).abs() <= 4e-6 * scale + 1e-6,
                    "{found} {expected} {ray:?} {path:?}"
                );
                // The test surface's uv are x and y.
                let uv = path.uv(s as f32);
                let reach = entry.abs().max(end);
                let first =
                    |i: usize| ray.direction[i] + ray.shift()[i] * ray.counted_facet_depth();
                let second = ray.shift().map(|shift| shift * v_z);
                let sum = |a: f64, b: f64| a.abs() + b.abs();
                let excess = sum(second[0], second[1]) * reach / sum(first(0), first(1));
                let share = if reach > 1e9 {
                    0.0
                } else {
                    1.0 / excess.max(1.0)
                };
                let scale = (1.0 + excess.min(1.0)) * (entry.abs() + s);
                for (i, found) in uv.to_array().into_iter().enumerate() {
                    let expected = (first(i) + share * second[i] * from_facet) * from_facet;
                    assert!(
                        (f64::from(found) - expected).abs() <= 4e-6 * scale,
                        "{found} {expected} {ray:?} {path:?}"
                    );
                }
            }
            if path.ends_on_floor() {
                to_floor += 1;
                assert!(
                    (path.depth_fraction(path.end()) - 1.0).abs() < 1e-5,
                    "{path:?}"
                );
            } else {
                to_cap += 1;
                assert!(path.depth_fraction(path.end()).abs() < 1e-5, "{path:?}");
            }
            // Neither floor nor cap before the end.
            for i in 1..20 {
                let inside = path.depth_fraction((end * f64::from(i) / 20.0) as f32);
                assert!(inside > -1e-5 && inside < 1.0 + 1e-5, "{inside} {path:?}");
            }
        }
        println!("{entering} enter, {to_floor} to the floor, {to_cap} to the cap");
        assert!(entering > 10_000 && to_floor > 5_000 && to_cap > 1_000);
    }

    #[test]
    fn the_steepest_descent_is_never_exceeded() {
        for ray in well_conditioned(2) {
            let path = ray.path(TIER_FAST);
            if !path.enters || path.end() == 0.0 {
                continue;
            }
            for i in 0..=10 {
                let s = f64::from(path.end()) * f64::from(i) / 10.0;
                let from_facet = f64::from(path.entry_from_facet) + s;
                let half_bend = ray.half_bend();
                let floor_depth = ray.depth * (1.0 - half_bend);
                let even = (ray.depth_at(from_facet) / floor_depth).clamp(0.0, 1.0);
                let warped = 1.0 + half_bend * (1.0 + half_bend) * (2.0 * even - 1.0);
                let descent = warped * (ray.v_z() - 2.0 * ray.q() * from_facet) / floor_depth;
                let scale = (ray.v_z().abs() + (ray.q() * from_facet).abs()) / floor_depth;
                assert!(
                    descent <= f64::from(path.depth_rate()) + 4e-6 * scale,
                    "{descent} {} {ray:?}",
                    path.depth_rate()
                );
            }
        }
    }

    #[test]
    fn a_sphere_is_met_to_third_order() {
        let mut random = Random(3);
        for _ in 0..2_000 {
            let radius = random.magnitude(1e-2, 1e2);
            let z = random.within(-0.3, 1.0);
            let angle = random.within(0.0, std::f64::consts::TAU);
            let tangential = (1.0f64 - z * z).sqrt();
            let ray = Ray {
                quadric: [0.5 / radius, 0.0, 0.5 / radius],
                facet_depth: 0.0,
                direction: [tangential * angle.cos(), tangential * angle.sin(), -z],
                facet_t: 3.0 * radius,
                depth: 0.3 * radius,
            };
            let path = ray.path(TIER_FAST);
            let entry = f64::from(path.entry_from_facet);
            let surface = test_surface(ray.quadric.map(|q| q as f32), 0.0);
            let direction = vec3(ray.direction.map(|x| x as f32));
            for fraction in [0.02, 0.1, 0.3] {
                // From the facet point (0, 0, R), where the quadric touches the sphere.
                let from_facet = fraction * radius;
                let [x, y, z] = ray.direction.map(|d| d * from_facet);
                let distance = (x * x + y * y + (radius + z).powi(2)).sqrt();
                let s = (from_facet - entry) as f32;
                let found = f64::from(path.depth_fraction(s)) * ray.depth;
                if s > path.end() {
                    continue;
                }
                // What is left is that the warp is a parabola, too.
                let error = (found - (radius - distance)).abs() / ray.depth;
                assert!(error < 4e-3, "{error} {fraction} {ray:?}");

                // The texture coordinates are x and y of the plane that touches
                // the sphere where the ray does; they are to be those of the
                // place from which the normal leads to the ray.
                let uv = path.uv(s);
                let foot = |along: f64| f64::from(along as f32) * radius / distance;
                let apart = (f64::from(uv.x) - foot(x)).hypot(f64::from(uv.y) - foot(y)) / radius;
                assert!(
                    apart < 1.5 * fraction.powi(3) + 3e-6,
                    "{apart} {fraction} {ray:?}"
                );

                // The normal at the end of the way: that of the sphere below it.
                let exact = Vec3::new(x as f32, y as f32, (radius + z) as f32) / distance as f32;
                let normal = path.surface_normal(&surface, direction, s, TIER_FAST);
                let error = f64::from((normal - exact).length());
                assert!(error < 1.2 * fraction.powi(3) + 1e-5, "{error} {fraction}");
                assert_eq!(
                    path.surface_normal(&surface, direction, s, TIER_PLANAR),
                    Vec3::Z
                );
            }
        }
    }

    #[test]
    fn planar_is_a_surface_without_curvature() {
        let mut random = Random(4);
        for _ in 0..10_000 {
            let ray = Ray::random(&mut random);
            let flat = Ray {
                quadric: [0.0; 3],
                facet_depth: 0.0,
                ..ray
            };
            let (straight, bent) = (ray.path(TIER_PLANAR), flat.path(TIER_FAST));
            // Debug prints every field, the sign of zero aside.
            let text = |path: QuadraticPath| {
                let path = QuadraticPath {
                    is_bent: false,
                    ..path
                };
                format!("{path:?}").replace("-0.0", "0.0")
            };
            assert_eq!(text(straight), text(bent), "{ray:?}");
        }
    }

    /// The straight ray down the axis, bent by `q` (it leans so little that q = `q`/2 · 10⁻⁸ or so).
    fn leaning(quadric: f32, v_z: f32, depth: f32, facet_depth: f32) -> QuadraticPath {
        let v_x = (1.0 - f64::from(v_z).powi(2)).sqrt() as f32;
        QuadraticPath::new(
            &test_surface([quadric, 0.0, 0.0], facet_depth),
            Vec3::new(v_x, 0.0, -v_z),
            1.0,
            depth,
            TIER_FAST,
        )
    }

    #[test]
    fn the_stable_root_keeps_its_digits() {
        // Section 10: C = −0.3 with B = 1 and A from 10⁻⁶ to 0; here B = V_z =
        // 0.6, so q = 0.64 · quadric, and the floor 0.18 deep lies at s = 0.3.
        for quadric in [1e-6, 1e-8, 1e-12, 1e-20, 0.0, -1e-8, -1e-6] {
            let path = leaning(quadric, 0.6, 0.18, 0.0);
            assert!((path.end() - 0.3).abs() < 3e-7, "{quadric} {}", path.end());
            assert!(path.ends_on_floor());
        }
        // The textbook form in f32 loses a part in hundred.
        let (a, b) = (0.64e-6f32, 0.6f32);
        let textbook = (b - (b * b - 4.0 * a * 0.18).sqrt()) / (2.0 * a);
        assert!((textbook - 0.3).abs() > 1e-3, "{textbook}");
    }

    #[test]
    fn the_exit_of_a_convex_surface() {
        // The exit of a chord of a circle: 2 V_z / k, here with k = 4.
        let path = leaning(2.0, 0.6, 0.06, 0.0);
        assert!(!path.ends_on_floor());
        assert!((path.end() - 0.3).abs() < 1e-6);
        // The floor at the very top of the arc is still the floor: (1 − 0.8) / k.
        let path = leaning(1.0, 0.6, 0.1 - 1e-6, 0.0);
        assert!(path.ends_on_floor());
        // A ray that climbs from a facet below the cap entered before the facet.
        let path = leaning(2.0, -0.6, 0.5, 0.01);
        assert!(path.enters && path.entry_from_facet < -0.4);
        assert!(path.entry_from_facet + path.end() > 0.0);
    }

    #[test]
    fn grazing_rays() {
        // Section 10. q > 0: only the cap.
        let convex = leaning(0.5, 0.0, 0.1, 0.0);
        assert!(convex.enters && !convex.ends_on_floor());
        assert_eq!(convex.end(), 0.0);
        // q = 0: along the cap for ever.
        let flat = leaning(0.0, 0.0, 0.1, 0.0);
        assert!(flat.enters && !flat.ends_on_floor());
        assert_eq!(flat.end(), 0.0);
        // q < 0: the floor of a circle with radius 1 at √(1.1² − 1).
        let concave = leaning(-0.5, 0.0, 0.1, 0.0);
        assert!(concave.enters && concave.ends_on_floor());
        assert!((concave.end() - 0.21f32.sqrt()).abs() < 1e-6);
        // Away from a flat or a hollow cap: never.
        assert!(!leaning(0.0, -0.1, 0.1, 0.0).enters);
        assert!(!leaning(-0.5, -0.1, 0.1, 0.0).enters);
        assert!(!leaning(0.0, -0.1, 0.1, 0.01).enters);
        // A facet deeper than the quadric reaches: its depth is forgotten.
        let forgotten = leaning(-0.5, 0.6, 0.1, 1.0);
        assert!(forgotten.enters && forgotten.entry_from_facet == 0.0);
        assert_eq!(forgotten.slope, 0.6);
    }

    #[test]
    fn the_march_starts_at_the_eye_inside_the_shell() {
        let direction = Vec3::new(0.8, 0.0, -0.6);
        let surface = test_surface([0.0; 3], 0.0);
        let path = QuadraticPath::new(&surface, direction, -0.25, 0.6, TIER_FAST);
        assert_eq!(path.entry_t, -0.25);
        assert_eq!(path.start(), 0.25);
        assert!((path.end() - 1.0).abs() < 1e-6);
        let outside = QuadraticPath::new(&surface, direction, 0.25, 0.6, TIER_FAST);
        assert_eq!(outside.start(), 0.0);
    }

    #[test]
    fn every_number_stays_finite() {
        let mut random = Random(5);
        let extreme = |random: &mut Random| -> f32 {
            let special = [
                0.0, -0.0, 1e-45, -1e-45, 1e-39, 1e-30, 1e-20, 1e-18, 1e-10, 1.0, 1e9,
            ];
            let value = match random.whole(0, 2) {
                0 => random.choose(&special),
                _ => random.magnitude(1e-45, 1e9) as f32,
            };
            if random.whole(0, 1) == 0 {
                value
            } else {
                -value
            }
        };
        for _ in 0..200_000 {
            let z = match random.whole(0, 3) {
                0 => random.choose(&[0.0, 1.0, -1.0]),
                1 => extreme(&mut random).clamp(-1.0, 1.0),
                _ => random.within(-1.0, 1.0) as f32,
            };
            let tangential = (1.0 - f64::from(z).powi(2)).sqrt() as f32;
            let angle =
                random.choose(&[0.0, 1.0, random_angle(&mut Random(u64::from(z.to_bits())))]);
            let direction = Vec3::new(
                tangential * angle.cos() as f32,
                tangential * angle.sin() as f32,
                -z,
            );
            let mut value = || extreme(&mut random);
            let surface = Surface {
                uv: Vec2::new(value(), value()),
                gradient_u: Vec3::new(value(), value(), value()),
                gradient_v: Vec3::new(value(), value(), value()),
                ..test_surface([value(), value(), value()], value())
            };
            // 1 / depth must be a number, too.
            let depth = value().abs().max(1e-30);
            let facet_t = value();
            for tier in [TIER_PLANAR, TIER_FAST] {
                let path = QuadraticPath::new(&surface, direction, facet_t, depth, tier);
                // Debug prints every field.
                let text = format!("{path:?}");
                assert!(
                    !text.contains("inf") && !text.contains("NaN"),
                    "{text} from {surface:?} {direction} {depth}"
                );
                assert!(path.start() >= 0.0 && path.end() >= 0.0 && path.slope >= 0.0);
                let normal = path.surface_normal(&surface, direction, path.end(), tier);
                assert!(normal.is_finite(), "{normal} {text}");
                assert!(path.depth_rate() >= 0.0, "{text}");
            }
        }
    }

    fn random_angle(random: &mut Random) -> f64 {
        random.within(0.0, std::f64::consts::TAU)
    }
}
