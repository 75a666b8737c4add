//! The carving as triangles: cap, floor and walls of every prism of an object.

use super::contour::Contours;
use bytemuck::{Pod, Zeroable};
use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;
use relievo::oracle::wide::{wide_object, wide_prism};
use relievo::prepare::{PreparedObject, PreparedScene};
use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use relievo_shared_f64::layout::PrismData;
use relievo_shared_f64::prism::Prism;
use relievo_shared_f64::profile::Profile;
use relievo_shared_f64::shape_map::ShapeMap;
use spade::handles::FixedDirectedEdgeHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::HashMap;

/// Most parts of an edge of the mesh.
const MOST_PARTS: f64 = 32.0;
/// Step of barycentrics: 2⁻³⁰.
const STEP: f64 = 1.0 / (1 << 30) as f64;

/// A vertex: 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Position relative to the scene's origin, world units.
    pub position: [f32; 3],
    /// Unit normal in steps of 1/127.
    pub normal: [i8; 3],
    /// One of the `CLASS_` constants.
    pub class: u8,
}

/// An object as plain triangles.
#[derive(Clone, Debug, Default)]
pub struct Carving {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Three indices a triangle, counter-clockwise from outside.
    pub indices: Vec<u32>,
}

/// What all prisms of an object have in common.
struct Source<'a> {
    contours: &'a Contours,
    /// Corners of the rectangle around each line, texels.
    bounds: Vec<[DVec2; 2]>,
    /// S_z, object units.
    depth: f64,
    /// Parts of an edge of the mesh.
    parts: f64,
}

/// Points of a triangle, each once, by their barycentrics w1 and w2. These are multiples of
/// [`STEP`], so that points on a side of the triangle are on it exactly.
#[derive(Default)]
struct Places {
    all: Vec<Point2<f64>>,
    known: HashMap<[i64; 2], usize>,
}

impl Places {
    /// Returns the index of the point with these barycentrics.
    fn find(&mut self, weights: DVec2) -> usize {
        let one = (1.0 / STEP) as i64;
        let [first, mut second] = (weights / STEP)
            .round()
            .to_array()
            .map(|steps| steps as i64);
        // Rounding may leave the third side.
        if (first + second - one).abs() <= 1 {
            second = one - first;
        }
        *self.known.entry([first, second]).or_insert_with(|| {
            let [w1, w2] = [first, second].map(|steps| steps as f64 * STEP);
            self.all.push(Point2::new(w1, w2));
            self.all.len() - 1
        })
    }
}

/// Returns the outlines of the pattern of `object` at the cap.
pub fn contours(object: &PreparedObject) -> Contours {
    let parameters = wide_object(&object.parameters);
    let map = ShapeMap::new(&parameters);
    let radius = Profile::new(&parameters).radius(0.0);
    let words = object.map.words();
    let size = [object.map.width(), object.map.height()].map(|side| side as usize);
    Contours::trace(size, |x, y| {
        let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        map.distance(words, center / map.size) - radius
    })
}

impl Carving {
    /// Carves the one object of `scene` with `contours`, the outlines of its pattern. Edges
    /// are within about `tolerance` world units of the true ones.
    pub fn new(scene: &PreparedScene, contours: &Contours, tolerance: f64) -> Carving {
        let object = &scene.objects[0];
        let parameters = wide_object(&object.parameters);
        let prisms = object.all_prisms(scene.origin);
        let prisms: Vec<PrismData> = prisms.iter().map(wide_prism).collect();
        let widest = |prism| texel_width(prism, contours.size);
        let width = prisms.iter().map(widest).fold(0.0, f64::max);
        let bend = prisms.iter().map(|prism| bend(prism, parameters.depth));
        let bend = bend.fold(0.0, f64::max);
        let simple = contours.simplified(tolerance / width.max(f64::MIN_POSITIVE));
        let source = Source {
            bounds: simple.lines.iter().map(|line| bounds(line)).collect(),
            contours: &simple,
            depth: parameters.depth,
            parts: (bend / tolerance).sqrt().ceil().clamp(1.0, MOST_PARTS),
        };
        let pieces: Vec<Carving> = prisms.par_iter().map(|prism| source.carve(prism)).collect();
        let mut whole = Carving::default();
        let vertices = pieces.iter().map(|piece| piece.vertices.len());
        whole.vertices.reserve_exact(vertices.sum());
        let indices = pieces.iter().map(|piece| piece.indices.len());
        whole.indices.reserve_exact(indices.sum());
        for piece in pieces {
            let first = whole.vertices.len() as u32;
            whole.vertices.extend(piece.vertices);
            whole
                .indices
                .extend(piece.indices.iter().map(|index| first + index));
        }
        whole
    }

