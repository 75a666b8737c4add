//! The quadric that approximates the surface at a vertex (sections 4 and 5 of
//! docs/algorithm.md).

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::corners_at::CornersAt;
use super::surface::Surface;
use super::tangents::TangentFrame;

/// Corners at one position share a fit if the cosine between their normals is
/// larger (1.4 mrad): more than the rounding of text files, less than any
/// visible edge.
const SAME_NORMAL_COSINE: f64 = 1.0 - 1e-6;

/// Neighbours are used if the cosine between their normal and the vertex normal
/// is larger.
const SMALLEST_NORMAL_Z: f64 = 0.1;

/// Neighbours along the normal are not used: minimum squared ratio of the
/// distance in the tangent plane to the distance.
const SMALLEST_FLATNESS: f64 = 1e-6;

/// Neighbours are collinear if the sum of the squared sines of the angles
/// between their directions is less.
const COLLINEAR: f64 = 1e-4;

/// Ridge of the fit, as a fraction of the mean diagonal of the normal equations.
const RIDGE: f64 = 1e-6;

/// The surface around a vertex in its tangent frame, to second order:
/// z = xx·x² + xy·x·y + yy·y², x along T, y along B, z along −N.
///
/// Unit: 1 / object units. xx and yy are positive on a convex surface: a sphere
/// of radius R has xx = yy = 1/(2R) and xy = 0. Section 4 calls them a, b and c.
///
/// ```
/// let sphere = relievo::mesh::Quadric { xx: 0.25, xy: 0.0, yy: 0.25 }; // R = 2
/// assert_eq!(sphere.principal_curvatures(), [0.5, 0.5]);
/// assert_eq!(sphere.evaluate(2.0, 0.0), 1.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Quadric {
    /// Coefficient of x².
    pub xx: f64,
    /// Coefficient of x·y.
    pub xy: f64,
    /// Coefficient of y².
    pub yy: f64,
}

impl Quadric {
    /// Returns the depth below the tangent plane at (x, y) in it. For a unit
    /// direction this is half the normal curvature.
    pub fn evaluate(self, x: f64, y: f64) -> f64 {
        self.xx * x * x + self.xy * x * y + self.yy * y * y
    }

    /// Returns the smallest and the largest curvature, in 1 / object units: twice
    /// the eigenvalues of the quadratic form.
    pub fn principal_curvatures(self) -> [f64; 2] {
        let mean = self.xx + self.yy;
        let deviation = (self.xx - self.yy).hypot(self.xy);
        [mean - deviation, mean + deviation]
    }
}

/// Corners with one position and normal, which share a fit.
struct Group {
    vertex: u32,
    normal: DVec3,
    /// Corner indices: 3 · face + corner.
    corners: Vec<u32>,
}

/// Computes the quadrics of every face's corners.
///
/// There is one fit for each welded position *and normal*. Across a UV seam the
/// normals are equal, and the fit uses the whole one-ring. At a hard edge they
/// differ, and each side is fitted to its own faces with their normals, so that
/// a cube is flat and the side of a cylinder does not depend on its caps. The fit
/// is a tensor in object space; each corner evaluates it in its own frame.
///
/// A group whose neighbours do not determine a fit takes the mean of their
/// tensors, or is flat if they have none.
pub(super) fn quadrics(
    surface: &Surface,
    corners_at: &CornersAt,
    frames: &[[TangentFrame; 3]],
) -> Vec<[Quadric; 3]> {
    let groups = group_corners(surface, corners_at);
    let mut group_of_corner = vec![0_u32; 3 * surface.faces.len()];
    for (index, group) in groups.iter().enumerate() {
        for corner in &group.corners {
            group_of_corner[*corner as usize] = index as u32;
        }
    }
    let neighbours: Vec<Vec<u32>> = groups
        .par_iter()
        .map(|group| neighbours_of(&group.corners, &group_of_corner))
        .collect();
    let fitted: Vec<Option<DMat3>> = groups
        .par_iter()
        .zip(&neighbours)
        .map(|(group, neighbours)| {
            let position = surface.positions[group.vertex as usize];
            let samples = neighbours.iter().map(|neighbour| {
                let neighbour = &groups[*neighbour as usize];
                (
                    surface.positions[neighbour.vertex as usize] - position,
                    neighbour.normal,
                )
            });
            fit(group.normal, samples)
        })
        .collect();
    let tensors: Vec<DMat3> = fitted
        .par_iter()
        .zip(&neighbours)
        .map(|(tensor, neighbours)| {
            tensor.unwrap_or_else(|| {
                let known = || {
                    neighbours
                        .iter()
                        .filter_map(|neighbour| fitted[*neighbour as usize])
                };
                known().sum::<DMat3>() * (1.0 / known().count().max(1) as f64)
            })
        })
        .collect();
    surface
        .faces
        .par_iter()
        .zip(frames)
        .enumerate()
        .map(|(index, (face, frames))| {
            std::array::from_fn(|corner| {
                let TangentFrame {
                    tangent,
                    handedness,
                } = frames[corner];
                let bitangent = handedness * face.normals[corner].cross(tangent);
                let tensor = tensors[group_of_corner[3 * index + corner] as usize];
                Quadric {
                    xx: tangent.dot(tensor * tangent),
                    xy: 2.0 * tangent.dot(tensor * bitangent),
                    yy: bitangent.dot(tensor * bitangent),
                }
            })
        })
        .collect()
}

