//! Options for loading a mesh.

use glam::{DQuat, DVec3};

use super::projection::Projection;

/// Upper bound of every triangle limit: MikkTSpace's corner indices are i32.
const LARGEST_TRIANGLE_LIMIT: usize = 1 << 28;

/// Default of [`MeshOptions::crease_angle`], degrees.
pub(crate) const DEFAULT_CREASE_ANGLE: f64 = 60.0;

/// Options for loading a mesh. The default keeps the mesh as it is and allows at
/// most 2²⁶ triangles and 4 GiB.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOptions {
    /// Names of the file's materials whose triangles are loaded; all if there are none.
    pub parts: Vec<String>,
    /// Projection that makes texture coordinates, replacing those of the mesh.
    pub projection: Option<Projection>,
    /// Scale in object units per unit of the mesh, > 0. Applied first.
    pub scale: f64,
    /// Rotation, applied after the scale; of any length but zero.
    pub rotation: DQuat,
    /// Translation in object units, applied last.
    pub translation: DVec3,
    /// Largest angle between two triangles whose edge is smooth where the mesh has
    /// no normals, in degrees from 0 to 180.
    pub crease_angle: f64,
    /// How far the surface is moved outward, in object units, ≥ 0: columns of that depth
    /// then rise from the mesh.
    pub raise: f64,
    /// Whether tangents are those of MikkTSpace. If not, each triangle has its own, which
    /// takes less time: enough for the planar and the accurate tier, which read none.
    pub smooth_tangents: bool,
    /// Maximum number of triangles; values above 2²⁸ are reduced to it.
    pub triangle_limit: usize,
    /// Maximum size of the file and its buffers, in bytes. Larger files are not
    /// read.
    pub byte_limit: u64,
}

impl MeshOptions {
    /// Effective limit on the number of triangles.
    pub(super) fn limit(&self) -> usize {
        self.triangle_limit.min(LARGEST_TRIANGLE_LIMIT)
    }
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            parts: Vec::new(),
            projection: None,
            scale: 1.0,
            rotation: DQuat::IDENTITY,
            translation: DVec3::ZERO,
            crease_angle: DEFAULT_CREASE_ANGLE,
            raise: 0.0,
            smooth_tangents: true,
            triangle_limit: 1 << 26,
            byte_limit: 4 << 30,
        }
    }
}
