//! Raising the surface of a mesh, for columns that rise from it.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::error::MeshError;
use super::options::MeshOptions;
use super::prepare::prepare;
use super::prism::Shell;
use super::raw::{Corner, RawMesh};
use super::triangles::{Mesh, MeshTriangle};

impl Mesh {
    /// Returns the mesh with its surface moved outward by `height` > 0, in object units.
    /// The floor of its shell is `self`.
    ///
    /// The surface is moved less where it would fold or meet itself, as the floor of a
    /// [`Shell`](super::Shell) is on the other side of the surface.
    pub(super) fn raised(&self, height: f64, path: &Path) -> Result<Mesh, MeshError> {
        let inside_out = Mesh {
            triangles: self.triangles.iter().map(inside_out).collect(),
            ..self.clone()
        };
        let shell = inside_out.shell(height);
        let count = self.triangles.iter().flat_map(|triangle| triangle.corners);
        let count = count.map(|corner| corner.position_index + 1).max();
        let mut raw = RawMesh {
            positions: vec![DVec3::ZERO; count.unwrap_or(0) as usize],
            normals: Vec::with_capacity(3 * self.triangles.len()),
            uvs: Vec::with_capacity(3 * self.triangles.len()),
            triangles: Vec::with_capacity(self.triangles.len()),
            face_without_uvs: None,
        };
        for (triangle, prism) in self.triangles.iter().zip(&shell.prisms) {
            let prism = prism.upside_down(shell.depth);
            let raised = prism.corners().map(|corner| prism.anchor + corner);
            let mut corners = triangle.corners.iter().zip(raised);
            raw.triangles.push(std::array::from_fn(|_| {
                let (corner, raised) = corners.next().expect("three corners");
                let index = raw.normals.len() as u32;
                raw.positions[corner.position_index as usize] = raised;
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
        let prisms = shell.prisms.iter();
        let shell = Shell {
            prisms: prisms.map(|prism| prism.upside_down(shell.depth)).collect(),
            ..shell
        };
        // Triangles without area are left out, in a valley that is closed.
        let is_whole = raised.triangles.len() == shell.prisms.len();
        Ok(Mesh {
            raised_by: is_whole.then(|| Arc::new(shell)),
            report: super::MeshReport {
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
    MeshTriangle { corners: [a, c, b] }
}

#[cfg(test)]
mod tests {
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
        let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).concat();
        let cube = |raise: f64| mesh((0..8).map(corner).collect(), triangles.clone(), raise);
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
