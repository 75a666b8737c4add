//! What is drawn of an object: for each facet a shape that covers the pixels whose rays may enter
//! it.
//!
//! The vertex shader (carved.wgsl) grows them by a part of a pixel, and covers the whole picture for a
//! facet whose shell may hold the eye.

use bevy::asset::RenderAssetUsages;
use bevy::camera::primitives::Aabb;
use bevy::math::{Vec2, Vec3, Vec3A, Vec4};
use bevy::mesh::{Mesh, MeshVertexAttribute, PrimitiveTopology, VertexFormat};
use relievo::prepare::PreparedObject;
use relievo_shared::layout::{PrismData, Triangle};
use relievo_shared::prism::{cap_hull, is_open, normal_hull};

/// Direction and length in which a corner moves when the sides of its triangle, or the faces around
/// its prism, move out by 1.
pub(crate) const OUTWARD: MeshVertexAttribute =
    MeshVertexAttribute::new("Relievo_Outward", 0x7e11_e001, VertexFormat::Float32x3);
/// Unit normal of a triangle that is seen smaller from the side; 0 for a shape around a prism.
pub(crate) const FACING: MeshVertexAttribute = Mesh::ATTRIBUTE_NORMAL;
/// Centre and radius of a ball around the facet's shell.
pub(crate) const BALL: MeshVertexAttribute =
    MeshVertexAttribute::new("Relievo_Ball", 0x7e11_e002, VertexFormat::Float32x4);
/// Whole repeats that the facet's texture coordinates leave out.
pub(crate) const WHOLE: MeshVertexAttribute =
    MeshVertexAttribute::new("Relievo_Whole", 0x7e11_e003, VertexFormat::Float32x2);
/// 4 × index of the facet + corner of the triangle that covers the picture; 3 for none.
pub(crate) const FACET: MeshVertexAttribute =
    MeshVertexAttribute::new("Relievo_Facet", 0x7e11_e004, VertexFormat::Uint32);

/// The largest number of facets.
pub(crate) const MOST_FACETS: usize = 1 << 30;

/// Sine of the sharpest corner that is moved by as much as its sides need.
const SHARPEST: f32 = 0.02;
/// Share of its size by which the shape around a prism is larger: rays may enter beside its sides.
const MARGIN: f32 = 0.02;

/// The shapes of all facets, and what bounds them.
pub(crate) struct Hull {
    pub mesh: Mesh,
    /// Box around the shells, space of the mesh.
    pub bounds: Aabb,
    /// Radius of a ball around the shells, with the object's origin as centre.
    pub radius: f32,
}

#[derive(Default)]
struct Vertices {
    position: Vec<Vec3>,
    outward: Vec<Vec3>,
    facing: Vec<Vec3>,
    ball: Vec<Vec4>,
    whole: Vec<Vec2>,
    facet: Vec<u32>,
}

impl Vertices {
    /// Adds a triangle of facet `index`, the `first` of it or not.
    fn triangle(&mut self, facet: &Facet, corners: [Vec3; 3], outward: [Vec3; 3], first: bool) {
        for (corner, (position, outward)) in (0..).zip(corners.into_iter().zip(outward)) {
            self.position.push(position);
            self.outward.push(outward);
            self.facing.push(facet.facing);
            self.ball.push(facet.ball);
            self.whole.push(facet.whole);
            self.facet
                .push(4 * facet.index + if first { corner } else { 3 });
        }
    }
}

/// What the vertices of a facet have in common.
struct Facet {
    index: u32,
    facing: Vec3,
    ball: Vec4,
    whole: Vec2,
}

