//! A quotient of literals, which no compiler computes outside a `const`.

use crate::Words;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn constants(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = words[0] * (1.0 / 3.0);
}
