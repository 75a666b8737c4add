//! Appends the triangles of a primitive to a mesh.

use std::collections::HashMap;

use glam::{DMat3, DVec2, DVec3};
use gltf::Semantic;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;

use super::super::material::Placed;
use super::super::raw::{Corner, LARGEST_NUMBER, RawMesh};
use super::buffers::Buffers;
use super::draco::Geometries;
use super::numbers::Numbers;
use super::parts::Part;
use super::problem::Problem;

impl Part<'_> {
    /// Adds the triangles to `mesh`; `restored` is the transform of the texture coordinates, if they
    /// are quantized.
    pub fn append(
        &self,
        buffers: &Buffers<'_>,
        geometries: &Geometries,
        restored: Option<&Placed>,
        has_normals: bool,
        mesh: &mut RawMesh,
    ) -> Result<(), Problem> {
        let decoded = self.draco.as_ref().map(|draco| geometries.of(draco));
        let stream = |semantic: &Semantic, dimensions, what| -> Result<_, Problem> {
            let Some(accessor) = self.primitive.get(semantic) else {
                return Ok(None);
            };
            if let Some(decoded) = decoded
                && let Some(numbers) = decoded.attribute(semantic, &accessor, dimensions)?
            {
                return Ok(Some(numbers));
            }
            Numbers::new(&accessor, dimensions, buffers, what).map(Some)
        };
        let positions = stream(&Semantic::Positions, Dimensions::Vec3, "positions")?
            .ok_or("has no positions; export it with them")?;
        let normals = match has_normals {
            true => stream(&Semantic::Normals, Dimensions::Vec3, "normals")?,
            false => None,
        };
        let uvs = match mesh.face_without_uvs {
            None => stream(
                &Semantic::TexCoords(0),
                Dimensions::Vec2,
                "texture coordinates",
            )?,
            Some(_) => None,
        };
        let indices = match (decoded, self.primitive.indices()) {
            (Some(decoded), _) => decoded.indices(),
            (None, None) => None,
            (None, Some(accessor)) => {
                let dimensions = Dimensions::Scalar;
                Some(Numbers::new(&accessor, dimensions, buffers, "indices")?)
            }
        };
        if let Some(indices) = &indices
            && !matches!(indices.kind, DataType::U8 | DataType::U16 | DataType::U32)
        {
            return Err("its indices are not integers; export it again".into());
        }
        for (what, stream) in [("normals", &normals), ("texture coordinates", &uvs)] {
            if let Some(stream) = stream
                && stream.count != positions.count
            {
                return Err(format!(
                    "it has {} {what} for {} positions; export it again",
                    stream.count, positions.count
                )
                .into());
            }
        }

        let matrix = self.transform.map(DMat3::from_mat4);
        let is_mirrored = matrix.is_some_and(|matrix| matrix.determinant() < 0.0);
        let for_normals = matrix.map(|matrix| {
            // The cofactors are the inverse transpose up to a factor, and exist for
            // every matrix.
            let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
            let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
            if is_mirrored { -cofactors } else { cofactors }
        });
        let mut known: HashMap<usize, u32> = HashMap::new();
        let mut corner = |number: usize| -> Result<Corner, Problem> {
            let vertex = match &indices {
                None => number,
                Some(indices) => indices.get::<1>(number)?[0] as usize,
            };
            if vertex >= positions.count {
                return Err(format!(
                    "it uses position {vertex}, but has {}; export it again",
                    positions.count
                )
                .into());
            }
            let index = match known.get(&vertex) {
                Some(index) => *index,
                None => {
                    let index = mesh.positions.len() as u32;
                    let position = DVec3::from(positions.get(vertex)?);
                    let placed = match &self.transform {
                        None => position,
                        Some(transform) => transform.transform_point3(position),
                    };
                    // False for NaN.
                    if !(placed.abs().max_element() <= LARGEST_NUMBER && placed.is_finite()) {
                        return Err(format!(
                            "position {vertex} is {placed}; coordinates must be finite and at most {LARGEST_NUMBER:e}"
                        )
                        .into());
                    }
                    mesh.positions.push(placed);
                    if let Some(normals) = &normals {
                        let normal = DVec3::from(normals.get(vertex)?);
                        let turned = for_normals
                            .map_or(normal, |matrix| (matrix * normal).normalize_or_zero());
                        // Zero normals are computed later.
                        mesh.normals.push(if turned.is_finite() {
                            turned
                        } else {
                            DVec3::ZERO
                        });
                    }
                    if let Some(uvs) = &uvs {
                        let [u, v] = uvs.get(vertex)?;
                        let [u, v] = match restored {
                            None => [u, v],
                            Some(Placed { scale, offset }) => [
                                u * f64::from(scale[0]) + f64::from(offset[0]),
                                v * f64::from(scale[1]) + f64::from(offset[1]),
                            ],
                        };
                        // v points up, as in OBJ files.
                        let uv = DVec2::new(u, 1.0 - v);
                        if !(uv.abs().max_element() <= LARGEST_NUMBER && uv.is_finite()) {
                            return Err(format!(
                                "texture coordinate {vertex} is {uv}; its numbers must be finite and at most {LARGEST_NUMBER:e}"
                            )
                            .into());
                        }
                        mesh.uvs.push(uv);
                    }
                    known.insert(vertex, index);
                    index
                }
            };
            Ok(Corner {
                position: index,
                normal: normals.is_some().then_some(index),
                uv: uvs.is_some().then_some(index),
            })
        };
        for triangle in 0..self.triangle_count()? {
            let numbers = match self.primitive.mode() {
                Mode::TriangleStrip if triangle % 2 == 1 => [triangle, triangle + 2, triangle + 1],
                Mode::TriangleStrip => [triangle, triangle + 1, triangle + 2],
                Mode::TriangleFan => [0, triangle + 1, triangle + 2],
                _ => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
            };
            let [a, b, c] = numbers.map(&mut corner);
            let (a, b, c) = (a?, b?, c?);
            mesh.triangles
                .push(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
        Ok(())
    }
}
