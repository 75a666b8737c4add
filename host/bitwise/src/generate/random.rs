//! Reproducible random numbers.

/// SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
/// Generators", OOPSLA 2014).
pub(super) struct Random(u64);

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    /// Returns the stream `index` of `seed`.
    pub(super) fn new(seed: u64, index: u64) -> Random {
        // Mixed, so that no stream is the continuation of another.
        Random(mix(mix(seed.wrapping_add(GOLDEN)) ^ index))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        mix(self.0)
    }

    /// Draws an integer in `0..=last`.
    pub(super) fn up_to(&mut self, last: u32) -> u32 {
        (((self.next() >> 32) * (u64::from(last) + 1)) >> 32) as u32
    }

    /// Draws a number in `0.0..=1.0`.
    pub(super) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / ((1_u64 << 53) - 1) as f64
    }

    /// Draws true or false, equally likely.
    pub(super) fn coin(&mut self) -> bool {
        self.next() >> 63 != 0
    }

    /// Draws one of the words; 0 if there are none.
    pub(super) fn pick(&mut self, words: &[u32]) -> u32 {
        match words.len() {
            0 => 0,
            count => words[self.up_to(count as u32 - 1) as usize],
        }
    }
}
