//! A checked index of an array.

use crate::Words;
use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn array(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = words[(words[0] as u32 & 7) as usize];
}
