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
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// Names of the file's materials that triangles have, in the order of their first use; `""`
    /// for triangles without one. Empty if no triangle has a material.
    pub materials: Vec<String>,
    /// Index of each triangle's material; empty if there are none.
    pub material_of: Vec<u32>,
    /// Place of the first face without texture coordinates, if any: "at line 7".
    pub face_without_uvs: Option<String>,
}

/// Checks that all `parts` are among the names of `materials`.
///
/// # Errors
///
/// The first one that is not, and what there is.
pub(super) fn check_parts(parts: &[String], materials: &[String]) -> Result<(), String> {
    let Some(part) = parts.iter().find(|part| !materials.contains(part)) else {
        return Ok(());
    };
    let names: Vec<String> = materials.iter().map(|name| format!("{name:?}")).collect();
    Err(match names.is_empty() {
        true => format!("has no part {part:?}, since its triangles have no materials"),
        false => format!("has no part {part:?}; its parts are {}", listed(&names)),
    })
}

/// Largest number of names in a message.
const LISTED: usize = 12;

/// Lists the first of `names`.
pub(super) fn listed(names: &[String]) -> String {
    let first = names[..names.len().min(LISTED)].join(", ");
    match names.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// Returns whether triangles of `material` are read where `parts` are asked for.
pub(super) fn is_wanted(parts: &[String], material: &str) -> bool {
    parts.is_empty() || parts.iter().any(|part| part == material)
}
