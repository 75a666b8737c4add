//! The room behind the surface, up to the opposite wall.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ray::{Ray, RayHit};
use rayon::prelude::*;

use super::Parts;
use crate::hierarchy;
use crate::mesh::bounds::Bounds;
use crate::mesh::surface::area_normal;
use crate::mesh::triangles::MeshTriangle;

/// Margin of the hierarchy's boxes, as a share of the mesh's diagonal.
const MARGIN: f32 = 1e-5;

/// A ray may pass a triangle's edge by this share of the triangle's area.
const EDGE: f64 = 1e-9;

/// Returns the local depth at every welded position, at most `depth`, at which the
/// shell and that of the opposite wall do not meet: half the way along −N to the
/// first triangle that is hit from behind. Rays start at the corners and at the
/// middle of every triangle.
pub(super) fn depths(parts: &Parts<'_>, bounds: &Bounds, depth: f64) -> Vec<f64> {
    let walls = Walls::new(parts.triangles, bounds);
    let by_corner: Vec<[f64; 3]> = (0..parts.triangles.len())
        .into_par_iter()
        .map(|index| {
            let corners = &parts.triangles[index].corners;
            let normal = |corner: usize| parts.normals[3 * index + corner];
            let positions = corners.map(|corner| corner.position);
            let normals = [0, 1, 2].map(normal);
            let mean = |v: [DVec3; 3]| (v[0] + v[1] + v[2]) / 3.0;
            let of_middle = walls.room(mean(positions), mean(normals), depth, |other| {
                other as usize == index
            });
            std::array::from_fn(|corner| {
                let position = corners[corner].position_index;
                // All corners at a position have one N, but where normals cancel out.
                let first = parts.corners_at.of(position)[0] as usize;
                if first != 3 * index + corner && parts.normals[first] == normals[corner] {
                    return of_middle;
                }
                let of_corner = walls.room(positions[corner], normals[corner], depth, |other| {
                    let others = &parts.triangles[other as usize].corners;
                    others
                        .iter()
                        .any(|corner| corner.position_index == position)
                });
                of_corner.min(of_middle)
            })
        })
        .collect();
    let mut depths = vec![depth; parts.corners_at.count()];
    for (triangle, of_corners) in parts.triangles.iter().zip(by_corner) {
        for (corner, of_corner) in triangle.corners.iter().zip(of_corners) {
            let least = &mut depths[corner.position_index as usize];
            *least = least.min(of_corner);
        }
    }
    depths
}

/// The triangles, to be hit from behind.
struct Walls {
    /// Corners in the order of the hierarchy, and the index of the triangle.
    triangles: Vec<([DVec3; 3], u32)>,
    hierarchy: Bvh2,
    /// Boxes are in units of the diagonal, from the centre: f32 suffices for a mesh
    /// of any size and place.
    centre: DVec3,
    diagonal: f64,
}

impl Walls {
    fn new(triangles: &[MeshTriangle], bounds: &Bounds) -> Walls {
        let (centre, diagonal) = (bounds.centre(), bounds.diagonal());
        let boxes: Vec<Aabb> = triangles
            .par_iter()
            .map(|triangle| {
                let points = triangle
                    .corners
                    .map(|corner| Vec3A::from(((corner.position - centre) / diagonal).as_vec3()));
                let [a, b, c] = points;
                Aabb::new(a.min(b).min(c) - MARGIN, a.max(b).max(c) + MARGIN)
            })
            .collect();
        let hierarchy = hierarchy::build_fast(&boxes);
        let in_order = hierarchy.primitive_indices.par_iter().map(|&index| {
            let corners = &triangles[index as usize].corners;
            (corners.map(|corner| corner.position), index)
        });
        Walls {
            triangles: in_order.collect(),
            hierarchy,
            centre,
            diagonal,
        }
    }

    /// Returns half the distance from `point` along −`normal` to the first triangle
    /// hit from behind, in lengths of `normal`; at most `depth`. Those that
    /// `is_left_out` accepts do not count.
    fn room(
        &self,
        point: DVec3,
        normal: DVec3,
        depth: f64,
        is_left_out: impl Fn(u32) -> bool,
    ) -> f64 {
        let start = ((point - self.centre) / self.diagonal).as_vec3();
        let reach = (2.0 * depth / self.diagonal) as f32 * (1.0 + MARGIN) + MARGIN;
        let ray = Ray::new(start.into(), (-normal).as_vec3().into(), 0.0, reach);
        let mut room = 2.0 * depth;
        self.hierarchy
            .ray_traverse(ray, &mut RayHit::none(), |_, leaf| {
                let (corners, index) = self.triangles[leaf];
                if let Some(distance) = hit_from_behind(corners, point, -normal)
                    && distance < room
                    && !is_left_out(index)
                {
                    room = distance;
                }
                (room / self.diagonal) as f32 * (1.0 + MARGIN) + MARGIN
            });
        0.5 * room
    }
}

/// Returns the distance at which a ray leaves the mesh through a triangle, in
/// lengths of `direction`.
fn hit_from_behind(corners: [DVec3; 3], point: DVec3, direction: DVec3) -> Option<f64> {
    let [a, b, c] = corners.map(|corner| corner - point);
    let normal = area_normal([a, b, c]);
    let along = normal.dot(direction);
    if along <= 0.0 {
        return None;
    }
    let least = -EDGE * along;
    let is_within = direction.dot(b.cross(a)) <= -least
        && direction.dot(c.cross(b)) <= -least
        && direction.dot(a.cross(c)) <= -least;
    let distance = normal.dot(a) / along;
    (is_within && distance >= 0.0).then_some(distance)
}
