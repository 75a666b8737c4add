//! What the host writes for shading: plain scalars, with the same layout in a storage
//! buffer and in a slice.

use crate::Real;
use bytemuck::{Pod, Zeroable};

/// Where a picture lies among the words: a chain of levels, each half as large as the one
/// before, two words a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Image {
    /// Index of its first word.
    pub first: u32,
    /// Width of the first level, texels.
    pub width: u32,
    /// Height of the first level, texels.
    pub height: u32,
    /// Number of levels; 0 if there is no picture.
    pub levels: u32,
}

/// Pictures follow the pattern; on walls and bevels, the outline and the depth.
pub const FOLLOWS_PATTERN: u32 = 0;
/// Pictures follow the mesh's texture coordinates; on walls and bevels, the outline and the
/// depth.
pub const FOLLOWS_MESH: u32 = 1;
/// Pictures follow the mesh's texture coordinates on walls and bevels, too, as pictures of an
/// unwrapped mesh have to.
pub const FOLLOWS_MESH_EVERYWHERE: u32 = 2;

/// A material, metallic-roughness as glTF 2.0 has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Material {
    /// Base colour, linear RGB.
    pub base_color: [Real; 3],
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: Real,
    /// Linear RGB of the light that it sends out.
    pub emission: [Real; 3],
    /// Perceptual roughness, 0…1.
    pub roughness: Real,
    /// Factor of the slopes of the normal picture.
    pub normal_scale: Real,
    /// Repeats of the pictures per repeat of the pattern, or of the mesh's texture coordinates.
    pub tiles: [Real; 2],
    /// Offset of the pictures, their repeats.
    pub offset: [Real; 2],
    /// What pictures follow, one of the `FOLLOWS_` constants.
    pub follows: u32,
    /// Largest change of the base colour from cell to cell, as a share of it.
    pub shade_variation: Real,
    /// Not 0: pictures are shifted from cell to cell.
    pub shifts: u32,
    /// Not 0: pictures are turned by quarters from cell to cell.
    pub turns: u32,
    /// Factor of the base colour.
    pub base_color_image: Image,
    /// Factors of roughness (green) and metallic (blue).
    pub metallic_roughness_image: Image,
    /// Normals in the frame of tangent, bitangent and normal; y points up.
    pub normal_image: Image,
    /// Factor of the emission.
    pub emission_image: Image,
}

/// The material of a surface class of an object, and what places pictures on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Finish {
    /// The material.
    pub material: Material,
    /// Index of the object's first facet among all [`FacetMaterial`]s.
    pub first_facet: u32,
    /// S_z, object units.
    pub depth: Real,
    /// 1 / repeats of the pattern along u and v.
    pub inverse_repeat: [Real; 2],
    /// Repeats after which the mesh closes, whole numbers; 0 if they are not whole.
    pub period: [Real; 2],
    /// The pattern's cells, one word a texel ([`cells`](super::cells)); no levels without them.
    pub cells: Image,
    /// Decides how cells vary.
    pub seed: u32,
    /// How far the pattern grows from cap to floor, repeats along u and v.
    pub growth: [Real; 2],
    /// δ at which a bevel, a fillet or terraces end: a wall is below them, or the floor if it is 1; 0
    /// without them.
    pub rim: Real,
    /// The class of most of a side, one of the `CLASS_` constants.
    pub side: u32,
    /// Width of a cell, texels of the map.
    pub cell_width: Real,
    /// What the pattern is on average.
    pub chart: Chart,
}

/// What a pattern is on average ([`mean`](super::mean)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Chart {
    /// How much of it is cap, and how its outline runs; no levels where that is not asked for.
    pub image: Image,
    /// Mean width of the gaps between its parts, texels of the image.
    pub gap: Real,
    /// How much of its outline runs along u and v, 0…1; 0 of outlines that run in all directions.
    pub order: Real,
    /// Mean way along u and along v from part to part, repeats.
    pub way: [Real; 2],
}

