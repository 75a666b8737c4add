//! Vertex normals: normalises given ones and computes missing ones.

use glam::DVec3;
use rayon::prelude::*;

use super::surface::{Face, Surface, area_normal, pairs};

/// Shorter normals are rounding noise and treated as missing.
const SHORTEST_NORMAL: f64 = 1e-10;

/// Rounding error of the angle between two faces, radians.
const ROUNDING: f64 = 1e-7;

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
                face.reverse();
            }
            usize::from(reversed)
        })
        .sum()
}

/// Computes missing normals and returns whether there were any.
///
/// The triangles around a welded position form fans: two of them belong together
/// if they share an edge there, which no third has, and the angle between them is
/// at most `crease_angle`, degrees. A normal is the mean of the fan's face normals,
/// weighted by the angle at the corner, so that it does not depend on the
/// triangulation of polygons. Where they cancel out, the corner takes the normal
/// of its face.
pub(super) fn complete(surface: &mut Surface, crease_angle: f64) -> bool {
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
    let mut fans = Fans::new(3 * surface.faces.len());
    for [one, other] in pairs(surface) {
        let [normal, other_normal] = [one, other].map(|side| weighted[side / 3].0);
        if normal.angle_between(other_normal) <= crease_angle.to_radians() + ROUNDING {
            for end in joined_corners(surface, [one, other]) {
                fans.join(end);
            }
        }
    }
    // Summed on one thread in the order of the faces, so that the result does
    // not depend on the number of threads.
    let mut sums = vec![(DVec3::ZERO, 0.0); 3 * surface.faces.len()];
    for (index, (normal, angles)) in weighted.iter().enumerate() {
        for (corner, angle) in angles.iter().enumerate() {
            let (sum, weight) = &mut sums[fans.first(3 * index + corner)];
            *sum += *angle * *normal;
            *weight += *angle;
        }
    }
    for (index, (face, (face_normal, _))) in surface.faces.iter_mut().zip(&weighted).enumerate() {
        for (corner, normal) in face.normals.iter_mut().enumerate() {
            if *normal == DVec3::ZERO {
                let (sum, weight) = sums[fans.first(3 * index + corner)];
                *normal = if sum.length() > CANCELLED * weight {
                    sum.normalize()
                } else {
                    *face_normal
                };
            }
        }
    }
    true
}

/// Returns the corners that two sides share at both of their ends.
fn joined_corners(surface: &Surface, [one, other]: [usize; 2]) -> [[usize; 2]; 2] {
    let ends = |side: usize| [1, 2].map(|i| side - side % 3 + (side % 3 + i) % 3);
    let vertex = |corner: usize| surface.faces[corner / 3].vertices[corner % 3];
    let ([start, end], [other_start, other_end]) = (ends(one), ends(other));
    if vertex(start) == vertex(other_start) {
        [[start, other_start], [end, other_end]]
    } else {
        [[start, other_end], [end, other_start]]
    }
}

/// Corners that share a normal, as disjoint sets.
struct Fans(Vec<u32>);

impl Fans {
    fn new(corners: usize) -> Fans {
        Fans((0..corners as u32).collect())
    }

    /// Returns the first corner of the fan of `corner`.
    fn first(&mut self, corner: usize) -> usize {
        let mut corner = corner;
        while self.0[corner] as usize != corner {
            // Halves the way for the next search.
            self.0[corner] = self.0[self.0[corner] as usize];
            corner = self.0[corner] as usize;
        }
        corner
    }

    fn join(&mut self, corners: [usize; 2]) {
        let [one, other] = corners.map(|corner| self.first(corner));
        self.0[one.max(other)] = one.min(other) as u32;
    }
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
