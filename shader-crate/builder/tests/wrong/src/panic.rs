//! An assertion.

use crate::Words;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn panic(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    assert!(words[0] > 0.0, "the first number must be positive");
    words[3] = words[0] + words[1];
}
