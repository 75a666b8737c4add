//! A division in a library of vectors.

use crate::Words;
use glam::Vec3;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn division_of_vectors(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    let v = Vec3::new(words[0], words[1], words[2]);
    let w = v / words[3];
    words[4] = w.x + w.y + w.z;
}
