//! The shape map as renderers read it: distances, packed into words.
//!
//! Source: algorithm.md, section 3.

use super::coding::{Coding, largest_code};
use super::{DistanceField, Encoding, Storage, rgba8};
use rayon::prelude::*;

/// Signed distances to the pattern in one of four forms, as 32-bit words.
///
/// | storage | a texel | its distance, texels |
/// |---|---|---|
/// | [`Storage::R8`], [`Storage::R16`] | an unsigned code | (code − bias) · step |
/// | [`Storage::R32F`] | the bits of an f32 | the f32 |
/// | [`Storage::Rgba8`] | R, G: normal; B: distance to the nearest centre of the pattern; A: 0 on the pattern, else 255 | A = 0: −½, else max(B · step − ½, ½) |
///
/// Texel i = y · width + x lies in word i · bits / 32 (rounded down), from bit
/// (i · bits) mod 32 on; of Rgba8, R takes the lowest bits and A the highest.
/// Rows are not padded; the last word is, with zeros.
///
/// What a renderer may rely on, for all of them:
///
/// - A stored distance is at most the true one, and less by no more than
///   [`quantum`](Self::quantum), with two exceptions. Values under
///   [`min_distance`](Self::min_distance), inside the pattern, are raised to
///   it. Values over [`max_distance`](Self::max_distance) are lowered to it,
///   which is safe for leaping as long as the pattern is grown by less.
///   (Without a pattern the true distance is a convention, and Rgba8's is less
///   by another ½.)
/// - Stored distances of texels that share an edge, also across the map's
///   edges, differ by at most 1 + `quantum`; of R32F by 1 and the rounding of
///   f32, 2⁻²³ of the distance.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeMap {
    width: u32,
    height: u32,
    coding: Coding,
    words: Vec<u32>,
}

impl ShapeMap {
    /// Encodes a distance field. Of fixed-point codes the step is the smallest
    /// power of two, within the limits of the storage, that lets the field's
    /// range fit; of Rgba8 it is f · max(EDT) / 255.
    pub fn encode(field: &DistanceField, encoding: impl Into<Encoding>) -> Self {
        let Encoding { storage, scale } = encoding.into();
        let (width, height) = (field.width(), field.height());
        let values = field.values();
        let (min, max) = range(values, |&value| value);
        match storage {
            Storage::R8 | Storage::R16 => {
                let coding = Coding::choose(storage, scale, min, max);
                Self::pack(width, height, coding, values, |value| {
                    coding.encode_code(value)
                })
            }
            Storage::R32F => {
                let coding = Coding::choose(storage, scale, min, max);
                Self::pack(width, height, coding, values, f32::to_bits)
            }
            Storage::Rgba8 => {
                let pattern_is_empty = min > 0.0;
                let max = rgba8::pattern_distance(max, pattern_is_empty);
                let coding = Coding::choose(storage, scale, min, max as f32);
                let words = rgba8::encode(field, coding, pattern_is_empty);
                Self {
                    width,
                    height,
                    coding,
                    words,
                }
            }
        }
    }

