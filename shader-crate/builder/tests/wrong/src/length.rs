//! A square root in a library of vectors, beside a correct one.

use crate::Words;
use glam::Vec3;
use relievo_exact as exact;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn length(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    let v = Vec3::new(words[0], words[1], words[2]);
    words[3] = v.length();
    words[4] = exact::sqrt(v.dot(v));
}
