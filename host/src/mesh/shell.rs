//! Curved prisms over the triangles (algorithm.md, section 6): the surface S
//! and the direction N out of it, both of degree two over each triangle, the
//! same on both sides of a shared edge.
//!
//! Where all corners at a position have one normal, this is section 6 as it
//! stands. At hard edges there are two kinds of normals: those of the corners
//! make S, so that what is flat stays flat, and mitred ones, one at each
//! position, make N, so that the prisms on both sides meet.

mod depth;
mod mitre;
mod quadratic;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::NO_NEIGHBOUR;

use super::surface::area_normal;
use super::{Mesh, MeshCorner, MeshTriangle};
use mitre::mitre;

pub(crate) use quadratic::Quadratic;

/// The prism of a triangle counts as folded where the determinant of its map is
/// at most this share of the flat prism's.
pub(crate) const FOLDED: f64 = 1e-3;

/// At the middle of an edge, N is at most 1 / this times as long as the mean of
/// its ends: where these two or the corner normals turn too far apart, nothing
/// can keep the prism's depth.
const LEAST_HEIGHT: f64 = 0.25;

/// The curved prism over one triangle: the points S(w) − d N(w) at the depths d
/// ≥ 0 in object units, with S and N of degree two in the weights w1 and w2 of
/// the second and the third corner (algorithm.md, section 6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshShell {
    /// Position of the first corner, in object units. `surface` is relative to it.
    pub anchor: DVec3,
    /// S without its constant, which is 0: the coefficients of w1, w2, w1²,
    /// w1 w2, w2², in object units.
    pub surface: [DVec3; 5],
    /// N: the coefficients of 1, w1, w2, w1², w1 w2, w2². Of length 1 at
    /// corners and middles of edges where the surface is smooth; where it is
    /// not, about as long as keeps the floor parallel to the faces around.
    pub normal: [DVec3; 6],
    /// Unit normals of the corners: those of the mesh.
    pub corner_normals: [DVec3; 3],
    /// For each corner what lies beyond the side opposite to it: 4 × the number
    /// of the neighbour + the number of the neighbour's corner opposite to the
    /// same side; or [`NO_NEIGHBOUR`].
    pub neighbours: [u32; 3],
}

impl MeshShell {
    /// S, relative to the anchor.
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

    /// N.
    pub(crate) fn normal(&self) -> Quadratic {
        Quadratic(self.normal)
    }

    /// The corners, relative to the anchor.
    pub(crate) fn corners(&self) -> [DVec3; 3] {
        let [first, second, first_first, _, second_second] = self.surface;
        [DVec3::ZERO, first + first_first, second + second_second]
    }

    /// Normal of the facet by its winding; its length is twice the area, in
    /// object units squared.
    pub(crate) fn area_normal(&self) -> DVec3 {
        area_normal(self.corners())
    }
}

/// One side of a triangle, as the edge between two positions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Numbers of the two positions, the lower one first.
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

    /// Index into lists of the sides of all triangles.
    fn index(&self) -> usize {
        3 * self.triangle as usize + self.opposite as usize
    }

    /// Indices into lists of the corners of all triangles: the side's ends,
    /// the one at the lower position first.
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

/// How the prism bends along a side, and what lies beyond it.
#[derive(Clone, Copy)]
struct Bend {
    /// E of section 6.
    surface: DVec3,
    /// G of section 6.
    normal: DVec3,
    neighbour: u32,
}

impl Mesh {
    /// The curved prisms over the triangles, in their order.
    pub fn shells(&self) -> Vec<MeshShell> {
        let triangles = &self.triangles;
        let normals = shell_normals(triangles);
        let bends = bends(triangles, &normals);
        triangles
            .par_iter()
            .enumerate()
            .map(|(index, triangle)| {
                let range = 3 * index..3 * index + 3;
                let bends: [Bend; 3] = std::array::from_fn(|side| bends[range.start + side]);
                let positions = triangle.corners.map(|corner| corner.position);
                let relative = positions.map(|position| position - positions[0]);
                let surface = Quadratic::new(relative, bends.map(|bend| bend.surface));
                let normals = std::array::from_fn(|corner| normals[range.start + corner]);
                let [_, surface @ ..] = surface.0;
                MeshShell {
                    anchor: positions[0],
                    surface,
                    normal: Quadratic::new(normals, bends.map(|bend| bend.normal)).0,
                    corner_normals: triangle.corners.map(|corner| corner.normal),
                    neighbours: bends.map(|bend| bend.neighbour),
                }
            })
            .collect()
    }
}

