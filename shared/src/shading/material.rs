//! Materials at a hit: which one, where its pictures lie, and what they say there.

use super::Tables;
use super::cells::{cell, hash, unit};
use super::image::sample;
use super::layout::{
    FINISHES, FOLLOWS_MESH_EVERYWHERE, FOLLOWS_PATTERN, FacetMaterial, Finish, Image, Material,
};
use crate::arithmetic::{clamp, div, max, normalize_or, sqrt};
use crate::gbuffer::Sample;
use crate::layout::{vec2, vec3};
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_WALL};
use crate::shape_map::Texels;
use crate::{Real, Vec2, Vec3};
use relievo_exact::log2;

/// What a material is at a hit.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// Base colour, linear RGB.
    pub base_color: Vec3,
    /// 0…1.
    pub metallic: Real,
    /// Perceptual roughness, 0…1.
    pub roughness: Real,
    /// Unit normal, world axes.
    pub normal: Vec3,
    /// Linear RGB.
    pub emission: Vec3,
}

/// Returns the index of the finish of `hit`, which is no miss, on a facet of slot 0.
#[inline]
pub fn finish_of(hit: &Sample) -> u32 {
    FINISHES * hit.finish + (hit.class - CLASS_CAP)
}

/// Returns whether `hit` is on a wall or a bevel.
#[inline]
fn is_side(hit: &Sample) -> bool {
    hit.class == CLASS_WALL || hit.class == CLASS_BEVEL
}

/// Where pictures lie at a hit.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// Repeats of the pictures from their upper left corner.
    pub at: Vec2,
    /// Repeats of the pictures along the width of a pixel, along both axes.
    pub width: Vec2,
    /// The x axis of the pictures along tangent and bitangent, which is (1, 0), (0, 1), (−1, 0)
    /// or (0, −1).
    pub axis: Vec2,
    /// Factor of the base colour.
    pub shade: Real,
}

impl Coordinates {
    /// Varies them by the hash of a cell.
    #[inline]
    fn varied(self, material: &Material, cell: u32) -> Coordinates {
        let (first, second, third) = (hash(cell ^ 1), hash(cell ^ 2), hash(cell ^ 3));
        let shade = 1.0 + material.shade_variation * (2.0 * unit(first) - 1.0);
        let mut varied = Coordinates { shade, ..self };
        if material.turns != 0 {
            // By quarters.
            let is_back = second & 1 == 1;
            let is_across = second & 2 == 2;
            let sign = if is_back { -1.0 } else { 1.0 };
            let (at, width) = (self.at, self.width);
            if is_across {
                varied.axis = Vec2::new(0.0, sign);
                varied.at = Vec2::new(at.y, -at.x) * sign;
                varied.width = Vec2::new(width.y, width.x);
            } else {
                varied.axis = Vec2::new(sign, 0.0);
                varied.at = at * sign;
            }
        }
        if material.shifts != 0 {
            varied.at += Vec2::new(unit(third), unit(hash(third)));
        }
        varied
    }
}

/// Returns where the pictures of `finish` lie at `hit`. `pixel` is a pixel's width at
/// distance 1, and `cosine` the one between surface and eye.
///
/// On walls and bevels the first axis follows the outline, and the second one the depth, unless
/// pictures follow the mesh everywhere.
#[inline]
pub fn coordinates<T: Texels + ?Sized>(
    words: &T,
    hit: &Sample,
    finish: &Finish,
    facet: &FacetMaterial,
    pixel: Real,
    cosine: Real,
) -> Coordinates {
    let material = &finish.material;
    let whole = hit.uv + vec2(facet.whole);
    let scale = if material.follows == FOLLOWS_PATTERN {
        Vec2::ONE
    } else {
        vec2(finish.inverse_repeat)
    };
    let (repeats, density) = (whole * scale, vec2(facet.density) * scale);
    let (at, density) = if is_side(hit) && material.follows != FOLLOWS_MESH_EVERYWHERE {
        let (along, density) = if hit.is_along_v {
            (repeats.y, density.y)
        } else {
            (repeats.x, density.x)
        };
        let down = hit.depth_fraction * finish.depth * density;
        (Vec2::new(along, down), Vec2::splat(density))
    } else {
        (repeats, density)
    };
    let tiles = vec2(material.tiles);
    // Between the widths along and across the slant.
    let slant = div(1.0, sqrt(max(cosine, 1e-2)));
    let footprint = div(hit.t, max(hit.unit, 1e-12)) * pixel * slant;
    let found = Coordinates {
        at: at * tiles + vec2(material.offset),
        width: density * tiles * footprint,
        axis: Vec2::X,
        shade: 1.0,
    };
    if finish.cells.levels == 0 {
        found
    } else {
        found.varied(material, cell(words, finish, whole))
    }
}

/// Returns the level of detail of `image` for pixels of `width` repeats.
#[inline]
fn level(image: &Image, width: Vec2) -> Real {
    let texels = max(
        width.x * (image.width as i32 as Real),
        width.y * (image.height as i32 as Real),
    );
    log2(clamp(texels, 1e-6, 1e6))
}

/// Returns what `material` is at `hit`, whose pictures lie at `coordinates`.
#[inline]
pub fn values<T: Tables + ?Sized>(
    tables: &T,
    hit: &Sample,
    material: &Material,
    coordinates: &Coordinates,
) -> Values {
    let mut found = Values {
        base_color: vec3(material.base_color) * coordinates.shade,
        metallic: material.metallic,
        roughness: material.roughness,
        normal: hit.normal,
        emission: vec3(material.emission),
    };
    // One lookup after the other: written once, and in the shader once.
    let mut which = 0;
    while which < 4 {
        let image = if which == 0 {
            material.base_color_image
        } else if which == 1 {
            material.metallic_roughness_image
        } else if which == 2 {
            material.normal_image
        } else {
            material.emission_image
        };
        if image.levels != 0 {
            let value = sample(
                tables,
                &image,
                coordinates.at,
                level(&image, coordinates.width),
            );
            let rgb = Vec3::new(value.x, value.y, value.z);
            if which == 0 {
                found.base_color *= rgb;
            } else if which == 1 {
                found.roughness *= rgb.y;
                found.metallic *= rgb.z;
            } else if which == 2 {
                // The tangent of a side is not that of pictures that follow the mesh there.
                if !is_side(hit) || material.follows != FOLLOWS_MESH_EVERYWHERE {
                    found.normal = bumped(hit, rgb, material.normal_scale, coordinates.axis);
                }
            } else {
                found.emission *= rgb;
            }
        }
        which += 1;
    }
    found
}

/// Returns the normal that a texel of a normal picture says.
#[inline]
fn bumped(hit: &Sample, texel: Vec3, scale: Real, axis: Vec2) -> Vec3 {
    let slopes = texel * 2.0 - Vec3::ONE;
    let bitangent = hit.normal.cross(hit.tangent);
    let down = if hit.is_mirrored {
        -bitangent
    } else {
        bitangent
    };
    let x = hit.tangent * axis.x + down * axis.y;
    // Rows of pictures run down, and y points up.
    let y = hit.tangent * axis.y - down * axis.x;
    let bumped = x * (slopes.x * scale) + y * (slopes.y * scale) + hit.normal * slopes.z;
    normalize_or(bumped, hit.normal)
}
