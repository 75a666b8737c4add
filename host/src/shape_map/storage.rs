//! The shape map as renderers read it: quantized distances, packed into words.
//!
//! Source: algorithm.md, section 3.

use super::DistanceField;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How many bits a texel takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Storage {
    /// 8 bits: steps of 2⁻⁸ to 2⁻¹ texel, a range of at most 128 texels. The
    /// precision of the paper's maps; small.
    Bits8,
    /// 16 bits: steps of 2⁻⁸ to 2⁻⁵ texel, a range of at most 2048 texels. The
    /// accurate one.
    Bits16,
    /// 32 bits, of which 24 and a sign are used: steps from 2⁻¹² texel on; never
    /// saturates. The reference to measure the others against.
    Bits32,
}

impl Storage {
    /// Bits of a texel.
    pub const fn bits(self) -> u32 {
        match self {
            Self::Bits8 => 8,
            Self::Bits16 => 16,
            Self::Bits32 => 32,
        }
    }

    /// Texels in a 32-bit word: 4, 2 or 1.
    pub const fn texels_per_word(self) -> u32 {
        32 / self.bits()
    }

    /// Smallest step, in texels.
    const fn finest_step(self) -> f64 {
        match self {
            Self::Bits8 | Self::Bits16 => 1.0 / 256.0,
            Self::Bits32 => 1.0 / 4096.0,
        }
    }

    /// Largest step, in texels; beyond the range it gives, distances saturate.
    const fn coarsest_step(self) -> f64 {
        match self {
            Self::Bits8 => 0.5,
            Self::Bits16 => 1.0 / 32.0,
            Self::Bits32 => f64::INFINITY,
        }
    }

    /// Whether `below` codes under zero and `above` codes over zero can be told apart.
    const fn fits(self, below: u64, above: u64) -> bool {
        match self {
            Self::Bits8 | Self::Bits16 => below + above < 1 << self.bits(),
            // The difference to the bias must be exact in f32.
            Self::Bits32 => below <= MAX_EXACT && above <= MAX_EXACT,
        }
    }

    /// The largest texel that may be stored with this bias.
    pub(super) const fn max_texel(self, bias: u32) -> u32 {
        match self {
            Self::Bits8 => u8::MAX as u32,
            Self::Bits16 => u16::MAX as u32,
            Self::Bits32 => bias + MAX_EXACT as u32,
        }
    }
}

/// Largest difference of a texel to the bias: an integer that f32 holds exactly.
const MAX_EXACT: u64 = (1 << 24) - 1;

/// Signed distances as integers: value in texels = (texel − bias) · step.
///
/// A stored distance is the true one rounded down to a multiple of the step, so
/// it never overestimates, with one exception: values under
/// [`min_distance`](Self::min_distance), deep inside the pattern, are raised to
/// it. Values over [`max_distance`](Self::max_distance) are lowered to it, which
/// is safe for leaping as long as the pattern is grown by less.
///
/// Texel i = y · width + x lies in word i · bits / 32 (rounded down), from bit
/// (i · bits) mod 32 on. Rows are not padded; the last word is, with zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeMap {
    width: u32,
    height: u32,
    quantization: Quantization,
    words: Vec<u32>,
}

/// How distances become texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quantization {
    pub(super) storage: Storage,
    /// Texel that stands for distance 0.
    pub(super) bias: u32,
    /// Texels (of length) per unit of the stored integer, a power of two.
    pub(super) step: f32,
    /// Whether values were out of range.
    pub(super) saturated: bool,
}

impl Quantization {
    /// The finest quantization that holds all of `min`…`max` (texels), or else
    /// the coarsest allowed, with at most half of the texels' range under zero.
    fn choose(storage: Storage, min: f32, max: f32) -> Self {
        let mut step = storage.finest_step();
        loop {
            // Conversion to an integer turns negative counts into 0.
            let below = -(f64::from(min) / step).floor() as u64;
            let above = (f64::from(max) / step).floor() as u64;
            let fits = storage.fits(below, above);
            if fits || step >= storage.coarsest_step() {
                let half = 1 << (storage.bits() - 1);
                return Self {
                    storage,
                    bias: if fits { below } else { below.min(half) } as u32,
                    step: step as f32,
                    saturated: !fits,
                };
            }
            step *= 2.0;
        }
    }

    fn encode(self, distance: f32) -> u32 {
        let units = (f64::from(distance) / f64::from(self.step)).floor();
        let max_texel = self.storage.max_texel(self.bias);
        (units + f64::from(self.bias)).clamp(0.0, f64::from(max_texel)) as u32
    }

    fn decode(self, texel: u32) -> f32 {
        (i64::from(texel) - i64::from(self.bias)) as f32 * self.step
    }
}

