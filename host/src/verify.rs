//! GPU words against CPU words: the same code must give the same picture.

use crate::render::{ColorWords, GeometryWords};

/// How far two renderings of one frame agree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Agreement {
    /// Pixels compared.
    pub pixels: usize,
    /// Pixels of which any colour word differs.
    pub color_pixels: usize,
    /// Colour words compared, four a pixel.
    pub color_words: usize,
    /// Colour words that differ.
    pub different_color_words: usize,
    /// Largest difference of a linear colour channel.
    pub largest_color_difference: f32,
    /// Pixels of which the surface class differs.
    pub class_pixels: usize,
    /// Geometry words compared, eight a pixel.
    pub geometry_words: usize,
    /// Geometry words that differ.
    pub different_geometry_words: usize,
    /// Largest difference of the distance t where both hit, relative to t.
    pub largest_distance_difference: f32,
}

impl Agreement {
    /// Whether every word is the same.
    pub fn is_exact(&self) -> bool {
        self.different_color_words == 0 && self.different_geometry_words == 0
    }
}

/// Compares two renderings of the same frame.
///
/// # Panics
/// If their sizes differ.
pub fn compare(color: [&ColorWords; 2], geometry: [&GeometryWords; 2]) -> Agreement {
    let [a, b] = color;
    assert_eq!((a.width, a.height), (b.width, b.height));
    let mut agreement = Agreement {
        pixels: a.words.len(),
        color_words: 4 * a.words.len(),
        geometry_words: 8 * a.words.len(),
        ..Agreement::default()
    };
    for (a, b) in a.words.iter().zip(&b.words) {
        let different = count_different(a, b);
        agreement.different_color_words += different;
        agreement.color_pixels += usize::from(different > 0);
        agreement.class_pixels += usize::from(a[3] != b[3]);
        for channel in 0..3 {
            let difference = (f32::from_bits(a[channel]) - f32::from_bits(b[channel])).abs();
            agreement.largest_color_difference =
                larger(agreement.largest_color_difference, difference);
        }
    }
    let [a, b] = geometry;
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pixels = a
        .place
        .iter()
        .zip(&b.place)
        .zip(a.surface.iter().zip(&b.surface));
    for ((place_a, place_b), (surface_a, surface_b)) in pixels {
        agreement.different_geometry_words +=
            count_different(place_a, place_b) + count_different(surface_a, surface_b);
        if surface_a[0] != 0 && surface_b[0] != 0 {
            let (ta, tb) = (f32::from_bits(place_a[0]), f32::from_bits(place_b[0]));
            agreement.largest_distance_difference = larger(
                agreement.largest_distance_difference,
                (ta - tb).abs() / ta.abs(),
            );
        }
    }
    agreement
}

fn count_different(a: &[u32; 4], b: &[u32; 4]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// The larger number; a NaN counts as infinitely large, so that it is seen.
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
        assert_eq!(
            (
                color_differs.color_pixels,
                color_differs.different_color_words
            ),
            (1, 1)
        );
        assert!(color_differs.largest_color_difference > 0.0);
        let geometry_differs = compare([&a, &a], [&g, &h]);
        assert!(!geometry_differs.is_exact());
        assert_eq!(geometry_differs.different_geometry_words, 1);
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
