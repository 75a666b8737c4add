//! Materials of scenes that are lit physically.

use super::Color;
use relievo_shared::shading::layout::{FOLLOWS_MESH, FOLLOWS_MESH_EVERYWHERE, FOLLOWS_PATTERN};
use std::path::PathBuf;

/// A material, metallic-roughness as glTF 2.0 has it. Objects name it in their
/// [`Finish`].
#[derive(Clone, Debug, PartialEq)]
pub struct PhysicalMaterial {
    /// Its name.
    pub name: String,
    /// Base colour.
    pub base_color: Color,
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f64,
    /// Perceptual roughness, 0…1.
    pub roughness: f64,
    /// Colour of the light that it sends out.
    pub emission: Color,
    /// Factor of that light.
    pub emission_strength: f64,
    /// Picture of factors of the base colour, sRGB.
    pub base_color_image: Option<PathBuf>,
    /// Picture of factors of roughness (green) and metallic (blue).
    pub metallic_roughness_image: Option<PathBuf>,
    /// Picture of normals, as OpenGL has them: y points up.
    pub normal_image: Option<PathBuf>,
    /// Factor of the slopes of that picture.
    pub normal_scale: f64,
    /// Picture of factors of the emission, sRGB.
    pub emission_image: Option<PathBuf>,
    /// What the pictures follow.
    pub coordinates: Coordinates,
    /// Repeats of the pictures per repeat of the pattern, or of the mesh's coordinates.
    pub tiles: [f64; 2],
    /// Largest change of the base colour from cell to cell of the pattern, as a share of it.
    pub shade_variation: f64,
    /// Whether pictures are shifted from cell to cell.
    pub shifts: bool,
    /// Whether pictures are turned by quarters from cell to cell.
    pub turns: bool,
}

impl Default for PhysicalMaterial {
    fn default() -> PhysicalMaterial {
        PhysicalMaterial {
            name: String::new(),
            base_color: Color([1.0; 3]),
            metallic: 0.0,
            roughness: 0.5,
            emission: Color([0.0; 3]),
            emission_strength: 1.0,
            base_color_image: None,
            metallic_roughness_image: None,
            normal_image: None,
            normal_scale: 1.0,
            emission_image: None,
            coordinates: Coordinates::default(),
            tiles: [1.0; 2],
            shade_variation: 0.0,
            shifts: false,
            turns: false,
        }
    }
}

impl PhysicalMaterial {
    /// Returns whether it differs from cell to cell of the pattern.
    pub fn varies(&self) -> bool {
        self.shade_variation > 0.0 || self.shifts || self.turns
    }

    /// Returns key and path of its pictures, for other paths to be set.
    pub(super) fn files_mut(&mut self) -> impl Iterator<Item = (&'static str, &mut PathBuf)> {
        [
            ("base_color_image", &mut self.base_color_image),
            (
                "metallic_roughness_image",
                &mut self.metallic_roughness_image,
            ),
            ("normal_image", &mut self.normal_image),
            ("emission_image", &mut self.emission_image),
        ]
        .into_iter()
        .filter_map(|(key, path)| Some((key, path.as_mut()?)))
    }
}

/// What the pictures of a material follow. On walls and bevels they follow the outline and the
/// depth, unless they follow the mesh everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coordinates {
    /// The repeats of the pattern.
    #[default]
    Pattern,
    /// The texture coordinates of the mesh.
    Mesh,
    /// Those, on walls and bevels, too.
    MeshEverywhere,
}

impl Coordinates {
    /// All of them.
    pub const ALL: [Coordinates; 3] = [
        Coordinates::Pattern,
        Coordinates::Mesh,
        Coordinates::MeshEverywhere,
    ];

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Coordinates::Pattern => "pattern",
            Coordinates::Mesh => "mesh",
            Coordinates::MeshEverywhere => "mesh-everywhere",
        }
    }

    /// Returns the `FOLLOWS_` constant of the shared layouts.
    pub(crate) fn code(self) -> u32 {
        match self {
            Coordinates::Pattern => FOLLOWS_PATTERN,
            Coordinates::Mesh => FOLLOWS_MESH,
            Coordinates::MeshEverywhere => FOLLOWS_MESH_EVERYWHERE,
        }
    }
}

/// Names of the materials of an object's surfaces: materials of the scene, or [`Finish::OF_MESH`].
/// A surface without one has the colour of the object's [`Material`](super::Material).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Finish {
    /// Of caps: the mesh surface on the pattern.
    pub cap: Option<String>,
    /// Of upright walls.
    pub wall: Option<String>,
    /// Of bevels and chamfers.
    pub bevel: Option<String>,
    /// Of the floor between the columns.
    pub floor: Option<String>,
}

impl Finish {
    /// Name that stands for the materials of the mesh file: each triangle has its own.
    pub const OF_MESH: &str = "@mesh";

    /// Returns a finish of the materials of the mesh file throughout.
    pub fn of_mesh() -> Finish {
        let name = || Some(Finish::OF_MESH.to_string());
        Finish {
            cap: name(),
            wall: name(),
            bevel: name(),
            floor: name(),
        }
    }

    /// Returns whether a surface has the materials of the mesh file.
    pub fn is_of_mesh(&self) -> bool {
        self.names().any(|(_, name)| name == Finish::OF_MESH)
    }

    /// Returns the key and the name of each material that is named.
    pub fn names(&self) -> impl Iterator<Item = (&'static str, &str)> {
        [
            ("cap", &self.cap),
            ("wall", &self.wall),
            ("bevel", &self.bevel),
            ("floor", &self.floor),
        ]
        .into_iter()
        .filter_map(|(key, name)| Some((key, name.as_deref()?)))
    }
}
