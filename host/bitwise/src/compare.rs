//! Counts the words that differ, by their distance in ULPs.
//!
//! ```
//! use relievo_bitwise::{Tally, ulp_distance};
//!
//! let (one, next) = (1_f32.to_bits(), 1_f32.next_up().to_bits());
//! assert_eq!(ulp_distance(one, next), 1);
//!
//! let mut tally = Tally::default();
//! tally.add(0, &[one], &[one, one], &[one, next]);
//! assert_eq!((tally.words, tally.different, tally.largest), (2, 1, 1));
//! assert_eq!((tally.first[0].word, tally.first[0].cpu), (1, next));
//! ```

use rayon::prelude::*;

/// Number of differences that a [`Tally`] keeps in full.
pub const KEPT: usize = 8;

/// Number of results that a thread compares at a time.
const CHUNK: usize = 4096;

/// Returns the number of steps between neighbouring f32 from one word to the other:
/// 0 for equal words, 1 between −0 and +0, and `u64::MAX` if the words differ and
/// one is a NaN.
pub fn ulp_distance(a: u32, b: u32) -> u64 {
    let place = |word: u32| match i64::from(word & 0x7fff_ffff) {
        magnitude if word >> 31 == 0 => magnitude,
        magnitude => -1 - magnitude,
    };
    if a == b {
        0
    } else if f32::from_bits(a).is_nan() || f32::from_bits(b).is_nan() {
        u64::MAX
    } else {
        place(a).abs_diff(place(b))
    }
}

/// Histogram of distances in ULPs, with the classes 0, 1, 2, 3–4, 5–8, …
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    /// Number of words per class; the last class is that of NaN.
    counts: [u64; Histogram::CLASSES],
}

impl Histogram {
    /// Classes for zero, for 2⁰ to 2³² ULPs, and for NaN.
    const CLASSES: usize = 35;

    fn add(&mut self, distance: u64, words: u64) {
        let class = match distance {
            0 => 0,
            u64::MAX => Histogram::CLASSES - 1,
            // Exponent of the next power of two; no two f32 are more than 2³² apart.
            _ => 1 + (u64::BITS - (distance - 1).leading_zeros()) as usize,
        };
        self.counts[class] += words;
    }

    fn merge(&mut self, other: &Histogram) {
        for (count, more) in self.counts.iter_mut().zip(other.counts) {
            *count += more;
        }
    }

    /// Returns the number of words without a distance: one side is a NaN or missing.
    pub fn nan(&self) -> u64 {
        self.counts[Histogram::CLASSES - 1]
    }

    /// Returns the classes that are not empty, each as its largest distance and its
    /// number of words. Those of [`Histogram::nan`] are not included.
    pub fn classes(&self) -> impl Iterator<Item = (u64, u64)> {
        let finite = &self.counts[..Histogram::CLASSES - 1];
        (0..)
            .zip(finite)
            .map(|(class, &count)| (if class == 0 { 0 } else { 1 << (class - 1) }, count))
            .filter(|&(_, count)| count > 0)
    }
}

impl Default for Histogram {
    fn default() -> Histogram {
        Histogram {
            counts: [0; Histogram::CLASSES],
        }
    }
}

/// A word that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Index of the input.
    pub index: u64,
    /// Words of the input.
    pub input: Vec<u32>,
    /// Index of the word in the result.
    pub word: usize,
    /// The GPU's word; 0 if missing.
    pub gpu: u32,
    /// The CPU's word; 0 if missing.
    pub cpu: u32,
    /// Their [`ulp_distance`]; `u64::MAX` if one is missing.
    pub ulp: u64,
}

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of inputs compared.
    pub inputs: u64,
    /// Number of inputs with at least one different word.
    pub inputs_different: u64,
    /// Number of words compared.
    pub words: u64,
    /// Number of words that differ.
    pub different: u64,
    /// Largest distance, ULPs, without NaN.
    pub largest: u64,
    /// Distances of all words.
    pub histogram: Histogram,
    /// The first [`KEPT`] differences, ordered by input and word.
    pub first: Vec<Difference>,
}