/// Number of finishes of an object, or of each of its mesh's materials: one for each class that
/// is hit, in the order of the `CLASS_` constants.
pub const FINISHES: u32 = 4;

/// How the pattern lies on a facet, and of which material of the mesh the facet is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FacetMaterial {
    /// Whole repeats that the facet's texture coordinates lack.
    pub whole: [Real; 2],
    /// |∇u| and |∇v|, repeats per object unit.
    pub density: [Real; 2],
    /// How many times [`FINISHES`] its finishes come after the object's first ones.
    pub slot: u32,
}

/// A light that is far away.
pub const LIGHT_DIRECTIONAL: u32 = 0;
/// A light at a place, in all directions.
pub const LIGHT_POINT: u32 = 1;
/// A light at a place, within a cone.
pub const LIGHT_SPOT: u32 = 2;

/// A light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Light {
    /// Linear RGB of a white matte surface that faces it, at distance 1 if it has a place.
    pub color: [Real; 3],
    /// One of the `LIGHT_` constants.
    pub kind: u32,
    /// Its place, world units, relative to the scene's origin.
    pub position: [Real; 3],
    /// 1 / the distance beyond which it is dark; 0 for none.
    pub inverse_range: Real,
    /// Unit direction towards it, or against which a spot light shines.
    pub direction: [Real; 3],
    /// A spot light's share is (cosine · `spot_scale` + `spot_offset`)², limited to 0…1.
    pub spot_scale: Real,
    /// See `spot_scale`.
    pub spot_offset: Real,
    /// Index of its first [`ShadowMap`].
    pub first_shadow: u32,
    /// Number of them: 0 without shadows, 1, or 6 around a point light.
    pub shadows: u32,
}

/// A picture of depths, seen from a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ShadowMap {
    /// The eye, world units, relative to the scene's origin.
    pub eye: [Real; 3],
    /// Distance of the near plane, world units.
    pub near: Real,
    /// As in [`Frame`](crate::layout::Frame).
    pub right: [Real; 3],
    /// Width and height, texels.
    pub size: u32,
    /// As in [`Frame`](crate::layout::Frame).
    pub up: [Real; 3],
    /// Index of its first word: reversed depths as the bits of f32, rows from the top.
    pub first: u32,
    /// As in [`Frame`](crate::layout::Frame).
    pub forward: [Real; 3],
    /// Width of a texel at distance 1, world units.
    pub texel: Real,
}

/// Light from all directions, and what is the same for all pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Lighting {
    /// Linear RGB of pixels without a hit.
    pub background: [Real; 3],
    /// Not 0: pixels without a hit show the environment, which there is.
    pub shows_environment: u32,
    /// Number of lights.
    pub lights: u32,
    /// Index of the first word of the environment's levels, of which each is rougher.
    pub environment: u32,
    /// Side of its first level, texels, without the border; each level is half as large.
    pub environment_size: u32,
    /// Number of its levels; 0 if there is no environment.
    pub environment_levels: u32,
    /// How much of the occlusion of its light counts, 0…1.
    pub occlusion: Real,
    /// Index of the first word of the table of reflected shares.
    pub reflectance: u32,
    /// How fast the tone curve flattens: it is about x / (1 + `shoulder` × s), where s is the sum of the
    /// channels; 0 without a curve.
    pub shoulder: Real,
    /// Linear RGB that the environment is multiplied by.
    pub environment_color: [Real; 3],
    /// Irradiance over π, as coefficients of 1, x, y, z, xy, yz, zx, z², x² − y²: linear RGB.
    pub irradiance: [[Real; 3]; 9],
}

/// Side of the table of reflected shares, texels.
pub const REFLECTANCE_SIZE: u32 = 32;

const _: () = {
    use core::mem::size_of;
    assert!(size_of::<Image>() == 16 && size_of::<Material>() == 132);
    assert!(size_of::<Finish>() == 228 && size_of::<FacetMaterial>() == 20);
    assert!(size_of::<Light>() == 60 && size_of::<ShadowMap>() == 64);
    assert!(size_of::<Lighting>() == 164);
};
