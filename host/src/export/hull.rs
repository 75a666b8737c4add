//! Encloses the facets in convex hulls, for engines that draw vertex buffers.
//!
//! Every ray that may hit something in the shell over a facet goes through its hull, whatever
//! the camera: perspective, orthographic, or that of a shadow map. The faces that are turned
//! away are drawn, so that a camera may be inside.

use crate::prepare::PreparedObject;
use crate::shaders::Facets;
use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use relievo_shared::layout::PrismData;
use relievo_shared::prism::{cap_hull, normal_hull};

/// Name of the file with the vertices.
pub(super) const VERTICES_FILE: &str = "hull.bin";
/// Name of the file with the indices.
pub(super) const INDICES_FILE: &str = "hull_indices.bin";

/// Share of their size by which hulls of prisms are larger: rays may enter beside their sides.
const PRISM_MARGIN: f64 = 0.02;

/// Farthest that a corner may move when its two sides move by 1; sharper triangles get a
/// rectangle around them.
const FARTHEST: f64 = 8.0;

/// A vertex of a hull.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct Vertex {
    /// Object units, in the space of the facets.
    pub(super) position: [f32; 3],
    /// Moves all its faces out by 1 if added to the position.
    pub(super) outward: [f32; 3],
    /// Index of the facet.
    pub(super) facet: u32,
}

/// The hulls of an object.
#[derive(Debug, Default)]
pub(super) struct Hull {
    /// Their vertices.
    pub(super) vertices: Vec<Vertex>,
    /// Three for each triangle, counterclockwise seen from outside.
    pub(super) indices: Vec<u32>,
}

/// Returns the hulls of the facets of `object`.
pub(super) fn hull(object: &PreparedObject, facets: Facets) -> Hull {
    let mut hull = Hull::default();
    match facets {
        Facets::Triangles | Facets::PlanarTriangles => {
            for (facet, triangle) in (0..).zip(object.triangles.iter()) {
                let corners = triangle.corners.map(|corner| wide(corner.position));
                // A triangle without area is never hit.
                if let Some(plane) = Plane::of(corners) {
                    // A ray hits the flat triangle's front, and never leaves through it.
                    hull.add(facet, &plane, &corners, 0.0, false);
                }
            }
        }
        Facets::Prisms => {
            for (facet, prism) in (0..).zip(object.prisms.iter()) {
                let points = prism_points(prism, f64::from(object.parameters.depth));
                let [a, b, c, ..] = points;
                let plane = Plane::of([a, b, c]).unwrap_or(Plane::facing(wide(prism.facet)));
                hull.add(facet, &plane, &points, PRISM_MARGIN, true);
            }
        }
    }
    hull
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// Returns points whose convex hull contains a prism; its three corners on the cap first.
fn prism_points(prism: &PrismData, depth: f64) -> [DVec3; 12] {
    let cap = cap_hull(prism).map(|point| wide(prism.anchor) + wide(point.to_array()));
    let normal = normal_hull(prism).map(|normal| wide(normal.to_array()));
    std::array::from_fn(|i| match i {
        0..6 => cap[i],
        _ => cap[i - 6] - depth * normal[i - 6],
    })
}

/// The plane of a facet, with the sides of a polygon in it.
struct Plane {
    normal: DVec3,
    right: DVec3,
    up: DVec3,
    /// Unit normals of the sides, counterclockwise.
    sides: Vec<DVec2>,
}

impl Plane {
    /// Returns that of a triangle; none if it has no area.
    fn of(corners: [DVec3; 3]) -> Option<Plane> {
        let [a, b, c] = corners;
        let edges = [b - a, c - b, a - c];
        let normal = edges[0].cross(edges[1]).try_normalize()?;
        let longest = |i: &DVec3, j: &DVec3| i.length_squared().total_cmp(&j.length_squared());
        let right = edges.into_iter().max_by(longest)?.try_normalize()?;
        let mut plane = Plane::facing(normal);
        (plane.right, plane.up) = (right, normal.cross(right));
        let sides: Option<Vec<DVec2>> = edges
            .iter()
            .map(|edge| plane.flat(edge.cross(normal)).try_normalize())
            .collect();
        let sides = sides?;
        // The middle of two moved sides moves by 1 / cos(half the angle between them).
        let is_blunt = |i: usize| {
            let twice_squared = 1.0 + sides[i].dot(sides[(i + 1) % 3]);
            0.5 * twice_squared * FARTHEST * FARTHEST > 1.0
        };
        if (0..3).all(is_blunt) {
            plane.sides = sides;
        }
        Some(plane)
    }

    /// Returns one with a rectangle.
    fn facing(normal: DVec3) -> Plane {
        let (right, up) = normal.any_orthonormal_pair();
        let (up, right) = if right.cross(up).dot(normal) < 0.0 {
            (right, up)
        } else {
            (up, right)
        };
        Plane {
            normal,
            right,
            up,
            sides: vec![DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y],
        }
    }

    fn flat(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.right), v.dot(self.up))
    }

    fn raised(&self, v: DVec2, height: f64) -> DVec3 {
        self.right * v.x + self.up * v.y + self.normal * height
    }
}