impl Tally {
    /// Returns whether words were compared and none differs.
    pub fn is_exact(&self) -> bool {
        self.words > 0 && self.different == 0
    }

    /// Compares the results for the input `index`. A word that one side lacks is a
    /// difference.
    pub fn add(&mut self, index: u64, input: &[u32], gpu: &[u32], cpu: &[u32]) {
        let count = gpu.len().max(cpu.len());
        self.inputs += 1;
        self.words += count as u64;
        if gpu == cpu {
            self.histogram.add(0, count as u64);
            return;
        }
        self.inputs_different += 1;
        for word in 0..count {
            let (gpu, cpu) = (gpu.get(word).copied(), cpu.get(word).copied());
            let ulp = match (gpu, cpu) {
                (Some(gpu), Some(cpu)) => ulp_distance(gpu, cpu),
                _ => u64::MAX,
            };
            self.histogram.add(ulp, 1);
            if ulp == 0 {
                continue;
            }
            self.different += 1;
            if ulp != u64::MAX {
                self.largest = self.largest.max(ulp);
            }
            let place = (index, word);
            let after = |kept: &Difference| (kept.index, kept.word) < place;
            let at = self.first.partition_point(after);
            if at < KEPT {
                let difference = Difference {
                    index,
                    input: input.to_vec(),
                    word,
                    gpu: gpu.unwrap_or(0),
                    cpu: cpu.unwrap_or(0),
                    ulp,
                };
                self.first.insert(at, difference);
                self.first.truncate(KEPT);
            }
        }
    }

    /// Adds the result of another comparison.
    pub fn merge(&mut self, other: Tally) {
        self.inputs += other.inputs;
        self.inputs_different += other.inputs_different;
        self.words += other.words;
        self.different += other.different;
        self.largest = self.largest.max(other.largest);
        self.histogram.merge(&other.histogram);
        self.first.extend(other.first);
        self.first.sort_by_key(|kept| (kept.index, kept.word));
        self.first.truncate(KEPT);
    }

    /// Compares the results of many inputs on all cores.
    pub fn of(batch: &Batch) -> Tally {
        let Some(output_words) = Some(batch.output_words).filter(|&words| words > 0) else {
            return Tally::default();
        };
        let longest = batch.gpu.len().max(batch.cpu.len());
        let count = longest.div_ceil(output_words);
        (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut tally = Tally::default();
                for number in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                    tally.add(
                        batch.first + number as u64,
                        group(batch.inputs, batch.input_words, number),
                        group(batch.gpu, output_words, number),
                        group(batch.cpu, output_words, number),
                    );
                }
                tally
            })
            .reduce(Tally::default, |mut tally, other| {
                tally.merge(other);
                tally
            })
    }
}

/// Results for consecutive inputs.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// Index of the first input.
    pub first: u64,
    /// Words of the inputs; may be empty, as for the pixels of a picture.
    pub inputs: &'a [u32],
    /// Number of words per input.
    pub input_words: usize,
    /// The GPU's words.
    pub gpu: &'a [u32],
    /// The CPU's words.
    pub cpu: &'a [u32],
    /// Number of words per result.
    pub output_words: usize,
}

