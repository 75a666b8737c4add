//! Inputs as words.

use relievo_bitwise::{Generator, Recorded};
use relievo_kernel::Kernel;

/// Returns `count` inputs of the function's domains.
#[track_caller]
pub(crate) fn generated(kernel: &Kernel, seed: u64, count: usize) -> Vec<u32> {
    let generator = Generator::new(kernel, &Recorded::new(), seed);
    let generator = generator.unwrap_or_else(|error| panic!("{error}"));
    let mut inputs = vec![0; count * kernel.input_words as usize];
    generator.fill(0, &mut inputs);
    inputs
}

/// Panics if these are not whole inputs.
#[track_caller]
pub(crate) fn check(kernel: &Kernel, inputs: &[u32]) {
    let words = kernel.input_words as usize;
    assert!(
        !inputs.is_empty() && inputs.len().is_multiple_of(words.max(1)),
        "{}: {} words are not one or more inputs of {words} words",
        kernel.name,
        inputs.len()
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_kernel::{domain::NUMBER, table};

    const SUM: &[Kernel] = table! {
        sum(f32: NUMBER, f32: NUMBER) -> f32 = |a: f32, b: f32| a + b;
    };

    #[test]
    fn generated_inputs_are_whole() {
        let inputs = generated(&SUM[0], 1, 5);
        assert_eq!(inputs.len(), 10);
        check(&SUM[0], &inputs);
    }

    #[test]
    #[should_panic(expected = "sum: 3 words are not one or more inputs of 2 words")]
    fn incomplete_inputs_are_refused() {
        check(&SUM[0], &[1, 2, 3]);
    }
}
