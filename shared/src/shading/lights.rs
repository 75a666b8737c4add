//! Directional, point and spot lights, as the glTF extension KHR_lights_punctual has them.

use super::Tables;
use super::layout::{LIGHT_DIRECTIONAL, LIGHT_SPOT, Light, ShadowMap};
use super::shadow_map::{self, face, visibility};
use crate::arithmetic::{clamp, div, kept3, max, normalize_or, sqrt};
use crate::layout::vec3;
use crate::{Real, Vec3};

/// Light that arrives at a point.
#[derive(Clone, Copy, Debug)]
pub struct Incoming {
    /// Unit direction towards the light.
    pub direction: Vec3,
    /// Linear RGB.
    pub color: Vec3,
}

/// Least square of a distance from a light, world units squared.
const NEAREST: Real = 1e-8;

/// Returns the light of `light` at `position`, without shadows.
#[inline]
pub fn incoming(light: &Light, position: Vec3) -> Incoming {
    let color = vec3(light.color);
    let axis = vec3(light.direction);
    if light.kind == LIGHT_DIRECTIONAL {
        return Incoming {
            direction: axis,
            color,
        };
    }
    let to_light = vec3(light.position) - position;
    let square = max(to_light.dot(to_light), NEAREST);
    let direction = normalize_or(to_light, axis);
    // Fades out towards the range.
    let far = square * light.inverse_range * light.inverse_range;
    let window = clamp(1.0 - far * far, 0.0, 1.0);
    let cone = if light.kind == LIGHT_SPOT {
        let share = direction.dot(axis) * light.spot_scale + light.spot_offset;
        let share = clamp(share, 0.0, 1.0);
        share * share
    } else {
        1.0
    };
    Incoming {
        direction,
        color: kept3(color * (div(window, square) * cone)),
    }
}

/// Returns the share of `light` that arrives at `position` with the unit `normal`, 0…1.
#[inline]
pub fn arriving<T: Tables + ?Sized>(
    tables: &T,
    light: &Light,
    position: Vec3,
    normal: Vec3,
) -> Real {
    if light.shadows == 0 {
        return 1.0;
    }
    visibility(
        tables,
        shadow_map(tables, light, position),
        position,
        normal,
    )
}

/// Returns how far above `position` the shadow map of `light`, which has one, is looked up, world
/// units.
#[inline]
pub fn lift<T: Tables + ?Sized>(tables: &T, light: &Light, position: Vec3) -> Real {
    shadow_map::lift(shadow_map(tables, light, position), position)
}

/// Returns the shadow map of `light`, which has one, that sees `position`.
#[inline]
fn shadow_map<'a, T: Tables + ?Sized>(
    tables: &'a T,
    light: &Light,
    position: Vec3,
) -> &'a ShadowMap {
    let which = if light.shadows == 1 {
        0
    } else {
        face(position - vec3(light.position))
    };
    tables.shadow_map(light.first_shadow + which)
}

/// Returns the unit vector half-way between two unit vectors, and its cosine with both.
#[inline]
pub fn half_way(to_light: Vec3, to_eye: Vec3, fallback: Vec3) -> (Vec3, Real) {
    let half_way = normalize_or(to_light + to_eye, fallback);
    // cos² of half the angle: exact also where the sum is short.
    let cosine = sqrt(max(0.5 + 0.5 * to_light.dot(to_eye), 0.0));
    (half_way, cosine)
}
