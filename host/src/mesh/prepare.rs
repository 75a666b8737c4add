//! Prepares a raw mesh for rendering.

use std::path::Path;

use glam::{DQuat, DVec2, DVec3};
use rayon::prelude::*;

use super::bounds::Bounds;
use super::curvature::{Quadric, quadrics};
use super::error::MeshError;
use super::gradients::{Gradients, corner_gradients};
use super::normals;
use super::options::MeshOptions;
use super::orient::orient;
use super::raw::{Corner, RawMesh};
use super::surface::{DEGENERATE_AREA, Face, Surface, area_normal};
use super::tangents::{TangentFrame, face_frames, tangent_frames};
use super::triangles::{Mesh, MeshCorner, MeshReport, MeshTriangle};
use super::weld::weld;

/// Range of the bounding box's diagonal and largest coordinate, in object units.
const SMALLEST_SIZE: f64 = 1e-12;
const LARGEST_SIZE: f64 = 1e12;

/// Prepares a mesh for rendering; `path` is named in errors only.
pub(super) fn prepare(
    source: &RawMesh,
    path: &Path,
    options: &MeshOptions,
) -> Result<Mesh, MeshError> {
    let rotation = checked_rotation(path, options)?;
    if source.triangles.is_empty() {
        return Err(MeshError::NoFaces {
            path: path.to_owned(),
        });
    }
    if let (None, Some(place)) = (options.projection, &source.face_without_uvs) {
        return Err(MeshError::MissingTextureCoordinates {
            path: path.to_owned(),
            place: place.clone(),
        });
    }
    let positions: Vec<DVec3> = source
        .positions
        .par_iter()
        .map(|position| options.translation + rotation * (options.scale * *position))
        .collect();
    let bounds = Bounds::of(positions.iter().copied());
    if bounds.min == bounds.max {
        return Err(MeshError::AllDegenerate {
            path: path.to_owned(),
            skipped: source.triangles.len(),
        });
    }
    check_size(path, &bounds)?;

    let welded = weld(&positions, bounds.diagonal());
    let faces: Vec<Face> = source
        .triangles
        .par_iter()
        .enumerate()
        .filter_map(|(index, corners)| {
            let vertices = corners.map(|corner| welded.indices[corner.position as usize]);
            let positions = vertices.map(|vertex| welded.positions[vertex as usize]);
            if is_degenerate(positions) {
                return None;
            }
            let uvs = match options.projection {
                Some(projection) => projection.project(positions, &bounds),
                None => corners.map(|corner| uv_of(source, corner)),
            };
            let normals = corners.map(|corner| rotation * normal_of(source, corner));
            Some(Face {
                vertices,
                normals,
                uvs,
                material: source.material_of.get(index).copied().unwrap_or(0),
            })
        })
        .collect();
    let skipped_degenerate = source.triangles.len() - faces.len();
    if faces.is_empty() {
        return Err(MeshError::AllDegenerate {
            path: path.to_owned(),
            skipped: skipped_degenerate,
        });
    }

    let mut surface = Surface {
        positions: welded.positions,
        faces,
    };
    // The winding comes first, since computed normals follow it.
    let reversed_triangles = normals::align_winding(&mut surface) + orient(&mut surface);
    let computed_normals = normals::complete(&mut surface, options.crease_angle);
    let corners_at = surface.corners_at();
    let (frames, gradients) = rayon::join(
        || {
            if options.smooth_tangents {
                tangent_frames(&surface, &corners_at, &bounds)
            } else {
                face_frames(&surface)
            }
        },
        || corner_gradients(&surface, &corners_at),
    );
    let quadrics = quadrics(&surface, &corners_at, &frames);
    let triangles = assemble(&surface, &frames, &quadrics, &gradients);

    let corners = || triangles.iter().flat_map(|triangle| &triangle.corners);
    let curvatures = || corners().flat_map(|corner| corner.quadric.principal_curvatures());
    let report = MeshReport {
        skipped_degenerate,
        reversed_triangles,
        computed_normals,
        projected_uvs: options.projection.is_some(),
        smallest_curvature: curvatures().fold(f64::INFINITY, f64::min),
        largest_curvature: curvatures().fold(f64::NEG_INFINITY, f64::max),
    };
    log::debug!(
        "{}: {} triangles, {report:?}",
        path.display(),
        triangles.len()
    );
    let mesh = Mesh {
        bounds: Bounds::of(corners().map(|corner| corner.position)),
        position_count: corners_at
            .all()
            .filter(|corners| !corners.is_empty())
            .count(),
        triangles,
        materials: source.materials.clone(),
        report,
        raised_by: None,
    };
    if options.raise > 0.0 {
        mesh.raised(options.raise, path)
    } else {
        Ok(mesh)
    }
}

