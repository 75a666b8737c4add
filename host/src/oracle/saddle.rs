//! The saddle, whose foot point is found by Newton's method.

use super::shape::{Foot, Metric, Shape};
use glam::{DVec2, DVec3};

/// The surface y = rise · (x² − z²) over a square around the origin, seen from
/// +y; u runs along +x, v along −z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saddle {
    /// Side of the square, object units.
    pub side: f64,
    /// Coefficient of the surface, 1 / object units.
    pub rise: f64,
}

/// Maximum number of steps: bisection alone exhausts an f64 in fewer.
const STEPS: usize = 100;

impl Saddle {
    /// Finds the nearest point of the surface without borders, and λ of
    /// point = foot + λ (−2 rise x, 1, 2 rise z): positive outside.
    ///
    /// x = p_x / (1 − 2 rise λ) and z = p_z / (1 + 2 rise λ); λ is the root of
    /// f(λ) = rise (x² − z²) + λ − p_y, which increases between the two poles. The
    /// squared distance plus λ times the surface's equation is convex there, so
    /// the root is the nearest point. Newton's steps that leave the bracket are
    /// replaced by bisection; at the end they converge quadratically. For a point
    /// above the ridge with two nearest points, λ is its limit.
    fn nearest(&self, point: DVec3) -> (DVec3, f64) {
        let twice = 2.0 * self.rise;
        let place = |lambda: f64| {
            let stretch = DVec2::new(1.0 - twice * lambda, 1.0 + twice * lambda);
            (DVec2::new(point.x, point.z) / stretch, stretch)
        };
        let height = |foot: DVec2| self.rise * (foot.x * foot.x - foot.y * foot.y);
        let limit = (1.0 - 1e-12) / twice;
        let (mut low, mut high) = (-limit, limit);
        let mut lambda = (point.y - height(DVec2::new(point.x, point.z))).clamp(low, high);
        for _ in 0..STEPS {
            let (foot, stretch) = place(lambda);
            let f = height(foot) + lambda - point.y;
            if f > 0.0 {
                high = lambda;
            } else {
                low = lambda;
            }
            let slope = 1.0 + twice * twice * (foot * foot / stretch).element_sum();
            let newton = lambda - f / slope;
            if (newton - lambda).abs() <= 4.0 * f64::EPSILON * limit {
                break;
            }
            lambda = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
        }
        let (foot, _) = place(lambda);
        (DVec3::new(foot.x, height(foot), foot.y), lambda)
    }

    /// Returns the maximum magnitude of the curvature, 1 / object units: that of the
    /// centre.
    fn curvature(&self) -> f64 {
        2.0 * self.rise
    }
}

impl Shape for Saddle {
    fn name(&self) -> &'static str {
        "saddle"
    }

    fn foot(&self, point: DVec3) -> Foot {
        let (foot, lambda) = self.nearest(point);
        let across = DVec2::new(foot.x, foot.z);
        let depth = -lambda * (1.0 + 4.0 * self.rise * self.rise * across.length_squared()).sqrt();
        let curvature = self.curvature();
        // The foot point moves at most 1 / (1 − κ |depth|) times as fast as the
        // point; over a distance b the depth changes by up to b.
        let excess = across.abs().max_element() - 0.5 * self.side;
        let slowness = (1.0 - depth.abs() * curvature).max(0.0);
        Foot {
            depth,
            uv: DVec2::new(foot.x, -foot.z) / self.side + 0.5,
            beyond: excess * slowness / (1.0 + excess.abs() * curvature),
        }
    }

    fn metric(&self, point: DVec3, limit: f64) -> Metric {
        let depth = self.foot(point).depth;
        let slowness = 1.0 - (depth.abs() + limit) * self.curvature();
        Metric {
            reach: limit,
            lengths: DVec2::splat(self.side * slowness),
        }
    }

    fn largest_depth(&self) -> f64 {
        self.curvature().recip()
    }

    fn radius(&self) -> f64 {
        let half = 0.5 * self.side;
        // The corners lie at height 0, the middles of the sides highest.
        half.hypot(half).max(half.hypot(self.rise * half * half)) + self.largest_depth()
    }

    fn closed(&self) -> [bool; 2] {
        [false, false]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SHAPE: Saddle = Saddle {
        side: 2.0,
        rise: 0.3,
    };

    proptest! {
        /// The foot lies on the surface, the point on its normal, and no other
        /// point of the surface is nearer.
        #[test]
        fn newton_finds_the_nearest_point(
            point in proptest::array::uniform3(-2.0f64..2.0),
            other in proptest::array::uniform2(-3.0f64..3.0),
        ) {
            let point = DVec3::from(point);
            let (foot, lambda) = SHAPE.nearest(point);
            let depth = SHAPE.foot(point).depth.abs();
            // Where normals meet, what is given is no more than the distance.
            if lambda.abs() < 0.99 * SHAPE.largest_depth() {
                let normal = DVec3::new(-2.0 * SHAPE.rise * foot.x, 1.0, 2.0 * SHAPE.rise * foot.z);
                prop_assert!((foot + normal * lambda).distance(point) < 1e-10, "{foot} {lambda}");
                prop_assert!((point.distance(foot) - depth).abs() < 1e-10);
            }
            let [x, z] = other;
            let other = DVec3::new(x, SHAPE.rise * (x * x - z * z), z);
            prop_assert!(point.distance(other) >= depth - 1e-9);
        }
    }
}
