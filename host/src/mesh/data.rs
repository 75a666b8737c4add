//! Meshes made in code, from vertices and indices.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::error::MeshError;
use super::options::MeshOptions;
use super::raw::{Corner, LARGEST_NUMBER, RawMesh, check_parts};

/// Vertices and the triangles between them.
///
/// ```
/// use relievo::mesh::{Mesh, MeshData, MeshOptions};
///
/// // A unit square in the plane z = 0, facing +z.
/// let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// let data = MeshData::new("square", corners.map(|[x, y]| [x, y, 0.0]), [[0, 1, 2], [0, 2, 3]])
///     .with_uvs(corners);
/// let mesh = Mesh::from_data(&data, &MeshOptions::default())?;
/// assert_eq!(mesh.triangles.len(), 2);
/// assert!(mesh.report.computed_normals);
/// # Ok::<(), relievo::mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MeshData {
    /// Name of the mesh in error messages.
    pub name: String,
    /// Position of each vertex, in object units before [`scale`](super::MeshOptions::scale).
    pub positions: Vec<[f64; 3]>,
    /// Normal of each vertex, of any length; empty to compute normals. A zero
    /// normal is computed too.
    pub normals: Vec<[f64; 3]>,
    /// Texture coordinates of each vertex, in repeats; empty if
    /// [`projection`](super::MeshOptions::projection) makes them.
    pub uvs: Vec<[f64; 2]>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl MeshData {
    /// Creates a mesh without normals and texture coordinates.
    pub fn new(
        name: impl Into<String>,
        positions: impl Into<Vec<[f64; 3]>>,
        triangles: impl Into<Vec<[u32; 3]>>,
    ) -> Self {
        Self {
            name: name.into(),
            positions: positions.into(),
            normals: Vec::new(),
            uvs: Vec::new(),
            triangles: triangles.into(),
        }
    }

    /// Sets the normals, one per vertex.
    #[must_use]
    pub fn with_normals(mut self, normals: impl Into<Vec<[f64; 3]>>) -> Self {
        self.normals = normals.into();
        self
    }

    /// Sets the texture coordinates, one pair per vertex.
    #[must_use]
    pub fn with_uvs(mut self, uvs: impl Into<Vec<[f64; 2]>>) -> Self {
        self.uvs = uvs.into();
        self
    }

    /// Checks the data and drops vertices that no triangle uses.
    ///
    /// # Errors
    ///
    /// [`MeshError::Invalid`] and [`MeshError::TooManyTriangles`].
    pub(super) fn source(&self, options: &MeshOptions) -> Result<RawMesh, MeshError> {
        let path = Path::new(&self.name);
        let triangle_limit = options.limit();
        if self.triangles.len() > triangle_limit {
            return Err(MeshError::TooManyTriangles {
                path: path.to_owned(),
                count: self.triangles.len(),
                limit: triangle_limit,
            });
        }
        let checked = check_parts(&options.parts, &[]).and_then(|()| self.check());
        checked.map_err(|problem| MeshError::Invalid {
            path: path.to_owned(),
            problem,
        })?;
        let (has_normals, has_uvs) = (!self.normals.is_empty(), !self.uvs.is_empty());
        let mut mesh = RawMesh {
            triangles: Vec::with_capacity(self.triangles.len()),
            face_without_uvs: (!has_uvs).then(|| "triangle 0".to_string()),
            ..RawMesh::default()
        };
        let mut used: Vec<Option<u32>> = vec![None; self.positions.len()];
        for triangle in &self.triangles {
            mesh.triangles.push(triangle.map(|vertex| {
                let vertex = vertex as usize;
                let index = *used[vertex].get_or_insert_with(|| {
                    mesh.positions.push(DVec3::from(self.positions[vertex]));
                    mesh.normals
                        .extend(self.normals.get(vertex).copied().map(DVec3::from));
                    mesh.uvs
                        .extend(self.uvs.get(vertex).copied().map(DVec2::from));
                    mesh.positions.len() as u32 - 1
                });
                Corner {
                    position: index,
                    normal: has_normals.then_some(index),
                    uv: has_uvs.then_some(index),
                }
            }));
        }
        Ok(mesh)
    }

    fn check(&self) -> Result<(), String> {
        let count = self.positions.len();
        if self.triangles.is_empty() {
            return Err("it has no triangles; add at least one".to_string());
        }
        if u32::try_from(count).is_err() {
            return Err(format!("it has {count} vertices; split it"));
        }
        for (what, length) in [
            ("normals", self.normals.len()),
            ("texture coordinates", self.uvs.len()),
        ] {
            if length != 0 && length != count {
                return Err(format!(
                    "it has {length} {what} for {count} positions; give one per position, or none"
                ));
            }
        }
        check_numbers("position", &self.positions)?;
        check_numbers("normal", &self.normals)?;
        check_numbers("texture coordinate", &self.uvs)?;
        for (triangle, indices) in self.triangles.iter().enumerate() {
            if let Some(index) = indices.iter().find(|index| **index as usize >= count) {
                return Err(format!(
                    "triangle {triangle} uses vertex {index}, but there are {count}; indices start at 0"
                ));
            }
        }
        Ok(())
    }
}