/// Returns the point p with p · n = h for two sides.
fn corner(sides: [DVec2; 2], heights: [f64; 2]) -> DVec2 {
    let [m, n] = sides;
    let [g, h] = heights;
    DVec2::new(g * n.y - h * m.y, h * m.x - g * n.x) / m.perp_dot(n)
}

impl Hull {
    /// Adds a straight prism around `points`, larger by a share of its size, with or without
    /// the face in front.
    fn add(&mut self, facet: u32, plane: &Plane, points: &[DVec3], share: f64, has_front: bool) {
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let around = || points.iter().map(|point| *point - centre);
        let highest = |heights: &mut dyn Iterator<Item = f64>| heights.fold(f64::MIN, f64::max);
        let margin = share * highest(&mut around().map(DVec3::length));
        let reach = |axis: DVec3| highest(&mut around().map(|point| point.dot(axis))) + margin;
        let (high, low) = (reach(plane.normal), -reach(-plane.normal));
        let heights: Vec<f64> = plane
            .sides
            .iter()
            .map(|side| reach(plane.raised(*side, 0.0)))
            .collect();
        let count = plane.sides.len();
        let first = self.vertices.len() as u32;
        for (height, out) in [(low, -1.0), (high, 1.0)] {
            for i in 0..count {
                let next = (i + 1) % count;
                let sides = [plane.sides[i], plane.sides[next]];
                let at = corner(sides, [heights[i], heights[next]]);
                let position = centre + plane.raised(at, height);
                let outward = plane.raised(corner(sides, [1.0, 1.0]), out);
                self.vertices.push(Vertex {
                    position: position.as_vec3().to_array(),
                    outward: outward.as_vec3().to_array(),
                    facet,
                });
            }
        }
        let count = count as u32;
        let back = |i: u32| first + i % count;
        let front = |i: u32| first + count + i % count;
        for i in 0..count {
            self.indices.extend([back(i), back(i + 1), front(i + 1)]);
            self.indices.extend([back(i), front(i + 1), front(i)]);
        }
        for i in 1..count - 1 {
            self.indices.extend([back(0), back(i + 1), back(i)]);
            if has_front {
                self.indices.extend([front(0), front(i), front(i + 1)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed hull of a triangle, or the one without a front, of thickness 0 then.
    fn of_triangle(corners: [DVec3; 3], has_front: bool) -> Hull {
        let mut hull = Hull::default();
        let plane = Plane::of(corners).unwrap();
        let share = if has_front { 0.1 } else { 0.0 };
        hull.add(5, &plane, &corners, share, has_front);
        hull
    }

    /// The faces, moved out by `distance`.
    fn faces(hull: &Hull, distance: f64) -> Vec<[DVec3; 3]> {
        let at = |index: &u32| {
            let vertex = &hull.vertices[*index as usize];
            wide(vertex.position) + distance * wide(vertex.outward)
        };
        hull.indices
            .chunks(3)
            .map(|triangle| [at(&triangle[0]), at(&triangle[1]), at(&triangle[2])])
            .collect()
    }

    /// A blunt triangle, a needle, and one with a corner of nearly 180°.
    const TRIANGLES: [[DVec3; 3]; 3] = [
        [DVec3::X, DVec3::Y, DVec3::Z],
        [
            DVec3::ZERO,
            DVec3::new(3.0, 0.0, 0.01),
            DVec3::new(3.0, 0.02, 0.0),
        ],
        [
            DVec3::ZERO,
            DVec3::new(1.0, 0.01, 0.0),
            DVec3::new(2.0, 0.0, 0.0),
        ],
    ];

    #[test]
    fn faces_are_around_the_triangle_and_move_out() {
        for (corners, count) in TRIANGLES.into_iter().zip([6, 8, 8]) {
            for has_front in [false, true] {
                let hull = of_triangle(corners, has_front);
                assert_eq!(hull.vertices.len(), count);
                assert!(hull.vertices.iter().all(|vertex| vertex.facet == 5));
                // A triangle has thickness only when it is moved out.
                let moved = faces(&hull, 1e-3);
                for (face, further) in moved.iter().zip(faces(&hull, 1.001)) {
                    let [a, b, c] = *face;
                    let normal = (b - a).cross(c - a).normalize();
                    for corner in corners {
                        assert!(normal.dot(corner - a) < -0.9e-3, "{corners:?} {face:?}");
                    }
                    for corner in further {
                        assert!((normal.dot(corner - a) - 1.0).abs() < 1e-3);
                    }
                }
            }
        }
    }

    #[test]
    fn every_edge_belongs_to_two_faces() {
        for corners in TRIANGLES {
            let hull = of_triangle(corners, true);
            let mut edges: Vec<[u32; 2]> = Vec::new();
            for face in hull.indices.chunks(3) {
                let [a, b, c] = [face[0], face[1], face[2]];
                edges.extend([[a, b], [b, c], [c, a]]);
            }
            for [start, end] in &edges {
                let back = edges.iter().filter(|edge| **edge == [*end, *start]);
                assert_eq!(back.count(), 1);
            }
        }
    }

    #[test]
    fn a_triangle_without_area_has_no_plane() {
        assert!(Plane::of([DVec3::ZERO; 3]).is_none());
        assert!(Plane::of([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]).is_none());
    }
}
