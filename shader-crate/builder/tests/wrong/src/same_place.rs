//! A division that has the line and the column of a correct one.

use crate::Words;
use relievo_exact as exact;
use spirv_std::spirv;

macro_rules! both {
    ($a:expr, $b:expr) => {
        exact::div($a, $b) / $b
    };
}

#[spirv(compute(threads(1)))]
pub fn same_place(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    words[3] = both!(words[0], words[1]);
}
