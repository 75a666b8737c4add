//! The materials of mesh files.

use std::collections::BTreeMap;

use super::raw::listed;
use super::source::MeshSource;

/// A material of a mesh file, metallic-roughness as glTF 2.0 has it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshMaterial {
    /// Its name in the file.
    pub name: String,
    /// Base colour, linear RGB.
    pub base_color: [f32; 3],
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f32,
    /// Perceptual roughness, 0…1.
    pub roughness: f32,
    /// Linear RGB of the light that it sends out.
    pub emission: [f32; 3],
    /// Factor of the slopes of the normal picture.
    pub normal_scale: f32,
    /// Repeats of the pictures per repeat of the texture coordinates.
    pub tiles: [f32; 2],
    /// Offset of the pictures from the upper left corner, their repeats.
    pub offset: [f32; 2],
    /// Factors of the base colour, sRGB: an index into [`MeshMaterials::pictures`].
    pub base_color_picture: Option<usize>,
    /// Factors of roughness (green) and metallic (blue).
    pub metallic_roughness_picture: Option<usize>,
    /// Normals; green points up.
    pub normal_picture: Option<usize>,
    /// Factors of the emission, sRGB.
    pub emission_picture: Option<usize>,
}

impl Default for MeshMaterial {
    /// A white dielectric.
    fn default() -> MeshMaterial {
        MeshMaterial {
            name: String::new(),
            base_color: [1.0; 3],
            metallic: 0.0,
            roughness: 0.5,
            emission: [0.0; 3],
            normal_scale: 1.0,
            tiles: [1.0; 2],
            offset: [0.0; 2],
            base_color_picture: None,
            metallic_roughness_picture: None,
            normal_picture: None,
            emission_picture: None,
        }
    }
}

impl MeshMaterial {
    /// Limits the numbers to those that the keys of a scene's materials may have.
    pub(super) fn limit(&mut self) {
        let limit = |number: &mut f32, low: f32, high: f32| {
            *number = match number.is_nan() {
                true => low.max(0.0),
                false => number.clamp(low, high),
            };
        };
        let shares = [&mut self.metallic, &mut self.roughness].into_iter();
        shares
            .chain(&mut self.base_color)
            .for_each(|share| limit(share, 0.0, 1.0));
        let light = self.emission.iter_mut();
        light.for_each(|light| limit(light, 0.0, 1e6));
        limit(&mut self.normal_scale, -10.0, 10.0);
        let tiles = self.tiles.iter_mut();
        tiles.for_each(|tiles| limit(tiles, 1e-4, 1e4));
        for offset in &mut self.offset {
            // Whole repeats do not matter.
            *offset %= 1.0;
            limit(offset, -1.0, 1.0);
        }
    }
}

/// The materials of a mesh file, and what could not be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MeshMaterials {
    /// The materials, in the order of [`Mesh::materials`](super::Mesh::materials).
    pub materials: Vec<MeshMaterial>,
    /// Names of their pictures in the file, and the bytes of image files.
    pub pictures: Vec<(String, Vec<u8>)>,
    /// What is not used, and the names of the materials that have it.
    pub unused: BTreeMap<String, Vec<String>>,
    /// Why pictures are left out.
    pub problems: Vec<String>,
}

/// How a picture lies on the texture coordinates: a scale, and then an offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub scale: [f32; 2],
    pub offset: [f32; 2],
}

impl Placed {
    /// As the texture coordinates are.
    pub const PLAIN: Placed = Placed {
        scale: [1.0; 2],
        offset: [0.0; 2],
    };
}

impl MeshMaterials {
    /// Returns the index of the picture `name`, if it was read.
    pub(super) fn known(&self, name: &str) -> Option<usize> {
        let mut pictures = self.pictures.iter();
        pictures.position(|(known, _)| known == name)
    }

    /// Adds a picture and returns its index.
    pub(super) fn add(&mut self, name: String, bytes: Vec<u8>) -> usize {
        self.pictures.push((name, bytes));
        self.pictures.len() - 1
    }

    /// Remembers that a material has something that is not used.
    pub(super) fn leave(&mut self, material: &str, what: impl Into<String>) {
        let materials = self.unused.entry(what.into()).or_default();
        // Materials come one after the other.
        if materials.last().is_none_or(|last| last != material) {
            materials.push(material.to_string());
        }
    }

    /// Returns whether a picture can lie as it should; the first one of a `material` says how all
    /// of its pictures lie.
    pub(super) fn can_place(
        &mut self,
        at: Placed,
        material: &str,
        placed: &mut Option<Placed>,
    ) -> bool {
        let is_scale = |scale: f32| scale.is_finite() && scale > 0.0;
        if !at.scale.into_iter().all(is_scale) {
            self.leave(material, "pictures that are mirrored");
            return false;
        }
        if *placed.get_or_insert(at) != at {
            self.leave(material, "scales and offsets of further pictures");
        }
        true
    }

    /// Tells of what is not used and what could not be read.
    pub fn warn(&self, source: &MeshSource) {
        for problem in &self.problems {
            log::warn!("the mesh `{source}`: {problem}");
        }
        for (what, materials) in &self.unused {
            let names: Vec<String> = materials.iter().map(|name| format!("{name:?}")).collect();
            let names = listed(&names);
            log::warn!("the mesh `{source}`: not used: {what} (materials {names})");
        }
    }
}