/// Returns the shapes of the facets of `object`, whose positions are relative to `origin` in the
/// space of the mesh, with so many repeats of the pattern.
pub(crate) fn hull(object: &PreparedObject, origin: Vec3, repeat: Vec2) -> Hull {
    let depth = object.parameters.depth;
    let mut vertices = Vertices::default();
    for (index, triangle) in object.triangles.iter().enumerate() {
        let corners = triangle.corners.map(|corner| Vec3::from(corner.position));
        let facet = Facet {
            index: index as u32,
            facing: facing(corners),
            ball: ball_around(corners, depth),
            whole: whole_repeats(object, index, triangle, repeat),
        };
        match object.prisms.get(index) {
            Some(prism) if object.has_prisms() => {
                let radius = prism.radius;
                let centre = Vec3::from(prism.anchor) + Vec3::from(prism.centre);
                let facet = Facet {
                    ball: centre.extend(radius),
                    facing: Vec3::ZERO,
                    ..facet
                };
                add_prism(&mut vertices, &facet, prism, corners, depth);
            }
            _ => vertices.triangle(&facet, corners, outward(corners), true),
        }
    }
    // The shells lie behind the facets, and normals are about unit vectors.
    let reach = 1.5 * depth;
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0_f32);
    let (low, high, furthest) =
        vertices
            .position
            .iter()
            .fold(none, |(low, high, far), position| {
                (
                    low.min(*position),
                    high.max(*position),
                    far.max(position.length()),
                )
            });
    for position in &mut vertices.position {
        *position += origin;
    }
    for ball in &mut vertices.ball {
        *ball += origin.extend(0.0);
    }
    let bounds = Aabb {
        center: Vec3A::from(origin + 0.5 * (low + high)),
        half_extents: Vec3A::from(0.5 * (high - low) + reach),
    };
    let usage = RenderAssetUsages::RENDER_WORLD;
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vertices.position)
        .with_inserted_attribute(OUTWARD, vertices.outward)
        .with_inserted_attribute(FACING, vertices.facing)
        .with_inserted_attribute(BALL, vertices.ball)
        .with_inserted_attribute(WHOLE, vertices.whole)
        .with_inserted_attribute(FACET, vertices.facet);
    Hull {
        mesh,
        bounds,
        radius: furthest + reach,
    }
}

/// Returns a ball around the shell over a triangle: that of
/// [`may_surround_eye`](relievo_shared::facet::may_surround_eye), but for the near plane.
fn ball_around([a, b, c]: [Vec3; 3], depth: f32) -> Vec4 {
    let side = (b - a).length().max((c - a).length());
    a.extend(std::f32::consts::SQRT_2 * (side + 2.0 * depth))
}

fn whole_repeats(object: &PreparedObject, index: usize, triangle: &Triangle, repeat: Vec2) -> Vec2 {
    let uv = object.mesh.triangles[index].corners[0].uv;
    let whole = Vec2::new(uv.x as f32, -uv.y as f32) * repeat;
    (whole - Vec2::from(triangle.corners[0].uv)).round()
}

