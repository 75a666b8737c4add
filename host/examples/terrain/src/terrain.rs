//! Heights and normals of the landscape, and what covers it. All lengths are metres.

use crate::noise::{fbm, gradient_noise, ridges, warp};
use glam::{Vec2, Vec3};
use relievo_exact::{clamp, normalize_or};
use relievo_kernel::kernel;

/// The height of lakes.
pub const WATER_LEVEL: f32 = 0.0;
/// No height is less.
pub const LOWEST: f32 = -400.0;
/// No height is larger.
pub const HIGHEST: f32 = 2600.0;
/// The detail of [`height()`], in octaves.
pub const FULL_DETAIL: f32 = 12.0;

/// Numbers of the world: others make another world.
const SEED: u32 = 2026;
/// From one mountain to the next is about twice this.
const MOUNTAIN: f32 = 2400.0;
/// From one range of mountains to the next is about twice this.
const RANGE: f32 = 7000.0;

/// Returns 3u² − 2u³ of u = (`x` − `low`) · `rate`, limited to 0 to 1: a step of width
/// 1 / `rate` that begins at `low`.
pub fn smooth(x: f32, low: f32, rate: f32) -> f32 {
    let u = clamp((x - low) * rate, 0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Returns the height of the ground at x and z, `LOWEST` to `HIGHEST`; under water it is
/// that of the bed. Coordinates mean something up to ± 1,000 km.
#[kernel(p in -100000.0..=100000.0)]
pub fn height(p: Vec2) -> f32 {
    coarse_height(p, FULL_DETAIL)
}

/// Returns [`height()`] with `detail` octaves only, a number from 0 to [`FULL_DETAIL`]:
/// smooth where a picture or a wheel has no use for more.
pub fn coarse_height(p: Vec2, detail: f32) -> f32 {
    const PER_RANGE: f32 = 1.0 / RANGE;
    const PER_MOUNTAIN: f32 = 1.0 / MOUNTAIN;
    let range = gradient_noise(p * PER_RANGE, SEED).value;
    let q = warp(p * PER_MOUNTAIN, 0.35, SEED.wrapping_add(1));
    // Where mountains are, and how high.
    let rise = smooth(range, -0.25, 2.0);
    let hills = fbm(q * 2.0, SEED.wrapping_add(11), 2).value;
    let mountains = ridges(q, SEED.wrapping_add(21), detail);
    let y = 260.0 * range + 60.0 * hills + mountains * (90.0 + 1250.0 * rise) - 180.0;
    clamp(y, LOWEST, HIGHEST)
}

/// Returns the upward normal of the ground at x and z, of differences over `step` metres.
#[kernel(p in -100000.0..=100000.0, step in 0.1..=100.0, detail in 0.0..=12.0)]
pub fn normal(p: Vec2, step: f32, detail: f32) -> Vec3 {
    // A loop, so that compilers that copy every call have one to copy.
    let mut falls = Vec2::ZERO;
    let mut side = Vec2::new(-1.0, 0.0);
    let mut number = 0;
    while number < 4 {
        falls -= side * coarse_height(p + side * step, detail);
        side = Vec2::new(-side.y, side.x);
        number += 1;
    }
    normalize_or(Vec3::new(falls.x, 2.0 * step, falls.y), Vec3::Y)
}

/// What covers the ground at a place. The weights sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Snow, on high and flat ground.
    pub snow: f32,
    /// Rock, where it is steep or high.
    pub rock: f32,
    /// Forest, on low ground that is not steep.
    pub forest: f32,
    /// Grass, between the forest and the rock.
    pub grass: f32,
    /// Sand, near the water.
    pub sand: f32,
}

/// Returns what covers the ground at x and z, of its height and its normal.
pub fn cover(p: Vec2, height: f32, normal: Vec3) -> Cover {
    const PATCH: f32 = 1.0 / 450.0;
    let patches = fbm(p * PATCH, SEED.wrapping_add(41), 5).value;
    let y = height + 220.0 * patches;
    let flat = normal.y;
    // Each takes its part of what those before it have left.
    let snow = smooth(y, 780.0, 0.003) * smooth(flat, 0.58, 6.0);
    let mut rest = 1.0 - snow;
    let rock = rest * (1.0 - smooth(flat, 0.70, 7.0) * (1.0 - smooth(y, 650.0, 0.0025)));
    rest -= rock;
    let sand = rest * (1.0 - smooth(height + 8.0 * patches, 3.0, 0.11));
    rest -= sand;
    let forest = rest * smooth(patches, -0.15, 4.0) * (1.0 - smooth(y, 350.0, 0.004));
    Cover {
        snow,
        rock,
        forest,
        grass: rest - forest,
        sand,
    }
}
