//! Tangent frames by MikkTSpace, the common convention of modelling tools.

use bevy_mikktspace::{TangentSpace, generate_tangents};
use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::bounds::Bounds;
use super::corners_at::CornersAt;
use super::surface::{Face, Surface};

/// Maximum number of faces at a vertex for MikkTSpace, which recurses around it
/// and compares all pairs. Faces at vertices with more get frames of their own.
const LARGEST_VALENCE: usize = 2048;

/// Number of faces that MikkTSpace takes at once: it uses one thread.
const BLOCK: usize = 1 << 13;

/// Tangents whose part in the tangent plane is shorter have no direction.
const SHORTEST_TANGENT: f64 = 1e-4;

/// Tangent and bitangent of a corner; the normal is the corner's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TangentFrame {
    /// Unit tangent T, orthogonal to the normal N, in the direction of increasing u.
    pub tangent: DVec3,
    /// ±1: the bitangent, in the direction of increasing v, is
    /// handedness · (N × T).
    pub handedness: f64,
}

impl TangentFrame {
    /// Returns the frame with the tangent projected into the plane orthogonal to
    /// `normal`; `None` if the projection has no direction.
    fn orthogonal(tangent: DVec3, normal: DVec3, handedness: f64) -> Option<Self> {
        let in_plane = tangent - tangent.dot(normal) * normal;
        let length = in_plane.length();
        // Projected again to remove the rounding of the first step.
        let unit = in_plane / length;
        let tangent = (unit - unit.dot(normal) * normal).normalize();
        // False for NaN.
        (length > SHORTEST_TANGENT && tangent.is_finite()).then_some(Self {
            tangent,
            handedness,
        })
    }

    /// Returns the frame of a single face: T along the derivative of the position
    /// by u, or an arbitrary frame if the texture coordinates have no area.
    fn of_face(corners: [DVec3; 3], uvs: [DVec2; 3], normal: DVec3) -> Self {
        let (uv1, uv2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        let handedness = if uv1.perp_dot(uv2) < 0.0 { -1.0 } else { 1.0 };
        let tangent =
            handedness * (uv2.y * (corners[1] - corners[0]) - uv1.y * (corners[2] - corners[0]));
        Self::orthogonal(tangent.normalize_or_zero(), normal, handedness).unwrap_or(Self {
            tangent: normal.any_orthonormal_vector(),
            handedness,
        })
    }
}

/// Computes the tangent frames of every face's corners from that face alone.
pub(super) fn face_frames(surface: &Surface) -> Vec<[TangentFrame; 3]> {
    let faces = surface.faces.par_iter();
    faces
        .map(|face| {
            let corners = surface.corners(face);
            face.normals
                .map(|normal| TangentFrame::of_face(corners, face.uvs, normal))
        })
        .collect()
}

/// Computes the tangent frames of every face's corners by MikkTSpace. `corners_at` has the
/// corners by position; `bounds` is the bounding box.
pub(super) fn tangent_frames(
    surface: &Surface,
    corners_at: &CornersAt,
    bounds: &Bounds,
) -> Vec<[TangentFrame; 3]> {
    // MikkTSpace works in f32 with absolute thresholds, so positions and texture
    // coordinates are normalised to unit size.
    let (centre, diagonal) = (bounds.centre(), bounds.diagonal());
    let positions: Vec<Vec3> = surface
        .positions
        .par_iter()
        .map(|position| ((position - centre) / diagonal).as_vec3())
        .collect();
    let uvs = || surface.faces.iter().flat_map(|face| face.uvs);
    let low = uvs().reduce(DVec2::min).unwrap_or_default();
    let high = uvs().reduce(DVec2::max).unwrap_or_default();
    let extent = (high - low).max_element();
    let uv_scale = if extent > 0.0 { 1.0 / extent } else { 1.0 };

    let inputs = Inputs {
        faces: &surface.faces,
        corners_at,
        positions,
        uv_origin: low,
        uv_scale,
    };
    let tangents = inputs.tangents(BLOCK);

    surface
        .faces
        .par_iter()
        .zip(tangents)
        .map(|(face, tangents)| {
            std::array::from_fn(|corner| {
                let [x, y, z, handedness] = tangents[corner].map(f64::from);
                let normal = face.normals[corner];
                TangentFrame::orthogonal(DVec3::new(x, y, z), normal, handedness).unwrap_or_else(
                    || TangentFrame::of_face(surface.corners(face), face.uvs, normal),
                )
            })
        })
        .collect()
}

/// Tangent and handedness at the corners of a face, as MikkTSpace gives them.
type Tangents = [[f32; 4]; 3];

/// The mesh as MikkTSpace reads it.
struct Inputs<'a> {
    faces: &'a [Face],
    corners_at: &'a CornersAt,
    /// The welded positions, at unit size.
    positions: Vec<Vec3>,
    uv_origin: DVec2,
    uv_scale: f64,
}

