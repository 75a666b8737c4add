//! The materials of a file.

use std::collections::HashMap;
use std::path::Path;

use gltf::accessor::DataType;
use gltf::image::Source;
use gltf::json::Value;
use gltf::material::AlphaMode;
use gltf::texture::Info;
use gltf::{Document, Material, Semantic};

use super::super::error::MeshError;
use super::super::material::{MeshMaterial, MeshMaterials, Placed};
use super::buffers::{Buffers, Kind, content};
use super::document::open;
use super::parts::{Part, parts};
use super::problem::{BufferError, Problem};
use crate::Files;

/// The extension that places pictures.
const TRANSFORM: &str = "KHR_texture_transform";

/// The materials that primitives have, in the order of their first use.
#[derive(Default)]
pub(super) struct Used<'a> {
    materials: Vec<Material<'a>>,
    /// Their indices by those in the file; `None` is that of the default material.
    index_of: HashMap<Option<usize>, u32>,
}

impl<'a> Used<'a> {
    pub fn by(parts: &[Part<'a>]) -> Used<'a> {
        let mut used = Used::default();
        for part in parts {
            let material = part.primitive.material();
            let next = used.materials.len() as u32;
            used.index_of.entry(material.index()).or_insert_with(|| {
                used.materials.push(material);
                next
            });
        }
        // The default alone is none.
        let are_named = used.index_of.keys().any(Option::is_some);
        if are_named { used } else { Used::default() }
    }

    pub fn names(&self) -> Vec<String> {
        self.materials.iter().map(name_of).collect()
    }

    /// Returns the index of a material that a primitive has.
    pub fn index(&self, material: &Material<'_>) -> u32 {
        self.index_of.get(&material.index()).copied().unwrap_or(0)
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

/// Returns how the pictures of `material` lie, as the first one with the first set of texture
/// coordinates says.
fn placed(material: &Material<'_>) -> Placed {
    let plain = material.pbr_metallic_roughness();
    let by_info = |info: Info<'_>| set_and_place(info.extension_value(TRANSFORM), info.tex_coord());
    let first = match material.pbr_specular_glossiness() {
        Some(glossy) => [glossy.diffuse_texture(), None],
        None => [
            plain.base_color_texture(),
            plain.metallic_roughness_texture(),
        ],
    };
    let normal = material
        .normal_texture()
        .map(|normal| set_and_place(normal.extension_value(TRANSFORM), normal.tex_coord()));
    let rest = [normal, material.emissive_texture().map(by_info)];
    first
        .into_iter()
        .map(|info| info.map(by_info))
        .chain(rest)
        .flatten()
        .find(|(set, _)| *set == 0)
        .map_or(Placed::PLAIN, |(_, at)| at)
}

/// Returns the set of texture coordinates of a texture, which is `set` unless its `transform` names
/// one, and how it places the picture.
fn set_and_place(transform: Option<&Value>, set: u32) -> (u64, Placed) {
    let named = transform.and_then(|transform| transform.get("texCoord")?.as_u64());
    (named.unwrap_or(u64::from(set)), placed_by(transform))
}

/// Returns what a KHR_texture_transform says.
fn placed_by(transform: Option<&Value>) -> Placed {
    let pair = |key: &str, default: [f32; 2]| {
        let number = |index: usize| Some(transform?.get(key)?.get(index)?.as_f64()? as f32);
        [0, 1].map(|index| number(index).unwrap_or(default[index]))
    };
    Placed {
        scale: pair("scale", [1.0; 2]),
        offset: pair("offset", [0.0; 2]),
    }
}

/// Returns the transforms that restore the texture coordinates of quantized files, by material: those
/// of its pictures, where the coordinates of a primitive are whole numbers.
pub(super) fn restored(document: &Document, parts: &[Part<'_>]) -> HashMap<Option<usize>, Placed> {
    let mut used = document.extensions_used();
    if !used.any(|name| name == "KHR_mesh_quantization") {
        return HashMap::new();
    }
    let quantized = parts.iter().filter(|part| {
        let accessor = part.primitive.get(&Semantic::TexCoords(0));
        accessor.is_some_and(|accessor| accessor.data_type() != DataType::F32)
    });
    let materials = quantized.map(|part| part.primitive.material());
    let placed = materials.map(|material| (material.index(), placed(&material)));
    placed.filter(|(_, at)| *at != Placed::PLAIN).collect()
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
    let restored = restored(&document, &parts);
    let mut reader = Reader {
        document: &document,
        files,
        path,
        blob,
        limit: byte_limit.saturating_sub(bytes.len() as u64),
        restored: None,
        found: MeshMaterials::default(),
    };
    for material in Used::by(&parts).materials {
        reader.restored = restored.get(&material.index()).copied();
        let read = reader.material(&material);
        let read = read.map_err(|error| error.of_mesh(path, byte_limit))?;
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
    /// The transform that the texture coordinates of a material have already.
    restored: Option<Placed>,
    found: MeshMaterials,
}

impl Reader<'_> {
    fn material(&mut self, material: &Material<'_>) -> Result<MeshMaterial, BufferError> {
        let name = name_of(material);
        let plain = material.pbr_metallic_roughness();
        let strength = material.emissive_strength().unwrap_or(1.0);
        let [red, green, blue, _] = plain.base_color_factor();
        let mut read = MeshMaterial {
            name: name.clone(),
            base_color: [red, green, blue],
            metallic: plain.metallic_factor(),
            roughness: plain.roughness_factor(),
            emission: material.emissive_factor().map(|light| light * strength),
            ..MeshMaterial::default()
        };
        // All pictures of a material lie alike.
        let mut placed = None;
        let mut base_color = plain.base_color_texture();
        let mut metallic_roughness = plain.metallic_roughness_texture();
        // What it says stands in for what metallic and roughness say.
        if let Some(glossy) = material.pbr_specular_glossiness() {
            let [red, green, blue, _] = glossy.diffuse_factor();
            read.base_color = [red, green, blue];
            read.metallic = 0.0;
            read.roughness = 1.0 - glossy.glossiness_factor();
            base_color = glossy.diffuse_texture();
            metallic_roughness = None;
            let what = "specular colours and pictures of glossiness";
            self.found.leave(&name, what);
        }
        if let Some(info) = base_color {
            read.base_color_picture = self.picture(&info, &name, &mut placed)?;
        }
        if let Some(info) = metallic_roughness {
            read.metallic_roughness_picture = self.picture(&info, &name, &mut placed)?;
        }
        if let Some(normal) = material.normal_texture() {
            read.normal_scale = normal.scale();
            let transform = normal.extension_value(TRANSFORM);
            let (set, at) = self.transform_of(transform, normal.tex_coord(), &name);
            if self.can_place(set, at, &name, &mut placed) {
                read.normal_picture = self.image(&normal.texture(), &name)?;
            }
        }
        if let Some(info) = material.emissive_texture() {
            read.emission_picture = self.picture(&info, &name, &mut placed)?;
            // Without its picture nothing says where it glows.
            if read.emission_picture.is_none() {
                read.emission = [0.0; 3];
            }
        }
        let Placed { scale, offset } = placed.unwrap_or(Placed::PLAIN);
        read.tiles = scale;
        // Ours begins at the lower end, where v is 1.
        read.offset = [offset[0], offset[1] + scale[1]];
        if material.occlusion_texture().is_some() {
            self.found.leave(&name, "pictures of occlusion");
        }
        if material.alpha_mode() != AlphaMode::Opaque {
            self.found.leave(&name, "transparency");
        }
        for extension in material.extensions().into_iter().flat_map(|all| all.keys()) {
            self.found.leave(&name, extension);
        }
        Ok(read)
    }

    /// Returns the index of a picture; `None` where it cannot be read or placed.
    fn picture(
        &mut self,
        info: &Info<'_>,
        material: &str,
        placed: &mut Option<Placed>,
    ) -> Result<Option<usize>, BufferError> {
        let transform = info.extension_value(TRANSFORM);
        let (set, at) = self.transform_of(transform, info.tex_coord(), material);
        match self.can_place(set, at, material, placed) {
            true => self.image(&info.texture(), material),
            false => Ok(None),
        }
    }

    /// Returns the set of texture coordinates of a texture, which is `set` unless its transform
    /// names one, and how it places the picture.
    fn transform_of(
        &mut self,
        transform: Option<&Value>,
        set: u32,
        material: &str,
    ) -> (u64, Placed) {
        let number = |key| transform.and_then(|transform| transform.get(key));
        let turn = number("rotation").and_then(Value::as_f64);
        if turn.is_some_and(|turn| turn != 0.0) {
            self.found.leave(material, "turns of pictures");
        }
        let (set, at) = set_and_place(transform, set);
        let is_restored = self.restored == Some(at);
        (set, if is_restored { Placed::PLAIN } else { at })
    }

    /// Returns whether a picture with the texture coordinates `set` can lie as it should.
    fn can_place(
        &mut self,
        set: u64,
        at: Placed,
        material: &str,
        placed: &mut Option<Placed>,
    ) -> bool {
        if set != 0 {
            let what = "pictures with a second set of texture coordinates";
            self.found.leave(material, what);
            return false;
        }
        self.found.can_place(at, material, placed)
    }

    /// Returns the index of the picture of a texture; `None` where it cannot be read.
    fn image(
        &mut self,
        texture: &gltf::Texture<'_>,
        material: &str,
    ) -> Result<Option<usize>, BufferError> {
        let Some(image) = texture.source() else {
            self.found
                .leave(material, "pictures in formats of extensions");
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
                self.found
                    .problems
                    .push(format!("{problem}; drawn without"));
                Ok(None)
            }
        }
    }
}
