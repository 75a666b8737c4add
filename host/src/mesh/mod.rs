//! Meshes: read from OBJ and glTF files and prepared for rendering, with a tangent
//! frame and a quadric at every corner (algorithm.md, sections 1, 4 and 5).
//!
//! Everything is f64 and does not depend on the number of threads. The steps
//! of [`Mesh::load`]: read, transform, weld positions, drop degenerate
//! triangles, project texture coordinates if asked, align the winding, compute
//! missing normals, tangent frames by MikkTSpace, fit quadrics.

mod curvature;
mod error;
mod gltf;
mod gradients;
mod normals;
mod obj;
mod prepare;
mod projection;
mod scan;
mod shell;
mod surface;
mod tangents;
#[cfg(test)]
mod tests;
mod weld;

use crate::Files;
use std::path::Path;

use glam::{DQuat, DVec2, DVec3};
use obj::SourceMesh;

pub use curvature::Quadric;
pub use error::MeshError;
pub use projection::Projection;
pub use shell::MeshShell;
pub(crate) use shell::{FOLDED, Quadratic};

/// Corner indices are u32 and MikkTSpace's i32: no limit above this holds.
const LARGEST_TRIANGLE_LIMIT: usize = 1 << 28;

/// How a mesh is loaded. The default changes nothing: scale 1, no rotation, no
/// translation, the file's own texture coordinates, at most 2²⁶ triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOptions {
    /// Makes texture coordinates, also in place of the file's own.
    pub projection: Option<Projection>,
    /// Object units per unit of the file, > 0. Applied first.
    pub scale: f64,
    /// Applied after the scale; of any length but zero.
    pub rotation: DQuat,
    /// Applied last, in object units.
    pub translation: DVec3,
    /// More triangles are an error; at most 2²⁸ in any case.
    pub triangle_limit: usize,
    /// A file of more bytes is an error, and is not read (default 4 GiB).
    pub byte_limit: u64,
}

impl MeshOptions {
    fn limit(&self) -> usize {
        self.triangle_limit.min(LARGEST_TRIANGLE_LIMIT)
    }
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            projection: None,
            scale: 1.0,
            rotation: DQuat::IDENTITY,
            translation: DVec3::ZERO,
            triangle_limit: 1 << 26,
            byte_limit: 4 << 30,
        }
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest coordinates, in object units.
    pub min: DVec3,
    /// Highest coordinates, in object units.
    pub max: DVec3,
}

impl Bounds {
    /// The smallest box around the points; one point at the origin if there
    /// are none.
    pub fn of(points: impl Iterator<Item = DVec3>) -> Self {
        points
            .map(|point| Self {
                min: point,
                max: point,
            })
            .reduce(|a, b| Self {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            })
            .unwrap_or(Self {
                min: DVec3::ZERO,
                max: DVec3::ZERO,
            })
    }

    /// The middle of the box.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Length of the diagonal, in object units.
    pub fn diagonal(&self) -> f64 {
        self.min.distance(self.max)
    }
}

/// A mesh, ready to be rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The triangles, at least one, none of them degenerate, wound
    /// counter-clockwise as seen from outside. In the order of the file.
    pub triangles: Vec<MeshTriangle>,
    /// Box around the triangles.
    pub bounds: Bounds,
    /// Number of welded positions that the triangles use.
    pub position_count: usize,
    /// What was done to the mesh.
    pub report: MeshReport,
}

/// What was done to a mesh while it was prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshReport {
    /// Triangles dropped because they have no area.
    pub skipped_degenerate: usize,
    /// Triangles turned round because their normals pointed against them.
    pub reversed_triangles: usize,
    /// Whether any normal was missing and computed.
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
pub struct MeshTriangle {
    /// The corners, counter-clockwise as seen from outside.
    pub corners: [MeshCorner; 3],
}

/// A corner of a [`MeshTriangle`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshCorner {
    /// Position, in object units.
    pub position: DVec3,
    /// Number of the welded position: equal for corners at one place, whatever
    /// their normals and texture coordinates. Not contiguous.
    pub position_index: u32,
    /// Unit normal N, pointing out.
    pub normal: DVec3,
    /// Unit tangent T, at a right angle to N, along growing u.
    pub tangent: DVec3,
    /// ±1: B = handedness · (N × T) points along growing v.
    pub handedness: f64,
    /// Texture coordinates, in repeats.
    pub uv: DVec2,
    /// The surface around the corner, in the frame T, B, N.
    pub quadric: Quadric,
    /// Surface gradient ∇u, at a right angle to N, in repeats per object unit.
    /// Zero, as ∇v, if the texture coordinates have no area.
    pub gradient_u: DVec3,
    /// Surface gradient ∇v; as `gradient_u`.
    pub gradient_v: DVec3,
}

impl MeshCorner {
    /// Unit bitangent B.
    pub fn bitangent(&self) -> DVec3 {
        self.handedness * self.normal.cross(self.tangent)
    }
}

impl Mesh {
    /// Loads the Wavefront OBJ or glTF 2.0 file at `path` and prepares it.
    /// Objects, groups and the nodes of glTF's default scene are merged;
    /// materials are ignored and need not exist.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`].
    pub fn load(path: &Path, options: &MeshOptions) -> Result<Self, MeshError> {
        let source = SourceMesh::load(&Files::Disk, path, options.limit(), options.byte_limit)?;
        prepare::prepare(&source, path, options)
    }

    /// As [`Mesh::load`], of `files`, but where `is_wanted` says no to the box around the
    /// mesh, that box is all there is.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`].
    pub fn load_if(
        files: &Files,
        path: &Path,
        options: &MeshOptions,
        is_wanted: &dyn Fn(&Bounds) -> bool,
    ) -> Result<Result<Self, Bounds>, MeshError> {
        let source = SourceMesh::load(files, path, options.limit(), options.byte_limit)?;
        let bounds = prepare::bounds(&source, path, options)?;
        if is_wanted(&bounds) {
            prepare::prepare(&source, path, options).map(Ok)
        } else {
            Ok(Err(bounds))
        }
    }

    /// As [`Mesh::load`], of the bytes of a file; `path` is named in errors, its
    /// extension counts as there, and other files are read from `files`.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`] but those of reading the file.
    pub fn from_bytes(
        files: &Files,
        bytes: &[u8],
        path: &Path,
        options: &MeshOptions,
    ) -> Result<Self, MeshError> {
        let source =
            SourceMesh::from_bytes(files, bytes, path, options.limit(), options.byte_limit)?;
        prepare::prepare(&source, path, options)
    }

    /// Prepares a mesh from the text of an OBJ file; `path` is named in errors
    /// only.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`] but those of reading the file.
    pub fn parse(text: &str, path: &Path, options: &MeshOptions) -> Result<Self, MeshError> {
        let source = SourceMesh::parse(text, path, options.limit())?;
        prepare::prepare(&source, path, options)
    }
}