impl Inputs<'_> {
    /// Returns whether MikkTSpace takes a face: it underflows for faces without area in f32.
    fn is_suitable(&self, face: u32) -> bool {
        let vertices = self.faces[face as usize].vertices;
        let [a, b, c] = vertices.map(|vertex| self.positions[vertex as usize]);
        let valences = vertices.map(|vertex| self.corners_at.of(vertex).len());
        a != b
            && b != c
            && c != a
            && valences
                .into_iter()
                .all(|valence| valence <= LARGEST_VALENCE)
    }

    /// Returns the corners of a face. Vertices are one where their bits are equal: adding 0
    /// makes −0 into 0.
    fn corners(&self, face: u32) -> [Corner; 3] {
        let face = &self.faces[face as usize];
        std::array::from_fn(|corner| Corner {
            position: self.positions[face.vertices[corner] as usize] + Vec3::ZERO,
            normal: face.normals[corner].as_vec3() + Vec3::ZERO,
            uv: (self.uv_scale * (face.uvs[corner] - self.uv_origin)).as_vec2() + Vec2::ZERO,
        })
    }

    /// Computes the tangents of every face, about `size` faces at once.
    fn tangents(&self, size: usize) -> Vec<Tangents> {
        let all = 0..self.faces.len() as u32;
        // Blocks are slabs, which have few neighbours.
        let low = self.positions.iter().copied().reduce(Vec3::min);
        let high = self.positions.iter().copied().reduce(Vec3::max);
        let axis = (high.unwrap_or_default() - low.unwrap_or_default()).max_position();
        let at = |face: u32| self.positions[self.faces[face as usize].vertices[0] as usize][axis];
        let suitable = all.filter(|face| self.is_suitable(*face));
        let mut keyed: Vec<(f32, u32)> = suitable.map(|face| (at(face), face)).collect();
        keyed.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut selected: Vec<u32> = keyed.into_iter().map(|(_, face)| face).collect();
        let blocks: Vec<Vec<Tangents>> = selected
            .par_chunks_mut(size)
            .map(|block| self.tangents_of(block))
            .collect();
        let mut tangents = vec![Tangents::default(); self.faces.len()];
        for (face, found) in selected.iter().zip(blocks.concat()) {
            tangents[*face as usize] = found;
        }
        tangents
    }

    /// Sorts the faces of `block`, and returns their tangents. They depend on the faces that
    /// have a position in common only.
    fn tangents_of(&self, block: &mut [u32]) -> Vec<Tangents> {
        block.sort_unstable();
        let vertices = block
            .iter()
            .flat_map(|face| self.faces[*face as usize].vertices);
        let around = vertices.flat_map(|vertex| self.corners_at.of(vertex));
        let mut selected: Vec<u32> = around
            .map(|corner| corner / 3)
            .filter(|face| self.is_suitable(*face))
            .collect();
        selected.sort_unstable();
        selected.dedup();
        let mut geometry = Geometry {
            tangents: vec![Tangents::default(); selected.len()],
            faces: selected.iter().map(|face| self.corners(*face)).collect(),
        };
        let Ok(()) = generate_tangents(&mut geometry) else {
            unreachable!("no error is defined");
        };
        let found = selected.iter().zip(geometry.tangents);
        found
            .filter(|(face, _)| block.binary_search(face).is_ok())
            .map(|(_, tangents)| tangents)
            .collect()
    }
}

/// A corner of a face for MikkTSpace, which reads it many times.
struct Corner {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
}

/// The faces of a part of a mesh for MikkTSpace.
struct Geometry {
    faces: Vec<[Corner; 3]>,
    /// Tangent and handedness of each corner of each of them.
    tangents: Vec<Tangents>,
}

impl bevy_mikktspace::Geometry for Geometry {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.faces[face][corner].position.to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.faces[face][corner].normal.to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.faces[face][corner].uv.to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face][corner] = tangent.unwrap_or_default().tangent_encoded();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wavy sheet with a seam in its texture coordinates, its faces in no order.
    #[test]
    fn blocks_do_not_show() {
        const SIDE: u32 = 24;
        let point = |i: u32| [i % SIDE, i / SIDE].map(|axis| f64::from(axis) / f64::from(SIDE));
        let height = |[x, y]: [f64; 2]| 0.1 * (9.0 * x).sin() * (7.0 * y).cos();
        let positions: Vec<DVec3> = (0..SIDE * SIDE)
            .map(|i| DVec3::new(point(i)[0], point(i)[1], height(point(i))))
            .collect();
        let cells = (0..SIDE * SIDE).filter(|i| i % SIDE + 1 < SIDE && i / SIDE + 1 < SIDE);
        let mut faces: Vec<Face> = cells
            .flat_map(|i| [[i, i + 1, i + SIDE + 1], [i, i + SIDE + 1, i + SIDE]])
            .map(|vertices| Face {
                vertices,
                material: 0,
                normals: [DVec3::new(0.1, 0.2, 1.0).normalize(); 3],
                uvs: vertices.map(|vertex| {
                    let mirrored = f64::from(vertices[0] % SIDE > SIDE / 2) * 2.0 - 1.0;
                    DVec2::new(mirrored * point(vertex)[0], point(vertex)[1])
                }),
            })
            .collect();
        let count = faces.len();
        for i in 0..count {
            faces.swap(i, 389 * i % count);
        }
        let surface = Surface { positions, faces };
        let corners_at = surface.corners_at();
        let inputs = Inputs {
            faces: &surface.faces,
            corners_at: &corners_at,
            positions: surface.positions.iter().map(|p| p.as_vec3()).collect(),
            uv_origin: DVec2::ZERO,
            uv_scale: 1.0,
        };
        let whole = inputs.tangents(count);
        let handedness = |sign: f32| whole.iter().flatten().any(|tangent| tangent[3] == sign);
        assert!(handedness(1.0) && handedness(-1.0));
        for size in [1, 10, 333] {
            let blocks = inputs.tangents(size);
            let other = whole.iter().zip(&blocks).filter(|(a, b)| a != b);
            assert_eq!(other.count(), 0, "blocks of {size}");
        }
    }
}