/// Groups the corners at each welded position by normal, in corner order.
fn group_corners(surface: &Surface, corners_at: &CornersAt) -> Vec<Group> {
    (0..surface.positions.len() as u32)
        .into_par_iter()
        .flat_map_iter(|vertex| {
            let mut groups: Vec<Group> = Vec::new();
            for &corner in corners_at.of(vertex) {
                let normal = surface.faces[corner as usize / 3].normals[corner as usize % 3];
                match groups
                    .iter_mut()
                    .find(|group| group.normal.dot(normal) > SAME_NORMAL_COSINE)
                {
                    Some(group) => group.corners.push(corner),
                    None => groups.push(Group {
                        vertex,
                        normal,
                        corners: vec![corner],
                    }),
                }
            }
            groups
        })
        .collect()
}

/// Returns the groups of the other corners of a group's faces, without
/// duplicates.
fn neighbours_of(corners: &[u32], group_of_corner: &[u32]) -> Vec<u32> {
    let mut neighbours: Vec<u32> = corners
        .iter()
        .flat_map(|corner| {
            let first = corner - corner % 3;
            [first + (corner + 1) % 3, first + (corner + 2) % 3]
        })
        .map(|other| group_of_corner[other as usize])
        .collect();
    neighbours.sort_unstable();
    neighbours.dedup();
    neighbours
}

/// Fits the tensor M with z = (x, y)ᵀ M (x, y) to neighbours, given by their
/// offsets and unit normals (section 5 of docs/algorithm.md). M is symmetric, in
/// object space, and acts in the tangent plane. Returns `None` for fewer than two
/// usable neighbours, or collinear ones.
fn fit(normal: DVec3, neighbours: impl Iterator<Item = (DVec3, DVec3)>) -> Option<DMat3> {
    let (x_axis, y_axis) = normal.any_orthonormal_pair();
    // Normal equations of the rows below, for the unknowns (xx, xy, yy).
    let mut matrix = DMat3::ZERO;
    let mut right_side = DVec3::ZERO;
    let mut add_row = |row: DVec3, value: f64| {
        matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        right_side += row * value;
    };
    // Sum of d dᵀ over the directions d: its determinant is the sum of the
    // squared sines between all pairs.
    let (mut scatter_xx, mut scatter_xy, mut scatter_yy) = (0.0, 0.0, 0.0);
    for (offset, neighbour_normal) in neighbours {
        let in_plane = DVec2::new(offset.dot(x_axis), offset.dot(y_axis));
        let height = -offset.dot(normal);
        let radius = in_plane.length();
        let normal_z = neighbour_normal.dot(normal);
        let is_steep = radius * radius < SMALLEST_FLATNESS * offset.length_squared();
        if normal_z <= SMALLEST_NORMAL_Z || is_steep {
            continue;
        }
        let DVec2 { x, y } = in_plane / radius;
        let slope =
            DVec2::new(neighbour_normal.dot(x_axis), neighbour_normal.dot(y_axis)) / normal_z;
        // Every row is a curvature, so the fit is independent of the scale.
        add_row(DVec3::new(x * x, x * y, y * y), height / (radius * radius));
        add_row(DVec3::new(2.0 * x, y, 0.0), slope.x / radius);
        add_row(DVec3::new(0.0, x, 2.0 * y), slope.y / radius);
        scatter_xx += x * x;
        scatter_xy += x * y;
        scatter_yy += y * y;
    }
    if scatter_xx * scatter_yy - scatter_xy * scatter_xy < COLLINEAR {
        return None;
    }
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    let ridge = DMat3::from_diagonal(DVec3::splat(RIDGE * trace / 3.0));
    let [xx, xy, yy] = ((matrix + ridge).inverse() * right_side).to_array();
    let along_x = xx * x_axis + 0.5 * xy * y_axis;
    let along_y = 0.5 * xy * x_axis + yy * y_axis;
    let tensor = outer_product(along_x, x_axis) + outer_product(along_y, y_axis);
    tensor.is_finite().then_some(tensor)
}

/// Returns the matrix a bᵀ.
fn outer_product(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