/// Returns the words of the group `number`, each of `length` words, as far as there
/// are any.
fn group(words: &[u32], length: usize, number: usize) -> &[u32] {
    let start = (number * length).min(words.len());
    let end = (start + length).min(words.len());
    &words[start..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(a: f32, b: f32) -> u64 {
        ulp_distance(a.to_bits(), b.to_bits())
    }

    #[test]
    fn distances_count_the_numbers_between() {
        assert_eq!(distance(1.0, 1.0), 0);
        assert_eq!(distance(1.0, f32::next_up(1.0)), 1);
        assert_eq!(distance(1.0, f32::next_down(1.0)), 1);
        assert_eq!(distance(1.0, 2.0), 1 << 23);
        assert_eq!(distance(-0.0, 0.0), 1);
        assert_eq!(distance(f32::from_bits(1), -f32::from_bits(1)), 3);
        assert_eq!(distance(-3.0, 5.0), distance(5.0, -3.0));
        assert_eq!(distance(f32::MAX, f32::INFINITY), 1);
        assert_eq!(distance(f32::NAN, 1.0), u64::MAX);
        assert_eq!(distance(f32::NAN, -f32::NAN), u64::MAX);
        assert_eq!(distance(f32::NAN, f32::NAN), 0);
    }

    #[test]
    fn classes_end_at_powers_of_two() {
        let mut histogram = Histogram::default();
        let farthest = distance(f32::INFINITY, f32::NEG_INFINITY);
        for distance in [0, 1, 2, 3, 4, 5, 8, 9, farthest, u64::MAX] {
            histogram.add(distance, 1);
        }
        let classes: Vec<_> = histogram.classes().collect();
        let expected = [
            (0, 1),
            (1, 1),
            (2, 1),
            (4, 2),
            (8, 2),
            (16, 1),
            (1 << 32, 1),
        ];
        assert_eq!(classes, expected);
        assert_eq!(histogram.nan(), 1);
    }

    #[test]
    fn a_tally_keeps_differences_and_their_places() {
        let one = 1.0_f32.to_bits();
        let mut tally = Tally::default();
        assert!(!tally.is_exact(), "nothing was compared");
        tally.add(5, &[50], &[one, 7], &[one, 7]);
        assert!(tally.is_exact());
        tally.add(3, &[30], &[one, 7], &[one + 3, 7]);
        tally.add(4, &[40], &[one, 0x7fc0_0000], &[one, 7]);
        assert!(!tally.is_exact());
        assert_eq!((tally.inputs, tally.inputs_different), (3, 2));
        assert_eq!((tally.words, tally.different), (6, 2));
        assert_eq!((tally.largest, tally.histogram.nan()), (3, 1));
        let first = &tally.first[0];
        assert_eq!(
            (first.index, first.input.as_slice(), first.word, first.ulp),
            (3, &[30][..], 0, 3)
        );
        assert_eq!((first.gpu, first.cpu), (one, one + 3));
        assert_eq!((tally.first[1].index, tally.first[1].word), (4, 1));
    }

    #[test]
    fn a_missing_word_is_a_difference() {
        let mut tally = Tally::default();
        tally.add(0, &[], &[1, 2], &[1]);
        assert_eq!((tally.words, tally.different), (2, 1));
        let batch = Batch {
            first: 0,
            inputs: &[],
            input_words: 0,
            gpu: &[1, 2, 3, 4],
            cpu: &[1, 2],
            output_words: 2,
        };
        let tally = Tally::of(&batch);
        assert_eq!((tally.inputs, tally.words, tally.different), (2, 4, 2));
    }

    #[test]
    fn many_cores_find_the_same_as_one() {
        let cpu: Vec<u32> = (0..30_000).collect();
        let mut gpu = cpu.clone();
        for at in (100..30_000).step_by(1000) {
            gpu[at] += 1 + (at as u32 % 7);
        }
        let batch = Batch {
            first: 1_000_000,
            inputs: &cpu[..10_000],
            input_words: 1,
            gpu: &gpu,
            cpu: &cpu,
            output_words: 3,
        };
        let tally = Tally::of(&batch);
        let mut alone = Tally::default();
        // Backwards, to show that the order does not matter.
        for number in (0..10_000).rev() {
            let words = 3 * number..3 * number + 3;
            alone.add(
                1_000_000 + number as u64,
                &cpu[number..number + 1],
                &gpu[words.clone()],
                &cpu[words],
            );
        }
        assert_eq!(tally, alone);
        assert_eq!((tally.different, tally.first.len()), (30, KEPT));
        assert_eq!(tally.first[0].index, 1_000_033);
        assert_eq!(tally.first[0].input, [33]);
        assert_eq!((tally.first[0].word, tally.first[1].index), (1, 1_000_366));
    }
}
