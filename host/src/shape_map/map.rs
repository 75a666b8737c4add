//! The shape map that renderers read: distances packed into words (section 3 of
//! docs/algorithm.md).
//!
//! ```
//! use relievo::shape_map::{Pattern, Storage, bake};
//!
//! let pattern = Pattern::from_pixels(4, 1, [true, false, false, false])?;
//! let map = bake(&pattern, Storage::R8, &|_| ());
//! assert_eq!([0, 1, 2, 3].map(|x| map.decode(x, 0)), [-0.5, 0.5, 1.5, 0.5]);
//! assert_eq!(map.words().len(), 1); // four texels of 8 bits
//! # Ok::<(), relievo::shape_map::ShapeMapError>(())
//! ```

use super::distance::DistanceField;
use super::storage::{Coding, Encoding, Storage, largest_code, pack};
use std::sync::Arc;

/// Everything about a map but its words.
#[cfg(feature = "transfer")]
pub(crate) type Header = (u32, u32, Storage, Coding);

/// Signed distances to the pattern in one of four forms, as 32-bit words.
///
/// | storage | a texel | its distance, texels |
/// |---|---|---|
/// | [`Storage::R8`], [`Storage::R16`] | an unsigned code | (code − bias) · step |
/// | [`Storage::R32F`] | the bits of an f32 | the f32 |
/// | [`Storage::Rgba8`] | R, G: normal; B: distance to the nearest centre of the pattern; A: 0 on the pattern, else 255 | A = 0: −½, else max(B · step − ½, ½) |
///
/// Texel i = y · width + x is in word i · bits / 32 (rounded down), from bit
/// (i · bits) mod 32 on; R of Rgba8 is in the lowest bits and A in the highest.
/// Rows are not padded; the last word is padded with zeros.
///
/// All forms guarantee:
///
/// - A stored distance is at most the true one, and less by at most
///   [`quantum`](Self::quantum), with two exceptions. Values below
///   [`min_distance`](Self::min_distance), inside the pattern, are raised to
///   it. Values above [`max_distance`](Self::max_distance) are lowered to it,
///   which is safe for leaping as long as the pattern is grown by less.
///   (In an empty pattern the true distance is a convention, and Rgba8's is less
///   by another ½.)
/// - Stored distances of texels that share an edge, also across the map's
///   edges, differ by at most 1 + `quantum`; of R32F by 1 and the rounding of
///   f32, 2⁻²³ of the distance.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeMap {
    width: u32,
    height: u32,
    storage: Storage,
    coding: Coding,
    words: Vec<u32>,
}

impl ShapeMap {
    /// Encodes a distance field. The step of fixed-point codes is the smallest
    /// power of two, within the limits of the storage, with which the field's
    /// range fits; that of Rgba8 is f · max(EDT) / 255.
    pub fn encode(field: &DistanceField, encoding: impl Into<Encoding>) -> Self {
        let Encoding { storage, scale } = encoding.into();
        let (coding, words) = (storage.form().encode)(field, scale);
        Self {
            width: field.width(),
            height: field.height(),
            storage,
            coding,
            words,
        }
    }

    /// Encodes `fields` of one size with the same step and bias: one map each.
    pub(crate) fn encode_all(fields: &[DistanceField], storage: Storage) -> Vec<Self> {
        let all = Self::encode(&DistanceField::joined(fields), storage);
        let texels: Vec<usize> = (0..all.width as usize * all.height as usize).collect();
        let size = [fields[0].width(), fields[0].height()];
        texels
            .chunks(texels.len() / fields.len())
            .map(|texels| {
                let words = pack(storage.bits(), texels, |index| all.texel_at(index));
                Self::new(size, storage, all.coding, words)
            })
            .collect()
    }

    /// Returns a map whose words hold the texels of `maps`, one map after the other, and then
    /// `records`. The maps have one size and one coding, which are those of the result.
    pub(crate) fn joined(maps: &[Arc<ShapeMap>], records: Vec<u32>) -> Self {
        let count = maps[0].width as usize * maps[0].height as usize;
        let texels: Vec<usize> = (0..count * maps.len()).collect();
        let texel = |index: usize| maps[index / count].texel_at(index % count);
        let mut words = pack(maps[0].storage.bits(), &texels, texel);
        words.extend(records);
        ShapeMap { words, ..*maps[0] }
    }

    /// Creates a map from its packed texels.
    pub(super) fn new(
        [width, height]: [u32; 2],
        storage: Storage,
        coding: Coding,
        words: Vec<u32>,
    ) -> Self {
        Self {
            width,
            height,
            storage,
            coding,
            words,
        }
    }

    /// Returns the width in texels, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in texels, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the form of the texels.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// Returns the code of distance 0 for R8 and R16, otherwise 0.
    pub fn bias(&self) -> u32 {
        self.coding.bias
    }

    /// Returns the texels (of length) per unit of the code (R8, R16: a power of two)
    /// or of the blue channel (Rgba8: f · max(EDT) / 255); 0 for R32F.
    pub fn step(&self) -> f32 {
        self.coding.step
    }

    /// Returns the largest difference of a stored distance to the true one, in
    /// texels: a step, or 0 for R32F.
    pub fn quantum(&self) -> f32 {
        self.coding.step
    }

