//! Storage buffers of compute shaders as sources and sinks of words.

use crate::{FromWords, Sink, Source, ToWords};
use spirv_std::arch::IndexUnchecked;

/// Calls a function on input number `id`, of `input_words` words, and writes its result to
/// the place of that number.
///
/// # Safety
/// Both buffers have the words of this number.
#[inline]
pub unsafe fn run<R: ToWords>(
    id: u32,
    input_words: u32,
    inputs: &[u32],
    outputs: &mut [u32],
    function: impl FnOnce(&mut Input) -> R,
) {
    // SAFETY: required of the caller.
    let (mut source, mut sink) = unsafe {
        (
            Input::new(inputs, id * input_words),
            Output::new(outputs, id * R::WORDS),
        )
    };
    function(&mut source).write(&mut sink);
}

/// Reads a value from the start of a storage buffer.
///
/// # Safety
/// The buffer has the words of the value.
#[inline]
pub unsafe fn load<T: FromWords>(words: &[u32]) -> T {
    // SAFETY: required of the caller.
    T::read(&mut unsafe { Input::new(words, 0) })
}

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
