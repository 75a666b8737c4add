//! The sphere.

use super::shape::{Foot, Metric, Shape, longitude};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A sphere around the origin; u is the longitude from +z towards +x, v the
/// latitude from −y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Object units.
    pub radius: f64,
}

impl Shape for Sphere {
    fn name(&self) -> &'static str {
        "sphere"
    }

    fn foot(&self, point: DVec3) -> Foot {
        Foot {
            depth: self.radius - point.length(),
            uv: spherical(point),
            beyond: f64::NEG_INFINITY,
        }
    }

    fn metric(&self, point: DVec3, limit: f64) -> Metric {
        let to_axis = point.x.hypot(point.z);
        // Half the distance to the axis, so that the lengths stay positive.
        let reach = limit.min(0.5 * to_axis);
        Metric {
            reach,
            lengths: DVec2::new(TAU * (to_axis - reach), PI * (point.length() - reach)),
        }
    }

    fn largest_depth(&self) -> f64 {
        self.radius
    }

    fn radius(&self) -> f64 {
        self.radius
    }

    fn closed(&self) -> [bool; 2] {
        [true, false]
    }
}

/// Returns longitude and latitude of `direction`, each 0…1; any length but zero.
pub(super) fn spherical(direction: DVec3) -> DVec2 {
    let latitude = direction.y.atan2(direction.x.hypot(direction.z));
    DVec2::new(longitude(direction), latitude / PI + 0.5)
}
