//! f32 arguments, by magnitude or by range.

use super::Distribution;
use super::random::Random;
use relievo_kernel::Kind;

/// Smallest non-zero magnitude in a range or of a unit vector's component: 2⁻²⁰, as
/// a word.
pub(super) const SMALLEST: u32 = (127 - 20) << 23;

const SIGN: u32 = 0x8000_0000;
/// Smallest normal and largest finite magnitude.
const NORMAL: u32 = 0x0080_0000;
const FINITE: u32 = 0x7f7f_ffff;

/// The numbers of a domain: zero or not, and for each sign an interval of
/// magnitudes. Magnitudes are words, which have the same order.
pub(super) struct Numbers {
    zero: bool,
    positive: Option<(u32, u32)>,
    negative: Option<(u32, u32)>,
    /// The few edge cases besides powers of two.
    special: Vec<u32>,
    /// Powers of two and their neighbours.
    powers: Vec<u32>,
}

impl Numbers {
    /// Numbers of either sign with a magnitude in `low..=high`, and zero if `zero`.
    pub(super) fn of_magnitude(zero: bool, low: f32, high: f32) -> Result<Numbers, &'static str> {
        if !(low.is_normal() && high.is_normal() && 0.0 < low && low <= high) {
            return Err("0 < low ≤ high must hold, both finite and not denormal");
        }
        let both = Some((low.to_bits(), high.to_bits()));
        Ok(Numbers::new(zero, both, both))
    }

    /// Numbers from `low` to `high`.
    pub(super) fn in_range(low: f32, high: f32) -> Result<Numbers, &'static str> {
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err("low ≤ high must hold, both finite");
        }
        // Interval of magnitudes from `near` to `far`, on one side of zero.
        let side = |near: f32, far: f32| {
            // `abs`, because `max` of −0 and +0 may be −0.
            let [near, far] = [near, far].map(|end| end.max(0.0).abs().to_bits());
            let near = near.max(SMALLEST);
            (near <= far).then_some((near, far))
        };
        let numbers = Numbers::new(
            low <= 0.0 && 0.0 <= high,
            side(low, high),
            side(-high, -low),
        );
        if !numbers.zero && numbers.positive.is_none() && numbers.negative.is_none() {
            return Err("it is empty: magnitudes below 2⁻²⁰ do not count");
        }
        Ok(numbers)
    }

    fn new(zero: bool, positive: Option<(u32, u32)>, negative: Option<(u32, u32)>) -> Numbers {
        let mut numbers = Numbers {
            zero,
            positive,
            negative,
            special: Vec::new(),
            powers: Vec::new(),
        };
        let of_both_signs = |magnitudes: Vec<u32>| {
            let mut words: Vec<u32> = magnitudes
                .into_iter()
                .flat_map(|word| [word - 1, word, word + 1])
                .flat_map(|word| [word, word | SIGN])
                .collect();
            words.sort_unstable();
            words.dedup();
            words.retain(|&word| numbers.holds(word));
            words
        };
        let mut special: Vec<u32> = (1..=16).map(|whole| (whole as f32).to_bits()).collect();
        special.extend([1.0_f32 / 3.0, 2.0 / 3.0].map(f32::to_bits));
        for (low, high) in positive.into_iter().chain(negative) {
            special.extend([low, high]);
        }
        let mut special = of_both_signs(special);
        if zero {
            special.push(0);
        }
        let powers = of_both_signs((1..255).map(|exponent| exponent << 23).collect());
        numbers.special = special;
        numbers.powers = powers;
        numbers
    }

    /// Returns whether a word is one of the numbers; of the zeros, only +0 is.
    pub(super) fn holds(&self, word: u32) -> bool {
        let magnitude = word & !SIGN;
        if magnitude == 0 {
            return self.zero && word == 0;
        }
        let side = if word == magnitude {
            self.positive
        } else {
            self.negative
        };
        (NORMAL..=FINITE).contains(&magnitude)
            && side.is_some_and(|(low, high)| (low..=high).contains(&magnitude))
    }

    /// Draws a number; `previous` is the scalar before in the same input.
    pub(super) fn draw(
        &self,
        distribution: Distribution,
        previous: Option<u32>,
        random: &mut Random,
    ) -> u32 {
        match distribution {
            Distribution::Bits => self.bits(random),
            Distribution::Value | Distribution::Recorded => self.value(random),
            Distribution::Edges => self.edge(previous, random),
        }
    }

    /// Draws uniformly in sign, exponent and mantissa.
    fn bits(&self, random: &mut Random) -> u32 {
        let (sign, (low, high)) = match (self.positive, self.negative) {
            (Some(positive), Some(negative)) => {
                if random.coin() {
                    (0, positive)
                } else {
                    (SIGN, negative)
                }
            }
            (Some(positive), None) => (0, positive),
            (None, Some(negative)) => (SIGN, negative),
            (None, None) => return 0,
        };
        sign | (low + random.up_to(high - low))
    }

    /// Draws uniformly in value.
    fn value(&self, random: &mut Random) -> u32 {
        let [smallest, largest] = self.ends().map(f64::from);
        let word = ((smallest + random.unit() * (largest - smallest)) as f32).to_bits();
        if self.holds(word) {
            return word;
        }
        // The value is in the gap around zero.
        match (self.zero, self.positive, self.negative) {
            (true, _, _) => 0,
            (false, Some((low, _)), None) => low,
            (false, None, Some((low, _))) => low | SIGN,
            _ => self.bits(random),
        }
    }

    /// Returns the smallest and the largest number.
    fn ends(&self) -> [f32; 2] {
        let negative = |magnitude| f32::from_bits(SIGN | magnitude);
        let smallest = match (self.negative, self.zero, self.positive) {
            (Some((_, high)), _, _) => negative(high),
            (None, false, Some((low, _))) => f32::from_bits(low),
            _ => 0.0,
        };
        let largest = match (self.positive, self.zero, self.negative) {
            (Some((_, high)), _, _) => f32::from_bits(high),
            (None, false, Some((low, _))) => negative(low),
            _ => 0.0,
        };
        [smallest, largest]
    }

    /// Draws an edge case, or uniformly in bits.
    fn edge(&self, previous: Option<u32>, random: &mut Random) -> u32 {
        let chosen = match (random.up_to(7), previous) {
            // Equal, cancelling or nearly so.
            (0, Some(previous)) => match random.up_to(3) {
                0 => previous,
                1 => previous ^ SIGN,
                2 => previous.wrapping_add(1),
                _ => previous.wrapping_sub(1),
            },
            (0..=2, _) => random.pick(&self.special),
            (3..=4, _) => random.pick(&self.powers),
            _ => return self.bits(random),
        };
        if self.holds(chosen) {
            chosen
        } else {
            self.bits(random)
        }
    }
}

/// Returns whether `word` is in `kind`, a magnitude or a range. Zero may have either
/// sign.
pub(super) fn contains(kind: Kind, word: u32) -> bool {
    let value = f32::from_bits(word);
    let magnitude = value.abs();
    if !(value == 0.0 || value.is_normal()) {
        return false;
    }
    match kind {
        Kind::Magnitude { low, high } => value == 0.0 || (low..=high).contains(&magnitude),
        Kind::NonZero { low, high } => (low..=high).contains(&magnitude),
        Kind::Range { low, high } => {
            (low..=high).contains(&value) && (value == 0.0 || magnitude >= f32::from_bits(SMALLEST))
        }
        Kind::Bits | Kind::UnitVector | Kind::Integer { .. } => false,
    }
}
