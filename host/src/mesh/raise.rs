//! Raising the surface of a mesh, for columns that rise from it.

use std::path::Path;

use glam::DVec3;

use super::error::MeshError;
use super::options::MeshOptions;
use super::prepare::prepare;
use super::raw::{Corner, RawMesh};
use super::triangles::{Mesh, MeshReport, MeshTriangle};

impl Mesh {
    /// Returns the mesh with its surface moved outward by `height` > 0, in object units.
    /// The floor of its shell is `self`.
    ///
    /// The surface is moved less where it would fold or meet itself, as the floor of a
    /// [`Shell`](super::Shell) is on the other side of the surface.
    pub(super) fn raised(&self, height: f64, path: &Path) -> Result<Mesh, MeshError> {
        let inside_out = Mesh {
            triangles: self.triangles.iter().map(inside_out).collect(),
            materials: Vec::new(),
            raised_by: None,
            ..*self
        };
        let mut shell = inside_out.shell(height);
        for prism in &mut shell.prisms {
            *prism = prism.upside_down(shell.depth);
        }
        let corners = self.triangles.iter().flat_map(|triangle| &triangle.corners);
        let count = corners.map(|corner| corner.position_index + 1).max();
        let mut raw = RawMesh {
            positions: vec![DVec3::ZERO; count.unwrap_or(0) as usize],
            normals: Vec::with_capacity(3 * self.triangles.len()),
            uvs: Vec::with_capacity(3 * self.triangles.len()),
            triangles: Vec::with_capacity(self.triangles.len()),
            materials: self.materials.clone(),
            material_of: self
                .triangles
                .iter()
                .map(|triangle| triangle.material)
                .collect(),
            face_without_uvs: None,
        };
        for (triangle, prism) in self.triangles.iter().zip(&shell.prisms) {
            let raised = prism.corners();
            raw.triangles.push(std::array::from_fn(|i| {
                let corner = &triangle.corners[i];
                let index = raw.normals.len() as u32;
                raw.positions[corner.position_index as usize] = prism.anchor + raised[i];
                raw.normals.push(corner.normal);
                raw.uvs.push(corner.uv);
                Corner {
                    position: corner.position_index,
                    normal: Some(index),
                    uv: Some(index),
                }
            }));
        }
        let raised = prepare(&raw, path, &MeshOptions::default())?;
        // Triangles without area are left out, in a valley that is closed.
        let is_whole = raised.triangles.len() == shell.prisms.len();
        Ok(Mesh {
            raised_by: is_whole.then(|| Box::new(shell)),
            report: MeshReport {
                smallest_curvature: raised.report.smallest_curvature,
                largest_curvature: raised.report.largest_curvature,
                ..self.report
            },
            ..raised
        })
    }
}

/// Returns a triangle with its inside turned out.
fn inside_out(triangle: &MeshTriangle) -> MeshTriangle {
    let [a, b, c] = triangle.corners.map(|mut corner| {
        corner.normal = -corner.normal;
        corner
    });
    MeshTriangle {
        corners: [a, c, b],
        material: triangle.material,
    }
}

#[cfg(test)]
mod tests {
    use super::super::orient::tests::cube;
    use super::super::{MeshData, Projection};
    use super::*;

    fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>, raise: f64) -> Mesh {
        let data = MeshData::new("mesh", positions, triangles);
        let options = MeshOptions {
            projection: Some(Projection::Spherical),
            crease_angle: 30.0,
            raise,
            ..MeshOptions::default()
        };
        Mesh::from_data(&data, &options).unwrap()
    }

    #[test]
    fn the_faces_of_a_cube_move_out_and_keep_their_uvs() {
        let (positions, triangles) = cube(0.5, DVec3::splat(0.5));
        let positions: Vec<[f64; 3]> = positions.iter().map(DVec3::to_array).collect();
        let cube = |raise: f64| mesh(positions.clone(), triangles.clone(), raise);
        let (plain, raised) = (cube(0.0), cube(0.25));
        assert!(
            (raised.bounds.min + 0.25).length() < 1e-9,
            "{:?}",
            raised.bounds
        );
        assert!((raised.bounds.max - 1.25).length() < 1e-9);
        for (old, new) in plain.triangles.iter().zip(&raised.triangles) {
            for (old, new) in old.corners.iter().zip(&new.corners) {
                assert_eq!(old.uv, new.uv);
                assert!(old.normal.distance(new.normal) < 1e-12);
            }
        }
        // Its floor is the cube.
        let shell = raised.shell(0.25);
        assert!(shell.local_depth.is_none() && shell.depth == 0.25);
        for (old, prism) in plain.triangles.iter().zip(&shell.prisms) {
            let floor = prism.upside_down(0.25);
            let [a, c, b] = floor.corners().map(|corner| floor.anchor + corner);
            for (old, new) in old.corners.iter().zip([a, b, c]) {
                assert!(old.position.distance(new) < 1e-12);
            }
        }
    }

    #[test]
    fn a_valley_is_raised_less_than_asked_for() {
        // Two sheets that face each other, 0.2 apart.
        let positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 0.2],
            [1.0, 0.0, 0.2],
            [0.0, 1.0, 0.2],
        ];
        let raised = mesh(positions, vec![[0, 1, 2], [3, 5, 4]], 0.5);
        let height = raised.triangles[0].corners[0].position.z;
        assert!((0.09..=0.1).contains(&height), "{height}");
    }
}
