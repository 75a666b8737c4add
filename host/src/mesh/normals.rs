//! Vertex normals: normalises given ones and computes missing ones.

use glam::DVec3;
use rayon::prelude::*;

use super::surface::{Face, Surface, area_normal};

/// Shorter normals are rounding noise and treated as missing.
const SHORTEST_NORMAL: f64 = 1e-10;

/// A sum of face normals shorter than this fraction of its weights has no
/// direction: it has cancelled out, as on a sheet with two sides.
const CANCELLED: f64 = 1e-6;

/// Returns the normal at unit length, or zero (missing) if it has no direction.
pub(super) fn normalized_or_missing(normal: DVec3) -> DVec3 {
    // Scaled first, so that squares of huge and tiny components are in range.
    let size = normal.abs().max_element();
    if size > SHORTEST_NORMAL && size.is_finite() {
        (normal / size).normalize()
    } else {
        DVec3::ZERO
    }
}

/// Reverses triangles whose three normals all point against their winding, as
/// some exporters write the other handedness. Returns their number.
pub(super) fn align_winding(surface: &mut Surface) -> usize {
    let positions = &surface.positions;
    surface
        .faces
        .par_iter_mut()
        .map(|face| {
            let normal = area_normal(face.vertices.map(|vertex| positions[vertex as usize]));
            let reversed = face.normals.iter().all(|corner| corner.dot(normal) < 0.0);
            if reversed {
                face.vertices.swap(1, 2);
                face.normals.swap(1, 2);
                face.uvs.swap(1, 2);
            }
            usize::from(reversed)
        })
        .sum()
}

/// Computes missing normals and returns whether there were any. A normal is the
/// mean of the face normals around the welded position, weighted by the angle at
/// the corner, so that it does not depend on the triangulation of polygons. Where
/// they cancel out, the corner takes the normal of its face.
pub(super) fn complete(surface: &mut Surface) -> bool {
    let is_missing = |face: &Face| face.normals.contains(&DVec3::ZERO);
    if !surface.faces.par_iter().any(is_missing) {
        return false;
    }
    let weighted: Vec<(DVec3, [f64; 3])> = surface
        .faces
        .par_iter()
        .map(|face| {
            let corners = surface.corners(face);
            (area_normal(corners).normalize(), corner_angles(corners))
        })
        .collect();
    // Summed on one thread in the order of the faces, so that the result does
    // not depend on the number of threads.
    let mut sums = vec![(DVec3::ZERO, 0.0); surface.positions.len()];
    for (face, (normal, angles)) in surface.faces.iter().zip(&weighted) {
        for (vertex, angle) in face.vertices.iter().zip(angles) {
            let (sum, weight) = &mut sums[*vertex as usize];
            *sum += *angle * *normal;
            *weight += *angle;
        }
    }
    surface
        .faces
        .par_iter_mut()
        .zip(&weighted)
        .for_each(|(face, (face_normal, _))| {
            for (normal, vertex) in face.normals.iter_mut().zip(face.vertices) {
                if *normal == DVec3::ZERO {
                    let (sum, weight) = sums[vertex as usize];
                    *normal = if sum.length() > CANCELLED * weight {
                        sum.normalize()
                    } else {
                        *face_normal
                    };
                }
            }
        });
    true
}

/// Returns the angle of a triangle at each corner, in radians.
fn corner_angles(corners: [DVec3; 3]) -> [f64; 3] {
    std::array::from_fn(|corner| {
        let to_next = corners[(corner + 1) % 3] - corners[corner];
        let to_previous = corners[(corner + 2) % 3] - corners[corner];
        to_next
            .cross(to_previous)
            .length()
            .atan2(to_next.dot(to_previous))
    })
}
