//! What an exact program may do. The builder accepts it.

use crate::Words;
use glam::Vec3;
use relievo_exact as exact;
use spirv_std::arch::IndexUnchecked;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn right(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    let v = Vec3::new(words[0], words[1], words[2]);
    words[3] = exact::div(v.x * v.y + v.z, v.y);
    const THIRD: f32 = 1.0 / 3.0;
    words[4] = exact::sqrt(v.dot(v)) * THIRD;
    words[8] = exact::sin(words[0]) + exact::pow(words[1], words[2]);
    let index = (words[0] as u32 & 7) as usize;
    // SAFETY: at most 7, of 12.
    words[5] = unsafe { *words.index_unchecked(index) };
    let w = Vec3::new(
        exact::div(v.x, v.z),
        exact::div(v.y, v.z),
        exact::div(v.z, v.z),
    );
    words[6] = w.x + w.y + w.z;
    words[7] = words[0].min(words[1]);
}
