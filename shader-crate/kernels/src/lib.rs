//! A compute shader for each canary of `relievo_kernel` and each kernel of
//! `relievo_shared`. Bindings of group 0: 0 words of the arguments, 1 words of the
//! results.
#![cfg_attr(target_arch = "spirv", no_std)]

use relievo_kernel::{Sink, Source, canary, entry_points, for_each_canary};
use relievo_shared::kernels::*;
use relievo_shared::{arithmetic, for_each_kernel, kernels};
use spirv_std::arch::IndexUnchecked;
use spirv_std::glam::UVec3;
use spirv_std::spirv;

/// Arguments in a storage buffer.
struct Input<'a> {
    words: &'a [u32],
    at: u32,
}

impl Source for Input<'_> {
    #[inline]
    fn next(&mut self) -> u32 {
        // SAFETY: the host binds the words of all invocations' arguments.
        let word = unsafe { *self.words.index_unchecked(self.at as usize) };
        self.at += 1;
        word
    }
}

/// Results in a storage buffer.
struct Output<'a> {
    words: &'a mut [u32],
    at: u32,
}

impl Sink for Output<'_> {
    #[inline]
    fn put(&mut self, word: u32) {
        // SAFETY: the host binds room for the words of all invocations' results.
        unsafe { *self.words.index_unchecked_mut(self.at as usize) = word };
        self.at += 1;
    }
}

for_each_canary!(entry_points);
for_each_kernel!(entry_points);
