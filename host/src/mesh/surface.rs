//! The mesh during preparation: triangles over welded positions.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::corners_at::CornersAt;

/// Largest area of a degenerate triangle, in squares of its longest edge
/// (section 5 of docs/algorithm.md).
pub(super) const DEGENERATE_AREA: f64 = 1e-12;

/// A triangle during preparation.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Welded positions: indices into [`Surface::positions`], all different.
    pub vertices: [u32; 3],
    /// Unit normals of the corners; zero where still unknown.
    pub normals: [DVec3; 3],
    /// Texture coordinates of the corners, in repeats.
    pub uvs: [DVec2; 3],
    /// Index of the material.
    pub material: u32,
}

impl Face {
    /// Reverses the winding.
    pub fn reverse(&mut self) {
        self.vertices.swap(1, 2);
        self.normals.swap(1, 2);
        self.uvs.swap(1, 2);
    }
}

/// Triangles over welded positions.
#[derive(Debug)]
pub(super) struct Surface {
    /// The welded positions, in object units.
    pub positions: Vec<DVec3>,
    /// The triangles, none of them degenerate.
    pub faces: Vec<Face>,
}

impl Surface {
    /// Returns the positions of the corners of `face`.
    pub fn corners(&self, face: &Face) -> [DVec3; 3] {
        face.vertices.map(|vertex| self.positions[vertex as usize])
    }

    /// Returns the corners of all faces by welded position.
    pub fn corners_at(&self) -> CornersAt {
        let vertices = self.faces.iter().flat_map(|face| face.vertices);
        CornersAt::new(self.positions.len(), vertices)
    }
}

/// Returns the pairs of sides that meet at an edge where no third triangle is. A
/// side is 3 × its triangle's index + the opposite corner.
pub(super) fn pairs(surface: &Surface) -> Vec<[usize; 2]> {
    let mut sides: Vec<([u32; 2], u32)> = (0..3 * surface.faces.len() as u32)
        .into_par_iter()
        .map(|side| {
            let vertices = surface.faces[side as usize / 3].vertices;
            let [a, b] = [1, 2].map(|i| vertices[(side as usize + i) % 3]);
            ([a.min(b), a.max(b)], side)
        })
        .collect();
    sides.par_sort_unstable();
    sides
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|sides| match sides {
            [(_, one), (_, other)] => Some([*one as usize, *other as usize]),
            _ => None,
        })
        .collect()
}

/// Returns the normal of a triangle by its winding; its length is twice the area.
pub(super) fn area_normal(corners: [DVec3; 3]) -> DVec3 {
    (corners[1] - corners[0]).cross(corners[2] - corners[0])
}
