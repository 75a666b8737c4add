//! Compares the GPU and CPU results of a kernel.
//!
//! ```
//! use relievo_bitwise::evaluate;
//! use relievo_kernel::{Domain, Kernel, Kind, table};
//!
//! const LENGTH: Domain = Domain::new("length", Kind::Magnitude { low: 1e-9, high: 1e9 });
//! const KERNELS: &[Kernel] = table! {
//!     square(f32: LENGTH) -> f32 = |x: f32| x * x;
//! };
//!
//! // The CPU side alone.
//! let mut words = [0];
//! evaluate(&KERNELS[0], &[3_f32.to_bits()], &mut words);
//! assert_eq!(words, [9_f32.to_bits()]);
//! ```

use crate::compare::{Batch, Tally};
use crate::generate::{Generator, Recorded};
use crate::{DeviceError, Runner};
use rayon::prelude::*;
use relievo_kernel::Kernel;

/// Number of inputs of a batch, if the device takes so many at a time.
const BATCH: u64 = 1 << 18;

/// Number of inputs that a thread evaluates at a time.
const CHUNK: usize = 1024;

/// The inputs of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// Number of inputs.
    pub inputs: u64,
    /// Seed of their generator.
    pub seed: u64,
    /// Recorded values, which a quarter of the inputs are taken from.
    pub recorded: &'a Recorded,
}

/// Runs `kernel` on the inputs of `plan` on GPU and CPU at the same time, and
/// counts the words that differ. `progress` is called with the number of inputs
/// done.
///
/// # Errors
/// [`DeviceError::Domain`] if a domain is invalid, and those of
/// [`Runner::submit`].
pub fn compare_kernel(
    runner: &mut Runner,
    kernel: &Kernel,
    plan: &Plan,
    progress: &dyn Fn(u64),
) -> Result<Tally, DeviceError> {
    let generator = Generator::new(kernel, plan.recorded, plan.seed)?;
    let (input_words, output_words) = (kernel.input_words as usize, kernel.output_words as usize);
    if generator.input_words() != input_words {
        return Err(DeviceError::Kernel {
            kernel: kernel.name,
            message: format!(
                "its arguments have {} words, and it reads {input_words}; make it with relievo_kernel::table",
                generator.input_words()
            ),
        });
    }
    let batch = BATCH.min(runner.capacity(kernel)? as u64);
    let (mut inputs, mut gpu, mut cpu) = (Vec::new(), Vec::new(), Vec::new());
    let mut tally = Tally::default();
    let mut done = 0;
    while done < plan.inputs {
        let count = batch.min(plan.inputs - done) as usize;
        inputs.resize(count * input_words, 0);
        cpu.resize(count * output_words, 0);
        generator.fill(done, &mut inputs);
        let pending = runner.submit(kernel, &inputs)?;
        evaluate(kernel, &inputs, &mut cpu);
        pending.collect(&mut gpu)?;
        tally.merge(Tally::of(&Batch {
            first: done,
            inputs: &inputs,
            input_words,
            gpu: &gpu,
            cpu: &cpu,
            output_words,
        }));
        done += count as u64;
        progress(done);
    }
    Ok(tally)
}

