//! The device's division, beside a correct one and twice.

use crate::Words;
use relievo_exact as exact;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn division(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = exact::div(words[0], words[1]);
    words[4] = words[0] / words[1];
    words[5] = 1.0 / words[2];
}
