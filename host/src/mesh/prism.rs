//! Curved prisms over the triangles (section 6 of docs/algorithm.md): the surface
//! S and the outward direction N, both of degree two over each triangle and
//! continuous across shared edges.
//!
//! Where all corners at a position have one normal, this is section 6. At hard
//! edges the corner normals define S, so that flat faces stay flat, and mitred
//! normals, one at each position, define N, so that the prisms on both sides
//! meet.
//!
//! Where a shell as deep as asked for would fold or pass through the opposite
//! wall, N is shorter: see [`Shell`].

mod clearance;
mod data;
mod depth;
mod mitre;
mod quadratic;
mod shell;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::NO_NEIGHBOUR;

use super::corners_at::CornersAt;
use super::surface::area_normal;
use super::triangles::{Mesh, MeshCorner, MeshTriangle};
use mitre::mitre;

pub use data::{LocalDepth, MeshPrism, Shell};
pub(crate) use quadratic::Quadratic;
pub(crate) use shell::SHALLOWEST;

/// A prism is folded where the determinant of its map is at most this fraction of
/// the flat prism's.
pub(crate) const FOLDED: f64 = 1e-3;

/// Bends shorter than this, relative to the edges, are rounding errors.
const STRAIGHT: f64 = 1e-9;

/// Limits the length of N at the middle of an edge to 1 / this times the mean of
/// its ends. Where these or the corner normals differ too much, the prism's depth
/// cannot be kept.
const LEAST_HEIGHT: f64 = 0.25;

impl MeshPrism {
    /// Returns the prism with its floor at `depth`, in object units, as its surface, and its
    /// surface as its floor. The triangle runs the other way round.
    pub(crate) fn upside_down(&self, depth: f64) -> MeshPrism {
        let [normal, next_normal, previous_normal] = self.corner_normals;
        let [_, normals @ ..] = self.normal;
        let floor: [DVec3; 5] = std::array::from_fn(|i| self.surface[i] - depth * normals[i]);
        let [first, second, first_first, first_second, second_second] = floor;
        let [n, n1, n2, n11, n12, n22] = self.normal;
        let [here, next, previous] = self.neighbours;
        let [share, next_share, previous_share] = self.shares;
        MeshPrism {
            anchor: self.anchor - depth * n,
            surface: [second, first, second_second, first_second, first_first],
            normal: [-n, -n2, -n1, -n22, -n12, -n11],
            shares: [share, previous_share, next_share],
            corner_normals: [-normal, -previous_normal, -next_normal],
            // Corners 1 and 2 of the neighbour change places too.
            neighbours: [here, previous, next].map(|link| match link {
                NO_NEIGHBOUR => link,
                _ => link ^ if link & 3 == 0 { 0 } else { 3 },
            }),
        }
    }

    /// Returns S, relative to the anchor.
    pub(crate) fn surface(&self) -> Quadratic {
        let [first, second, first_first, first_second, second_second] = self.surface;
        Quadratic([
            DVec3::ZERO,
            first,
            second,
            first_first,
            first_second,
            second_second,
        ])
    }

    /// Returns whether S is straight along two edges or more.
    pub(crate) fn is_straight(&self) -> bool {
        let [first, second, first_first, first_second, second_second] = self.surface;
        let least = STRAIGHT * (first.length() + second.length());
        let bends = [
            first_first,
            second_second,
            first_first + second_second - first_second,
        ];
        bends.iter().filter(|bend| bend.length() <= least).count() >= 2
    }

    /// Returns N.
    pub(crate) fn normal(&self) -> Quadratic {
        Quadratic(self.normal)
    }

    /// Returns the least of the corners' shares.
    pub(crate) fn least_share(&self) -> f64 {
        self.shares.into_iter().fold(1.0, f64::min)
    }

    /// Returns the corners, relative to the anchor.
    pub(crate) fn corners(&self) -> [DVec3; 3] {
        let [first, second, first_first, _, second_second] = self.surface;
        [DVec3::ZERO, first + first_first, second + second_second]
    }

    /// Returns the facet normal by the winding; its length is twice the area, in
    /// object units squared.
    pub(crate) fn area_normal(&self) -> DVec3 {
        area_normal(self.corners())
    }
}

/// One side of a triangle, as the edge between two positions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Indices of the two positions, the lower one first.
    edge: [u32; 2],
    triangle: u32,
    /// The corner opposite to the side.
    opposite: u32,
}

