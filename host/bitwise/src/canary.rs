//! Small kernels that show whether a device computes f32 arithmetic exactly.
//!
//! ```
//! use relievo_bitwise::{Signature, Told};
//!
//! let told = Told {
//!     name: "multiply_add",
//!     required: true,
//!     tells: "it fuses a·b + c",
//!     words: 4096,
//!     different: 3,
//! };
//! let signature = Signature { told: vec![told] };
//! assert!(!signature.is_exact());
//! assert_eq!(signature.describe(), "multiply_add differs");
//! ```

use crate::check::{Plan, compare_kernel};
use crate::generate::Recorded;
use crate::{DeviceError, Runner};
use relievo_kernel::Kernel;

/// Number of inputs of each canary.
const INPUTS: u64 = 4096;
const SEED: u64 = 1;

/// A kernel that shows one property of a device.
#[derive(Clone, Copy, Debug)]
pub struct Canary {
    /// The kernel.
    pub kernel: Kernel,
    /// Whether a difference means that the device is not exact.
    pub required: bool,
    /// Meaning of a difference, as a text for people.
    pub tells: &'static str,
}

/// Result of a canary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Told {
    /// The kernel's name.
    pub name: &'static str,
    /// Whether a difference means that the device is not exact.
    pub required: bool,
    /// Meaning of a difference, as a text for people.
    pub tells: &'static str,
    /// Number of words compared.
    pub words: u64,
    /// Number of words that differ.
    pub different: u64,
}

/// Results of all canaries on a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// One result per canary, in their order.
    pub told: Vec<Told>,
}

impl Signature {
    /// Runs each canary on a few thousand inputs.
    ///
    /// # Errors
    /// Those of [`compare_kernel`].
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

    /// Returns whether there are required canaries and none of them differs.
    pub fn is_exact(&self) -> bool {
        let mut required = self.told.iter().filter(|told| told.required).peekable();
        required.peek().is_some() && required.all(|told| told.different == 0)
    }

    /// Returns whether the canary `name` is there and does not differ.
    pub fn passes(&self, name: &str) -> bool {
        let is_passed = |told: &Told| told.name == name && told.different == 0;
        self.told.iter().any(is_passed)
    }

    /// Returns all results in one line: "multiply_add exact, denormal differs".
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
    fn gpu_a_signature_distinguishes_right_from_wrong() {
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
