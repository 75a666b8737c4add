//! The torus.

use super::shape::{Foot, Metric, Shape, longitude};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A torus around the y axis; u runs around it, v around its tube, from the
/// outer equator upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    /// From the centre to the middle of the tube, object units.
    pub major: f64,
    /// From the middle of the tube to the surface, object units.
    pub minor: f64,
}

impl Shape for Torus {
    fn name(&self) -> &'static str {
        "torus"
    }

    fn foot(&self, point: DVec3) -> Foot {
        let ring = point.x.hypot(point.z) - self.major;
        Foot {
            depth: self.minor - ring.hypot(point.y),
            uv: DVec2::new(
                longitude(point),
                (point.y.atan2(ring) / TAU).rem_euclid(1.0),
            ),
            beyond: f64::NEG_INFINITY,
        }
    }

    fn metric(&self, point: DVec3, limit: f64) -> Metric {
        let to_axis = point.x.hypot(point.z);
        let to_middle = (to_axis - self.major).hypot(point.y);
        // Half of the remainder, so that the lengths stay positive.
        let reach = limit.min(0.5 * to_axis).min(0.5 * to_middle);
        Metric {
            reach,
            lengths: DVec2::new(to_axis - reach, to_middle - reach) * TAU,
        }
    }

    fn largest_depth(&self) -> f64 {
        self.minor
    }

    fn radius(&self) -> f64 {
        self.major + self.minor
    }

    fn closed(&self) -> [bool; 2] {
        [true, true]
    }
}