impl Side {
    fn new(triangles: &[MeshTriangle], triangle: usize, opposite: usize) -> Self {
        let corners = &triangles[triangle].corners;
        let start = corners[(opposite + 1) % 3].position_index;
        let end = corners[(opposite + 2) % 3].position_index;
        Self {
            edge: [start.min(end), start.max(end)],
            triangle: triangle as u32,
            opposite: opposite as u32,
        }
    }

    /// Returns the index in lists of the sides of all triangles.
    fn index(&self) -> usize {
        3 * self.triangle as usize + self.opposite as usize
    }

    /// Returns the indices of the side's ends in lists of the corners of all
    /// triangles, the one at the lower position first.
    fn ends(&self, triangles: &[MeshTriangle]) -> [usize; 2] {
        let triangle = self.triangle as usize;
        let [start, end] = [1, 2].map(|i| (self.opposite as usize + i) % 3);
        let ends = [3 * triangle + start, 3 * triangle + end];
        if triangles[triangle].corners[start].position_index == self.edge[0] {
            ends
        } else {
            [ends[1], ends[0]]
        }
    }
}

/// The bend of a prism along a side, and the neighbour there.
#[derive(Clone, Copy)]
struct Bend {
    /// E of section 6.
    surface: DVec3,
    /// G of section 6, as a multiple of the mean N of the side's ends.
    stretch: f64,
    neighbour: u32,
}

impl Bend {
    /// No bend, and no neighbour.
    const STRAIGHT: Bend = Bend {
        surface: DVec3::ZERO,
        stretch: 0.0,
        neighbour: NO_NEIGHBOUR,
    };
}

/// What the prisms over the triangles of a mesh consist of.
struct Parts<'a> {
    triangles: &'a [MeshTriangle],
    corners_at: CornersAt,
    /// N at the corners of all triangles, where nothing limits the depth.
    normals: Vec<DVec3>,
    /// Bends along the sides of all triangles.
    bends: Vec<Bend>,
}

