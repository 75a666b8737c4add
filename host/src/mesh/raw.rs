//! A triangle mesh as it is read from a file or made in code, before preparation.

use glam::{DVec2, DVec3};

/// Largest magnitude of a coordinate. Larger values are treated as mistakes:
/// their squares would leave the range of the renderers' f32 arithmetic.
pub(super) const LARGEST_NUMBER: f64 = 1e12;

/// A corner of a triangle: indices into the streams of a [`RawMesh`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    /// Index into [`RawMesh::positions`].
    pub position: u32,
    /// Index into [`RawMesh::normals`], if the mesh has normals.
    pub normal: Option<u32>,
    /// Index into [`RawMesh::uvs`], if the mesh has texture coordinates.
    pub uv: Option<u32>,
}

/// A triangle mesh as its source states it. All objects and groups are merged.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RawMesh {
    /// Vertex positions, in the units of the file, finite.
    pub positions: Vec<DVec3>,
    /// Vertex normals, of any length. Empty unless every corner has one.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, in repeats. Empty unless every corner has them.
    pub uvs: Vec<DVec2>,
    /// The triangles. A polygon becomes a fan around its first corner, so concave
    /// polygons should be triangulated on export.
    pub triangles: Vec<[Corner; 3]>,
    /// Place of the first face without texture coordinates, if any: "at line 7".
    pub face_without_uvs: Option<String>,
}
