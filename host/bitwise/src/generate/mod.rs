//! Generates inputs for kernels from the domains of their arguments.
//!
//! Each input depends only on the seed and its index, not on threads or batches.
//! Four distributions alternate ([`Distribution`]).
//!
//! ```
//! use relievo_bitwise::{Generator, Recorded, contains};
//! use relievo_kernel::{Domain, Kernel, Kind, table};
//!
//! const LENGTH: Domain = Domain::new("length", Kind::NonZero { low: 1e-9, high: 1e9 });
//! const KERNELS: &[Kernel] = table! {
//!     square(f32: LENGTH) -> f32 = |x: f32| x * x;
//! };
//!
//! # fn main() -> Result<(), relievo_bitwise::DomainError> {
//! let generator = Generator::new(&KERNELS[0], &Recorded::new(), 7)?;
//! let mut inputs = [0; 100];
//! generator.fill(0, &mut inputs);
//! assert!(contains(LENGTH.kind, &inputs));
//!
//! let mut later = [0; 50];
//! generator.fill(50, &mut later);
//! assert_eq!(later, inputs[50..]);
//! # Ok(())
//! # }
//! ```

mod bits;
mod direction;
mod integer;
mod number;
mod random;

use integer::Integers;
use number::Numbers;
use random::Random;
use rayon::prelude::*;
use relievo_kernel::{Domain, Kernel, Kind};
use std::collections::BTreeMap;

/// Values recorded in a real program, as words, by the name of their domain; unit
/// vectors as three words each. Values outside the domain ([`contains`]) are
/// dropped, and −0 becomes +0, since kernels must not depend on the sign of zero.
pub type Recorded = BTreeMap<String, Vec<u32>>;

/// Number of inputs that a thread generates at a time.
const CHUNK: usize = 1024;

/// Distribution of the arguments of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Uniform in bits: sign, exponent over the whole domain, mantissa. Unit
    /// vectors: components of any magnitude, normalised. Integers: every number of
    /// bits is equally likely.
    Bits,
    /// Uniform in value; unit vectors: on the sphere.
    Value,
    /// Each scalar an edge case or as [`Distribution::Bits`]. Edge cases: zero, the
    /// ends of the domain, powers of two, thirds and small integers, the neighbours
    /// of all these, and the previous scalar, its negation and its neighbours. Unit
    /// vectors: axes, diagonals and vectors close to an axis.
    Edges,
    /// Drawn from [`Recorded`], or as [`Distribution::Value`] if none are recorded.
    Recorded,
}

impl Distribution {
    /// Returns the distribution of the input `index`.
    pub fn of(index: u64) -> Distribution {
        match index % 4 {
            0 => Distribution::Bits,
            1 => Distribution::Value,
            2 => Distribution::Edges,
            _ => Distribution::Recorded,
        }
    }
}

/// An argument with an invalid domain.
#[derive(Debug, thiserror::Error)]
#[error("kernel {kernel:?}, domain {domain:?}: {message}; correct the domain")]
pub struct DomainError {
    /// The kernel.
    pub kernel: &'static str,
    /// The name of the argument's domain.
    pub domain: &'static str,
    /// The reason.
    pub message: &'static str,
}

/// Generates the inputs of one kernel.
pub struct Generator {
    arguments: Vec<Argument>,
    input_words: usize,
    seed: u64,
}

struct Argument {
    words: usize,
    values: Values,
    /// Recorded values in the domain.
    pool: Vec<u32>,
}

enum Values {
    Bits,
    Numbers(Numbers),
    Integers(Integers),
    Directions,
}

impl Generator {
    /// Makes a generator for the arguments of `kernel`.
    ///
    /// # Errors
    /// [`DomainError`] if a domain is empty, not finite or denormal, or if the
    /// number of words of a unit-vector argument is not a multiple of 3.
    pub fn new(kernel: &Kernel, recorded: &Recorded, seed: u64) -> Result<Generator, DomainError> {
        let mut arguments = Vec::new();
        for argument in kernel.arguments {
            Argument::collect(argument, recorded, &mut arguments).map_err(
                |(domain, message)| DomainError {
                    kernel: kernel.name,
                    domain,
                    message,
                },
            )?;
        }
        Ok(Generator {
            input_words: arguments.iter().map(|argument| argument.words).sum(),
            arguments,
            seed,
        })
    }

    /// Returns the number of words per input.
    pub fn input_words(&self) -> usize {
        self.input_words
    }

