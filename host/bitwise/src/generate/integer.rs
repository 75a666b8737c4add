//! Integer arguments.

use super::Distribution;
use super::random::Random;

/// The integers from `low` to `high`.
pub(super) struct Integers {
    low: u32,
    high: u32,
    edges: Vec<u32>,
}

impl Integers {
    pub(super) fn new(low: u32, high: u32) -> Result<Integers, &'static str> {
        if low > high {
            return Err("low ≤ high must hold");
        }
        let mut edges: Vec<u32> = (0..32)
            .map(|exponent| 1 << exponent)
            .chain([0, low, high])
            .flat_map(|word: u32| [word.wrapping_sub(1), word, word.wrapping_add(1)])
            .filter(|word| (low..=high).contains(word))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        Ok(Integers { low, high, edges })
    }

    /// Draws an integer.
    pub(super) fn draw(&self, distribution: Distribution, random: &mut Random) -> u32 {
        match distribution {
            Distribution::Bits => self.bits(random),
            Distribution::Value | Distribution::Recorded => {
                self.low + random.up_to(self.high - self.low)
            }
            Distribution::Edges if random.coin() => random.pick(&self.edges),
            Distribution::Edges => self.bits(random),
        }
    }

    /// Draws a distance from `low` with every number of bits equally likely.
    fn bits(&self, random: &mut Random) -> u32 {
        let span = self.high - self.low;
        let count = random.up_to(u32::BITS - span.leading_zeros());
        let longest = if count == 0 {
            0
        } else {
            u32::MAX >> (u32::BITS - count)
        };
        self.low + random.up_to(longest.min(span))
    }
}
