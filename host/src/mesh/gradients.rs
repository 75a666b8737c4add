//! Surface gradients of the texture coordinates at the corners.
//!
//! Gradients that are constant over each triangle would make the walls of the
//! extrusion jump between triangles. Corners at one position therefore share the
//! mean of their triangles' gradients, each projected into the tangent plane
//! along the corner's normal, where these are similar: not at a pole, and not
//! where two charts of an atlas meet.

use super::corners_at::CornersAt;
use super::surface::{DEGENERATE_AREA, Surface, area_normal};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// ∇u and ∇v, in repeats per object unit, orthogonal to the corner's normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gradients {
    pub u: DVec3,
    pub v: DVec3,
}

/// Maximum distance of similar gradients, as a fraction of the longer one.
const ALIKE: f64 = 0.35;

/// Computes the gradients of every face's corners, which `corners_at` has by position.
pub(super) fn corner_gradients(surface: &Surface, corners_at: &CornersAt) -> Vec<[Gradients; 3]> {
    let own: Vec<[Gradients; 3]> = surface
        .faces
        .par_iter()
        .map(|face| {
            let corners = surface.corners(face);
            let [u, v] = uv_gradients(corners, face.uvs);
            let facet_normal = area_normal(corners);
            face.normals.map(|normal| Gradients {
                u: tilt(u, normal, facet_normal),
                v: tilt(v, normal, facet_normal),
            })
        })
        .collect();
    surface
        .faces
        .par_iter()
        .enumerate()
        .map(|(f, face)| {
            std::array::from_fn(|c| {
                let mine = own[f][c];
                let around = corners_at.of(face.vertices[c]);
                // A large fan is a pole, where no gradients are similar.
                if around.len() > 64 {
                    return mine;
                }
                let mut sum = Gradients {
                    u: DVec3::ZERO,
                    v: DVec3::ZERO,
                };
                let mut weights = 0.0;
                for other in around.iter().map(|corner| *corner as usize) {
                    let theirs = own[other / 3][other % 3];
                    if alike(mine.u, theirs.u) && alike(mine.v, theirs.v) {
                        let corners = surface.corners(&surface.faces[other / 3]);
                        let weight = area_normal(corners).length();
                        sum.u += theirs.u * weight;
                        sum.v += theirs.v * weight;
                        weights += weight;
                    }
                }
                let normal = face.normals[c];
                let mean = |g: DVec3| {
                    let g = g / weights;
                    g - normal * normal.dot(g)
                };
                if weights > 0.0 {
                    Gradients {
                        u: mean(sum.u),
                        v: mean(sum.v),
                    }
                } else {
                    mine
                }
            })
        })
        .collect()
}

/// Projects a gradient of the facet along `normal` into the plane orthogonal to
/// it, since points on one normal have the same texture coordinates.
fn tilt(gradient: DVec3, normal: DVec3, facet_normal: DVec3) -> DVec3 {
    let cosine = normal.dot(facet_normal);
    // Beyond about 84° between the normals the projection is meaningless.
    if cosine > 0.1 * facet_normal.length() {
        gradient - facet_normal * (gradient.dot(normal) / cosine)
    } else {
        gradient - normal * gradient.dot(normal)
    }
}

/// Returns whether two gradients are similar.
fn alike(a: DVec3, b: DVec3) -> bool {
    let longer = a.length_squared().max(b.length_squared());
    a.distance_squared(b) <= ALIKE * ALIKE * longer
}

/// Returns the surface gradients of u and v over a triangle, in repeats per
/// object unit; zero if the texture coordinates have no area.
fn uv_gradients(corners: [DVec3; 3], uvs: [DVec2; 3]) -> [DVec3; 2] {
    let (uv1, uv2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
    let longest = uv1
        .length_squared()
        .max(uv2.length_squared())
        .max(uv1.distance_squared(uv2));
    let area = 0.5 * uv1.perp_dot(uv2).abs();
    if area <= DEGENERATE_AREA * longest {
        return [DVec3::ZERO; 2];
    }
    // The reciprocal basis of the two edges in the plane of the triangle.
    let (edge1, edge2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let normal = area_normal(corners);
    let reciprocal1 = edge2.cross(normal) / normal.length_squared();
    let reciprocal2 = normal.cross(edge1) / normal.length_squared();
    [
        uv1.x * reciprocal1 + uv2.x * reciprocal2,
        uv1.y * reciprocal1 + uv2.y * reciprocal2,
    ]
}

/// Returns the smaller singular value of the matrix with the rows `u` and `v`.
pub(crate) fn smaller_stretch(u: DVec3, v: DVec3) -> f64 {
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let (mean, half) = (0.5 * (uu + vv), 0.5 * (uu - vv));
    (mean - half.hypot(uv)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_are_singular_values() {
        assert_eq!(smaller_stretch(DVec3::X * 3.0, DVec3::Y * 2.0), 2.0);
        assert!(smaller_stretch(DVec3::X, DVec3::X * 5.0) < 1e-9);
        assert_eq!(smaller_stretch(DVec3::ZERO, DVec3::ZERO), 0.0);
    }
}
