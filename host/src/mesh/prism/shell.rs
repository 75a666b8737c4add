//! The shell of a mesh: its prisms, as deep as there is room.

use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::data::{LocalDepth, MeshPrism, Shell};
use super::{Bend, Parts, clearance};
use crate::mesh::surface::area_normal;
use crate::mesh::triangles::{Mesh, MeshCorner, MeshTriangle};
use glam::DVec3;
use relievo_shared::layout::NO_NEIGHBOUR;

/// Largest change of the local depth along an edge, as a share of its length.
const SLOPE: f64 = 0.15;

/// Largest ratio of the local depths at the two ends of an edge. Where it is larger, δ in a
/// prism is far from linear, and rays get lost.
const RATIO: f64 = 4.0;

/// Largest local depth, as a share of the radius of curvature along an edge. Deeper, columns
/// are pinched, and a quadric says too little about the way of a ray.
const OF_RADIUS: f64 = 0.45;

/// Largest local depth, as a share of the depth at which the prism over a curved triangle
/// folds: a little more than [`OF_RADIUS`], which is the limit where the surface is smooth.
const CURVED: f64 = 0.46;

/// Largest local depth, as a share of the depth at which the prism over a flat triangle
/// folds: it is only sheared.
const LARGEST: f64 = 0.9;

/// Cosine of the largest angle between the normals of a flat triangle's corners and its own:
/// 3°.
const FLAT: f64 = 0.998_63;

/// Share of the largest local depth that a prism gets in place of a larger one.
const GIVEN: f64 = 0.89;

/// Where the local depth is reduced, the largest distance of an edge of the surface from
/// the straight edge, as a share of that depth.
const BULGE: f64 = 0.12;

/// The most by which a round reduces the local depth of a prism that folds.
const LEAST_FACTOR: f64 = 0.5;

/// Rounds after which prisms that still fold are straightened.
const ROUNDS: usize = 24;

/// The least local depth as a share of the mesh's diagonal. Below it the rounding
/// of δ shows, and rays get lost.
pub(crate) const SHALLOWEST: f64 = 3e-5;

impl Mesh {
    /// Computes the shell for a `depth` > 0, in object units. That of a mesh whose surface is
    /// raised is known: it reaches down to the mesh, whatever the `depth`.
    ///
    /// ```
    /// use relievo::mesh::{Mesh, MeshData, MeshOptions, Projection};
    ///
    /// // A plate, 0.1 thick.
    /// let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
    /// let positions = (0..8).map(corner).map(|[x, y, z]| [x, y, 0.1 * z]);
    /// let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    /// let triangles = quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).concat();
    /// let data = MeshData::new("plate", positions.collect::<Vec<_>>(), triangles);
    /// let options = MeshOptions { projection: Some(Projection::Spherical), ..Default::default() };
    /// let plate = Mesh::from_data(&data, &options)?;
    ///
    /// assert!(plate.shell(0.04).local_depth.is_none());
    /// let reduced = plate.shell(0.2).local_depth.unwrap();
    /// assert_eq!(reduced.share, 1.0);
    /// // 80 % of half the thickness, where the rim folds.
    /// assert!((reduced.median - 0.04).abs() < 1e-3);
    /// # Ok::<(), relievo::mesh::MeshError>(())
    /// ```
    pub fn shell(&self, depth: f64) -> Shell {
        if let Some(shell) = &self.raised_by {
            return Shell::clone(shell);
        }
        let mut parts = Parts::new(&self.triangles);
        let least = (SHALLOWEST * self.bounds.diagonal()).min(depth);
        let mut field = Field {
            depths: clearance::depths(&parts, &self.bounds, depth),
            edges: Vec::new(),
            depth,
            least,
        };
        field.limit_by_radius(&self.triangles);
        let indices: Vec<usize> = (0..parts.corners_at.count()).collect();
        field.smooth(&self.triangles, &indices);
        field.remove_large_bends(&mut parts);
        let mut suspects: Vec<usize> = (0..self.triangles.len()).collect();
        while !suspects.is_empty() {
            unfold(&mut parts, &mut field, suspects);
            suspects = field.remove_large_bends(&mut parts);
        }
        let local_depth = field.report(self);
        let corners = self.triangles.iter().flat_map(|triangle| triangle.corners);
        let depths = corners.map(|corner| field.depths[corner.position_index as usize]);
        field.depth = depths.fold(least, f64::max);
        let prisms: Vec<MeshPrism> = (0..self.triangles.len())
            .into_par_iter()
            .map(|index| parts.prism(index, field.shares(&parts, index)))
            .collect();
        Shell {
            depth: field.depth,
            prisms,
            local_depth,
        }
    }
}

/// The local depth at every welded position.
struct Field {
    depths: Vec<f64>,
    /// Positions at the ends of every edge in both directions, and its length;
    /// sorted, and empty until needed.
    edges: Vec<(u32, u32, f64)>,
    /// The largest and the least depth allowed.
    depth: f64,
    least: f64,
}

