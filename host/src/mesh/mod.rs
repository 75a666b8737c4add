//! Meshes: read from OBJ and glTF files or made in code, and prepared for
//! rendering with a tangent frame and a quadric at every corner (sections 1, 4
//! and 5 of docs/algorithm.md).
//!
//! Preparation runs in f64 and its result does not depend on the number of
//! threads. The steps: read, transform, weld positions, drop degenerate
//! triangles, project texture coordinates if asked, align the winding, compute
//! missing normals between creases, compute tangent frames by MikkTSpace, fit quadrics,
//! and raise the surface if asked.
//!
//! ```
//! use relievo::mesh::{Mesh, MeshData, MeshOptions, Projection};
//!
//! let tetrahedron = MeshData::new(
//!     "tetrahedron",
//!     [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!     [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
//! );
//! let options = MeshOptions {
//!     projection: Some(Projection::Spherical),
//!     scale: 2.0,
//!     ..MeshOptions::default()
//! };
//! let mesh = Mesh::from_data(&tetrahedron, &options)?;
//! assert_eq!((mesh.triangles.len(), mesh.position_count), (4, 4));
//! assert_eq!(mesh.bounds.max.to_array(), [2.0; 3]);
//! # Ok::<(), relievo::mesh::MeshError>(())
//! ```

mod bounds;
mod corners_at;
mod curvature;
mod data;
mod encoding;
mod error;
mod gltf;
mod gradients;
mod load;
mod material;
mod mtl;
mod normals;
mod obj;
mod options;
mod orient;
mod prepare;
mod prism;
mod projection;
mod raise;
mod raw;
mod scan;
mod source;
mod surface;
mod tangents;
#[cfg(test)]
mod tests;
mod triangles;
mod weld;

pub use bounds::Bounds;
pub use curvature::Quadric;
pub use data::MeshData;
pub use error::MeshError;
pub(crate) use gradients::smaller_stretch;
pub(crate) use material::{MeshMaterial, MeshMaterials};
pub(crate) use options::DEFAULT_CREASE_ANGLE;
pub use options::MeshOptions;
pub(crate) use prism::{FOLDED, Quadratic, SHALLOWEST};
pub use prism::{LocalDepth, MeshPrism, Shell};
pub use projection::Projection;
pub use source::MeshSource;
pub use triangles::{Mesh, MeshCorner, MeshReport, MeshTriangle};
