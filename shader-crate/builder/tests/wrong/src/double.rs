//! Numbers of 64 bits.

use crate::Words;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn double(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = (f64::from(words[0]) + f64::from(words[1])) as f32;
}
