//! A division of integers by a variable.

use spirv_std::spirv;

#[spirv(compute(threads(1)))]
pub fn integer_division(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut [u32; 3]) {
    words[2] = words[0] / words[1];
}
