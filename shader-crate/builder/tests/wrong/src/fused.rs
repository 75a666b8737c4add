//! A fused multiply-add.

use crate::Words;
use spirv_std::num_traits::Float;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn fused(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = words[0].mul_add(words[1], words[2]);
}
