//! An option that may be empty.

use crate::Words;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn unwrap(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    let positive = if words[0] > 0.0 { Some(words[0]) } else { None };
    words[3] = positive.unwrap();
}
