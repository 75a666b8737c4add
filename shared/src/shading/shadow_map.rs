//! Shadows of all objects on all objects, from pictures of depths that are seen from the
//! lights.

use super::layout::ShadowMap;
use crate::arithmetic::{div, floor};
use crate::layout::vec3;
use crate::shape_map::Texels;
use crate::{Real, Vec3};

/// Distance by which a point is moved along its normal, texels.
const OFFSET: Real = 1.5;
/// Part of a texel by which depths may differ, per unit of distance.
const BIAS: Real = 1.0;

/// 1 over the sum of the tent's weights.
const NINTH: Real = 1.0 / 9.0;

/// Returns the share of the light that arrives at `position` with the unit `normal`, 0…1: the
/// mean over a tent of 3 × 3 texels.
#[inline]
pub fn visibility<T: Texels + ?Sized>(
    words: &T,
    map: &ShadowMap,
    position: Vec3,
    normal: Vec3,
) -> Real {
    let eye = vec3(map.eye);
    let forward = vec3(map.forward);
    let from_eye = position + normal * lift(map, position) - eye;
    let distance = from_eye.dot(forward);
    if distance <= map.near {
        return 1.0;
    }
    let inverse = div(1.0, distance);
    let half = 0.5 * (map.size as i32 as Real);
    let x = half + half * (from_eye.dot(vec3(map.right)) * inverse) - 0.5;
    let y = half - half * (from_eye.dot(vec3(map.up)) * inverse) - 0.5;
    let depth = map.near * inverse * (1.0 + BIAS * map.texel);
    let (column, row) = (floor(x), floor(y));
    let (across, down) = (x - column, y - row);
    let last = map.size as i32 - 1;
    let weight = |index: i32, rest: Real| {
        if index == 0 {
            1.0 - rest
        } else if index == 3 {
            rest
        } else {
            1.0
        }
    };
    let mut sum = 0.0;
    let mut index = 0;
    while index < 16 {
        let (i, j) = (index & 3, index >> 2);
        let column = column as i32 + i - 1;
        let row = row as i32 + j - 1;
        let is_inside = column >= 0 && row >= 0 && column <= last && row <= last;
        let stored = if is_inside {
            f32::from_bits(words.word(map.first + (row * (last + 1) + column) as u32))
        } else {
            0.0
        };
        if stored <= depth {
            sum += weight(i, across) * weight(j, down);
        }
        index += 1;
    }
    sum * NINTH
}

/// Returns the distance by which `position` is moved along its normal, world units.
#[inline]
pub fn lift(map: &ShadowMap, position: Vec3) -> Real {
    OFFSET * map.texel * (position - vec3(map.eye)).dot(vec3(map.forward))
}

/// Returns which of the six pictures around a point light sees the direction `d` from it: +x,
/// −x, +y, −y, +z, −z.
#[inline]
pub fn face(d: Vec3) -> u32 {
    use crate::arithmetic::abs;
    let (x, y, z) = (abs(d.x), abs(d.y), abs(d.z));
    let side = |x: Real| if x < 0.0 { 1 } else { 0 };
    if x >= y && x >= z {
        side(d.x)
    } else if y >= z {
        2 + side(d.y)
    } else {
        4 + side(d.z)
    }
}
