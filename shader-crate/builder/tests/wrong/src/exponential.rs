//! An exponential at three places, one of them in another function.

use crate::Words;
use spirv_std::num_traits::Float;
use spirv_std::spirv;

/// Returns the density at a depth.
fn density(depth: f32) -> f32 {
    (-depth).exp()
}

#[spirv(compute(threads(1)))]
pub fn exponential(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = words[0].exp() + words[1].exp();
    words[4] = density(words[2]);
}
