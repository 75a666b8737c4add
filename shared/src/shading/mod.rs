//! Colours of pixels whose hits are known: materials, lights, shadows and environment.
//!
//! Scenes that have none of these are lit by [`light`](crate::light), while they are drawn.

pub mod brdf;
pub mod cells;
pub mod edges;
pub mod environment;
pub mod image;
pub mod layout;
pub mod lights;
pub mod material;
pub mod mean;
mod pattern;
pub mod shadow_map;

pub use layout::{Chart, FacetMaterial, Finish, Image, Light, Lighting, Material, ShadowMap};

use crate::arithmetic::{div, kept3, max};
use crate::camera::pixel_ray;
use crate::contract::check3;
use crate::gbuffer::{self, Hits, Sample};
use crate::layout::{Frame, vec3};
use crate::normals::{CLASS_MISS, CLASS_SKY};
use crate::shape_map::Texels;
use crate::trace::word;
use crate::{Real, Vec3};
use brdf::Reflector;
use glam::{UVec3, UVec4};

/// What shading reads: storage buffers, or slices. The words are those of pictures, of the
/// environment and of shadow maps.
pub trait Tables: Texels {
    /// Returns finish `index`.
    fn finish(&self, index: u32) -> &Finish;
    /// Returns how the pattern lies on facet `index` of all facets, and its material.
    fn facet(&self, index: u32) -> &FacetMaterial;
    /// Returns light `index`.
    fn light(&self, index: u32) -> &Light;
    /// Returns shadow map `index`.
    fn shadow_map(&self, index: u32) -> &ShadowMap;
}

/// Returns the words of pixel (`x`, `y`) of the picture of `hits`: linear RGB as the bits of
/// three f32, and the class.
#[inline]
pub fn words<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    (x, y): (u32, u32),
    hits: &H,
) -> UVec4 {
    let hit = hits.sample(x, y);
    let direction = pixel_ray(frame, x, y);
    let (rgb, class) = if hit.class == CLASS_MISS {
        missed(tables, lighting, direction)
    } else {
        (shade(tables, frame, lighting, direction, &hit), hit.class)
    };
    color_words(rgb, class)
}

/// Returns the words of pixel (`x`, `y`) for smooth edges: as [`words`], where the class word also has the shares of
/// its neighbours and of what lies between ([`edges::from_code`]), whose light is beside its own
/// ([`edges::lights_of`]). Hits know the mesh. Black where only the
/// [`mean`](mean::words) is seen: where hits say so, or `is_mean_only`.
#[inline]
pub fn words_with_edges<T: Tables + ?Sized, H: Hits + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    (x, y): (u32, u32),
    hits: &H,
    is_mean_only: bool,
) -> UVec4 {
    let class = hits.sample(x, y).class;
    let division = edges::division(tables, frame, hits, x, y);
    if class == CLASS_MISS {
        let (rgb, class) = missed(tables, lighting, pixel_ray(frame, x, y));
        let shares = edges::Shares {
            between: 0.0,
            ..division.shares()
        };
        return color_words(rgb, shares.code(class));
    }
    // Before the rest: it takes fewer registers than the shares.
    let code = division.shares().code(class);
    let [before, after] = division.between();
    // The bits of the sum of the light between, and at last the words of all light: one after the other in
    // the same registers.
    let (mut words, mut total) = (UVec3::ZERO, 0.0);
    // A bit for each part: a side and the floor between it and its neighbours, and at last the hit.
    let mut parts = 0;
    if !is_mean_only && !gbuffer::is_mean_only(hits.words(x, y).1) {
        parts = 0b10000;
        if before > 0.0 {
            parts |= 0b00011;
        }
        if after > 0.0 {
            parts |= 0b01100;
        }
    }
    // Written once, and in the shader once, since compilers do not unroll a loop whose end they do not know. All
    // invocations count alike: which part it is takes no registers.
    let mut part = 0;
    while parts != 0 {
        if parts & 1 != 0 {
            let is_own = part == 4;
            let (share, ray, hit) = if is_own {
                // Read again, so that it takes no registers meanwhile.
                let ray = pixel_ray(frame, x, y);
                (1.0, ray, hits.sample_on_mesh(x, y))
            } else {
                let part = edges::Part {
                    is_after: part > 1,
                    is_floor: part & 1 == 1,
                };
                edges::between(tables, frame, hits, (x, y), &division, part)
            };
            if share > 0.0 {
                let light = shade(tables, frame, lighting, ray, &hit);
                let sum = edges::light_in(words);
                if is_own {
                    let between = if total > 0.0 {
                        sum * div(1.0, total)
                    } else {
                        light
                    };
                    words = edges::light_words(light, between, code);
                } else {
                    let weight = share * mixed(lighting, light);
                    let sum = sum + light * weight;
                    words = UVec3::new(word(sum.x), word(sum.y), word(sum.z));
                    total += weight;
                }
            }
        }
        parts >>= 1;
        part += 1;
    }
    UVec4::new(words.x, words.y, words.z, code)
}