/// Returns the bounding box of all positions after the transform.
pub(super) fn bounds(
    source: &RawMesh,
    path: &Path,
    options: &MeshOptions,
) -> Result<Bounds, MeshError> {
    let rotation = checked_rotation(path, options)?;
    let positions = source.positions.iter();
    Ok(Bounds::of(positions.map(|position| {
        options.translation + rotation * (options.scale * *position)
    })))
}

/// Checks the transform and returns the rotation at unit length.
fn checked_rotation(path: &Path, options: &MeshOptions) -> Result<DQuat, MeshError> {
    let failure = |problem: String| MeshError::InvalidTransform {
        path: path.to_owned(),
        problem,
    };
    let scale = options.scale;
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(failure(format!(
            "the scale is {scale}; it must be a positive number"
        )));
    }
    let translation = options.translation;
    if !translation.is_finite() {
        return Err(failure(format!(
            "the translation is {translation}; it must be finite"
        )));
    }
    let rotation = options.rotation.normalize();
    if !rotation.is_finite() {
        return Err(failure(format!(
            "the rotation is {}; it must be a quaternion of non-zero length",
            options.rotation
        )));
    }
    Ok(rotation)
}

/// Checks that the mesh is in the range of the renderers' f32 arithmetic.
fn check_size(path: &Path, bounds: &Bounds) -> Result<(), MeshError> {
    let diagonal = bounds.diagonal();
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    // False for NaN.
    let fits = reach <= LARGEST_SIZE && (SMALLEST_SIZE..=LARGEST_SIZE).contains(&diagonal);
    if fits {
        Ok(())
    } else {
        Err(MeshError::SizeOutOfRange {
            path: path.to_owned(),
            diagonal,
            reach,
        })
    }
}

/// Returns whether the triangle's area is at most [`DEGENERATE_AREA`] of its
/// longest edge squared, or not finite.
fn is_degenerate(corners: [DVec3; 3]) -> bool {
    let [a, b, c] = corners;
    let longest = a
        .distance_squared(b)
        .max(b.distance_squared(c))
        .max(c.distance_squared(a));
    let area = 0.5 * area_normal(corners).length();
    let has_area = area > DEGENERATE_AREA * longest && area.is_finite();
    !has_area
}

/// Returns the texture coordinates of a corner. Meshes without them have a
/// projection, which has been checked.
fn uv_of(source: &RawMesh, corner: Corner) -> DVec2 {
    corner
        .uv
        .map_or(DVec2::ZERO, |index| source.uvs[index as usize])
}

/// Returns the unit normal of a corner, or zero if it has none.
fn normal_of(source: &RawMesh, corner: Corner) -> DVec3 {
    corner.normal.map_or(DVec3::ZERO, |index| {
        normals::normalized_or_missing(source.normals[index as usize])
    })
}

/// Combines the parts into triangles.
fn assemble(
    surface: &Surface,
    frames: &[[TangentFrame; 3]],
    quadrics: &[[Quadric; 3]],
    gradients: &[[Gradients; 3]],
) -> Vec<MeshTriangle> {
    surface
        .faces
        .par_iter()
        .zip(frames)
        .zip(quadrics)
        .zip(gradients)
        .map(|(((face, frames), quadrics), gradients)| {
            let positions = surface.corners(face);
            let corners = std::array::from_fn(|corner| MeshCorner {
                position: positions[corner],
                position_index: face.vertices[corner],
                normal: face.normals[corner],
                tangent: frames[corner].tangent,
                handedness: frames[corner].handedness,
                uv: face.uvs[corner],
                quadric: quadrics[corner],
                gradient_u: gradients[corner].u,
                gradient_v: gradients[corner].v,
            });
            MeshTriangle {
                corners,
                material: face.material,
            }
        })
        .collect()
}
