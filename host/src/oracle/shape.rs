//! Interface of a smooth surface for the analytic oracle, in object space.

use glam::{DVec2, DVec3};

/// A point relative to the smooth surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Depth of the point below the surface along its normal, object units;
    /// negative outside. 1-Lipschitz: no point of the surface is nearer.
    pub depth: f64,
    /// Texture coordinates of the nearest point of the surface, as in the mesh:
    /// 0…1 over the surface, v up.
    pub uv: DVec2,
    /// Lower bound of the distance to the solid for points beyond the surface's
    /// borders. Between the borders it is negative, and its magnitude is a lower
    /// bound of the distance to them; −∞ for a surface without borders.
    pub beyond: f64,
}

/// Lengths of texture coordinates around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Distance from the point within which `lengths` hold, object units.
    pub reach: f64,
    /// Minimum length of a unit of u and of v, object units: the gradients of u
    /// and v are at most one over these.
    pub lengths: DVec2,
}

/// A smooth surface whose depth and texture coordinates are known.
pub trait Shape: Sync {
    /// Returns its name, which is that of its mesh in `assets/meshes`.
    fn name(&self) -> &'static str;

    /// Returns `point` relative to the surface.
    fn foot(&self, point: DVec3) -> Foot;

    /// Returns the metric around `point`, whose depth is at least 0 and less than
    /// [`Shape::largest_depth`], with a reach of at most `limit`.
    fn metric(&self, point: DVec3, limit: f64) -> Metric;

    /// Returns the depth at which normals of the surface first meet, object units:
    /// an upper bound of the depth of a relief.
    fn largest_depth(&self) -> f64;

    /// Returns the radius of a ball around the origin that contains the surface and
    /// everything below it.
    fn radius(&self) -> f64;

    /// Returns whether u and v are periodic.
    fn closed(&self) -> [bool; 2];
}

/// Computes the longitude around the y axis as a texture coordinate, 0…1 from +z
/// towards +x.
pub(super) fn longitude(point: DVec3) -> f64 {
    (point.x.atan2(point.z) / std::f64::consts::TAU).rem_euclid(1.0)
}
