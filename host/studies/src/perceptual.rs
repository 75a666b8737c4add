//! Perceptual difference of two pictures: LDR-FLIP (P. Andersson et al., "FLIP:
//! a difference evaluator for alternating images", 2020).

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, flip};
use relievo::picture::Picture;

/// Returns the mean FLIP difference of `picture` from `reference` at 67 pixels
/// per degree, from 0 (none) to 1.
///
/// # Panics
/// If the sizes differ.
pub fn difference(reference: &Picture, picture: &Picture) -> f64 {
    let image =
        |picture: &Picture| FlipImageRgb8::with_data(picture.width, picture.height, &picture.bytes);
    let errors = flip(image(reference), image(picture), DEFAULT_PIXELS_PER_DEGREE).to_vec();
    let sum: f64 = errors.iter().map(|error| f64::from(*error)).sum();
    sum / errors.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns 40 × 30 grey pixels with a red square of side `side`.
    fn picture(side: usize) -> Picture {
        let pixel = |i: usize| match (i % 40 < side, i / 40 < side) {
            (true, true) => [200, 20, 20],
            _ => [128; 3],
        };
        Picture {
            width: 40,
            height: 30,
            bytes: (0..40 * 30).flat_map(pixel).collect(),
        }
    }

    #[test]
    fn the_same_pictures_do_not_differ_and_others_the_more_the_more_differs() {
        let reference = picture(4);
        assert_eq!(difference(&reference, &picture(4)), 0.0);
        let near = difference(&reference, &picture(5));
        let far = difference(&reference, &picture(20));
        assert!(0.0 < near && near < far && far < 1.0, "{near} {far}");
    }
}