impl ShapeMap {
    /// Quantizes a distance field. The step is the smallest power of two, within
    /// the limits of the `storage`, that lets the field's range fit.
    pub fn encode(field: &DistanceField, storage: Storage) -> Self {
        let (min, max) = field
            .values()
            .par_iter()
            .map(|&value| (value, value))
            .reduce(
                || (f32::INFINITY, f32::NEG_INFINITY),
                |a, b| (a.0.min(b.0), a.1.max(b.1)),
            );
        let quantization = Quantization::choose(storage, min, max);
        Self::pack(
            field.width(),
            field.height(),
            quantization,
            field.values(),
            |distance| quantization.encode(distance),
        )
    }

    /// Packs `source`, one item per texel, through `texel`, whose results must
    /// fit the storage.
    pub(super) fn pack<T: Copy + Sync>(
        width: u32,
        height: u32,
        quantization: Quantization,
        source: &[T],
        texel: impl Fn(T) -> u32 + Sync,
    ) -> Self {
        let storage = quantization.storage;
        let words = source
            .par_chunks(storage.texels_per_word() as usize)
            .map(|texels| {
                // The first texel takes the lowest bits. `checked_shl`, as a
                // single texel of 32 bits would be shifted by its full width.
                texels.iter().rev().fold(0u32, |word, &item| {
                    word.checked_shl(storage.bits()).unwrap_or(0) | texel(item)
                })
            })
            .collect();
        Self {
            width,
            height,
            quantization,
            words,
        }
    }

    /// Width in texels, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in texels, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Bits per texel.
    pub fn storage(&self) -> Storage {
        self.quantization.storage
    }

    /// The stored integer that stands for distance 0.
    pub fn bias(&self) -> u32 {
        self.quantization.bias
    }

    /// Length of one unit of the stored integer, in texels: a power of two.
    pub fn step(&self) -> f32 {
        self.quantization.step
    }

    /// The packed texels, see [`ShapeMap`] for their order.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The least distance that can be stored, in texels; 0 or negative.
    pub fn min_distance(&self) -> f32 {
        self.quantization.decode(0)
    }

    /// The largest distance that can be stored, in texels. A saturated map may
    /// be leapt through safely while the pattern is grown by less than this.
    pub fn max_distance(&self) -> f32 {
        let Quantization { storage, bias, .. } = self.quantization;
        self.quantization.decode(storage.max_texel(bias))
    }

    /// Whether any distance was out of the range that can be stored.
    pub fn saturated(&self) -> bool {
        self.quantization.saturated
    }

    /// The stored integer; coordinates beyond the map wrap around.
    pub fn texel(&self, x: u32, y: u32) -> u32 {
        let (x, y) = (x % self.width, y % self.height);
        self.texel_at(y as usize * self.width as usize + x as usize)
    }

    /// The stored distance in texels; coordinates beyond the map wrap around.
    pub fn decode(&self, x: u32, y: u32) -> f32 {
        self.quantization.decode(self.texel(x, y))
    }

    pub(super) fn quantization(&self) -> Quantization {
        self.quantization
    }

    /// The stored integer of texel `index` = y · width + x.
    pub(super) fn texel_at(&self, index: usize) -> u32 {
        let storage = self.quantization.storage;
        let per_word = storage.texels_per_word() as usize;
        let shift = (index % per_word) as u32 * storage.bits();
        let mask = u32::MAX >> (32 - storage.bits());
        (self.words[index / per_word] >> shift) & mask
    }
}

#[cfg(test)]
mod tests {
    use super::super::distance::tests::patterns;
    use super::super::{Pattern, signed_distance_field};
    use super::*;
    use proptest::prelude::*;

    const ALL: [Storage; 3] = [Storage::Bits8, Storage::Bits16, Storage::Bits32];

    fn field(pattern: &Pattern) -> DistanceField {
        signed_distance_field(pattern, &|_| ())
    }

    /// A disc, or the hole of one, in a square map.
    fn disc(size: u32, radius: u32, hole: bool) -> DistanceField {
        let pattern = Pattern::from_fn(size, size, |x, y| {
            let (x, y) = (x.abs_diff(size / 2), y.abs_diff(size / 2));
            (x * x + y * y < radius * radius) != hole
        });
        field(&pattern.unwrap())
    }

