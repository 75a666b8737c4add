//! A function that calls itself.

use crate::Words;
use spirv_std::spirv;

/// Returns n!.
fn factorial(n: f32) -> f32 {
    if n > 1.0 { n * factorial(n - 1.0) } else { 1.0 }
}

#[spirv(compute(threads(1)))]
pub fn recursion(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = factorial(words[0]);
}
