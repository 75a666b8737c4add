//! A product of 64 bits.

use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn wide(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut [u32; 3]) {
    words[2] = ((u64::from(words[0]) * u64::from(words[1])) >> 32) as u32;
}