impl<'a> Parts<'a> {
    fn new(triangles: &'a [MeshTriangle]) -> Parts<'a> {
        let corners = triangles.iter().flat_map(|triangle| &triangle.corners);
        let positions = corners.map(|corner| corner.position_index);
        let count = positions.clone().max().map_or(0, |last| last as usize + 1);
        let corners_at = CornersAt::new(count, positions);
        let normals = prism_normals(triangles, &corners_at);
        let bends = bends(triangles, &normals);
        Parts {
            triangles,
            corners_at,
            normals,
            bends,
        }
    }

    /// Returns the prism over a triangle, with the local depths at its corners as
    /// shares of the object's.
    fn prism(&self, index: usize, shares: [f64; 3]) -> MeshPrism {
        let triangle = &self.triangles[index];
        let at = |i: usize| 3 * index + i;
        let bends: [Bend; 3] = std::array::from_fn(|side| self.bends[at(side)]);
        let normals: [DVec3; 3] =
            std::array::from_fn(|corner| shares[corner] * self.normals[at(corner)]);
        let stretches = std::array::from_fn(|side| {
            let mean = 0.5 * (normals[(side + 1) % 3] + normals[(side + 2) % 3]);
            bends[side].stretch * mean
        });
        let positions = triangle.corners.map(|corner| corner.position);
        let relative = positions.map(|position| position - positions[0]);
        let surface = Quadratic::new(relative, bends.map(|bend| bend.surface));
        let [_, surface @ ..] = surface.0;
        MeshPrism {
            anchor: positions[0],
            surface,
            normal: Quadratic::new(normals, stretches).0,
            shares,
            corner_normals: triangle.corners.map(|corner| corner.normal),
            neighbours: bends.map(|bend| bend.neighbour),
        }
    }
}

impl Mesh {
    /// Computes the curved prisms over the triangles, in their order, where nothing
    /// limits the depth.
    pub fn prisms(&self) -> Vec<MeshPrism> {
        let parts = Parts::new(&self.triangles);
        (0..self.triangles.len())
            .into_par_iter()
            .map(|index| parts.prism(index, [1.0; 3]))
            .collect()
    }
}

fn corner_at(triangles: &[MeshTriangle], index: usize) -> &MeshCorner {
    &triangles[index / 3].corners[index % 3]
}

/// Returns the angle of the triangle at a corner, in radians.
fn corner_angle(triangles: &[MeshTriangle], index: usize) -> f64 {
    let corners = &triangles[index / 3].corners;
    let [here, next, previous] = [0, 1, 2].map(|i| corners[(index % 3 + i) % 3].position);
    let (to_next, to_previous) = (next - here, previous - here);
    to_next
        .cross(to_previous)
        .length()
        .atan2(to_next.dot(to_previous))
}

/// Computes the shell normal of every corner: one at each position, or the
/// corner's own where the normals there cancel out.
fn prism_normals(triangles: &[MeshTriangle], corners_at: &CornersAt) -> Vec<DVec3> {
    let mitred: Vec<(u32, DVec3)> = (0..corners_at.count() as u32)
        .into_par_iter()
        .flat_map_iter(|position| {
            let corners = corners_at.of(position);
            let normals: Vec<(DVec3, f64)> = corners
                .iter()
                .map(|index| {
                    let index = *index as usize;
                    let angle = corner_angle(triangles, index);
                    (corner_at(triangles, index).normal, angle)
                })
                .collect();
            let mitre = mitre(&normals);
            corners
                .iter()
                .zip(normals)
                .map(move |(index, (own, _))| (*index, mitre.unwrap_or(own)))
        })
        .collect();
    let mut normals = vec![DVec3::ZERO; mitred.len()];
    for (index, normal) in mitred {
        normals[index as usize] = normal;
    }
    normals
}

/// Computes the bends along every side of every triangle.
fn bends(triangles: &[MeshTriangle], normals: &[DVec3]) -> Vec<Bend> {
    let mut sides: Vec<Side> = (0..3 * triangles.len())
        .into_par_iter()
        .map(|index| Side::new(triangles, index / 3, index % 3))
        .collect();
    sides.par_sort_unstable();
    let unordered: Vec<(usize, Bend)> = sides
        .par_chunk_by(|a, b| a.edge == b.edge)
        .flat_map_iter(|sides| edge_bends(triangles, normals, sides))
        .collect();
    let mut bends = vec![Bend::STRAIGHT; unordered.len()];
    for (index, bend) in unordered {
        bends[index] = bend;
    }
    bends
}

/// Computes the bends along one edge, with the indices of its `sides`.
///
/// All triangles at the edge take the mean of the bends by their normals, so that
/// they meet there. The result is independent of the direction in which a
/// triangle runs through the edge.
fn edge_bends(
    triangles: &[MeshTriangle],
    normals: &[DVec3],
    sides: &[Side],
) -> impl Iterator<Item = (usize, Bend)> {
    let (mut bend, mut stretch) = (DVec3::ZERO, 0.0);
    for side in sides {
        let ends = side.ends(triangles);
        let [start, end] = ends.map(|index| corner_at(triangles, index));
        let along = end.position - start.position;
        let heights = [along.dot(start.normal), -along.dot(end.normal)];
        bend -= 0.5 * (heights[0] * start.normal + heights[1] * end.normal);
        let facet = triangles[side.triangle as usize]
            .corners
            .map(|c| c.position);
        let middle = (start.normal + end.normal).normalize_or(area_normal(facet).normalize());
        stretch += 1.0 / middle_normal(normals, ends).dot(middle).max(LEAST_HEIGHT);
    }
    let share = 1.0 / sides.len() as f64;
    let surface = bend * share;
    let stretch = 4.0 * (stretch * share - 1.0);
    let linked = linked(triangles, normals, sides);
    sides.iter().enumerate().map(move |(i, side)| {
        let neighbour = if linked {
            let other = sides[1 - i];
            4 * other.triangle + other.opposite
        } else {
            NO_NEIGHBOUR
        };
        let bend = Bend {
            surface,
            stretch,
            neighbour,
        };
        (side.index(), bend)
    })
}

/// Returns the mean of the shell normals at an edge's ends.
fn middle_normal(normals: &[DVec3], ends: [usize; 2]) -> DVec3 {
    0.5 * (normals[ends[0]] + normals[ends[1]])
}

/// Returns whether a ray that leaves the prism at one of `sides` enters the one at
/// the other: there are two sides, in opposite directions, with the same wall.
fn linked(triangles: &[MeshTriangle], normals: &[DVec3], sides: &[Side]) -> bool {
    let [one, other] = sides else { return false };
    let runs_up = |side: &Side| side.ends(triangles)[0] % 3 == (side.opposite as usize + 1) % 3;
    let wall = |side: &Side| side.ends(triangles).map(|index| normals[index]);
    one.triangle != other.triangle && runs_up(one) != runs_up(other) && wall(one) == wall(other)
}
