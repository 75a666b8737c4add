//! Any bits, as arguments of functions that take every number.

use super::Distribution;
use super::random::Random;

/// An odd number: its multiples modulo 2³² are all words, in an order that looks random.
const STEP: u32 = 0x9e37_79b1;

/// Numbers where functions end or change: zeros, the smallest and the largest numbers,
/// infinities, NaN, 1, π/4, and 2²³.
const EDGES: [u32; 12] = [
    0,
    1,
    0x007f_ffff,
    0x0080_0000,
    0x7f7f_ffff,
    0x7f80_0000,
    0x7fc0_0000,
    0x3f80_0000,
    0x3f00_0000,
    0x3f49_0fdb,
    0x4b00_0000,
    0x42fe_0000,
];

/// Returns word `index` of all words.
pub(super) fn count(index: u64) -> u32 {
    (index as u32).wrapping_mul(STEP)
}

/// Draws a word; as a number: any, of a moderate magnitude, or an edge case.
pub(super) fn draw(distribution: Distribution, random: &mut Random) -> u32 {
    let word = random.up_to(u32::MAX);
    match distribution {
        Distribution::Bits => word,
        // 2⁻¹⁶…2¹⁶
        Distribution::Value | Distribution::Recorded => {
            word & 0x807f_ffff | (111 + random.up_to(31)) << 23
        }
        Distribution::Edges => {
            let near = random
                .pick(&EDGES)
                .wrapping_add(random.up_to(4))
                .wrapping_sub(2);
            near ^ (word & 0x8000_0000)
        }
    }
}