    /// Fills `inputs` with consecutive inputs, from index `first` on.
    pub fn fill(&self, first: u64, inputs: &mut [u32]) {
        if self.input_words == 0 {
            return;
        }
        let chunks = inputs.par_chunks_mut(CHUNK * self.input_words);
        chunks.enumerate().for_each(|(chunk, inputs)| {
            let first = first + (chunk * CHUNK) as u64;
            for (index, input) in (first..).zip(inputs.chunks_exact_mut(self.input_words)) {
                self.draw(index, input);
            }
        });
    }

    fn draw(&self, index: u64, input: &mut [u32]) {
        let is_word = |only: &Argument| only.words == 1 && matches!(only.values, Values::Bits);
        if let [only] = &self.arguments[..]
            && is_word(only)
        {
            input[0] = bits::count(index);
            return;
        }
        let distribution = Distribution::of(index);
        let mut random = Random::new(self.seed, index);
        let mut previous = None;
        let mut rest = input;
        for argument in &self.arguments {
            let (words, after) = rest.split_at_mut(argument.words);
            argument.draw(distribution, &mut previous, &mut random, words);
            rest = after;
        }
    }
}

impl Argument {
    /// Adds an argument, or all its parts. Fails with the name of a domain.
    fn collect(
        argument: &relievo_kernel::Argument,
        recorded: &Recorded,
        all: &mut Vec<Argument>,
    ) -> Result<(), (&'static str, &'static str)> {
        if argument.parts.is_empty() {
            let domain = argument.domain;
            let made = Argument::new(argument.words as usize, domain, recorded);
            all.push(made.map_err(|message| (domain.name, message))?);
        }
        for part in argument.parts {
            Argument::collect(part, recorded, all)?;
        }
        Ok(())
    }

    fn new(words: usize, domain: Domain, recorded: &Recorded) -> Result<Argument, &'static str> {
        let values = match domain.kind {
            Kind::Bits => Values::Bits,
            Kind::Magnitude { low, high } => {
                Values::Numbers(Numbers::of_magnitude(true, low, high)?)
            }
            Kind::NonZero { low, high } => {
                Values::Numbers(Numbers::of_magnitude(false, low, high)?)
            }
            Kind::Range { low, high } => Values::Numbers(Numbers::in_range(low, high)?),
            Kind::Integer { low, high } => Values::Integers(Integers::new(low, high)?),
            Kind::UnitVector if words.is_multiple_of(3) => Values::Directions,
            Kind::UnitVector => return Err("unit vectors take three scalars each"),
        };
        let is_number = !matches!(values, Values::Integers(_) | Values::Bits);
        let is_zero = |word: u32| word << 1 == 0 && is_number;
        let pool = recorded.get(domain.name).map_or(&[][..], Vec::as_slice);
        let pool = pool
            .chunks_exact(group(domain.kind))
            .filter(|words| contains(domain.kind, words))
            .flatten()
            .map(|&word| if is_zero(word) { 0 } else { word })
            .collect();
        Ok(Argument {
            words,
            values,
            pool,
        })
    }

    fn draw(
        &self,
        distribution: Distribution,
        previous: &mut Option<u32>,
        random: &mut Random,
        words: &mut [u32],
    ) {
        let recorded = distribution == Distribution::Recorded && !self.pool.is_empty();
        match &self.values {
            Values::Directions if recorded => {
                for direction in words.chunks_exact_mut(3) {
                    let at = 3 * random.up_to(self.pool.len() as u32 / 3 - 1) as usize;
                    direction.copy_from_slice(&self.pool[at..at + 3]);
                }
            }
            Values::Directions => {
                for direction in words.chunks_exact_mut(3) {
                    direction.copy_from_slice(&direction::draw(distribution, random));
                }
            }
            _ if recorded => words.fill_with(|| random.pick(&self.pool)),
            Values::Numbers(numbers) => {
                for word in words {
                    *word = numbers.draw(distribution, *previous, random);
                    *previous = Some(*word);
                }
            }
            Values::Bits => words.fill_with(|| bits::draw(distribution, random)),
            Values::Integers(integers) => words.fill_with(|| integers.draw(distribution, random)),
        }
    }
}

/// Returns the number of words per value of a domain.
fn group(kind: Kind) -> usize {
    match kind {
        Kind::UnitVector => 3,
        _ => 1,
    }
}

/// Returns whether all values in `words` are of this kind, unit vectors as three
/// words each. Zero may have either sign.
pub fn contains(kind: Kind, words: &[u32]) -> bool {
    match kind {
        Kind::Bits => true,
        Kind::Integer { low, high } => words.iter().all(|word| (low..=high).contains(word)),
        Kind::UnitVector => {
            let (vectors, rest) = words.as_chunks::<3>();
            rest.is_empty() && vectors.iter().all(|&vector| direction::contains(vector))
        }
        _ => words.iter().all(|&word| number::contains(kind, word)),
    }
}

#[cfg(test)]
mod tests;