/// Returns the linear RGB and the class of a pixel without a hit.
#[inline]
fn missed<T: Tables + ?Sized>(tables: &T, lighting: &Lighting, direction: Vec3) -> (Vec3, u32) {
    if lighting.shows_environment != 0 {
        let sky = environment::radiance(tables, lighting, direction, 0.0);
        (sky, CLASS_SKY)
    } else {
        (vec3(lighting.background), CLASS_MISS)
    }
}

/// Returns the weight of `rgb` where it is mixed with other light before the tone curve, so that the
/// curve shows about the mean of what it would show of each (Karis, "Tone mapping", 2013).
#[inline]
fn mixed(lighting: &Lighting, rgb: Vec3) -> Real {
    div(1.0, 1.0 + lighting.shoulder * (rgb.x + rgb.y + rgb.z))
}

/// Returns the words of a pixel: linear RGB, and its class word.
#[inline]
fn color_words(rgb: Vec3, class: u32) -> UVec4 {
    let rgb = kept3(rgb);
    check3(rgb);
    UVec4::new(word(rgb.x), word(rgb.y), word(rgb.z), class)
}

/// Returns the linear RGB of `hit`, seen along `direction`.
#[inline]
pub fn shade<T: Tables + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    direction: Vec3,
    hit: &Sample,
) -> Vec3 {
    shade_under(
        tables,
        frame,
        lighting,
        direction,
        hit,
        false,
        |light, _, _, position| lights::arriving(tables, light, position, hit.normal),
    )
}

/// Returns the linear RGB of `hit`, seen along `direction`. If it `is_anywhere`, it stands for all that its pixel
/// shows of a part, not for one place ([`coordinates`](material::coordinates)). `arriving` returns the share of a light,
/// given with its index, that arrives at a position in the world.
#[inline]
pub fn shade_under<T: Tables + ?Sized>(
    tables: &T,
    frame: &Frame,
    lighting: &Lighting,
    direction: Vec3,
    hit: &Sample,
    is_anywhere: bool,
    mut arriving: impl FnMut(&Light, u32, &lights::Incoming, Vec3) -> Real,
) -> Vec3 {
    let first = material::finish_of(hit);
    let facet = tables.facet(tables.finish(first).first_facet + hit.facet);
    let finish = tables.finish(first + facet.slot * layout::FINISHES);
    let position = vec3(frame.eye) + direction * hit.t;
    let to_eye = -direction;
    let coordinates =
        material::coordinates(tables, frame, direction, hit, is_anywhere, finish, facet);
    let values = material::values(tables, hit, &finish.material, &coordinates);
    let normal = values.normal;
    let surface = Reflector::new(
        values.base_color,
        values.metallic,
        values.roughness,
        normal.dot(to_eye),
    )
    .with_reflectance(tables, lighting.reflectance);
    let mut color = values.emission;
    if lighting.environment_levels != 0 {
        let mirrored = kept3(direction - normal * (2.0 * direction.dot(normal)));
        let open = 1.0 - lighting.occlusion * (1.0 - hit.openness);
        color += surface.surrounded(
            environment::irradiance(lighting, normal) * surface.interreflected(open),
            environment::radiance(tables, lighting, mirrored, surface.roughness) * open,
        );
    }
    let mut index = 0;
    while index < lighting.lights {
        let light = tables.light(index);
        let incoming = lights::incoming(light, position);
        let cosine = normal.dot(incoming.direction);
        // Nothing shines through the carved surface, whatever a picture says of its normal.
        if cosine > 0.0 && hit.normal.dot(incoming.direction) > 0.0 {
            let share = arriving(light, index, &incoming, position);
            if share > 0.0 {
                color += lit(&surface, normal, to_eye, &incoming, cosine) * share;
            }
        }
        index += 1;
    }
    color
}

/// Returns the light that a surface with unit `normal` sends to the eye.
#[inline]
pub fn lit(
    surface: &Reflector,
    normal: Vec3,
    to_eye: Vec3,
    incoming: &lights::Incoming,
    cosine: Real,
) -> Vec3 {
    let (half_way, half_cosine) = lights::half_way(incoming.direction, to_eye, normal);
    let cosine = max(cosine, 0.0);
    surface.reflected(normal, half_way, half_cosine, cosine) * incoming.color * cosine
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests;
