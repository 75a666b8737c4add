//! Developable surfaces: plane and open cylinder.

use super::shape::{Foot, Metric, Shape, longitude};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A square in the xz plane, seen from +y; u runs along +x, v along −z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Object units.
    pub side: f64,
}

impl Shape for Plane {
    fn name(&self) -> &'static str {
        "plane"
    }

    fn foot(&self, point: DVec3) -> Foot {
        Foot {
            depth: -point.y,
            uv: DVec2::new(point.x, -point.z) / self.side + 0.5,
            beyond: point.x.abs().max(point.z.abs()) - 0.5 * self.side,
        }
    }

    fn metric(&self, _: DVec3, limit: f64) -> Metric {
        Metric {
            reach: limit,
            lengths: DVec2::splat(self.side),
        }
    }

    fn largest_depth(&self) -> f64 {
        // Bounded by the ball of `radius`.
        self.side
    }

    fn radius(&self) -> f64 {
        1.5 * self.side
    }

    fn closed(&self) -> [bool; 2] {
        [false, false]
    }
}

/// A cylinder around the y axis without caps, centred at the origin; u is the
/// longitude from +z towards +x, v runs upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Object units.
    pub radius: f64,
    /// Object units.
    pub height: f64,
}

impl Shape for Cylinder {
    fn name(&self) -> &'static str {
        "cylinder"
    }

    fn foot(&self, point: DVec3) -> Foot {
        Foot {
            depth: self.radius - point.x.hypot(point.z),
            uv: DVec2::new(longitude(point), point.y / self.height + 0.5),
            beyond: point.y.abs() - 0.5 * self.height,
        }
    }

    fn metric(&self, point: DVec3, limit: f64) -> Metric {
        let to_axis = point.x.hypot(point.z);
        let reach = limit.min(0.5 * to_axis);
        Metric {
            reach,
            lengths: DVec2::new(TAU * (to_axis - reach), self.height),
        }
    }

    fn largest_depth(&self) -> f64 {
        self.radius
    }

    fn radius(&self) -> f64 {
        self.radius.hypot(0.5 * self.height)
    }

    fn closed(&self) -> [bool; 2] {
        [true, false]
    }
}
