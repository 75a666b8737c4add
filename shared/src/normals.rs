//! The surface class of a hit and the normal that lights it (section 9).

use crate::arithmetic::normalize_or;
use crate::layout::Object;
use crate::march::{END_CAP, END_FLOOR, END_MISS, March};
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::Surface;
use crate::{Real, Vec2, Vec3};

/// Nothing was hit.
pub const CLASS_MISS: u32 = 0;
/// The mesh surface, on the pattern.
pub const CLASS_CAP: u32 = 1;
/// The upright side of the extrusion.
pub const CLASS_WALL: u32 = 2;
/// The sloped side of a bevel or a chamfer.
pub const CLASS_BEVEL: u32 = 3;
/// The ground between the columns.
pub const CLASS_FLOOR: u32 = 4;

/// The class of the point where the march ended.
#[inline]
pub fn class_of(march: &March, object: &Object) -> u32 {
    if march.end == END_MISS {
        CLASS_MISS
    } else if march.end == END_CAP {
        CLASS_CAP
    } else if march.end == END_FLOOR {
        if object.cut_out != 0 {
            CLASS_MISS
        } else {
            CLASS_FLOOR
        }
    } else if object.bevel > 0.0 && march.depth_fraction < object.chamfer {
        CLASS_BEVEL
    } else {
        CLASS_WALL
    }
}

/// The unit normal at a hit of `class` at `uv`, where `surface_normal` is the
/// smooth surface's normal at the hit.
///
/// Sides follow the gradient of g = D − e − b δ: normals are covectors, so the
/// map's gradient is carried by ∇u and ∇v, and ∇δ = −N / S_z tilts a bevel.
#[inline]
pub fn normal_at<T: Texels + ?Sized>(
    class: u32,
    object: &Object,
    map: &ShapeMap,
    texels: &T,
    surface: &Surface,
    surface_normal: Vec3,
    uv: Vec2,
) -> Vec3 {
    if class != CLASS_WALL && class != CLASS_BEVEL {
        return surface_normal;
    }
    let slope = map.gradient(texels, uv);
    let raw =
        surface.gradient_u * (slope.x * map.size.x) + surface.gradient_v * (slope.y * map.size.y);
    // Upright with respect to the surface at the hit.
    let upright = raw - surface_normal * surface_normal.dot(raw);
    let tilt: Real = if class == CLASS_BEVEL {
        crate::arithmetic::div(object.bevel * map.size.x, object.depth)
    } else {
        0.0
    };
    normalize_or(upright + surface_normal * tilt, surface_normal)
}
