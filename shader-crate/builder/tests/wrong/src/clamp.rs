//! A function of the standard library that panics.

use crate::Words;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn clamp(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = words[0].clamp(words[1], words[2]);
}