    /// Packs `source`, one item per texel, through `texel`, whose results must
    /// fit the storage.
    pub(super) fn pack<T: Copy + Sync>(
        width: u32,
        height: u32,
        coding: Coding,
        source: &[T],
        texel: impl Fn(T) -> u32 + Sync,
    ) -> Self {
        let storage = coding.storage;
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
            coding,
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

    /// The form of the texels.
    pub fn storage(&self) -> Storage {
        self.coding.storage
    }

    /// R8, R16: the code that stands for distance 0. Else 0.
    pub fn bias(&self) -> u32 {
        self.coding.bias
    }

    /// Texels (of length) per unit of the code (R8, R16: a power of two) or of
    /// the blue channel (Rgba8: f · max(EDT) / 255). R32F: 0.
    pub fn step(&self) -> f32 {
        self.coding.step
    }

    /// The most, in texels, by which a stored distance lies under the true one:
    /// a step, or 0 for R32F.
    pub fn quantum(&self) -> f32 {
        self.coding.step
    }

    /// Rgba8: the paper's scale f, 0 < f ≤ 1 (equation (5)). Else 1.
    pub fn scale(&self) -> f32 {
        self.coding.scale
    }

    /// Rgba8: the paper's τ = f · max(EDT) / W in map widths (wu), so that
    /// D = τ · B / 255 for the blue channel B (equations (4) and (5)). The
    /// pattern may be grown by less than this where f < 1. Else none.
    pub fn tau(&self) -> Option<f32> {
        (self.storage() == Storage::Rgba8).then(|| 255.0 * self.step() / self.width as f32)
    }

    /// The packed texels, see [`ShapeMap`] for their order.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The least distance that can be stored, in texels; 0 or negative. R32F,
    /// which has no bounds: the least in the map, found by reading all of it.
    pub fn min_distance(&self) -> f32 {
        match self.storage() {
            Storage::R32F => self.float_range().0,
            Storage::R8 | Storage::R16 | Storage::Rgba8 => self.coding.decode(0),
        }
    }

    /// The largest distance that can be stored, in texels. A saturated map may
    /// be leapt through safely while the pattern is grown by less than this.
    /// R32F, which has no bounds: the largest in the map, found by reading all
    /// of it.
    pub fn max_distance(&self) -> f32 {
        match self.storage() {
            Storage::R32F => self.float_range().1,
            storage @ (Storage::R8 | Storage::R16 | Storage::Rgba8) => {
                self.coding.decode(largest_code(storage))
            }
        }
    }

    fn float_range(&self) -> (f32, f32) {
        range(&self.words, |&word| f32::from_bits(word))
    }

    /// Whether distances are out of the range that can be stored. Rgba8:
    /// whether f < 1; its inside, −½ everywhere, does not count.
    pub fn saturated(&self) -> bool {
        self.coding.saturated
    }

    /// The stored texel, see [`ShapeMap`]; coordinates beyond the map wrap around.
    pub fn texel(&self, x: u32, y: u32) -> u32 {
        let (x, y) = (x % self.width, y % self.height);
        self.texel_at(y as usize * self.width as usize + x as usize)
    }

    /// The stored distance in texels; coordinates beyond the map wrap around.
    pub fn decode(&self, x: u32, y: u32) -> f32 {
        self.coding.decode(self.texel(x, y))
    }

    /// Rgba8: the stored normal, a unit vector (to ±1/255) along x and y of the
    /// map's pixels (y down), away from the pattern; none on ridges, where no
    /// side is nearer, and none in other storages. Coordinates beyond the map
    /// wrap around.
    pub fn normal(&self, x: u32, y: u32) -> Option<[f32; 2]> {
        match self.storage() {
            Storage::Rgba8 => rgba8::decode_normal(self.texel(x, y)),
            Storage::R8 | Storage::R16 | Storage::R32F => None,
        }
    }

    pub(super) fn coding(&self) -> Coding {
        self.coding
    }

    /// The stored texel number `index` = y · width + x.
    pub(super) fn texel_at(&self, index: usize) -> u32 {
        let storage = self.storage();
        let per_word = storage.texels_per_word() as usize;
        let shift = (index % per_word) as u32 * storage.bits();
        (self.words[index / per_word] >> shift) & largest_code(storage)
    }
}

/// The least and the largest value.
fn range<T: Sync>(source: &[T], value: impl Fn(&T) -> f32 + Sync) -> (f32, f32) {
    source
        .par_iter()
        .map(|item| (value(item), value(item)))
        .reduce(
            || (f32::INFINITY, f32::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        )
}

#[cfg(test)]
mod tests {
    use super::super::distance::tests::patterns;
    use super::super::{Pattern, signed_distance_field};
    use super::*;
    use proptest::prelude::*;

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

    /// Rounded down, by no more than the quantum, unless out of range; and
    /// still Lipschitz. True of every storage.
    fn check(field: &DistanceField, map: &ShapeMap) {
        let quantum = map.quantum();
        let (min, max) = (map.min_distance(), map.max_distance());
        assert_eq!((map.width(), map.height()), (field.width(), field.height()));
        // Without a pattern the blue channel holds the convention itself.
        let empty = field.values().iter().all(|&value| value > 0.0);
        let convention = if empty && map.storage() == Storage::Rgba8 {
            0.5
        } else {
            0.0
        };
        for y in 0..field.height() {
            for x in 0..field.width() {
                let (value, stored) = (field.get(x, y), map.decode(x, y));
                assert!(stored <= value.max(min), "{value} {stored}");
                let wanted = value.clamp(min, max);
                assert!(wanted - stored <= quantum + convention, "{value} {stored}");
                for neighbour in [map.decode(x + 1, y), map.decode(x, y + 1)] {
                    let difference = (stored - neighbour).abs();
                    let rounding = f32::EPSILON * max.abs().max(min.abs());
                    assert!(difference <= 1.0 + quantum + rounding, "{difference}");
                }
            }
        }
    }

    /// Power-of-two steps, and saturated exactly if a value is out of range.
    fn check_codes(field: &DistanceField, map: &ShapeMap) {
        check(field, map);
        let step = map.step();
        assert_eq!(step.log2().exp2(), step);
        let held = map.min_distance()..map.max_distance() + step;
        let clamped = field.values().iter().any(|value| !held.contains(value));
        assert_eq!(map.saturated(), clamped);
    }

    proptest! {
        #[test]
        fn stored_distances_are_rounded_down(
            pattern in patterns(24, 17),
            scale in 0.001f32..1.0,
        ) {
            let field = field(&pattern);
            for storage in [Storage::R8, Storage::R16] {
                let map = ShapeMap::encode(&field, storage);
                prop_assert!(!map.saturated());
                check_codes(&field, &map);
            }
            for encoding in [Storage::Rgba8.into(), Encoding::rgba8(scale).unwrap()] {
                let map = ShapeMap::encode(&field, encoding);
                prop_assert_eq!(map.saturated(), encoding.scale < 1.0);
                check(&field, &map);
            }
        }

        #[test]
        fn floats_are_the_distances_themselves(pattern in patterns(24, 17)) {
            let field = field(&pattern);
            let map = ShapeMap::encode(&field, Storage::R32F);
            check(&field, &map);
            prop_assert_eq!((map.bias(), map.step(), map.quantum()), (0, 0.0, 0.0));
            let decoded: Vec<f32> = map.words().iter().map(|&word| f32::from_bits(word)).collect();
            prop_assert_eq!(&decoded[..], field.values());
        }
    }

    #[test]
    fn texels_are_packed_from_the_low_bits_on() {
        let pack = |storage, texels: &[u32]| {
            let coding = Coding::choose(storage, 1.0, 0.0, 0.0);
            ShapeMap::pack(texels.len() as u32, 1, coding, texels, |t| t)
        };
        let map = pack(Storage::R8, &[1, 2, 3, 4, 0xff]);
        assert_eq!(map.words(), [0x0403_0201, 0x0000_00ff]);
        assert_eq!((map.texel(3, 0), map.texel(4, 7)), (4, 0xff));
        let map = pack(Storage::R16, &[0x1234, 0xabcd, 0xffff]);
        assert_eq!(map.words(), [0xabcd_1234, 0x0000_ffff]);
        assert_eq!((map.texel(1, 0), map.texel(3, 0)), (0xabcd, 0x1234));
        for storage in [Storage::R32F, Storage::Rgba8] {
            let map = pack(storage, &[u32::MAX, 7]);
            assert_eq!(map.words(), [u32::MAX, 7]);
            assert_eq!(map.texel(1, 0), 7);
        }
    }

    #[test]
    fn far_distances_saturate_at_both_ends() {
        for (field, clamped_above) in [(disc(300, 10, false), true), (disc(300, 10, true), false)] {
            let map = ShapeMap::encode(&field, Storage::R8);
            assert!(map.saturated());
            assert_eq!(map.step(), 0.5);
            assert_eq!(map.bias(), if clamped_above { 19 } else { 128 });
            check_codes(&field, &map);
            check_codes(&field, &ShapeMap::encode(&field, Storage::R16));
            check(&field, &ShapeMap::encode(&field, Storage::R32F));
            for scale in [1.0, 0.25] {
                let encoding = Encoding::rgba8(scale).unwrap();
                check(&field, &ShapeMap::encode(&field, encoding));
            }
        }
    }

    #[test]
    fn empty_and_full_patterns() {
        let empty = field(&Pattern::from_fn(3, 4, |_, _| false).unwrap());
        let full = field(&Pattern::from_fn(3, 4, |_, _| true).unwrap());
        for storage in [Storage::R8, Storage::R16, Storage::R32F] {
            assert_eq!(ShapeMap::encode(&empty, storage).decode(1, 1), 5.0);
            assert_eq!(ShapeMap::encode(&full, storage).decode(1, 1), -5.0);
        }
        let map = ShapeMap::encode(&full, Storage::R32F);
        assert_eq!((map.min_distance(), map.max_distance()), (-5.0, -5.0));
        // Too large for 8 bits: all ground, all cap.
        let empty = field(&Pattern::from_fn(400, 300, |_, _| false).unwrap());
        let map = ShapeMap::encode(&empty, Storage::R8);
        assert_eq!((map.decode(0, 0), map.saturated()), (127.5, true));
        let full = field(&Pattern::from_fn(400, 300, |_, _| true).unwrap());
        let map = ShapeMap::encode(&full, Storage::R8);
        assert_eq!((map.decode(0, 0), map.saturated()), (-64.0, true));
        assert_eq!(map.max_distance(), 63.5);
    }
}
