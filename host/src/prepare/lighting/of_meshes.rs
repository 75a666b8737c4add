//! The materials that mesh files bring with them.

use super::pictures::{Encoding, Pictures};
use crate::limits::Account;
use crate::mesh::{Mesh, MeshMaterial, MeshMaterials, MeshSource};
use crate::scene::{Scene, SceneObject};
use crate::shape_map::ShapeMapError;
use crate::{Error, Files};
use relievo_shared::shading::layout::FOLLOWS_MESH_EVERYWHERE;
use relievo_shared::shading::{Image, Material};
use std::path::PathBuf;

/// The materials of mesh files; each file is read once.
pub(super) struct OfMeshes<'a> {
    scene: &'a Scene,
    known: Vec<(&'a MeshSource, MeshMaterials, Files)>,
}

impl<'a> OfMeshes<'a> {
    /// Returns no materials.
    pub(super) fn new(scene: &'a Scene) -> OfMeshes<'a> {
        OfMeshes {
            scene,
            known: Vec::new(),
        }
    }

    /// Returns the materials of the mesh of `object`, in the order of [`Mesh::materials`]. Those
    /// that no triangle of `mesh` has are not filled in.
    pub(super) fn materials(
        &mut self,
        object: &'a SceneObject,
        mesh: &Mesh,
        pictures: &mut Pictures<'_>,
        words: &mut Vec<u32>,
        account: &mut Account<'_>,
    ) -> Result<Vec<Material>, Error> {
        let index = match self
            .known
            .iter()
            .position(|(source, ..)| **source == object.mesh)
        {
            Some(index) => index,
            None => {
                self.read(object, account)?;
                self.known.len() - 1
            }
        };
        let (source, read, files) = &self.known[index];
        if read.materials.is_empty() {
            return Err(Error::Object {
                scene: self.scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "has materials `@mesh`, but the triangles of its mesh {source} have none; name materials of the scene, or colours"
                ),
            });
        }
        if object.projection.is_some() && !read.pictures.is_empty() {
            log::warn!(
                "object {:?}: pictures of the materials of its mesh follow its projection, not the mesh's own texture coordinates",
                object.name
            );
        }
        let mut is_used = vec![false; read.materials.len()];
        for triangle in &mesh.triangles {
            is_used[triangle.material as usize] = true;
        }
        let materials = read.materials.iter().zip(is_used);
        materials
            .map(|(material, is_used)| match is_used {
                true => {
                    let mut load = |picture: Option<usize>, encoding| {
                        let Some(picture) = picture else {
                            return Ok(Image::default());
                        };
                        let path = picture_path(source, &read.pictures[picture].0);
                        let loaded = pictures.load_from(files, &path, encoding, words, account);
                        match loaded {
                            Err(Error::ShapeMap(error @ ShapeMapError::DecodeImage { .. })) => {
                                log::warn!("{error}; drawn without");
                                Ok(Image::default())
                            }
                            loaded => loaded,
                        }
                    };
                    layout(material, &mut load)
                }
                false => Ok(Material::default()),
            })
            .collect()
    }

    fn read(&mut self, object: &'a SceneObject, account: &Account<'_>) -> Result<(), Error> {
        let source = &object.mesh;
        let mut read = MeshMaterials::load(&self.scene.files, source, account.left(1))?;
        read.warn(source);
        let bytes = read.pictures.iter_mut();
        let bytes = bytes.map(|(name, bytes)| {
            let path = picture_path(source, name);
            (path, std::mem::take(bytes).into())
        });
        let files = Files::memory(bytes);
        self.known.push((source, read, files));
        Ok(())
    }
}

/// Returns a name of a picture for messages, which no file has.
fn picture_path(source: &MeshSource, name: &str) -> PathBuf {
    PathBuf::from(format!("{source}, picture {name}"))
}

/// Returns a material in the layout of the shared code; `load` loads its pictures.
fn layout(
    material: &MeshMaterial,
    load: &mut dyn FnMut(Option<usize>, Encoding) -> Result<Image, Error>,
) -> Result<Material, Error> {
    let emission_image = load(material.emission_picture, Encoding::Color)?;
    Ok(Material {
        base_color: material.base_color,
        metallic: material.metallic,
        // Without its picture nothing says where it glows.
        emission: match material.emission_picture.is_some() && emission_image.levels == 0 {
            true => [0.0; 3],
            false => material.emission,
        },
        roughness: material.roughness,
        normal_scale: material.normal_scale,
        tiles: material.tiles,
        offset: material.offset,
        follows: FOLLOWS_MESH_EVERYWHERE,
        base_color_image: load(material.base_color_picture, Encoding::Color)?,
        metallic_roughness_image: load(material.metallic_roughness_picture, Encoding::Linear)?,
        normal_image: load(material.normal_picture, Encoding::Linear)?,
        emission_image,
        ..Material::default()
    })
}
