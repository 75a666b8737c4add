//! The materials of a file.

use std::path::Path;

use gltf::image::Source;
use gltf::material::AlphaMode;
use gltf::texture::Info;
use gltf::{Document, Material};

use super::super::error::MeshError;
use super::super::material::{MeshMaterial, MeshMaterials, Unused};
use super::buffers::{BufferError, Buffers, Kind, content};
use super::parts::{Part, parts};
use super::problem::Problem;
use super::{buffer_error, open};
use crate::Files;

/// The materials that parts have, in the order of their first use.
pub(super) struct Used<'a>(Vec<Material<'a>>);

impl<'a> Used<'a> {
    pub fn by(parts: &[Part<'a>]) -> Used<'a> {
        let mut used = Used(Vec::new());
        for part in parts {
            let material = part.primitive.material();
            if !used.0.iter().any(|known| known.index() == material.index()) {
                used.0.push(material);
            }
        }
        // The default alone is none.
        if let [only] = &used.0[..]
            && only.index().is_none()
        {
            used.0.clear();
        }
        used
    }

    pub fn names(&self) -> Vec<String> {
        self.0.iter().map(name_of).collect()
    }

    /// Returns the index of a material that parts have.
    pub fn index(&self, material: &Material<'_>) -> u32 {
        let mut used = self.0.iter();
        let index = used.position(|known| known.index() == material.index());
        index.unwrap_or(0) as u32
    }
}

/// Returns the name of a material, which a file may leave out; `""` for the default one.
pub(super) fn name_of(material: &Material<'_>) -> String {
    match (material.name(), material.index()) {
        (Some(name), _) => name.to_string(),
        (None, Some(index)) => format!("material {index}"),
        (None, None) => String::new(),
    }
}

/// Returns the materials of a file in the order of
/// [`Mesh::materials`](super::super::Mesh::materials). Pictures are read from `files`, relative
/// to the folder of `path`.
///
/// # Errors
///
/// [`MeshError::Invalid`] and [`MeshError::TooLarge`].
pub(in super::super) fn materials(
    files: &Files,
    bytes: &[u8],
    path: &Path,
    byte_limit: u64,
) -> Result<MeshMaterials, MeshError> {
    let (document, blob) = open(bytes, path, byte_limit)?;
    let parts = parts(&document).map_err(|Problem(problem)| MeshError::Invalid {
        path: path.to_owned(),
        problem,
    })?;
    let mut reader = Reader {
        document: &document,
        files,
        path,
        blob,
        limit: byte_limit.saturating_sub(bytes.len() as u64),
        found: MeshMaterials::default(),
    };
    for material in Used::by(&parts).0 {
        let read = reader.material(&material);
        let read = read.map_err(|error| buffer_error(error, path, byte_limit))?;
        reader.found.materials.push(read);
    }
    Ok(reader.found)
}

struct Reader<'a> {
    document: &'a Document,
    files: &'a Files,
    path: &'a Path,
    blob: Option<&'a [u8]>,
    /// Bytes that pictures may still have.
    limit: u64,
    found: MeshMaterials,
}

impl Reader<'_> {
    fn material(&mut self, material: &Material<'_>) -> Result<MeshMaterial, BufferError> {
        let name = name_of(material);
        let plain = material.pbr_metallic_roughness();
        let strength = material.emissive_strength().unwrap_or(1.0);
        let [red, green, blue, mut alpha] = plain.base_color_factor();
        let mut read = MeshMaterial {
            name: name.clone(),
            base_color: [red, green, blue],
            metallic: plain.metallic_factor(),
            roughness: plain.roughness_factor(),
            emission: material.emissive_factor().map(|light| light * strength),
            ..MeshMaterial::default()
        };
        let mut base_color = plain.base_color_texture();
        // What it says stands in for what metallic and roughness say.
        if let Some(glossy) = material.pbr_specular_glossiness() {
            let [red, green, blue, opacity] = glossy.diffuse_factor();
            read.base_color = [red, green, blue];
            read.metallic = 0.0;
            read.roughness = 1.0 - glossy.glossiness_factor();
            alpha = opacity;
            base_color = glossy.diffuse_texture();
            self.leave(&name, "specular colours and glossiness pictures");
        } else if let Some(info) = plain.metallic_roughness_texture() {
            read.metallic_roughness_picture = self.picture(&info, &name, &mut read.tiles)?;
        }
        if let Some(info) = base_color {
            read.base_color_picture = self.picture(&info, &name, &mut read.tiles)?;
        }
        if let Some(info) = material.emissive_texture() {
            read.emission_picture = self.picture(&info, &name, &mut read.tiles)?;
        }
        if let Some(normal) = material.normal_texture() {
            read.normal_scale = normal.scale();
            if normal.tex_coord() == 0 {
                read.normal_picture = self.image(&normal.texture(), &name)?;
            } else {
                self.leave(&name, "pictures with a second set of texture coordinates");
            }
        }
        if material.occlusion_texture().is_some() {
            self.leave(&name, "pictures of occlusion");
        }
        if material.alpha_mode() != AlphaMode::Opaque || alpha < 1.0 {
            self.leave(&name, "transparency");
        }
        for extension in material.extensions().into_iter().flat_map(|all| all.keys()) {
            self.leave(&name, extension);
        }
        Ok(read)
    }