/// Returns the unit normal of a triangle; 0 if it has no area.
fn facing([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Returns for each corner how it moves when the sides move out by 1.
fn outward(corners: [Vec3; 3]) -> [Vec3; 3] {
    std::array::from_fn(|i| {
        let [before, corner, after] = [2, 0, 1].map(|step| corners[(i + step) % 3]);
        let towards = (corner - before).normalize_or_zero();
        let away = (after - corner).normalize_or_zero();
        (towards - away) / towards.cross(away).length().max(SHARPEST)
    })
}

/// Adds a shape around the faces through which rays enter a prism: around its cap, or around the
/// whole of it if a side is open.
fn add_prism(
    vertices: &mut Vertices,
    facet: &Facet,
    prism: &PrismData,
    corners: [Vec3; 3],
    depth: f32,
) {
    let anchor = Vec3::from(prism.anchor);
    let cap = cap_hull(prism).map(|point| anchor + Vec3::from(point.to_array()));
    let mut points = cap.to_vec();
    if is_open(prism) {
        let down = normal_hull(prism).map(|normal| depth * Vec3::from(normal.to_array()));
        points.extend(cap.iter().zip(down).map(|(cap, down)| *cap - down));
    }
    let up = Vec3::from(prism.facet);
    let (polygon, [low, high]) = around(&points, corners, up);
    let side = |height: f32| -> Vec<Vec3> {
        let lift = |point: &Vec3| *point + up * (height - up.dot(*point));
        polygon.iter().map(lift).collect()
    };
    let (bottom, top) = (side(low), side(high));
    // Larger by the same factor from the centre, its nearest face moves out by 1, and others by more.
    let corners = bottom.iter().chain(&top);
    let centre = corners.sum::<Vec3>() / (2 * polygon.len()) as f32;
    let from_sides = (0..polygon.len()).map(|i| {
        let (start, end) = (top[i], top[(i + 1) % polygon.len()]);
        (end - start)
            .cross(up)
            .normalize_or_zero()
            .dot(start - centre)
    });
    let nearest = from_sides.fold(0.5 * (high - low), f32::min);
    let outward = |corner: Vec3| (corner - centre) / nearest.max(f32::MIN_POSITIVE);
    let mut is_first = true;
    let mut add = |corners: [Vec3; 3]| {
        vertices.triangle(facet, corners, corners.map(outward), is_first);
        is_first = false;
    };
    for i in 1..polygon.len() - 1 {
        add([top[0], top[i], top[i + 1]]);
        add([bottom[0], bottom[i + 1], bottom[i]]);
    }
    for i in 0..polygon.len() {
        let next = (i + 1) % polygon.len();
        add([bottom[i], bottom[next], top[next]]);
        add([bottom[i], top[next], top[i]]);
    }
}

/// Returns a polygon and two heights along `up` between which all `points` lie: the triangle with
/// its sides moved out, or a rectangle where it has a sharp corner.
fn around(points: &[Vec3], corners: [Vec3; 3], up: Vec3) -> (Vec<Vec3>, [f32; 2]) {
    let spread = |along: Vec3| {
        let places = points.iter().map(|point| along.dot(*point));
        places.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], place| {
            [low.min(place), high.max(place)]
        })
    };
    let along = (corners[1] - corners[0]).normalize_or(up.any_orthonormal_vector());
    let across = up.cross(along);
    let (x, y, mut z) = (spread(along), spread(across), spread(up));
    let margin = MARGIN * (x[1] - x[0]).max(y[1] - y[0]).max(z[1] - z[0]);
    z = [z[0] - margin, z[1] + margin];
    let moves = outward(corners);
    let is_sharp = moves.iter().any(|outward| outward.length() > 8.0);
    if is_sharp {
        let [x, y] = [x, y].map(|[low, high]| [low - margin, high + margin]);
        let at = |x: f32, y: f32| along * x + across * y;
        let polygon = [
            at(x[0], y[0]),
            at(x[1], y[0]),
            at(x[1], y[1]),
            at(x[0], y[1]),
        ];
        return (polygon.to_vec(), z);
    }
    // Each side moves out by its own distance; the new corner is where two of them meet.
    let sides: [(Vec3, f32); 3] = std::array::from_fn(|i| {
        let (start, end) = (corners[i], corners[(i + 1) % 3]);
        let out = (end - start).cross(up).normalize_or_zero();
        let furthest = points.iter().map(|point| out.dot(*point - start));
        (out, furthest.fold(0.0, f32::max) + margin)
    });
    let polygon = (0..3).map(|i| {
        let ((before, by_before), (after, by_after)) = (sides[(i + 2) % 3], sides[i]);
        // The displacement d in the plane with d · before and d · after given.
        let overlap = before.dot(after);
        let scale = 1.0 / (1.0 - overlap * overlap);
        let moved =
            before * (by_before - overlap * by_after) + after * (by_after - overlap * by_before);
        corners[i] + moved * scale
    });
    (polygon.collect(), z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_move_so_that_sides_move_out_by_one() {
        let corners = [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 3.0];
        let moved: [Vec3; 3] = std::array::from_fn(|i| corners[i] + outward(corners)[i]);
        assert!((moved[0] - Vec3::new(-1.0, -1.0, 0.0)).length() < 1e-5);
        for i in 0..3 {
            let (start, end) = (corners[i], corners[(i + 1) % 3]);
            let out = (end - start).cross(Vec3::Z).normalize();
            assert!((out.dot(moved[i] - start) - 1.0).abs() < 1e-4, "{i}");
        }
    }

    #[test]
    fn the_shape_around_points_contains_them() {
        let sharp = [Vec3::ZERO, Vec3::X * 4.0, Vec3::new(3.9, 0.1, 0.0)];
        let plain = [Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 3.0];
        for corners in [plain, sharp] {
            let mut points = corners.to_vec();
            points.extend([Vec3::new(-0.5, 1.0, 0.3), Vec3::new(3.0, 2.0, -0.7)]);
            let (polygon, [low, high]) = around(&points, corners, Vec3::Z);
            assert!(low < -0.7 && high > 0.3);
            for i in 0..polygon.len() {
                let (start, end) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                let out = (end - start).cross(Vec3::Z);
                assert!(points.iter().all(|point| out.dot(*point - start) < 0.0));
            }
        }
    }
}
