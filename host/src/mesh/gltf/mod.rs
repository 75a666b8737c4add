//! glTF 2.0 files, as text (`.gltf`) or binary (`.glb`).
//!
//! The `gltf` crate parses the JSON description. Accessors are read here, each
//! element on use, so that cost follows the number of triangles and not the
//! counts that a file claims.

mod buffers;
#[cfg(test)]
mod compressed_tests;
mod document;
mod draco;
mod materials;
mod meshopt;
mod numbers;
mod parts;
mod problem;
#[cfg(test)]
mod tests;
mod triangles;

use std::path::Path;

use gltf::Semantic;

use super::error::MeshError;
use super::options::MeshOptions;
use super::raw::{RawMesh, check_parts, is_wanted};
use crate::Files;
use buffers::Buffers;
use document::{MAGIC, open};
use draco::Geometries;
pub(super) use materials::materials;
use materials::{Used, name_of, restored};
use parts::{Part, parts};
use problem::Problem;

/// Returns whether a file is glTF, by its first bytes or its extension.
pub(super) fn is_gltf(bytes: &[u8], path: &Path) -> bool {
    let first = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .iter()
        .find(|byte| !byte.is_ascii_whitespace());
    // No statement of an OBJ file starts with these.
    bytes.starts_with(MAGIC)
        || first == Some(&b'{')
        || path.extension().is_some_and(|extension| {
            extension.eq_ignore_ascii_case("gltf") || extension.eq_ignore_ascii_case("glb")
        })
}

/// Parses a glTF file. Its buffers are read from `files`, relative to the folder
/// of `path`.
///
/// # Errors
///
/// [`MeshError::Invalid`], [`MeshError::NoFaces`], [`MeshError::TooManyTriangles`],
/// [`MeshError::TooLarge`].
pub(super) fn parse(
    files: &Files,
    bytes: &[u8],
    path: &Path,
    options: &MeshOptions,
) -> Result<RawMesh, MeshError> {
    let failure = |Problem(problem)| MeshError::Invalid {
        path: path.to_owned(),
        problem,
    };
    let (document, blob) = open(bytes, path, options.byte_limit)?;
    let mut parts = parts(&document).map_err(failure)?;
    let materials = Used::by(&parts);
    if !parts.is_empty() {
        let checked = check_parts(&options.parts, &materials.names());
        checked.map_err(|problem| failure(problem.into()))?;
    }
    parts.retain(|part| is_wanted(&options.parts, &name_of(&part.primitive.material())));

    let (mut count, limit) = (0_usize, options.limit());
    for part in &parts {
        count = count.saturating_add(part.triangle_count().map_err(failure)?);
        if count > limit {
            return Err(MeshError::TooManyTriangles {
                path: path.to_owned(),
                count,
                limit,
            });
        }
    }
    if count == 0 {
        return Err(MeshError::NoFaces {
            path: path.to_owned(),
        });
    }

    let views = parts.iter().flat_map(Part::views);
    let left = options.byte_limit.saturating_sub(bytes.len() as u64);
    let buffers = Buffers::load(&document, views, files, path, blob, left)
        .map_err(|error| error.of_mesh(path, options.byte_limit))?;
    let compressed = parts.iter().filter_map(|part| part.draco.as_ref());
    let geometries = Geometries::decode(compressed, &buffers)
        .map_err(|error| error.of_mesh(path, options.byte_limit))?;
    let restored = restored(&document, &parts);
    let lacking = |semantic: Semantic| {
        parts
            .iter()
            .find(|part| part.primitive.get(&semantic).is_none())
    };
    let without_uvs = lacking(Semantic::TexCoords(0)).map(|part| format!("in {}", part.name));
    let mut mesh = RawMesh {
        triangles: Vec::with_capacity(count),
        materials: materials.names(),
        face_without_uvs: without_uvs,
        ..RawMesh::default()
    };
    let has_normals = lacking(Semantic::Normals).is_none();
    for part in &parts {
        let restored = restored.get(&part.primitive.material().index());
        part.append(&buffers, &geometries, restored, has_normals, &mut mesh)
            .map_err(|Problem(problem)| failure(format!("{}: {problem}", part.name).into()))?;
        if !mesh.materials.is_empty() {
            let material = materials.index(&part.primitive.material());
            mesh.material_of.resize(mesh.triangles.len(), material);
        }
    }
    Ok(mesh)
}