fn corner_at(triangles: &[MeshTriangle], index: usize) -> &MeshCorner {
    &triangles[index / 3].corners[index % 3]
}

/// The angle of its triangle at a corner, in radians.
fn corner_angle(triangles: &[MeshTriangle], index: usize) -> f64 {
    let corners = &triangles[index / 3].corners;
    let [here, next, previous] = [0, 1, 2].map(|i| corners[(index % 3 + i) % 3].position);
    let (to_next, to_previous) = (next - here, previous - here);
    to_next
        .cross(to_previous)
        .length()
        .atan2(to_next.dot(to_previous))
}

/// The shell normal of every corner: one at each position, and the corner's own
/// where the normals there have no direction in common.
fn shell_normals(triangles: &[MeshTriangle]) -> Vec<DVec3> {
    let mut by_position: Vec<(u32, u32)> = (0..3 * triangles.len())
        .into_par_iter()
        .map(|index| (corner_at(triangles, index).position_index, index as u32))
        .collect();
    by_position.par_sort_unstable();
    let mitred: Vec<(u32, DVec3)> = by_position
        .par_chunk_by(|a, b| a.0 == b.0)
        .flat_map_iter(|corners| {
            let normals: Vec<(DVec3, f64)> = corners
                .iter()
                .map(|&(_, index)| {
                    let index = index as usize;
                    let angle = corner_angle(triangles, index);
                    (corner_at(triangles, index).normal, angle)
                })
                .collect();
            let mitre = mitre(&normals);
            corners
                .iter()
                .zip(normals)
                .map(move |(&(_, index), (own, _))| (index, mitre.unwrap_or(own)))
        })
        .collect();
    let mut normals = vec![DVec3::ZERO; mitred.len()];
    for (index, normal) in mitred {
        normals[index as usize] = normal;
    }
    normals
}

/// How the prisms bend along every side of every triangle.
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
    let straight = Bend {
        surface: DVec3::ZERO,
        normal: DVec3::ZERO,
        neighbour: NO_NEIGHBOUR,
    };
    let mut bends = vec![straight; unordered.len()];
    for (index, bend) in unordered {
        bends[index] = bend;
    }
    bends
}

/// How the prisms bend along one edge, with the indices of its `sides`.
///
/// All triangles at the edge take the mean of what their normals ask for, so
/// that they meet there. Nothing here depends on the direction in which a
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
        let ends = side.ends(triangles);
        let neighbour = if linked {
            let other = sides[1 - i];
            4 * other.triangle + other.opposite
        } else {
            NO_NEIGHBOUR
        };
        let bend = Bend {
            surface,
            normal: stretch * middle_normal(normals, ends),
            neighbour,
        };
        (side.index(), bend)
    })
}

/// The mean of the shell normals at an edge's ends.
fn middle_normal(normals: &[DVec3], ends: [usize; 2]) -> DVec3 {
    0.5 * (normals[ends[0]] + normals[ends[1]])
}

/// Whether a ray that leaves the prism at one of `sides` enters one at another:
/// there are two, they run through the edge in opposite directions, and their
/// walls meet.
fn linked(triangles: &[MeshTriangle], normals: &[DVec3], sides: &[Side]) -> bool {
    let [one, other] = sides else { return false };
    let runs_up = |side: &Side| side.ends(triangles)[0] % 3 == (side.opposite as usize + 1) % 3;
    let wall = |side: &Side| side.ends(triangles).map(|index| normals[index]);
    one.triangle != other.triangle && runs_up(one) != runs_up(other) && wall(one) == wall(other)
}
