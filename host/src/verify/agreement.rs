//! Compares two renderings of a frame word by word.
//!
//! ```
//! use relievo::render::{ColorWords, GeometryWords};
//! use relievo::verify::compare;
//!
//! let gpu = ColorWords { width: 1, height: 1, words: vec![[1, 2, 3, 1]] };
//! let cpu = ColorWords { width: 1, height: 1, words: vec![[1, 2, 4, 1]] };
//! let geometry = GeometryWords {
//!     width: 1,
//!     height: 1,
//!     place: vec![[0; 4]],
//!     surface: vec![[0; 4]],
//! };
//! let agreement = compare([&gpu, &cpu], [&geometry, &geometry]);
//! assert_eq!((agreement.words(), agreement.different()), (12, 1));
//! ```

use crate::render::{ColorWords, GeometryWords};
use relievo_bitwise::{Batch, Tally};
use relievo_shared::shading::edges::{from_code, lights_of};

/// Names of the words of a pixel of [`ColorWords`].
pub const COLOR_NAMES: [&str; 4] = ["red", "green", "blue", "class"];
/// Names of the words of a pixel of [`GeometryWords`]: place, then surface.
pub const GEOMETRY_NAMES: [&str; 8] = [
    "t",
    "u",
    "v",
    "delta",
    "class and steps",
    "N.x",
    "N.y",
    "N.z",
];

/// Differences between two renderings of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Width of the pictures, pixels.
    pub width: usize,
    /// Colour words. Inputs are pixels, in rows from the top.
    pub color: Tally,
    /// Geometry words. Inputs are pixels, in rows from the top.
    pub geometry: Tally,
    /// Largest difference of a linear colour channel.
    pub largest_color_difference: f32,
    /// Number of pixels with different surface classes.
    pub class_pixels: usize,
    /// Largest relative difference of the distance t where both hit.
    pub largest_distance_difference: f32,
}

impl Agreement {
    /// Returns whether words were compared and none differs.
    pub fn is_exact(&self) -> bool {
        self.color.is_exact() && self.geometry.is_exact()
    }

    /// Returns the number of words compared.
    pub fn words(&self) -> u64 {
        self.color.words + self.geometry.words
    }

    /// Returns the number of words that differ.
    pub fn different(&self) -> u64 {
        self.color.different + self.geometry.different
    }
}

/// Compares two renderings of a frame, the GPU's first.
///
/// # Panics
/// If their sizes differ.
pub fn compare(color: [&ColorWords; 2], geometry: [&GeometryWords; 2]) -> Agreement {
    let [gpu, cpu] = color;
    assert_eq!((gpu.width, gpu.height), (cpu.width, cpu.height));
    let mut agreement = Agreement {
        width: gpu.width as usize,
        color: tally(gpu.words.as_flattened(), cpu.words.as_flattened(), 4),
        ..Agreement::default()
    };
    for (gpu, cpu) in gpu.words.iter().zip(&cpu.words) {
        agreement.class_pixels += usize::from(from_code(gpu[3]).0 != from_code(cpu[3]).0);
        agreement.largest_color_difference = larger(
            agreement.largest_color_difference,
            color_difference(*gpu, *cpu),
        );
    }
    let [gpu, cpu] = geometry;
    assert_eq!((gpu.width, gpu.height), (cpu.width, cpu.height));
    agreement.geometry = tally(&interleaved(gpu), &interleaved(cpu), 8);
    let distances = gpu.place.iter().zip(&cpu.place);
    let classes = gpu.surface.iter().zip(&cpu.surface);
    for ((place_gpu, place_cpu), (surface_gpu, surface_cpu)) in distances.zip(classes) {
        if surface_gpu[0] != 0 && surface_cpu[0] != 0 {
            let [t_gpu, t_cpu] = [place_gpu[0], place_cpu[0]].map(f32::from_bits);
            agreement.largest_distance_difference = larger(
                agreement.largest_distance_difference,
                (t_gpu - t_cpu).abs() / t_cpu.abs(),
            );
        }
    }
    agreement
}

/// Returns the largest difference of a linear colour channel between two pixels of [`ColorWords`], of what they hit
/// and of what lies between them and their neighbours, which counts by its share. Infinite if one is NaN.
pub fn color_difference(a: [u32; 4], b: [u32; 4]) -> f32 {
    let [a, b] = [a, b].map(|words| {
        let (own, between) = lights_of(words.into());
        [own, between * from_code(words[3]).1.between]
    });
    let channels = a.iter().zip(b).flat_map(|(a, b)| (*a - b).to_array());
    channels.fold(0.0, |largest, channel| larger(largest, channel.abs()))
}

/// Returns place and surface of each pixel in turn.
fn interleaved(geometry: &GeometryWords) -> Vec<u32> {
    let pixels = geometry.place.iter().zip(&geometry.surface);
    pixels
        .flat_map(|(place, surface)| place.iter().chain(surface).copied())
        .collect()
}

fn tally(gpu: &[u32], cpu: &[u32], words: usize) -> Tally {
    Tally::of(&Batch {
        first: 0,
        inputs: &[],
        input_words: 0,
        gpu,
        cpu,
        output_words: words,
    })
}

/// Returns the larger number. A NaN in `b` counts as infinite.
fn larger(a: f32, b: f32) -> f32 {
    if b.is_nan() { f32::INFINITY } else { a.max(b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color(words: Vec<[u32; 4]>) -> ColorWords {
        ColorWords {
            width: words.len() as u32,
            height: 1,
            words,
        }
    }

    fn geometry(place: Vec<[u32; 4]>, surface: Vec<[u32; 4]>) -> GeometryWords {
        GeometryWords {
            width: place.len() as u32,
            height: 1,
            place,
            surface,
        }
    }

    #[test]
    fn one_different_bit_is_seen() {
        let one = 1f32.to_bits();
        let a = color(vec![[one, one, one, 1]; 3]);
        let mut b = a.clone();
        b.words[1][2] ^= 1;
        let g = geometry(vec![[one; 4]; 3], vec![[1; 4]; 3]);
        let mut h = g.clone();
        h.surface[2][1] ^= 1;
        assert!(compare([&a, &a], [&g, &g]).is_exact());
        let color_differs = compare([&a, &b], [&g, &g]);
        assert!(!color_differs.is_exact());
        let tally = &color_differs.color;
        assert_eq!((tally.inputs_different, tally.different), (1, 1));
        assert_eq!((tally.first[0].index, tally.first[0].word), (1, 2));
        assert!(color_differs.largest_color_difference > 0.0);
        let geometry_differs = compare([&a, &a], [&g, &h]);
        assert!(!geometry_differs.is_exact());
        assert_eq!(geometry_differs.different(), 1);
        let first = &geometry_differs.geometry.first[0];
        assert_eq!((first.index, GEOMETRY_NAMES[first.word]), (2, "N.x"));
    }

    #[test]
    fn a_nan_is_a_difference_without_bound() {
        let a = color(vec![[f32::NAN.to_bits(), 0, 0, 1]]);
        let b = color(vec![[0, 0, 0, 1]]);
        let g = geometry(vec![[0; 4]], vec![[0; 4]]);
        assert_eq!(
            compare([&a, &b], [&g, &g]).largest_color_difference,
            f32::INFINITY
        );
    }
}
