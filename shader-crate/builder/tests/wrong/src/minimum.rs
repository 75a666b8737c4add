//! Functions of the driver that look harmless.

use crate::Words;
use spirv_std::num_traits::Float;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn minimum(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = words[0].min(words[1]).abs();
    words[4] = words[2].floor();
}
