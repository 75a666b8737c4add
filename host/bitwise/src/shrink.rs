//! Makes an input that shows a difference simpler.
//!
//! ```
//! use relievo_bitwise::shrink;
//! use relievo_kernel::{Kernel, domain::NUMBER, table};
//!
//! const KERNELS: &[Kernel] = table! {
//!     sum(f32: NUMBER, f32: NUMBER) -> f32 = |a: f32, b: f32| a + b;
//! };
//!
//! // A wrong device: it is wrong where the second number is more than 10.
//! let wrong = |inputs: &[u32]| {
//!     Ok::<_, ()>(inputs.chunks(2).map(|input| f32::from_bits(input[1]) > 10.0).collect())
//! };
//! let input = [123.456_f32, 789.012].map(f32::to_bits);
//! let shrunk = shrink(&KERNELS[0], &input, wrong)?;
//! assert_eq!(shrunk, [0.0_f32, 16.0].map(f32::to_bits));
//! # Ok::<(), ()>(())
//! ```

use crate::generate::contains;
use relievo_kernel::{Argument, Kernel, Kind};

/// Returns a simpler input with a difference: with more zeros, smaller numbers and fewer
/// digits, in the domains of the arguments. `differs` tells of each of some inputs whether
/// it shows a difference; it is called with the inputs' words one after another.
///
/// # Errors
/// Those of `differs`.
pub fn shrink<E>(
    kernel: &Kernel,
    input: &[u32],
    mut differs: impl FnMut(&[u32]) -> Result<Vec<bool>, E>,
) -> Result<Vec<u32>, E> {
    let kinds = kinds(kernel);
    let mut best = input.to_vec();
    loop {
        let mut candidates = candidates(&kinds, &best);
        // The simplest first. Each round is simpler than the last, so the loop ends.
        candidates.sort_by_key(|candidate| complexity(&kinds, candidate));
        let differ = differs(&candidates.concat())?;
        let simpler = candidates
            .into_iter()
            .zip(differ)
            .find(|(_, differs)| *differs);
        match simpler {
            Some((simpler, _)) => best = simpler,
            None => return Ok(best),
        }
    }
}

/// Returns the kind of each word of an input.
pub fn kinds(kernel: &Kernel) -> Vec<Kind> {
    let mut kinds = Vec::new();
    for argument in kernel.arguments {
        collect(argument, &mut kinds);
    }
    kinds
}

fn collect(argument: &Argument, kinds: &mut Vec<Kind>) {
    if argument.parts.is_empty() {
        kinds.extend(std::iter::repeat_n(
            argument.domain.kind,
            argument.words as usize,
        ));
    }
    for part in argument.parts {
        collect(part, kinds);
    }
}

/// Returns inputs that differ from this one in one word, and are simpler.
fn candidates(kinds: &[Kind], input: &[u32]) -> Vec<Vec<u32>> {
    let mut all = Vec::new();
    for (place, (&kind, &word)) in kinds.iter().zip(input).enumerate() {
        let simpler = match kind {
            Kind::UnitVector => Vec::new(),
            // Inputs that the user gives may lie outside.
            Kind::Integer { low, .. } if word > low => {
                vec![low, low + (word - low) / 2, word - 1]
            }
            Kind::Integer { .. } => Vec::new(),
            _ => numbers(word),
        };
        for simpler in simpler {
            if rank(kind, simpler) < rank(kind, word) && contains(kind, &[simpler]) {
                let mut candidate = input.to_vec();
                candidate[place] = simpler;
                all.push(candidate);
            }
        }
    }
    all
}

/// Returns numbers that may be simpler.
fn numbers(word: u32) -> Vec<u32> {
    let x = f32::from_bits(word);
    let mut all = vec![0, 1.0_f32.to_bits(), x.abs().to_bits(), x.trunc().to_bits()];
    // Fewer digits.
    all.extend([0, 2, 4, 8, 12, 16, 20, 22].map(|digits| word & !(0x007f_ffff >> digits)));
    // Closer to 1.
    let exponent = (word >> 23 & 0xff) as i32 - 127;
    all.extend(
        [0, exponent / 2, exponent - exponent.signum()]
            .map(|exponent| word & 0x807f_ffff | ((exponent + 127) as u32) << 23),
    );
    all
}

/// Returns how complicated an input is.
fn complexity(kinds: &[Kind], input: &[u32]) -> u64 {
    let ranks = kinds
        .iter()
        .zip(input)
        .map(|(&kind, &word)| rank(kind, word));
    ranks.sum()
}

/// Returns how complicated a word is: 0 is the simplest number, then come those of few
/// digits and of magnitudes close to 1.
fn rank(kind: Kind, word: u32) -> u64 {
    match kind {
        Kind::UnitVector => 0,
        Kind::Integer { .. } => u64::from(word),
        _ if word << 1 == 0 => 0,
        _ => {
            let digits = 23 - (word & 0x007f_ffff | 0x0080_0000).trailing_zeros();
            let exponent = ((word >> 23 & 0xff) as i32 - 127).unsigned_abs();
            u64::from(1 + (word >> 31) + 8 * digits + exponent)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use relievo_kernel::{FromWords, domain::ANY, table};

    const KERNELS: &[Kernel] = table! {
        any(f32: ANY, [u32; 2]: <[u32; 2] as FromWords>::ARGUMENT.domain) -> f32 = |x: f32, _: [u32; 2]| x;
    };

    proptest! {
        #[test]
        fn an_input_stays_one_that_differs(input in any::<[u32; 3]>(), limit in any::<u32>()) {
            let differs = |input: &[u32]| input[0] & 1 == 0 || input[1] ^ input[2] > limit;
            prop_assume!(differs(&input));
            let shrunk = shrink(&KERNELS[0], &input, |inputs| {
                Ok::<_, ()>(inputs.chunks(3).map(differs).collect())
            }).unwrap();
            prop_assert!(differs(&shrunk), "{input:x?} {shrunk:x?}");
            let kinds = [ANY.kind, Kind::Integer { low: 0, high: 9 }, Kind::Integer { low: 0, high: 9 }];
            prop_assert!(complexity(&kinds, &shrunk) <= complexity(&kinds, &input));
        }
    }

    #[test]
    fn what_differs_everywhere_becomes_zero() {
        let input = [f32::NAN.to_bits(), 7, u32::MAX];
        let all = |inputs: &[u32]| Ok::<_, ()>(vec![true; inputs.len() / 3]);
        assert_eq!(shrink(&KERNELS[0], &input, all).unwrap(), [0; 3]);
    }

    #[test]
    fn integers_below_their_domain_stay_as_they_are() {
        const KERNEL: &[Kernel] = table! {
            count(u32: relievo_kernel::Domain::integer("count", 3, 9)) -> u32 = |n: u32| n;
        };
        let all = |inputs: &[u32]| Ok::<_, ()>(vec![true; inputs.len()]);
        assert_eq!(shrink(&KERNEL[0], &[1], all).unwrap(), [1]);
        assert_eq!(shrink(&KERNEL[0], &[8], all).unwrap(), [3]);
    }
}
