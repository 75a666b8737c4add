//! Tangent frames by MikkTSpace, the common convention of modelling tools.

use bevy_mikktspace::{TangentSpace, generate_tangents};
use glam::{DVec2, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use super::surface::{Face, Surface};

/// Maximum number of faces at a vertex for MikkTSpace, which recurses around it
/// and compares all pairs. Faces at vertices with more get frames of their own.
const LARGEST_VALENCE: u32 = 2048;

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

/// Computes the tangent frames of every face's corners. `centre` and `diagonal`
/// are those of the bounding box.
pub(super) fn tangent_frames(
    surface: &Surface,
    centre: DVec3,
    diagonal: f64,
) -> Vec<[TangentFrame; 3]> {
    // MikkTSpace works in f32 with absolute thresholds, so positions and texture
    // coordinates are normalised to unit size.
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

    // It underflows for faces without area in f32.
    let valences = surface.valences();
    let is_suitable = |face: &Face| {
        let [a, b, c] = face.vertices.map(|vertex| positions[vertex as usize]);
        a != b
            && b != c
            && c != a
            && face
                .vertices
                .iter()
                .all(|vertex| valences[*vertex as usize] <= LARGEST_VALENCE)
    };
    let selected: Vec<usize> = (0..surface.faces.len())
        .filter(|face| is_suitable(&surface.faces[*face]))
        .collect();
    let mut geometry = Geometry {
        faces: &surface.faces,
        tangents: vec![[[0.0; 4]; 3]; surface.faces.len()],
        selected,
        positions,
        uv_origin: low,
        uv_scale,
    };
    let Ok(()) = generate_tangents(&mut geometry) else {
        unreachable!("no error is defined");
    };

    surface
        .faces
        .par_iter()
        .zip(geometry.tangents)
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

/// The mesh for MikkTSpace.
struct Geometry<'a> {
    faces: &'a [Face],
    /// Indices of the faces for MikkTSpace.
    selected: Vec<usize>,
    positions: Vec<Vec3>,
    uv_origin: DVec2,
    uv_scale: f64,
    /// Tangent and handedness of each corner of each face.
    tangents: Vec<[[f32; 4]; 3]>,
}

impl bevy_mikktspace::Geometry for Geometry<'_> {
    fn num_faces(&self) -> usize {
        self.selected.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.faces[self.selected[face]].vertices[corner] as usize].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.faces[self.selected[face]].normals[corner]
            .as_vec3()
            .to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.faces[self.selected[face]].uvs[corner];
        let unit: Vec2 = (self.uv_scale * (uv - self.uv_origin)).as_vec2();
        unit.to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[self.selected[face]][corner] = tangent.unwrap_or_default().tangent_encoded();
    }
}
