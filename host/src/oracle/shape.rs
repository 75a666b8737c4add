//! What an analytic oracle knows of a smooth surface, in the surface's own space.

use glam::{DVec2, DVec3};

/// A point of space, seen from the smooth surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// How deep the point lies below the surface, along its normal; negative
    /// outside. Object units, and 1-Lipschitz: no point of the surface is nearer.
    pub depth: f64,
    /// Texture coordinates of the nearest point of the surface, as the mesh has
    /// them: 0…1 over the surface, v up.
    pub uv: DVec2,
    /// How far the point lies beyond the surface's borders: no more than the
    /// distance to what stands on and under the surface. Negative between the
    /// borders, and there no more than the distance to them in magnitude;
    /// minus infinity where there are none.
    pub beyond: f64,
}

/// How fast texture coordinates change around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// How far from the point `lengths` hold, object units.
    pub reach: f64,
    /// The least length of a unit of u and of v there, object units: the
    /// gradients of u and v are no longer than one over these.
    pub lengths: DVec2,
}

/// A smooth surface whose depth and texture coordinates are known.
pub trait Shape: Sync {
    /// Its name, and that of its mesh in `assets/meshes`.
    fn name(&self) -> &'static str;

    /// `point` as seen from the surface.
    fn foot(&self, point: DVec3) -> Foot;

    /// How texture coordinates change around `point`, whose depth is from 0 to
    /// less than [`Shape::largest_depth`], within at most `limit` of it and no
    /// deeper than the largest depth.
    fn metric(&self, point: DVec3, limit: f64) -> Metric;

    /// Where normals of the surface first meet below it, object units: nothing
    /// can be carved deeper.
    fn largest_depth(&self) -> f64;

    /// Radius of a ball around the origin that holds the surface and all that
    /// lies below it.
    fn radius(&self) -> f64;

    /// Whether u and v come back to where they began.
    fn closed(&self) -> [bool; 2];
}

/// Longitude around the y axis as a texture coordinate, 0…1 from +z towards +x.
pub(super) fn longitude(point: DVec3) -> f64 {
    (point.x.atan2(point.z) / std::f64::consts::TAU).rem_euclid(1.0)
}
