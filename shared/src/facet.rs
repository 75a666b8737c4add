//! Intersection of the eye's ray with a flat triangle.

use crate::arithmetic::{abs, div, max};
use crate::layout::{Frame, Object, Triangle, vec3};
use crate::{Real, Vec3};

/// Intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetHit {
    /// Whether the ray hits the triangle's front side.
    pub hit: bool,
    /// Distance from the eye, object units.
    pub t: Real,
    /// Barycentrics of the corners; they sum to 1.
    pub weights: Vec3,
    /// The facet's normal, pointing out, of any length.
    pub normal: Vec3,
}

/// Intersects the ray from `eye` along the unit vector `direction` with the front
/// side of `triangle`.
///
/// The test is watertight: the sign for an edge is computed from the edge's
/// midpoint and difference (Plücker coordinates), which two triangles that
/// share the edge compute from the same numbers, one the exact negative of the
/// other. A ray through a closed mesh never slips between two triangles, on
/// any device that rounds sums and products alike.
// The CPU calls it for every facet on a ray, most of which it misses.
#[inline(always)]
pub fn intersect(eye: Vec3, direction: Vec3, triangle: &Triangle) -> FacetHit {
    let a = vec3(triangle.corners[0].position) - eye;
    let b = vec3(triangle.corners[1].position) - eye;
    let c = vec3(triangle.corners[2].position) - eye;
    let normal = (b - a).cross(c - a);
    let miss = FacetHit {
        hit: false,
        t: 0.0,
        weights: Vec3::ZERO,
        normal,
    };
    let facing = direction.dot(normal);
    if facing >= 0.0 {
        return miss;
    }
    // Seen from the front, every edge has the ray on its left.
    let wa = direction.dot((c - b).cross(c + b));
    if wa < 0.0 {
        return miss;
    }
    let wb = direction.dot((a - c).cross(a + c));
    let wc = direction.dot((b - a).cross(b + a));
    let sum = wa + wb + wc;
    if wb >= 0.0 && wc >= 0.0 && sum > 0.0 {
        let scale = div(1.0, sum);
        FacetHit {
            hit: true,
            t: div(a.dot(normal), facing),
            weights: Vec3::new(wa * scale, wb * scale, wc * scale),
            normal,
        }
    } else {
        miss
    }
}

/// Share of a triangle's size by which [`may_hit`] lets rays pass beside it.
const BESIDE: Real = 0.02;

/// Returns whether [`intersect`] may find a hit on the front side of `triangle`, however a
/// device rounds.
#[inline]
pub fn may_hit(eye: Vec3, direction: Vec3, triangle: &Triangle) -> bool {
    let a = vec3(triangle.corners[0].position) - eye;
    let b = vec3(triangle.corners[1].position) - eye;
    let c = vec3(triangle.corners[2].position) - eye;
    let wa = direction.dot((c - b).cross(c + b));
    let wb = direction.dot((a - c).cross(a + c));
    let wc = direction.dot((b - a).cross(b + a));
    let least = -BESIDE * abs(wa + wb + wc);
    wa >= least && wb >= least && wc >= least
}

