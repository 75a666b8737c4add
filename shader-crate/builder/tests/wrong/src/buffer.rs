//! A checked index of a buffer of any length.

use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn buffer(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut [f32]) {
    words[3] = words[words[0] as usize];
}