    /// Rounded down, by less than a step, unless clamped; and still Lipschitz.
    fn check(field: &DistanceField, map: &ShapeMap) {
        let step = map.step();
        let (min, max) = (map.min_distance(), map.max_distance());
        assert_eq!(step.log2().exp2(), step);
        let mut clamped = false;
        for y in 0..field.height() {
            for x in 0..field.width() {
                let (value, stored) = (field.get(x, y), map.decode(x, y));
                if value < min {
                    assert_eq!(stored, min);
                } else if value >= max + step {
                    assert_eq!(stored, max);
                } else {
                    assert!(stored <= value && value - stored < step, "{value} {stored}");
                }
                clamped |= value < min || value >= max + step;
                for neighbour in [map.decode(x + 1, y), map.decode(x, y + 1)] {
                    assert!((stored - neighbour).abs() <= 1.0 + step);
                }
            }
        }
        assert_eq!(map.saturated(), clamped);
    }

    proptest! {
        #[test]
        fn stored_distances_are_rounded_down(pattern in patterns(24, 17)) {
            let field = field(&pattern);
            for storage in ALL {
                let map = ShapeMap::encode(&field, storage);
                prop_assert!(!map.saturated());
                check(&field, &map);
            }
        }
    }

    #[test]
    fn texels_are_packed_from_the_low_bits_on() {
        let quantization = |storage| Quantization {
            storage,
            bias: 0,
            step: 1.0,
            saturated: false,
        };
        let pack = |storage, texels: &[u32]| {
            ShapeMap::pack(texels.len() as u32, 1, quantization(storage), texels, |t| t)
        };
        let map = pack(Storage::Bits8, &[1, 2, 3, 4, 0xff]);
        assert_eq!(map.words(), [0x0403_0201, 0x0000_00ff]);
        assert_eq!((map.texel(3, 0), map.texel(4, 7)), (4, 0xff));
        let map = pack(Storage::Bits16, &[0x1234, 0xabcd, 0xffff]);
        assert_eq!(map.words(), [0xabcd_1234, 0x0000_ffff]);
        assert_eq!((map.texel(1, 0), map.texel(3, 0)), (0xabcd, 0x1234));
        let map = pack(Storage::Bits32, &[u32::MAX, 7]);
        assert_eq!(map.words(), [u32::MAX, 7]);
        assert_eq!(map.texel(1, 0), 7);
    }

    #[test]
    fn the_step_is_the_finest_that_fits() {
        let step = |storage, min, max| Quantization::choose(storage, min, max).step;
        // 256 codes: −128…127 of 2⁻⁸ just fit.
        assert_eq!(step(Storage::Bits8, -0.5, 0.499), 1.0 / 256.0);
        assert_eq!(step(Storage::Bits8, -0.5, 0.5), 1.0 / 128.0);
        assert_eq!(step(Storage::Bits16, -100.0, 155.9), 1.0 / 256.0);
        assert_eq!(step(Storage::Bits16, -100.0, 156.0), 1.0 / 128.0);
        assert_eq!(step(Storage::Bits16, -0.5, 5000.0), 1.0 / 32.0);
        assert_eq!(step(Storage::Bits32, -4000.0, 4095.9), 1.0 / 4096.0);
        assert_eq!(step(Storage::Bits32, -0.5, 4096.0), 1.0 / 2048.0);
        assert_eq!(step(Storage::Bits32, -0.5, 1.5e9), 128.0);
    }

    #[test]
    fn far_distances_saturate_at_both_ends() {
        for (field, clamped_above) in [(disc(300, 10, false), true), (disc(300, 10, true), false)] {
            let map = ShapeMap::encode(&field, Storage::Bits8);
            assert!(map.saturated());
            assert_eq!(map.step(), 0.5);
            assert_eq!(map.bias(), if clamped_above { 19 } else { 128 });
            check(&field, &map);
            for storage in [Storage::Bits16, Storage::Bits32] {
                check(&field, &ShapeMap::encode(&field, storage));
            }
        }
    }

    #[test]
    fn empty_and_full_patterns() {
        for storage in ALL {
            let empty = field(&Pattern::from_fn(3, 4, |_, _| false).unwrap());
            assert_eq!(ShapeMap::encode(&empty, storage).decode(1, 1), 5.0);
            let full = field(&Pattern::from_fn(3, 4, |_, _| true).unwrap());
            assert_eq!(ShapeMap::encode(&full, storage).decode(1, 1), -5.0);
        }
        // Too large for 8 bits: all ground, all cap.
        let empty = field(&Pattern::from_fn(400, 300, |_, _| false).unwrap());
        let map = ShapeMap::encode(&empty, Storage::Bits8);
        assert_eq!((map.decode(0, 0), map.saturated()), (127.5, true));
        let full = field(&Pattern::from_fn(400, 300, |_, _| true).unwrap());
        let map = ShapeMap::encode(&full, Storage::Bits8);
        assert_eq!((map.decode(0, 0), map.saturated()), (-64.0, true));
        assert_eq!(map.max_distance(), 63.5);
    }
}
