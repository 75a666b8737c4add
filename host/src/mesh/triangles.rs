//! The prepared mesh that renderers read.

use glam::{DVec2, DVec3};

use super::bounds::Bounds;
use super::curvature::Quadric;
use super::prism::Shell;

/// A mesh prepared for rendering.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Mesh {
    /// The triangles in the order of the source: at least one, none degenerate,
    /// counter-clockwise as seen from outside.
    pub triangles: Vec<MeshTriangle>,
    /// Names of the mesh file's materials; `""` for triangles without one. Empty if no triangle
    /// has a material.
    pub materials: Vec<String>,
    /// Bounding box of the triangles.
    pub bounds: Bounds,
    /// Number of welded positions that the triangles use.
    pub position_count: usize,
    /// Changes made during preparation, and the range of curvatures.
    pub report: MeshReport,
    /// The shell between a raised surface and the mesh below it.
    pub(super) raised_by: Option<Box<Shell>>,
}

/// Changes made to a mesh during preparation, and its range of curvatures.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct MeshReport {
    /// Number of degenerate triangles that were dropped.
    pub skipped_degenerate: usize,
    /// Number of triangles whose winding was reversed to match their normals or, without
    /// normals, their neighbours and the outside.
    pub reversed_triangles: usize,
    /// Whether missing normals were computed.
    pub computed_normals: bool,
    /// Whether the texture coordinates come from a projection.
    pub projected_uvs: bool,
    /// Smallest principal curvature of the quadrics, in 1 / object units;
    /// negative where the surface is concave or a saddle.
    pub smallest_curvature: f64,
    /// Largest principal curvature of the quadrics, in 1 / object units.
    pub largest_curvature: f64,
}

/// A triangle of a [`Mesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct MeshTriangle {
    /// The corners, counter-clockwise as seen from outside.
    pub corners: [MeshCorner; 3],
    /// Index of its material among [`Mesh::materials`]; 0 if there are none.
    pub material: u32,
}

/// A corner of a [`MeshTriangle`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct MeshCorner {
    /// Position, in object units.
    pub position: DVec3,
    /// Index of the welded position: equal for corners at one position, whatever
    /// their normals and texture coordinates. Not contiguous.
    pub position_index: u32,
    /// Outward unit normal N.
    pub normal: DVec3,
    /// Unit tangent T, orthogonal to N, in the direction of increasing u.
    pub tangent: DVec3,
    /// ±1: B = handedness · (N × T) points in the direction of increasing v.
    pub handedness: f64,
    /// Texture coordinates, in repeats.
    pub uv: DVec2,
    /// Quadric approximation of the surface at the corner, in the frame T, B, N.
    pub quadric: Quadric,
    /// Surface gradient ∇u, orthogonal to N, in repeats per object unit. Zero if
    /// the texture coordinates have no area.
    pub gradient_u: DVec3,
    /// Surface gradient ∇v; as `gradient_u`.
    pub gradient_v: DVec3,
}

impl MeshCorner {
    /// Returns the unit bitangent B.
    pub fn bitangent(&self) -> DVec3 {
        self.handedness * self.normal.cross(self.tangent)
    }
}