/// Returns whether the eye of `frame` may lie in the shell over `triangle`, or so near
/// that the near plane does: a ball around both contains the eye. Then a facet in
/// front of the near plane or behind the eye counts as hit, too.
#[inline]
pub fn may_surround_eye(frame: &Frame, object: &Object, triangle: &Triangle) -> bool {
    let eye = vec3(frame.eye);
    let a = vec3(triangle.corners[0].position) - eye;
    let b = vec3(triangle.corners[1].position) - eye;
    let c = vec3(triangle.corners[2].position) - eye;
    let (ab, ac) = (b - a, c - a);
    let side = max(ab.dot(ab), ac.dot(ac));
    // (x + y)² ≤ 2 (x² + y²)
    let shell = 2.0 * object.depth + frame.near;
    a.dot(a) <= 2.0 * (side + shell * shell)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::layout::Corner;
    use proptest::prelude::*;

    fn triangle(corners: [[Real; 3]; 3]) -> Triangle {
        Triangle {
            corners: corners.map(|position| Corner {
                position,
                ..Corner::default()
            }),
            ..Triangle::default()
        }
    }

    fn unit(v: Vec3) -> Vec3 {
        crate::arithmetic::normalize_or(v, Vec3::Z)
    }

    #[test]
    fn the_front_is_hit_and_the_back_is_not() {
        let front = triangle([[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]]);
        let back = triangle([[0.0, 0.0, -1.0], [0.0, 1.0, -1.0], [1.0, 0.0, -1.0]]);
        let direction = unit(Vec3::new(0.2, 0.3, -1.0));
        let hit = intersect(Vec3::ZERO, direction, &front);
        assert!(hit.hit);
        assert!(
            (direction * hit.t - Vec3::new(0.2, 0.3, -1.0))
                .dot(Vec3::ONE)
                .abs()
                < 1e-6
        );
        assert!((hit.weights - Vec3::new(0.5, 0.2, 0.3)).abs().max_element() < 1e-6);
        assert!(!intersect(Vec3::ZERO, direction, &back).hit);
    }

    #[test]
    fn a_triangle_without_area_is_never_hit() {
        let point = triangle([[0.0, 0.0, -1.0]; 3]);
        let line = triangle([[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [2.0, 0.0, -1.0]]);
        for direction in [Vec3::NEG_Z, unit(Vec3::new(1.0, 0.0, -1.0))] {
            assert!(!intersect(Vec3::ZERO, direction, &point).hit);
            assert!(!intersect(Vec3::ZERO, direction, &line).hit);
        }
    }

    /// The shell of a facet behind the eye may still surround the eye.
    #[test]
    fn a_facet_behind_the_eye_is_met_at_a_negative_distance() {
        let behind = triangle([[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 1.0, 1.0]]);
        let hit = intersect(Vec3::ZERO, Vec3::NEG_Z, &behind);
        assert!(hit.hit);
        assert!((hit.t + 1.0).abs() < 1e-6, "{}", hit.t);
    }

    proptest! {
        /// Against the textbook's determinants (Cramer's rule) in f64.
        #[test]
        fn hits_agree_with_cramers_rule(
            numbers in proptest::array::uniform9(-2.0f32..2.0),
            eye in proptest::array::uniform3(-2.0f32..2.0),
            aim in proptest::array::uniform2(-0.5f32..1.5),
        ) {
            let [a, b, c] = [0, 3, 6].map(|i| Vec3::from_slice(&numbers[i..i + 3]));
            let eye = Vec3::from(eye);
            let target = a + (b - a) * aim[0] + (c - a) * aim[1];
            let direction = unit(target - eye);
            let found = intersect(eye, direction, &triangle([a, b, c].map(|p| p.to_array())));

            let wide = |v: Vec3| v.as_dvec3();
            let (ab, ac, ae) = (wide(b) - wide(a), wide(c) - wide(a), wide(eye) - wide(a));
            let ray = wide(direction);
            let normal = ab.cross(ac);
            let determinant = -ray.dot(normal);
            // Not seen from the side, and not a sliver.
            prop_assume!(determinant.abs() > 0.05 * normal.length());
            prop_assume!(normal.length() > 0.05 * ab.length() * ac.length() && normal.length() > 0.05);
            let cross = ae.cross(ray);
            let wb = ac.dot(cross) / determinant;
            let wc = -ab.dot(cross) / determinant;
            let weights = [1.0 - wb - wc, wb, wc];
            let margin = weights.iter().fold(f64::INFINITY, |least, &w| least.min(w));
            if margin.abs() > 1e-3 {
                prop_assert_eq!(found.hit, determinant > 0.0 && margin > 0.0);
            }
            if found.hit {
                let t = ae.dot(normal) / determinant;
                prop_assert!((f64::from(found.t) - t).abs() < 1e-3, "{} {}", found.t, t);
                for (i, weight) in weights.into_iter().enumerate() {
                    prop_assert!((f64::from(found.weights[i]) - weight).abs() < 1e-3);
                }
            }
        }

        /// A fan of triangles around a point covers every ray near the point.
        #[test]
        fn shared_edges_do_not_leak(
            height in 0.1f32..50.0,
            aim in 0.0f32..1.0,
            corner in 0usize..6,
            offset in -1e-6f32..1e-6,
            eye in (-0.3f32..0.3, -0.3f32..0.3, 0.0f32..0.3),
        ) {
            let rim: Vec<[f32; 3]> = (0..6)
                .map(|i| {
                    let angle = core::f32::consts::TAU * i as f32 / 6.0;
                    [angle.cos(), angle.sin(), -height]
                })
                .collect();
            let centre = [0.0, 0.0, -height];
            let eye = Vec3::new(eye.0, eye.1, eye.2);
            // Aim along an edge of the fan, a rounding error aside.
            let target = Vec3::from(centre).lerp(Vec3::from(rim[corner]), aim * 0.9)
                + Vec3::new(offset, -offset, 0.0);
            let direction = unit(target - eye);
            let hits = (0..6)
                .filter(|&i| {
                    let t = triangle([centre, rim[i], rim[(i + 1) % 6]]);
                    intersect(eye, direction, &t).hit
                })
                .count();
            prop_assert!(hits >= 1);
        }
    }
}
