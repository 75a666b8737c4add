//! Materials at a hit: which one, where its pictures lie, and what they say there.

use super::Tables;
use super::cells::{cell, hash, unit};
use super::image::{Footprint, sample_over};
use super::layout::{
    FINISHES, FOLLOWS_MESH_EVERYWHERE, FOLLOWS_PATTERN, FacetMaterial, Finish, Material,
};
use crate::arithmetic::{clamp, div, max, normalize_or, sqrt};
use crate::camera::on_plane;
use crate::gbuffer::{Sample, is_side};
use crate::layout::{Frame, vec2, vec3};
use crate::normals::CLASS_CAP;
use crate::shape_map::Texels;
use crate::{Real, Vec2, Vec3};

/// Least cosine between a surface and the direction to the eye, of what a pixel covers.
const LEAST_FOOTPRINT_COSINE: Real = 0.02;

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

/// Returns the unit vector along growing v, or on a side along growing depth.
#[inline]
fn second_axis(hit: &Sample) -> Vec3 {
    let bitangent = hit.normal.cross(hit.tangent);
    if hit.is_mirrored {
        -bitangent
    } else {
        bitangent
    }
}

/// Where pictures lie at a hit.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// Repeats of the pictures from their upper left corner.
    pub at: Vec2,
    /// What a pixel covers, repeats of the pictures.
    pub footprint: Footprint,
    /// The x axis of the pictures along tangent and bitangent, which is (1, 0), (0, 1), (−1, 0)
    /// or (0, −1).
    pub axis: Vec2,
    /// Factor of the base colour.
    pub shade: Real,
    /// How many images of the material are looked up, the one of normals last.
    pub images: u32,
}

impl Coordinates {
    /// Varies them by the hash of a cell; `share` is how much of its shade is seen.
    #[inline]
    fn varied(self, material: &Material, cell: u32, share: Real) -> Coordinates {
        let (first, second, third) = (hash(cell ^ 1), hash(cell ^ 2), hash(cell ^ 3));
        let shade = 1.0 + share * material.shade_variation * (2.0 * unit(first) - 1.0);
        let mut varied = Coordinates { shade, ..self };
        if material.turns != 0 {
            // By quarters.
            let is_back = second & 1 == 1;
            let is_across = second & 2 == 2;
            let sign = if is_back { -1.0 } else { 1.0 };
            let at = self.at;
            let turned = |v: Vec2| Vec2::new(v.y, -v.x);
            if is_across {
                varied.axis = Vec2::new(0.0, sign);
                varied.at = turned(at) * sign;
                varied.footprint = Footprint {
                    right: turned(self.footprint.right),
                    down: turned(self.footprint.down),
                };
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

/// Returns where the pictures of `finish` lie at `hit`, seen along `direction`.
///
/// On walls and bevels the first axis follows the outline, and the second one the depth, unless
/// pictures follow the mesh everywhere. A hit that `is_anywhere` in its pixel is a square as wide as what the pixel
/// covers is long: one lookup, instead of several along it. Its image of normals is not looked up.
#[inline]
pub fn coordinates<T: Texels + ?Sized>(
    words: &T,
    frame: &Frame,
    direction: Vec3,
    hit: &Sample,
    is_anywhere: bool,
    finish: &Finish,
    facet: &FacetMaterial,
) -> Coordinates {
    let material = &finish.material;
    let whole = hit.uv + vec2(facet.whole);
    let scale = if material.follows == FOLLOWS_PATTERN {
        Vec2::ONE
    } else {
        vec2(finish.inverse_repeat)
    };
    let (repeats, density) = (whole * scale, vec2(facet.density) * scale);
    let is_along = is_side(hit.class) && material.follows != FOLLOWS_MESH_EVERYWHERE;
    let (at, density) = if is_along {
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
    let [right, down] = on_plane(frame, direction, hit.t, hit.normal, LEAST_FOOTPRINT_COSINE);
    let across = second_axis(hit);
    let on_axes = |side: Vec3| Vec2::new(hit.tangent.dot(side), across.dot(side));
    // Where pictures follow the mesh on a side, their axes are not known.
    let footprint = if is_anywhere {
        let longest = max(right.dot(right), down.dot(down));
        Footprint::square(Vec2::splat(sqrt(longest)))
    } else if is_along || !is_side(hit.class) {
        Footprint {
            right: on_axes(right),
            down: on_axes(down),
        }
    } else {
        let area = right.cross(down);
        Footprint::square(Vec2::splat(sqrt(sqrt(area.dot(area)))))
    };
    let per_unit = div(1.0, max(hit.unit, 1e-12));
    let scale = density * tiles * per_unit;
    let found = Coordinates {
        at: at * tiles + vec2(material.offset),
        footprint: footprint.scaled(scale),
        axis: Vec2::X,
        shade: 1.0,
        images: if is_anywhere { 3 } else { 4 },
    };
    if finish.cells.levels == 0 {
        found
    } else {
        let size = Vec2::new(
            finish.cells.width as i32 as Real,
            finish.cells.height as i32 as Real,
        );
        let scale = vec2(facet.density) * size * per_unit;
        let width = footprint.scaled(scale).longest();
        let cells = div(width, max(finish.cell_width, 1e-6));
        // Cells that are smaller than a pixel are seen together.
        let share = clamp(1.5 - cells, 0.0, 1.0);
        found.varied(material, cell(words, finish, whole), share)
    }
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
    while which < coordinates.images {
        let image = if which == 0 {
            material.base_color_image
        } else if which == 1 {
            material.metallic_roughness_image
        } else if which == 2 {
            material.emission_image
        } else {
            material.normal_image
        };
        if image.levels != 0 {
            let value = sample_over(tables, &image, coordinates.at, &coordinates.footprint);
            let rgb = Vec3::new(value.x, value.y, value.z);
            if which == 0 {
                found.base_color *= rgb;
            } else if which == 1 {
                found.roughness *= rgb.y;
                found.metallic *= rgb.z;
            } else if which == 2 {
                found.emission *= rgb;
            } else if !is_side(hit.class) || material.follows != FOLLOWS_MESH_EVERYWHERE {
                // The tangent of a side is not that of pictures that follow the mesh there.
                found.normal = bumped(hit, rgb, material.normal_scale, coordinates.axis);
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
    let down = second_axis(hit);
    let x = hit.tangent * axis.x + down * axis.y;
    // Rows of pictures run down, and y points up.
    let y = hit.tangent * axis.y - down * axis.x;
    let bumped = x * (slopes.x * scale) + y * (slopes.y * scale) + hit.normal * slopes.z;
    normalize_or(bumped, hit.normal)
}
