//! Small kernels that tell what a device does to f32 arithmetic.

use crate::check::{Plan, compare_kernel};
use crate::generate::Recorded;
use crate::{DeviceError, Runner};
use relievo_kernel::Kernel;

/// Inputs of each canary.
const INPUTS: u64 = 4096;
const SEED: u64 = 1;

/// A kernel that tells something about a device.
#[derive(Clone, Copy, Debug)]
pub struct Canary {
    /// What is run.
    pub kernel: Kernel,
    /// Whether the device is not exact if this differs.
    pub required: bool,
    /// What a difference means, for a person.
    pub tells: &'static str,
}

/// What a canary has told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Told {
    /// The kernel's name.
    pub name: &'static str,
    /// Whether the device is not exact if this differs.
    pub required: bool,
    /// What a difference means.
    pub tells: &'static str,
    /// Words compared.
    pub words: u64,
    /// Words that differ.
    pub different: u64,
}

/// What all canaries have told of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// In the order of the canaries.
    pub told: Vec<Told>,
}

impl Signature {
    /// Runs each canary on a few thousand inputs.
    ///
    /// # Errors
    /// As [`compare_kernel`].
    pub fn take(runner: &mut Runner, canaries: &[Canary]) -> Result<Signature, DeviceError> {
        let plan = Plan {
            inputs: INPUTS,
            seed: SEED,
            recorded: &Recorded::new(),
        };
        let told = canaries
            .iter()
            .map(|canary| {
                let tally = compare_kernel(runner, &canary.kernel, &plan, &|_| ())?;
                Ok(Told {
                    name: canary.kernel.name,
                    required: canary.required,
                    tells: canary.tells,
                    words: tally.words,
                    different: tally.different,
                })
            })
            .collect::<Result<_, DeviceError>>()?;
        Ok(Signature { told })
    }

    /// Whether there are required canaries, and none of them differs.
    pub fn is_exact(&self) -> bool {
        let mut required = self.told.iter().filter(|told| told.required).peekable();
        required.peek().is_some() && required.all(|told| told.different == 0)
    }

    /// All canaries in one line: "multiply_add exact, denormal differs".
    pub fn describe(&self) -> String {
        let told: Vec<String> = self
            .told
            .iter()
            .map(|told| {
                let what = if told.different == 0 {
                    "exact"
                } else {
                    "differs"
                };
                format!("{} {what}", told.name)
            })
            .collect();
        told.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{OFF_BY_ONE, TABLE, runners};

    #[test]
    fn gpu_a_signature_tells_right_from_wrong() {
        let canary = |kernel, required| Canary {
            kernel,
            required,
            tells: "a constant is another",
        };
        let right = canary(TABLE[1], true);
        for mut runner in runners() {
            let mut take = |wrong_is_required| {
                let wrong = canary(OFF_BY_ONE[0], wrong_is_required);
                Signature::take(&mut runner, &[right, wrong]).expect("a signature")
            };
            let signature = take(false);
            assert!(signature.is_exact());
            assert_eq!(signature.describe(), "product_and_sum exact, scale differs");
            assert_eq!(signature.told[0].words, 2 * INPUTS);
            assert!(signature.told[1].different > 1000);
            assert!(!take(true).is_exact());
            let empty = Signature::take(&mut runner, &[]).expect("a signature");
            assert!(!empty.is_exact(), "nothing was required");
        }
    }
}
