//! Noise of lattice points in the plane: a hash, gradient noise, and sums of octaves.

use glam::{UVec3, Vec2};
use relievo_exact::{abs, clamp, div, floor};
use relievo_kernel::{ToWords, kernel};

/// Coordinates are limited to ± this many cells of the lattice.
pub const FARTHEST_CELL: f32 = 1_048_576.0;

/// From one octave to the next the plane is turned by atan(3/4) and shrunk to half, as a
/// product of complex numbers: the lattices of two octaves have no direction in common.
const TURN: Vec2 = Vec2::new(1.6, 1.2);

/// A value with its derivative.
#[derive(Clone, Copy, Debug, PartialEq, ToWords)]
pub struct Sample {
    /// The value.
    pub value: f32,
    /// The derivative by x and by y.
    pub slope: Vec2,
}

/// Returns three random words of three words: `pcg3d` of Jarzynski and Olano, "Hash
/// Functions for GPU Rendering", Journal of Computer Graphics Techniques 9 (3), 2020.
///
/// ```
/// use glam::UVec3;
/// use terrain::noise::hash;
///
/// assert_ne!(hash(UVec3::new(1, 2, 3)), hash(UVec3::new(2, 1, 3)));
/// ```
#[kernel]
pub fn hash(v: UVec3) -> UVec3 {
    let mut x = v.x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let mut y = v.y.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let mut z = v.z.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x = x.wrapping_add(y.wrapping_mul(z));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    UVec3::new(x, y, z)
}

/// Returns the upper half of a random word as a number between −1 and 1.
fn signed(word: u32) -> f32 {
    const SCALE: f32 = 1.0 / 65_536.0;
    ((word >> 16) as f32 * 2.0 + 1.0) * SCALE - 1.0
}

/// Returns the gradient at a point of the lattice.
fn gradient(x: i32, y: i32, seed: u32) -> Vec2 {
    let words = hash(UVec3::new(x as u32, y as u32, seed));
    Vec2::new(signed(words.x), signed(words.y))
}

/// Returns the part of `x` above the whole number `cell`, 0 to 1, in steps of 2⁻²⁰: its
/// powers are 0 or far from denormal numbers.
fn offset(x: f32, cell: f32) -> f32 {
    ((x - cell) + 8.0) - 8.0
}

/// Returns gradient noise (Perlin, "Improving Noise", 2002), −1 to 1, with its derivative
/// (Quilez, "Gradient noise derivatives", 2017). Two derivatives are continuous.
#[kernel(p in -100.0..=100.0)]
pub fn gradient_noise(p: Vec2, seed: u32) -> Sample {
    let px = clamp(p.x, -FARTHEST_CELL, FARTHEST_CELL);
    let py = clamp(p.y, -FARTHEST_CELL, FARTHEST_CELL);
    let (cell_x, cell_y) = (floor(px), floor(py));
    let (fx, fy) = (offset(px, cell_x), offset(py, cell_y));
    let (x, y) = (cell_x as i32, cell_y as i32);

    let g00 = gradient(x, y, seed);
    let g10 = gradient(x + 1, y, seed);
    let g01 = gradient(x, y + 1, seed);
    let g11 = gradient(x + 1, y + 1, seed);
    let v00 = g00.dot(Vec2::new(fx, fy));
    let v10 = g10.dot(Vec2::new(fx - 1.0, fy));
    let v01 = g01.dot(Vec2::new(fx, fy - 1.0));
    let v11 = g11.dot(Vec2::new(fx - 1.0, fy - 1.0));

    // The fade 6f⁵ − 15f⁴ + 10f³ and its derivative 30f²(f − 1)².
    let wx = fx * fx * fx * (fx * (fx * 6.0 - 15.0) + 10.0);
    let wy = fy * fy * fy * (fy * (fy * 6.0 - 15.0) + 10.0);
    let dx = 30.0 * fx * fx * (fx - 1.0) * (fx - 1.0);
    let dy = 30.0 * fy * fy * (fy - 1.0) * (fy - 1.0);

    let (along_x, along_y, both) = (v10 - v00, v01 - v00, (v00 - v10) + (v11 - v01));
    let gradients =
        g00 + (g10 - g00) * wx + (g01 - g00) * wy + ((g00 - g10) + (g11 - g01)) * (wx * wy);
    Sample {
        value: v00 + wx * along_x + wy * along_y + wx * wy * both,
        slope: gradients + Vec2::new(dx * (along_x + wy * both), dy * (along_y + wx * both)),
    }
}

/// Returns the product of two complex numbers.
fn product(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// Returns fractal Brownian motion: the sum of `octaves` of gradient noise, each of half the
/// size and height of the one before, with its derivative. Less than 2 in magnitude.
#[kernel(p in -100.0..=100.0, octaves in 0..=16)]
pub fn fbm(p: Vec2, seed: u32, octaves: u32) -> Sample {
    let mut sum = Sample {
        value: 0.0,
        slope: Vec2::ZERO,
    };
    let mut turn = Vec2::new(1.0, 0.0);
    let mut amplitude = 1.0;
    let mut octave = 0;
    while octave < octaves {
        let noise = gradient_noise(product(p, turn), seed.wrapping_add(octave));
        sum.value += amplitude * noise.value;
        // The chain rule: turned back, and as much steeper as the octave is smaller.
        sum.slope += product(noise.slope, Vec2::new(turn.x, -turn.y)) * amplitude;
        turn = product(turn, TURN);
        amplitude *= 0.5;
        octave += 1;
    }
    sum
}

/// Returns `p` moved by up to 2 · `strength` along a vector of fractal Brownian motion
/// (Quilez, "Domain warping", 2002).
pub fn warp(p: Vec2, strength: f32, seed: u32) -> Vec2 {
    let x = fbm(p, seed, 2).value;
    let y = fbm(p, seed.wrapping_add(100), 2).value;
    p + Vec2::new(x, y) * strength
}

/// Returns ridges of `detail` octaves, 0 to 2; a fraction fades the last octave in.
///
/// Octaves are folded at 0 to sharp ridges (Musgrave's ridged multifractal, in "Texturing
/// and Modeling", 2003), and count the less, the steeper the larger ones are: slopes look
/// washed, and valleys are flat (Quilez, "Value noise derivatives", 2008).
#[kernel(p in -100.0..=100.0, detail in 0.0..=16.0)]
pub fn ridges(p: Vec2, seed: u32, detail: f32) -> f32 {
    const EROSION: f32 = 0.45;
    let mut q = p;
    let mut slope = Vec2::ZERO;
    let mut sum = 0.0;
    let mut amplitude = 1.0;
    let mut rest = detail;
    let mut octave = 0;
    while rest > 0.0 && octave < 16 {
        let noise = gradient_noise(q, seed.wrapping_add(octave));
        let ridge = 1.0 - abs(noise.value);
        slope += noise.slope;
        let share = amplitude * clamp(rest, 0.0, 1.0);
        sum += div(share * ridge * ridge, 1.0 + EROSION * slope.dot(slope));
        q = product(q, TURN);
        amplitude *= 0.5;
        rest -= 1.0;
        octave += 1;
    }
    sum
}