/// A position to spread a depth from; the least depth comes first.
#[derive(PartialEq)]
struct Reached {
    depth: f64,
    position: u32,
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_depth = other.depth.total_cmp(&self.depth);
        by_depth.then(other.position.cmp(&self.position))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Field {
    /// Returns the local depths at a triangle's corners as shares of the depth.
    fn shares(&self, parts: &Parts<'_>, index: usize) -> [f64; 3] {
        parts.triangles[index].corners.map(|corner| {
            let depth = self.depths[corner.position_index as usize];
            (depth / self.depth).min(1.0)
        })
    }

    /// Limits the slope around `positions`, whose depth has been reduced. Returns
    /// the positions whose depth this reduces.
    fn smooth(&mut self, triangles: &[MeshTriangle], positions: &[usize]) -> Vec<usize> {
        for &position in positions {
            self.depths[position] = self.depths[position].clamp(self.least, self.depth);
        }
        let reduced = positions.iter().filter(|p| self.depths[**p] < self.depth);
        let mut heap: BinaryHeap<Reached> = reduced
            .map(|&position| Reached {
                depth: self.depths[position],
                position: position as u32,
            })
            .collect();
        if heap.is_empty() {
            return Vec::new();
        }
        if self.edges.is_empty() {
            self.edges = edges(triangles);
        }
        let mut changed = Vec::new();
        while let Some(Reached { depth, position }) = heap.pop() {
            if depth > self.depths[position as usize] {
                continue;
            }
            let start = self.edges.partition_point(|edge| edge.0 < position);
            for &(from, to, length) in &self.edges[start..] {
                if from != position {
                    break;
                }
                let limit = (depth + SLOPE * length).min(RATIO * depth);
                if limit < self.depths[to as usize] {
                    self.depths[to as usize] = limit;
                    changed.push(to as usize);
                    heap.push(Reached {
                        depth: limit,
                        position: to,
                    });
                }
            }
        }
        changed
    }

    /// Limits the local depth to [`OF_RADIUS`] of the radius of curvature along every edge.
    fn limit_by_radius(&mut self, triangles: &[MeshTriangle]) {
        for triangle in triangles {
            for side in 0..3 {
                let [a, b] = [1, 2].map(|i| &triangle.corners[(side + i) % 3]);
                let along = b.position - a.position;
                let turn = (b.normal - a.normal).dot(along);
                let limit = OF_RADIUS * along.length_squared();
                for corner in [a, b] {
                    let depth = &mut self.depths[corner.position_index as usize];
                    if turn * *depth > limit {
                        *depth = limit / turn;
                    }
                }
            }
        }
    }

    /// Removes the bends of the surface along edges whose middle is further than [`BULGE`] of
    /// the local depth from the straight edge, where that depth is reduced. Returns the
    /// triangles that this changes.
    fn remove_large_bends(&self, parts: &mut Parts<'_>) -> Vec<usize> {
        let mut changed = Vec::new();
        for (index, triangle) in parts.triangles.iter().enumerate() {
            let depths = triangle
                .corners
                .map(|corner| self.depths[corner.position_index as usize]);
            for side in 0..3 {
                let least = depths[(side + 1) % 3].min(depths[(side + 2) % 3]);
                let bend = &mut parts.bends[3 * index + side].surface;
                // In the middle of the edge: E / 4.
                if least < self.depth && 0.25 * bend.length() > BULGE * least {
                    *bend = DVec3::ZERO;
                    changed.push(index);
                }
            }
        }
        changed.dedup();
        changed
    }

    fn report(&self, mesh: &Mesh) -> Option<LocalDepth> {
        // Least and mean local depth, and the area.
        let mut reduced: Vec<[f64; 3]> = mesh
            .triangles
            .iter()
            .filter_map(|triangle| {
                let corners = triangle.corners;
                let depths = corners.map(|corner| self.depths[corner.position_index as usize]);
                let least = depths.into_iter().fold(f64::INFINITY, f64::min);
                let area = area_normal(corners.map(|corner| corner.position)).length();
                let mean = depths.iter().sum::<f64>() / 3.0;
                (least < self.depth).then_some([mean, least, area])
            })
            .collect();
        reduced.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let area: f64 = reduced.iter().map(|[_, _, area]| area).sum();
        let mut left = 0.5 * area;
        let [median, ..] = reduced.iter().find(|[_, _, area]| {
            left -= area;
            left <= 0.0
        })?;
        let all = mesh.triangles.iter();
        let all = all.map(|triangle| triangle.corners.map(|corner| corner.position));
        let whole: f64 = all.map(|corners| area_normal(corners).length()).sum();
        let least = reduced.iter().map(|[_, least, _]| *least);
        Some(LocalDepth {
            share: (area / whole).min(1.0),
            least: least.fold(f64::INFINITY, f64::min),
            median: *median,
        })
    }
}

/// Returns every edge in both directions, with its length, sorted.
fn edges(triangles: &[MeshTriangle]) -> Vec<(u32, u32, f64)> {
    let mut edges: Vec<(u32, u32, f64)> = triangles
        .par_iter()
        .flat_map_iter(|triangle| {
            [0, 1, 2].into_iter().flat_map(|corner| {
                let [a, b] = [corner, (corner + 1) % 3].map(|i| &triangle.corners[i]);
                let length = a.position.distance(b.position);
                let (a, b) = (a.position_index, b.position_index);
                [(a, b, length), (b, a, length)]
            })
        })
        .collect();
    edges.par_sort_unstable_by_key(|&(from, to, _)| (from, to));
    edges.dedup_by_key(|&mut (from, to, _)| (from, to));
    edges
}

/// Returns the largest local depth over a triangle as a share of the depth at which its
/// prism folds.
fn largest_share(triangle: &MeshTriangle) -> f64 {
    let normal = area_normal(triangle.corners.map(|corner| corner.position)).normalize_or_zero();
    let is_flat = |corner: &MeshCorner| corner.normal.dot(normal) >= FLAT;
    if triangle.corners.iter().all(is_flat) {
        LARGEST
    } else {
        CURVED
    }
}

/// Reduces the local depth until none of the `suspects` and their neighbours folds.
///
/// A prism that folds however thin it is gets flat: first its surface loses its
/// bends, then it stands alone, with its facet's normal.
fn unfold(parts: &mut Parts<'_>, field: &mut Field, mut suspects: Vec<usize>) {
    for round in 0.. {
        let folding: Vec<(usize, f64)> = suspects
            .par_iter()
            .filter_map(|&index| {
                let prism = parts.prism(index, field.shares(parts, index));
                let share = largest_share(&parts.triangles[index]);
                // Most prisms are far from folding: the first test is cheap.
                if share * prism.safe_depth() > field.depth {
                    return None;
                }
                let largest = share * prism.largest_depth();
                (largest <= field.depth).then_some((index, largest))
            })
            .collect();
        if folding.is_empty() {
            return;
        }
        let mut reduced = Vec::new();
        let mut flattened = Vec::new();
        for (index, largest) in folding {
            let positions = parts.triangles[index]
                .corners
                .map(|c| c.position_index as usize);
            let is_least = positions.iter().all(|p| field.depths[*p] <= field.least);
            if largest > 0.0 && !is_least && round < ROUNDS {
                let factor = (GIVEN * largest / field.depth).max(LEAST_FACTOR);
                reduced.extend(positions.map(|position| (position, factor)));
            } else if !parts.straighten(index, &mut flattened) {
                parts.set_apart(index, &mut flattened);
                // Its sides are open: as little as possible is seen through them.
                reduced.extend(positions.map(|position| (position, 0.0)));
            }
        }
        // A position is reduced once, by the triangle that needs it most.
        reduced.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        reduced.dedup_by_key(|(position, _)| *position);
        let mut changed: Vec<usize> = reduced.iter().map(|(position, _)| *position).collect();
        for (position, factor) in reduced {
            field.depths[position] *= factor;
        }
        changed.extend(field.smooth(parts.triangles, &changed));
        suspects = changed
            .into_iter()
            .flat_map(|position| parts.corners_at.of(position as u32))
            .map(|corner| *corner as usize / 3)
            .chain(flattened)
            .collect();
        suspects.sort_unstable();
        suspects.dedup();
    }
}

impl Parts<'_> {
    /// Removes the bends of the surface along the edges of a triangle, for all
    /// triangles there. Returns whether there were any, and adds the triangles that
    /// change.
    fn straighten(&mut self, index: usize, changed: &mut Vec<usize>) -> bool {
        let vertices = self.triangles[index].corners.map(|c| c.position_index);
        let mut was_bent = false;
        for opposite in 0..3 {
            let [start, end] = [1, 2].map(|i| vertices[(opposite + i) % 3]);
            for other in self.corners_at.of(start).iter().map(|corner| corner / 3) {
                let corners = self.triangles[other as usize].corners;
                let third = corners
                    .iter()
                    .position(|c| c.position_index != start && c.position_index != end);
                let has_edge = corners.iter().any(|c| c.position_index == end);
                let Some(third) = third.filter(|_| has_edge) else {
                    continue;
                };
                let bend = &mut self.bends[3 * other as usize + third].surface;
                if *bend != DVec3::ZERO {
                    *bend = DVec3::ZERO;
                    was_bent = true;
                    changed.push(other as usize);
                }
            }
        }
        was_bent
    }

    /// Gives a triangle a straight prism along its own normal, which no neighbour
    /// shares and which does not fold. Adds it to `changed`, unless it has one.
    fn set_apart(&mut self, index: usize, changed: &mut Vec<usize>) {
        let corners = self.triangles[index].corners.map(|corner| corner.position);
        let normal = area_normal(corners).normalize();
        let sides = 3 * index..3 * index + 3;
        if self.normals[sides.clone()] == [normal; 3] {
            return;
        }
        for side in sides {
            let neighbour = self.bends[side].neighbour;
            if neighbour != NO_NEIGHBOUR {
                let other = 3 * (neighbour >> 2) + (neighbour & 3);
                self.bends[other as usize].neighbour = NO_NEIGHBOUR;
            }
            self.bends[side] = Bend::STRAIGHT;
            self.normals[side] = normal;
        }
        changed.push(index);
    }
}
