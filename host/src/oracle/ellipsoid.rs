//! The ellipsoid, whose foot point is found by Newton's method.

use super::shape::{Foot, Metric, Shape};
use super::sphere::spherical;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// An ellipsoid around the origin: a sphere with its texture, stretched along the
/// axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Half axes along x, y and z, object units.
    pub axes: DVec3,
}

impl Ellipsoid {
    /// Finds the nearest point of the surface, and λ of
    /// point = foot + λ foot / axes²: positive outside, negative inside.
    ///
    /// foot_i = a_i² p_i / (λ + a_i²) lies on the surface where
    /// f(λ) = Σ (a_i p_i / (λ + a_i²))² − 1 is 0. Above −min a_i² f is decreasing
    /// and convex, so Newton's method started where f ≥ 0 approaches the only root
    /// from below, and converges quadratically.
    fn nearest(&self, point: DVec3) -> (DVec3, f64) {
        let squares = self.axes * self.axes;
        // A coordinate of 0 would hide its side of the surface deep inside.
        let least = 1e-9 * self.axes.min_element();
        let point = DVec3::from(point.to_array().map(|x| x.signum() * x.abs().max(least)));
        let scaled = self.axes * point;
        // One term of the sum is 1 here, so f ≥ 0.
        let mut lambda = (scaled.abs() - squares).max_element();
        for _ in 0..STEPS {
            let terms = scaled / (squares + lambda);
            let f = terms.length_squared() - 1.0;
            let slope = -2.0 * (terms * terms / (squares + lambda)).element_sum();
            let next = lambda - f / slope;
            // Converged to rounding.
            if next <= lambda {
                break;
            }
            lambda = next;
        }
        (squares * point / (squares + lambda), lambda)
    }

    /// Returns the maximum curvature, 1 / object units.
    fn curvature(&self) -> f64 {
        self.axes.max_element() / self.axes.min_element().powi(2)
    }
}

/// Maximum number of steps. Far from the root a step increases λ + a² by half, so
/// these suffice from the least coordinate to any root.
const STEPS: usize = 100;

impl Shape for Ellipsoid {
    fn name(&self) -> &'static str {
        "ellipsoid"
    }

    fn foot(&self, point: DVec3) -> Foot {
        let (foot, lambda) = self.nearest(point);
        Foot {
            depth: -lambda * (foot / (self.axes * self.axes)).length(),
            uv: spherical(foot / self.axes),
            beyond: f64::NEG_INFINITY,
        }
    }

    fn metric(&self, point: DVec3, limit: f64) -> Metric {
        let (foot, lambda) = self.nearest(point);
        let depth = -lambda * (foot / (self.axes * self.axes)).length();
        // The foot point moves at most 1 / slowness times as fast as the point, and
        // its image on the unit sphere 1 / axis times as fast as that.
        let slowness = 1.0 - (depth + limit) * self.curvature();
        let least = self.axes.min_element() * slowness;
        let unit = foot / self.axes;
        let to_axis = unit.x.hypot(unit.z);
        let reach = limit.min(0.5 * to_axis * least);
        Metric {
            reach,
            lengths: DVec2::new(TAU * (to_axis - reach / least), PI) * least,
        }
    }

    fn largest_depth(&self) -> f64 {
        self.curvature().recip()
    }

    fn radius(&self) -> f64 {
        self.axes.max_element()
    }

    fn closed(&self) -> [bool; 2] {
        [true, false]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SHAPE: Ellipsoid = Ellipsoid {
        axes: DVec3::new(1.2, 0.8, 1.0),
    };

    proptest! {
        /// λ solves the equation to rounding, inside, outside and on the planes
        /// of symmetry, and no other point of the surface is nearer.
        #[test]
        fn newton_finds_the_nearest_point(
            point in proptest::array::uniform3(-2.0f64..2.0),
            flatten in proptest::array::uniform3(0u8..4),
            other in proptest::array::uniform3(-1.0f64..1.0),
        ) {
            let flat = DVec3::from(flatten.map(|f| f64::from(u8::from(f > 0))));
            let point = DVec3::from(point) * flat;
            let (foot, lambda) = SHAPE.nearest(point);
            // Where normals meet, the denominator of the foot is a small difference.
            let meets = lambda + SHAPE.axes.min_element().powi(2) < 1e-3;
            let tolerance = if meets { 1e-6 } else { 1e-12 };
            prop_assert!(((foot / SHAPE.axes).length() - 1.0).abs() < tolerance, "{foot}");
            let distance = point.distance(foot);
            let depth = SHAPE.foot(point).depth;
            prop_assert!((distance - depth.abs()).abs() < 1e-8 + tolerance);
            prop_assert_eq!(lambda > 0.0, (point / SHAPE.axes).length() > 1.0);
            let other = SHAPE.axes * DVec3::from(other).normalize_or(DVec3::X);
            prop_assert!(point.distance(other) >= distance - 1e-8 - tolerance);
        }
    }
}
