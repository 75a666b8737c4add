//! What an exact program may do. The builder accepts it.

use crate::Words;
use glam::Vec3;
use relievo_shared::arithmetic;
use spirv_std::arch::IndexUnchecked;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn right(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    let v = Vec3::new(words[0], words[1], words[2]);
    words[3] = arithmetic::div(v.x * v.y + v.z, v.y);
    words[4] = arithmetic::sqrt(v.dot(v)) * (1.0 / 3.0);
    let index = (words[0] as u32 & 7) as usize;
    // SAFETY: at most 7, of 12.
    words[5] = unsafe { *words.index_unchecked(index) };
    let w = Vec3::new(
        arithmetic::div(v.x, v.z),
        arithmetic::div(v.y, v.z),
        arithmetic::div(v.z, v.z),
    );
    words[6] = w.x + w.y + w.z;
    words[7] = words[0].min(words[1]);
}