/// Runs `kernel` on all cores of the CPU: reads `input_words` words of `inputs`
/// and writes `output_words` words to `outputs` per input.
pub fn evaluate(kernel: &Kernel, inputs: &[u32], outputs: &mut [u32]) {
    // Chunks must not be empty, even for a kernel without words.
    let chunk = |words: u32| CHUNK * words.max(1) as usize;
    inputs
        .par_chunks(chunk(kernel.input_words))
        .zip(outputs.par_chunks_mut(chunk(kernel.output_words)))
        .for_each(|(inputs, outputs)| (kernel.run)(inputs, outputs));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{FUSED, OFF_BY_ONE, SILENT, TABLE, runners, untouched_runners};
    use std::cell::Cell;

    const INPUTS: u64 = 600_001;

    fn plan(recorded: &Recorded) -> Plan<'_> {
        Plan {
            inputs: INPUTS,
            seed: 11,
            recorded,
        }
    }

    /// Returns the differences between `right` and `twin`, computed on the CPU
    /// alone, and the inputs.
    fn expected(right: &Kernel, twin: &Kernel) -> (Tally, Vec<u32>) {
        let (input_words, output_words) = (right.input_words as usize, right.output_words as usize);
        let generator = Generator::new(right, &Recorded::new(), 11).expect("domains");
        let mut inputs = vec![0; INPUTS as usize * input_words];
        generator.fill(0, &mut inputs);
        let results = [right, twin].map(|kernel| {
            let mut words = vec![0; INPUTS as usize * output_words];
            (kernel.run)(&inputs, &mut words);
            words
        });
        let mut tally = Tally::default();
        for number in 0..INPUTS as usize {
            let output = number * output_words..(number + 1) * output_words;
            tally.add(
                number as u64,
                &inputs[number * input_words..(number + 1) * input_words],
                &results[0][output.clone()],
                &results[1][output],
            );
        }
        (tally, inputs)
    }

    #[test]
    fn gpu_a_right_kernel_has_no_differences() {
        let recorded = Recorded::from([("factor".to_string(), vec![1.5_f32.to_bits()])]);
        let seen = Cell::new(0);
        // naga does not pass on the NoContraction of the module.
        let exact = untouched_runners()
            .into_iter()
            .map(|runner| (runner, TABLE));
        let everywhere = runners().into_iter().map(|runner| (runner, &TABLE[1..]));
        for (mut runner, kernels) in exact.chain(everywhere) {
            for kernel in kernels {
                let tally = compare_kernel(&mut runner, kernel, &plan(&recorded), &|done| {
                    seen.set(done);
                })
                .expect("a comparison");
                assert!(tally.is_exact(), "{} {:?}", kernel.name, tally.first);
                assert_eq!(tally.words, INPUTS * u64::from(kernel.output_words));
                assert_eq!(seen.get(), INPUTS);
            }
        }
    }

    #[test]
    fn gpu_wrong_twins_are_found_with_their_inputs() {
        let exact = untouched_runners()
            .into_iter()
            .map(|runner| (runner, &TABLE[0], &FUSED[0]));
        let everywhere = runners()
            .into_iter()
            .map(|runner| (runner, &TABLE[2], &OFF_BY_ONE[0]));
        for (mut runner, right, twin) in exact.chain(everywhere) {
            let (expected, inputs) = expected(right, twin);
            assert!(expected.different > 1000, "{}", twin.name);
            let recorded = Recorded::new();
            let tally =
                compare_kernel(&mut runner, twin, &plan(&recorded), &|_| ()).expect("a comparison");
            assert_eq!(tally, expected, "{}", twin.name);
            for difference in &tally.first {
                let words = difference.input.len();
                let start = difference.index as usize * words;
                assert_eq!(difference.input, inputs[start..start + words]);
                let mut results = [[0], [0]];
                (right.run)(&difference.input, &mut results[0]);
                (twin.run)(&difference.input, &mut results[1]);
                assert_eq!([[difference.gpu], [difference.cpu]], results);
            }
        }
    }

    #[test]
    fn gpu_a_shader_that_writes_nothing_is_found() {
        for mut runner in runners() {
            let recorded = Recorded::new();
            let tally = compare_kernel(&mut runner, &SILENT[0], &plan(&recorded), &|_| ())
                .expect("a comparison");
            assert_eq!(tally.different, tally.words);
        }
    }

    #[test]
    fn gpu_a_kernel_whose_words_do_not_fit_is_refused() {
        for mut runner in runners() {
            let mut kernel = TABLE[0];
            kernel.input_words = 2;
            let recorded = Recorded::new();
            let error = compare_kernel(&mut runner, &kernel, &plan(&recorded), &|_| ());
            let message = error.unwrap_err().to_string();
            assert!(message.contains("\"multiply_add\""), "{message}");
        }
    }

    #[test]
    fn all_cores_evaluate_what_one_does() {
        let kernel = &TABLE[1];
        let inputs: Vec<u32> = (0..20_002).map(|n| (n as f32 * 0.5).to_bits()).collect();
        let mut outputs = [vec![0; 20_002], vec![0; 20_002]];
        evaluate(kernel, &inputs, &mut outputs[0]);
        (kernel.run)(&inputs, &mut outputs[1]);
        assert_eq!(outputs[0], outputs[1]);
        assert!(outputs[0].iter().any(|&word| word != 0));
    }
}
