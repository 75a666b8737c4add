//! How much of the sky a point of the carved surface sees, from the distance map: ambient
//! occlusion.
//!
//! The outline near a point is taken for a long groove: one wall at the stored distance, and
//! another one where the distance map says so further on. What a plane facing up or a
//! wall sees between them is the form factor of an infinite strip.

use crate::arithmetic::{div, kept, max, normalize_or, sqrt};
use crate::layout::{Object, vec2};
use crate::model::Hit;
use crate::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::{FAR, Real, Vec2};

/// Part of a step by which the distance grows where there is no wall ahead.
const AHEAD: Real = 0.9;

/// Returns the share of the hemisphere that a wall hides from a point on the ground, `distance`
/// before it and `height` below its top.
#[inline]
pub(crate) fn hidden(distance: Real, height: Real) -> Real {
    let distance = max(distance, 0.0);
    let length = sqrt(distance * distance + height * height);
    0.5 - 0.5 * div(distance, max(length, 1e-12))
}

/// Returns the share of the light from all directions that reaches a hit, 0…1; `density` is
/// |∇u|, repeats per object unit. `distance` and `gradient` are those of the map there; a cap
/// needs neither.
#[inline]
pub fn openness<T: Texels + ?Sized>(
    object: &Object,
    map: &ShapeMap,
    texels: &T,
    hit: &Hit,
    distance: Real,
    gradient: Vec2,
    density: Real,
) -> Real {
    let Hit {
        class,
        uv,
        depth_fraction,
        ..
    } = *hit;
    if class == CLASS_CAP {
        return 1.0;
    }
    let profile = Profile::new(object);
    // Texels per object unit.
    let scale = max(density * map.size.x, 1e-6);
    let away = normalize_or(Vec2::new(kept(gradient.x), kept(gradient.y)), Vec2::X);
    let height = max(depth_fraction * object.depth * scale, 1e-3);
    let cap = profile.radius(0.0);
    // The other wall: about a depth further on, or three.
    let quotients = &object.quotients;
    let texel = vec2(quotients.gradient_offset) * (2.0 * quotients.gradient_scale);
    let mut step = max(height, 2.0);
    let mut beyond = FAR;
    let mut probe = 0;
    while probe < 2 {
        let ahead = map.distance(texels, uv + away * texel * step);
        if beyond == FAR && ahead < distance + AHEAD * step {
            beyond = max(step + ahead - cap, 0.0);
        }
        step *= 3.0;
        probe += 1;
    }
    let is_walled = beyond != FAR;
    if class == CLASS_FLOOR {
        let far = if is_walled {
            hidden(beyond, height)
        } else {
            0.0
        };
        1.0 - hidden(distance - cap, height) - far
    } else {
        // A wall sees the strip of sky between it and the other one.
        let sky = if is_walled {
            0.5 - 0.5 * div(height, sqrt(beyond * beyond + height * height))
        } else {
            0.5
        };
        of_side(class, sky)
    }
}

/// Returns the share of the light from all directions that reaches a side of `class`, where an upright wall
/// sees the share `sky` of the hemisphere as sky, 0…½. Half of what a wall sees is the ground; bevels lean
/// back.
#[inline]
pub(crate) fn of_side(class: u32, sky: Real) -> Real {
    let ground = if class == CLASS_BEVEL { 0.5 } else { 0.25 };
    ground + 0.5 * sky
}