    /// Remembers that a material has something that is not used.
    fn leave(&mut self, material: &str, what: &str) {
        self.found.unused.push(Unused {
            material: material.to_string(),
            what: what.to_string(),
        });
    }

    /// Returns the index of a picture, and sets how often it repeats.
    fn picture(
        &mut self,
        info: &Info<'_>,
        material: &str,
        tiles: &mut [f32; 2],
    ) -> Result<Option<usize>, BufferError> {
        let transform = info.texture_transform();
        let set = transform
            .as_ref()
            .and_then(|transform| transform.tex_coord());
        if set.unwrap_or(info.tex_coord()) != 0 {
            self.leave(
                material,
                "pictures with a second set of texture coordinates",
            );
            return Ok(None);
        }
        if let Some(transform) = transform {
            let scale = transform.scale();
            let is_scale = scale.iter().all(|scale| scale.is_finite() && *scale > 0.0);
            if !is_scale || transform.offset() != [0.0; 2] || transform.rotation() != 0.0 {
                self.leave(material, "pictures that are shifted, turned or mirrored");
            }
            if is_scale {
                *tiles = scale;
            }
        }
        self.image(&info.texture(), material)
    }

    /// Returns the index of the picture of a texture; `None` where it cannot be read.
    fn image(
        &mut self,
        texture: &gltf::Texture<'_>,
        material: &str,
    ) -> Result<Option<usize>, BufferError> {
        let Some(image) = texture.source() else {
            self.leave(material, "pictures in formats of extensions");
            return Ok(None);
        };
        let kind = Kind::Image(image.index());
        // A picture is read once.
        let name = match image.source() {
            Source::Uri { uri, .. } if !uri.starts_with("data:") => uri.to_string(),
            _ => format!("image {}", image.index()),
        };
        if let Some(index) = self.found.known(&name) {
            return Ok(Some(index));
        }
        let read = match image.source() {
            Source::Uri { uri, .. } => {
                let content = content(self.files, self.path, uri, kind, self.limit);
                content.map(|bytes| bytes.into_owned())
            }
            Source::View { view, .. } => {
                let views = std::iter::once(view.clone());
                let limit = self.limit;
                Buffers::load(
                    self.document,
                    views,
                    self.files,
                    self.path,
                    self.blob,
                    limit,
                )
                .and_then(|buffers| Ok(buffers.view(&view)?.to_vec()))
            }
        };
        match read {
            Ok(bytes) => {
                self.limit = self.limit.saturating_sub(bytes.len() as u64);
                Ok(Some(self.found.add(name, bytes)))
            }
            Err(BufferError::TooLarge) => Err(BufferError::TooLarge),
            Err(BufferError::Problem(Problem(problem))) => {
                self.found.problems.push(problem);
                Ok(None)
            }
        }
    }
}
