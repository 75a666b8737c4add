//! A division in a file that has the name of one that may divide.

use crate::Words;
use spirv_std::spirv;

/// Returns a / b.
fn native_div(a: f32, b: f32) -> f32 {
    a / b
}

#[spirv(compute(threads(1)))]
pub fn native(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = native_div(words[0], words[1]);
}
