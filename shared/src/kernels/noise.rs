//! Maps of noise.

use crate::layout::{FORMAT_CODES, Object, TIER_FAST};
use crate::shape_map::Texels;

/// A map whose texels are hashes of their indices and a seed.
pub(super) struct Noise(pub(super) u32);

impl Texels for Noise {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        // Multiplications and shifts of a common integer hash (lowbias32).
        let mut x = index ^ self.0;
        x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
        x = (x ^ (x >> 15)).wrapping_mul(0xd35a_2d97);
        x ^ (x >> 15)
    }
}

/// Noise as f32 distances: the words' low bits as a small number of texels.
pub(super) struct FloatNoise(pub(super) Noise);

impl Texels for FloatNoise {
    #[inline]
    fn word(&self, index: u32) -> u32 {
        let word = self.0.word(index);
        ((word & 0xffff) as i32 as f32 * 0.000_244_140_63 - 4.0).to_bits()
    }
}

/// Returns an object with a map of 32 × 16 texels of noise; `choice` decides their
/// storage.
#[inline]
pub(super) fn noise_object(choice: u32) -> Object {
    let kind = choice & 3;
    Object {
        map_size: [32.0, 16.0],
        map_step: if kind == 0 { 0.0625 } else { 0.000_122_070_31 },
        map_quantum: 0.0625,
        map_reach: 1.5,
        map_bias: if kind == 0 { 64 } else { 0x4000 },
        map_packing: if kind == 0 { 2 } else { 1 },
        map_format: FORMAT_CODES,
        linear_steps: 12,
        binary_steps: 4,
        tier: TIER_FAST,
        ..Object::default()
    }
    .complete()
}