    /// Returns the number of triangles.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    /// Returns the bytes of vertices and indices.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.vertices[..]) + size_of_val(&self.indices[..])) as u64
    }

    fn vertex(&mut self, position: DVec3, normal: DVec3, class: u32) -> u32 {
        let normal = (normal.normalize_or_zero() * 127.0).round().to_array();
        self.vertices.push(Vertex {
            position: position.as_vec3().to_array(),
            normal: normal.map(|component| component as i8),
            class: class as u8,
        });
        self.vertices.len() as u32 - 1
    }
}

impl Source<'_> {
    /// Carves the prism of `data`.
    fn carve(&self, data: &PrismData) -> Carving {
        let prism = Prism::new(data, self.depth);
        let (mut places, pieces) = self.pieces(data);
        // The grid follows the curvature; on the edges it is that of the neighbours.
        let parts = self.parts as u32;
        for i in 0..=parts {
            for j in 0..=parts - i {
                places.find(DVec2::new(f64::from(i), f64::from(j)) / self.parts);
            }
        }
        let mut carving = Carving::default();
        let weights: Vec<[f64; 2]> = places.all.iter().map(|place| [place.x, place.y]).collect();
        let mut mesh =
            ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(places.all, Vec::new())
                .expect("barycentrics are finite");
        let mut walls: Vec<FixedDirectedEdgeHandle> = Vec::new();
        for [from, to] in pieces {
            let [from, to] = [from, to].map(spade::handles::FixedVertexHandle::from_index);
            walls.extend(mesh.try_add_constraint(from, to));
        }
        let solid = self.solid_faces(&mesh, &walls, data);

        let at = |index: usize, depth_fraction: f64| {
            let [w1, w2] = weights[index];
            prism.anchor + prism.point(DVec3::new(w1, w2, depth_fraction))
        };
        let normal_at = |index: usize| {
            let [w1, w2] = weights[index];
            let corners = data.corner_normals.map(DVec3::from);
            corners[0] * (1.0 - w1 - w2) + corners[1] * w1 + corners[2] * w2
        };
        let mut known = [vec![u32::MAX; weights.len()], vec![u32::MAX; weights.len()]];
        for face in mesh.inner_faces() {
            let is_solid = solid[face.fix().index()];
            let (known, depth_fraction, class) = if is_solid {
                (&mut known[0], 0.0, CLASS_CAP)
            } else {
                (&mut known[1], 1.0, CLASS_FLOOR)
            };
            for vertex in face.vertices() {
                let index = vertex.fix().index();
                if known[index] == u32::MAX {
                    let position = at(index, depth_fraction);
                    known[index] = carving.vertex(position, normal_at(index), class);
                }
                carving.indices.push(known[index]);
            }
        }
        for wall in walls {
            let edge = mesh.directed_edge(wall);
            let [from, to] = [edge.from(), edge.to()].map(|vertex| vertex.fix().index());
            let corners = [at(from, 0.0), at(from, 1.0), at(to, 0.0), at(to, 1.0)];
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let [a, b, c, d] = corners.map(|corner| carving.vertex(corner, normal, CLASS_WALL));
            carving.indices.extend([a, b, c, c, b, d]);
        }
        carving
    }

    /// Returns the pieces of the lines in the triangle of `data`, as indices of their ends.
    /// The pattern lies to the left of each, seen from outside.
    fn pieces(&self, data: &PrismData) -> (Places, Vec<[usize; 2]>) {
        let mut places = Places::default();
        let mut pieces = Vec::new();
        let size = self.contours.size;
        let [origin, first, second] = data.uv.map(|uv| DVec2::from(uv) * size);
        let texels = DMat2::from_cols(first, second);
        let is_mirrored = texels.determinant() < 0.0;
        if texels.determinant().abs() < 1e-9 {
            return (places, pieces);
        }
        let to_weights = texels.inverse();
        let triangle = bounds(&[origin, origin + first, origin + second]);
        for (line, [low, high]) in self.contours.lines.iter().zip(&self.bounds) {
            let from = ((triangle[0] - *high) / size).ceil().as_i64vec2();
            let to = ((triangle[1] - *low) / size).floor().as_i64vec2();
            for y in from.y..=to.y {
                for x in from.x..=to.x {
                    let moved = DVec2::new(x as f64, y as f64) * size - origin;
                    for pair in line.windows(2) {
                        let ends = [pair[0], pair[1]].map(|point| to_weights * (point + moved));
                        let Some([a, b]) = clip(ends) else {
                            continue;
                        };
                        // No longer than the parts of an edge.
                        let change = b - a;
                        let longest = change.abs().max_element().max(change.element_sum().abs());
                        let count = (longest * self.parts).ceil().max(1.0);
                        let ends: Vec<usize> = (0..=count as u32)
                            .map(|i| places.find(a.lerp(b, f64::from(i) / count)))
                            .collect();
                        for pair in ends.windows(2).filter(|pair| pair[0] != pair[1]) {
                            pieces.push(if is_mirrored {
                                [pair[1], pair[0]]
                            } else {
                                [pair[0], pair[1]]
                            });
                        }
                    }
                }
            }
        }
        (places, pieces)
    }

    /// Returns whether each face lies in the pattern: those to the left of `walls` do, and
    /// what is joined to them.
    fn solid_faces(
        &self,
        mesh: &ConstrainedDelaunayTriangulation<Point2<f64>>,
        walls: &[FixedDirectedEdgeHandle],
        data: &PrismData,
    ) -> Vec<bool> {
        let mut solid: Vec<Option<bool>> = vec![None; mesh.num_all_faces()];
        let mut pending = Vec::new();
        for wall in walls {
            let edge = mesh.directed_edge(*wall);
            pending.extend(edge.face().as_inner().map(|face| (face, true)));
            pending.extend(edge.rev().face().as_inner().map(|face| (face, false)));
        }
        if walls.is_empty() {
            // No line crosses the triangle: its middle says it for all.
            let middle =
                DVec2::from(data.uv[0]) + (DVec2::from(data.uv[1]) + DVec2::from(data.uv[2])) / 3.0;
            let is_solid = self.contours.is_inside(middle * self.contours.size);
            pending.extend(mesh.inner_faces().map(|face| (face, is_solid)));
        }
        while let Some((face, is_solid)) = pending.pop() {
            let known = &mut solid[face.fix().index()];
            if known.is_some() {
                continue;
            }
            *known = Some(is_solid);
            let edges = face.adjacent_edges().into_iter();
            let open = edges.filter(|edge| !edge.is_constraint_edge());
            let beyond = open.filter_map(|edge| edge.rev().face().as_inner());
            pending.extend(beyond.map(|face| (face, is_solid)));
        }
        solid.into_iter().map(|known| known == Some(true)).collect()
    }
}

