//! Light from all directions: irradiance as spherical harmonics of the second order (Ramamoorthi
//! and Hanrahan, 2001), and a chain of octahedral pictures, each blurred for a greater
//! roughness. Texels are RGB of 9 bits with a shared exponent of 5; each level has a border of
//! one texel.

use super::layout::Lighting;
use crate::arithmetic::{abs, clamp, div, kept3, max};
use crate::gbuffer::octahedral_fold;
use crate::layout::vec3;
use crate::shape_map::Texels;
use crate::{Real, Vec3};

/// Returns the irradiance over π at a surface with unit `normal`, linear RGB.
#[inline]
pub fn irradiance(lighting: &Lighting, normal: Vec3) -> Vec3 {
    let n = kept3(normal);
    let [one, x, y, z, xy, yz, zx, zz, difference] = &lighting.irradiance;
    let sum = vec3(*one)
        + vec3(*x) * n.x
        + vec3(*y) * n.y
        + vec3(*z) * n.z
        + vec3(*xy) * (n.x * n.y)
        + vec3(*yz) * (n.y * n.z)
        + vec3(*zx) * (n.z * n.x)
        + vec3(*zz) * (n.z * n.z)
        + vec3(*difference) * (n.x * n.x - n.y * n.y);
    let sum = Vec3::new(max(sum.x, 0.0), max(sum.y, 0.0), max(sum.z, 0.0));
    kept3(sum * vec3(lighting.environment_color))
}

/// Returns the colour of a texel.
#[inline]
pub fn from_shared_exponent(word: u32) -> Vec3 {
    // 2^(exponent − 15 − 9).
    let scale = f32::from_bits(((word >> 27) + 103) << 23);
    let part = |code: u32| (code & 511) as i32 as Real;
    Vec3::new(part(word), part(word >> 9), part(word >> 18)) * scale
}

/// Returns the light from the unit `direction`, blurred for `roughness`, linear RGB.
#[inline]
pub fn radiance<T: Texels + ?Sized>(
    words: &T,
    lighting: &Lighting,
    direction: Vec3,
    roughness: Real,
) -> Vec3 {
    let d = kept3(direction);
    let scale = div(1.0, max(abs(d.x) + abs(d.y) + abs(d.z), 1e-6));
    let at = octahedral_fold(d.x * scale, d.y * scale, d.z);
    let last = lighting.environment_levels as i32 - 1;
    let level = clamp(roughness, 0.0, 1.0) * last as Real;
    let whole = clamp(level, 0.0, (last - 1) as Real) as u32;
    let blend = level - whole as i32 as Real;
    let mut first = lighting.environment;
    let mut size = lighting.environment_size;
    let mut found = Vec3::ZERO;
    let mut index = 0;
    while index < whole + 2 {
        if index >= whole {
            let weight = if index == whole { 1.0 - blend } else { blend };
            found += bilinear(words, first, size, at.x, at.y) * weight;
        }
        first += (size + 2) * (size + 2);
        size >>= 1;
        index += 1;
    }
    kept3(found * vec3(lighting.environment_color))
}

/// Returns the level of `size` texels at (`x`, `y`), each −1…1.
#[inline]
fn bilinear<T: Texels + ?Sized>(words: &T, first: u32, size: u32, x: Real, y: Real) -> Vec3 {
    let side = size as i32 as Real;
    let part = |x: Real| {
        // The border's texel is the first one.
        let at = clamp((x * 0.5 + 0.5) * side + 0.5, 0.5, side + 0.5);
        let low = at as u32;
        (low, at - low as i32 as Real)
    };
    let (column, across) = part(x);
    let (row, down) = part(y);
    let texel = |x: u32, y: u32| from_shared_exponent(words.word(first + y * (size + 2) + x));
    let line = |y: u32| texel(column, y) * (1.0 - across) + texel(column + 1, y) * across;
    line(row) * (1.0 - down) + line(row + 1) * down
}
