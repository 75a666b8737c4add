//! The error of loading a mesh.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use super::projection::Projection;

/// An error of loading or preparing a mesh. Every message names the mesh and
/// the remedy.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The file cannot be read.
    #[error("cannot read the mesh `{}`: {source}; check the path and its permissions", path.display())]
    Read {
        /// The mesh file.
        path: PathBuf,
        /// The reason of the operating system.
        source: io::Error,
    },
    /// The path names a directory.
    #[error("the mesh `{}` is a directory; name an OBJ or glTF file in it", path.display())]
    IsDirectory {
        /// The mesh file.
        path: PathBuf,
    },
    /// The file is not text.
    #[error(
        "the mesh `{}` is not text; it must be a Wavefront OBJ file, or glTF 2.0 (.gltf, .glb)",
        path.display()
    )]
    NotText {
        /// The mesh file.
        path: PathBuf,
    },
    /// A statement of the OBJ file is invalid.
    #[error("the mesh `{}`, line {line}: {problem}", path.display())]
    Statement {
        /// The mesh file.
        path: PathBuf,
        /// Line of the statement, counted from 1.
        line: usize,
        /// The problem, and what is expected.
        problem: String,
    },
    /// The OBJ parser refused a file that passed the checks above.
    #[error("cannot parse the mesh `{}`: {source}; export it again as a Wavefront OBJ or glTF file", path.display())]
    Parse {
        /// The mesh file.
        path: PathBuf,
        /// The reason of the OBJ parser.
        source: tobj::LoadError,
    },
    /// The glTF file or the data made in code are invalid or not supported.
    #[error("the mesh `{}`: {problem}", path.display())]
    Invalid {
        /// The mesh file, or the name of the data.
        path: PathBuf,
        /// The problem and the remedy.
        problem: String,
    },
    /// The file is larger than allowed.
    #[error(
        "the mesh `{}` is larger than the limit of {limit} bytes, with its buffers; simplify it or raise the limit (--max-memory)",
        path.display()
    )]
    TooLarge {
        /// The mesh file.
        path: PathBuf,
        /// The limit: [`super::MeshOptions::byte_limit`].
        limit: u64,
    },
    /// The file has no faces.
    #[error(
        "the mesh `{}` has no faces; export it with its polygons (`f` statements, or triangles in glTF), not as points or lines",
        path.display()
    )]
    NoFaces {
        /// The mesh file.
        path: PathBuf,
    },
    /// All triangles are degenerate.
    #[error(
        "all {skipped} triangles of the mesh `{}` are degenerate (they have no area); check the exporter's precision",
        path.display()
    )]
    AllDegenerate {
        /// The mesh file.
        path: PathBuf,
        /// Number of degenerate triangles.
        skipped: usize,
    },
    /// The mesh has more triangles than allowed.
    #[error(
        "the mesh `{}` has at least {count} triangles, more than the limit of {limit}; simplify it or raise the limit (--max-triangles, --max-memory)",
        path.display()
    )]
    TooManyTriangles {
        /// The mesh file.
        path: PathBuf,
        /// Number of triangles, counted until the limit was passed.
        count: usize,
        /// The limit: [`super::MeshOptions::triangle_limit`].
        limit: usize,
    },
    /// Faces have no texture coordinates, and no projection is given.
    #[error(
        "the mesh `{}` has faces without texture coordinates (first {place}); add `projection = \"spherical\"` \
         (or {}) to the object in the scene file, or export the mesh with its UVs",
        path.display(),
        other_projections()
    )]
    MissingTextureCoordinates {
        /// The mesh file.
        path: PathBuf,
        /// Place of the first face without texture coordinates: "at line 7".
        place: String,
    },
    /// The scale, rotation or translation is invalid.
    #[error("the transform of the mesh `{}` is invalid: {problem}", path.display())]
    InvalidTransform {
        /// The mesh file.
        path: PathBuf,
        /// The problem, and what is expected.
        problem: String,
    },
    /// The transformed mesh is too small, too large or too far away for the
    /// renderers' f32 arithmetic.
    #[error(
        "the mesh `{}` is out of range: its bounding box is {diagonal:e} object units across and reaches {reach:e} from \
         the origin, but 1e-12 to 1e12 is supported; change the scale or the translation of the object",
        path.display()
    )]
    SizeOutOfRange {
        /// The mesh file.
        path: PathBuf,
        /// Diagonal of the bounding box, in object units.
        diagonal: f64,
        /// Largest magnitude of a coordinate, in object units.
        reach: f64,
    },
}

/// Returns the names of all projections but spherical.
fn other_projections() -> String {
    Projection::ALL
        .iter()
        .filter(|projection| **projection != Projection::Spherical)
        .map(|projection| format!("\"{}\"", projection.name()))
        .collect::<Vec<_>>()
        .join(", ")
}