    /// Returns the paper's scale f for Rgba8, 0 < f ≤ 1 (equation (5)), otherwise 1.
    pub fn scale(&self) -> f32 {
        self.coding.scale
    }

    /// Returns the paper's τ = f · max(EDT) / W for Rgba8, in map widths (wu), with
    /// D = τ · B / 255 for the blue channel B (equations (4) and (5)). If f < 1,
    /// the pattern may be grown by less than this.
    pub fn tau(&self) -> Option<f32> {
        (self.storage() == Storage::Rgba8).then(|| 255.0 * self.step() / self.width as f32)
    }

    /// Returns the packed texels in the order of [`ShapeMap`].
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Returns the lowest distance that can be stored, in texels; 0 or negative. For
    /// R32F, which has no bounds: the lowest in the map, found by reading all of
    /// it.
    pub fn min_distance(&self) -> f32 {
        self.range().0
    }

    /// Returns the highest distance that can be stored, in texels. Leaping through a
    /// saturated map is safe while the pattern is grown by less than this. For
    /// R32F, which has no bounds: the highest in the map, found by reading all
    /// of it.
    pub fn max_distance(&self) -> f32 {
        self.range().1
    }

    fn range(&self) -> (f32, f32) {
        (self.storage.form().range)(self.coding, &self.words)
    }

    /// Returns whether distances are out of the range that can be stored; for Rgba8
    /// whether f < 1. The inside of Rgba8 is −½ everywhere and is not counted.
    pub fn saturated(&self) -> bool {
        self.coding.saturated
    }

    /// Returns a texel; coordinates wrap around.
    pub fn texel(&self, x: u32, y: u32) -> u32 {
        let (x, y) = (x % self.width, y % self.height);
        self.texel_at(y as usize * self.width as usize + x as usize)
    }

    /// Returns the stored distance in texels; coordinates wrap around.
    pub fn decode(&self, x: u32, y: u32) -> f32 {
        (self.storage.form().decode)(self.coding, self.texel(x, y))
    }

    /// Returns the stored normal of Rgba8: a unit vector (to ±1/255) away from the
    /// pattern, in pixels (y down). `None` on ridges, where no side is nearer, and
    /// for other forms. Coordinates wrap around.
    pub fn normal(&self, x: u32, y: u32) -> Option<[f32; 2]> {
        (self.storage.form().normal)(self.texel(x, y))
    }

    /// Returns everything but the words.
    #[cfg(feature = "transfer")]
    pub(crate) fn header(&self) -> Header {
        (self.width, self.height, self.storage, self.coding)
    }

    /// Creates a map from [`ShapeMap::header`] and its words; `None` if they are too few.
    #[cfg(feature = "transfer")]
    pub(crate) fn from_header(header: Header, words: Vec<u32>) -> Option<Self> {
        let (width, height, storage, coding) = header;
        let texels = (width as usize).checked_mul(height as usize)?;
        let needed = texels.div_ceil(storage.texels_per_word() as usize);
        // Records of layers may follow.
        let is_whole = texels > 0 && words.len() >= needed;
        is_whole.then(|| Self::new([width, height], storage, coding, words))
    }

    /// Checks that an encoder can have made every texel.
    pub(super) fn check_texels(&self) -> Result<(), String> {
        let Some(check) = self.storage.form().check_texel else {
            return Ok(());
        };
        let diagonal = f64::from(self.width).hypot(f64::from(self.height)) as f32;
        let count = self.width as usize * self.height as usize;
        (0..count).try_for_each(|index| check(self.texel_at(index), diagonal))
    }

    pub(super) fn coding(&self) -> Coding {
        self.coding
    }

    /// Returns the texel number `index` = y · width + x.
    fn texel_at(&self, index: usize) -> u32 {
        let storage = self.storage();
        let per_word = storage.texels_per_word() as usize;
        let shift = (index % per_word) as u32 * storage.bits();
        (self.words[index / per_word] >> shift) & largest_code(storage.bits())
    }
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

    /// Returns the field of a disc, or of its complement, in a square map.
    fn disc(size: u32, radius: u32, hole: bool) -> DistanceField {
        let pattern = Pattern::from_fn(size, size, |x, y| {
            let (x, y) = (x.abs_diff(size / 2), y.abs_diff(size / 2));
            (x * x + y * y < radius * radius) != hole
        });
        field(&pattern.unwrap())
    }

    /// Checks the guarantees of every form.
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
        let packed = |storage: Storage, texels: &[u32]| {
            let map = ShapeMap::encode(&disc(4, 1, false), storage);
            let words = pack(storage.bits(), texels, |t| t);
            ShapeMap::new([texels.len() as u32, 1], storage, map.coding, words)
        };
        let map = packed(Storage::R8, &[1, 2, 3, 4, 0xff]);
        assert_eq!(map.words(), [0x0403_0201, 0x0000_00ff]);
        assert_eq!((map.texel(3, 0), map.texel(4, 7)), (4, 0xff));
        let map = packed(Storage::R16, &[0x1234, 0xabcd, 0xffff]);
        assert_eq!(map.words(), [0xabcd_1234, 0x0000_ffff]);
        assert_eq!((map.texel(1, 0), map.texel(3, 0)), (0xabcd, 0x1234));
        for storage in [Storage::R32F, Storage::Rgba8] {
            let map = packed(storage, &[u32::MAX, 7]);
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
