//! Storage buffers of compute shaders as sources and sinks of words.

use crate::{Sink, Source};
use spirv_std::arch::IndexUnchecked;

/// Arguments in a storage buffer.
pub struct Input<'a> {
    words: &'a [u32],
    at: u32,
}

impl<'a> Input<'a> {
    /// Reads from word `at` on.
    ///
    /// # Safety
    /// The words that are read lie in the buffer: a checked index would ask for its length,
    /// and drop results silently.
    #[inline]
    pub unsafe fn new(words: &'a [u32], at: u32) -> Input<'a> {
        Input { words, at }
    }
}

impl Source for Input<'_> {
    #[inline]
    fn next(&mut self) -> u32 {
        // SAFETY: promised by the caller of `new`.
        let word = unsafe { *self.words.index_unchecked(self.at as usize) };
        self.at += 1;
        word
    }
}

/// Results in a storage buffer.
pub struct Output<'a> {
    words: &'a mut [u32],
    at: u32,
}

impl<'a> Output<'a> {
    /// Writes from word `at` on.
    ///
    /// # Safety
    /// The words that are written lie in the buffer.
    #[inline]
    pub unsafe fn new(words: &'a mut [u32], at: u32) -> Output<'a> {
        Output { words, at }
    }
}

impl Sink for Output<'_> {
    #[inline]
    fn put(&mut self, word: u32) {
        // SAFETY: promised by the caller of `new`.
        unsafe { *self.words.index_unchecked_mut(self.at as usize) = word };
        self.at += 1;
    }
}