/// Returns the second and the third corner relative to the first.
fn corners(data: &PrismData) -> [DVec3; 2] {
    let [first, second, first_first, _, second_second] = data.surface.map(DVec3::from);
    [first + first_first, second + second_second]
}

/// Returns the part of the piece between `ends`, barycentrics, that lies in the triangle.
fn clip(ends: [DVec2; 2]) -> Option<[DVec2; 2]> {
    let [a, b] = ends;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for [at, until] in [
        [a.x, b.x],
        [a.y, b.y],
        [1.0 - a.element_sum(), 1.0 - b.element_sum()],
    ] {
        match (at >= 0.0, until >= 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (false, true) => from = from.max(at / (at - until)),
            (true, false) => to = to.min(at / (at - until)),
        }
    }
    let inside = |w: DVec2| {
        let w = w.max(DVec2::ZERO);
        w / w.element_sum().max(1.0)
    };
    (from < to).then(|| [from, to].map(|place| inside(a.lerp(b, place))))
}

/// Returns the corners of the rectangle around `points`.
fn bounds(points: &[DVec2]) -> [DVec2; 2] {
    let low = points.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
    let high = points
        .iter()
        .fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
    [low, high]
}

/// Returns the width of a texel on the facet, world units: the root of its area.
fn texel_width(data: &PrismData, size: DVec2) -> f64 {
    let [first, second] = corners(data);
    let texels = DMat2::from_cols(
        DVec2::from(data.uv[1]) * size,
        DVec2::from(data.uv[2]) * size,
    );
    let area = texels.determinant().abs();
    if area > 0.0 {
        (first.cross(second).length() / area).sqrt()
    } else {
        0.0
    }
}

/// Returns how far an edge of one part lies from cap or floor, at most, world units.
fn bend(data: &PrismData, depth: f64) -> f64 {
    let [_, _, surface @ ..] = data.surface.map(DVec3::from);
    let [_, _, _, normal @ ..] = data.normal.map(DVec3::from);
    let pairs = surface.iter().zip(&normal);
    let most = pairs.map(|(s, n)| s.length().max((*s - *n * depth).length()));
    0.25 * most.fold(0.0, f64::max)
}