/// Checks that all numbers are finite and at most [`LARGEST_NUMBER`].
fn check_numbers<const N: usize>(what: &str, elements: &[[f64; N]]) -> Result<(), String> {
    let is_wrong = |number: &f64| number.is_nan() || number.abs() > LARGEST_NUMBER;
    match elements
        .iter()
        .position(|element| element.iter().any(is_wrong))
    {
        None => Ok(()),
        Some(index) => Err(format!(
            "{what} {index} is {:?}; numbers must be finite and at most {LARGEST_NUMBER:e}",
            elements[index]
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Mesh, MeshOptions, Projection};
    use super::*;

    fn square() -> MeshData {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        MeshData::new(
            "square",
            corners.map(|[x, y]| [x, y, 0.0]),
            [[0, 1, 2], [0, 2, 3]],
        )
        .with_normals([[0.0, 0.0, 2.0]; 4])
        .with_uvs(corners)
    }

    fn load(data: &MeshData) -> Result<Mesh, MeshError> {
        Mesh::from_data(data, &MeshOptions::default())
    }

    #[test]
    fn data_give_the_mesh_that_a_file_gives() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\n\
                    f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n";
        let file = Mesh::parse(text, Path::new("a.obj"), &MeshOptions::default()).unwrap();
        assert_eq!(load(&square()).unwrap(), file);
        // A vertex that no triangle uses does not count.
        let mut more = square();
        more.positions.push([9.0; 3]);
        more.normals.push([1.0; 3]);
        more.uvs.push([9.0; 2]);
        assert_eq!(load(&more).unwrap(), file);
    }

    #[test]
    fn missing_normals_are_computed_and_missing_uvs_projected() {
        let mut data = square();
        data.normals.clear();
        assert_eq!(
            load(&data).unwrap().triangles,
            load(&square()).unwrap().triangles
        );
        data.uvs.clear();
        let error = load(&data).unwrap_err();
        assert!(
            matches!(error, MeshError::MissingTextureCoordinates { .. }),
            "{error}"
        );
        let options = MeshOptions {
            projection: Some(Projection::PlanarZ),
            ..MeshOptions::default()
        };
        assert!(
            Mesh::from_data(&data, &options)
                .unwrap()
                .report
                .projected_uvs
        );
    }

    #[test]
    fn invalid_data_are_refused() {
        let changed = |change: fn(&mut MeshData)| {
            let mut data = square();
            change(&mut data);
            data
        };
        for (data, part) in [
            (changed(|data| data.triangles.clear()), "no triangles"),
            (changed(|data| data.positions.clear()), "for 0 positions"),
            (
                changed(|data| data.positions[1][2] = f64::NAN),
                "position 1 is [1.0, 0.0, NaN]",
            ),
            (
                changed(|data| data.normals[2][0] = f64::INFINITY),
                "normal 2",
            ),
            (
                changed(|data| data.uvs[3][0] = -1e13),
                "texture coordinate 3",
            ),
            (
                changed(|data| data.triangles[1][2] = 4),
                "triangle 1 uses vertex 4, but there are 4",
            ),
            (
                changed(|data| data.uvs.truncate(3)),
                "3 texture coordinates for 4 positions",
            ),
        ] {
            let message = load(&data).unwrap_err().to_string();
            assert!(message.contains("`square`"), "{message}");
            assert!(message.contains(part), "{message}");
        }
        let options = MeshOptions {
            triangle_limit: 1,
            ..MeshOptions::default()
        };
        let error = Mesh::from_data(&square(), &options).unwrap_err();
        assert!(matches!(
            error,
            MeshError::TooManyTriangles { count: 2, .. }
        ));
    }
}
