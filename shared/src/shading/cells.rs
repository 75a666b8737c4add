//! Cells of the pattern, its connected pieces: each brick of a wall has random numbers of its own.
//!
//! A word of the map of cells is the number of the nearest cell (20 bits), and how many repeats
//! along u and v that cell's own repeat lies before the texel's, each plus 1 (2 bits).

use super::layout::{Finish, Image};
use crate::arithmetic::{clamp, floor, floor_to_int};
use crate::shape_map::Texels;
use crate::{Real, Vec2};

/// Bits of a cell's number.
pub const NUMBER_BITS: u32 = 20;

/// Returns a random number that follows from `x` (O'Neill, "PCG", 2014, as a hash).
#[inline]
pub fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Returns the number of 0…1 of a hash.
#[inline]
pub fn unit(hash: u32) -> Real {
    const STEP: Real = 1.0 / 16_777_216.0;
    (hash >> 8) as i32 as Real * STEP
}

/// Returns the place of `x` (repeats) in a row of `size` texels.
#[inline]
fn texel(x: Real, size: u32) -> u32 {
    let last = size as i32 - 1;
    // Of a number that is too large to have a fraction, rounding is all that is left.
    let index = floor_to_int(clamp(x - floor(x), 0.0, 1.0) * (size as i32 as Real));
    (if index > last { last } else { index }) as u32
}

/// Returns the hash of the cell at `uv`, repeats of the whole mesh.
#[inline]
pub fn cell<T: Texels + ?Sized>(words: &T, finish: &Finish, uv: Vec2) -> u32 {
    let Image {
        first,
        width,
        height,
        ..
    } = finish.cells;
    let word = words.word(first + texel(uv.y, height) * width + texel(uv.x, width));
    let number = word & ((1 << NUMBER_BITS) - 1);
    let before = |shift: u32| ((word >> (NUMBER_BITS + shift)) & 3) as i32 - 1;
    // The repeats of a closed mesh begin again.
    let wrapped = |x: Real, before: i32, period: Real, inverse: Real| {
        let index = floor(x) - before as Real;
        if period > 0.0 {
            index - period * floor((index + 0.5) * inverse)
        } else {
            index
        }
    };
    let [inverse_u, inverse_v] = finish.inverse_repeat;
    let column = floor_to_int(wrapped(uv.x, before(0), finish.period[0], inverse_u)) as u32;
    let row = floor_to_int(wrapped(uv.y, before(2), finish.period[1], inverse_v)) as u32;
    hash(hash(hash(number ^ hash(finish.seed)) ^ column) ^ row)
}
