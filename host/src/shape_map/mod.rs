//! Shape maps: from a binary picture to the distances a renderer marches through.
//!
//! | step | module | result |
//! |---|---|---|
//! | 1. threshold an image, a drawing or text | [`pattern`] | [`Pattern`]: which pixels are extruded |
//! | 2. distance transform | [`distance`] | [`DistanceField`]: exact, toroidal, signed, in texels |
//! | 3. encode | [`storage`], [`map`] | [`ShapeMap`]: packed texels in one of four forms |
//! | 4. keep (optional) | [`mod@file`] | a PNG or OpenEXR file that says how to decode it |
//!
//! [`bake`] does steps 2 and 3. The map repeats in both directions, so every
//! distance is measured on the torus. Unit of all distances here: one texel
//! (divide by the map's width for the renderer's width units, wu).
//!
//! Source: algorithm.md, sections 1 and 3.

mod coding;
pub mod distance;
mod drawing;
mod error;
pub mod file;
mod input;
mod lettering;
pub mod map;
pub mod pattern;
mod rgba8;
pub mod storage;

pub use distance::{DistanceField, Progress, signed_distance_field};
pub use drawing::{DEFAULT_RASTER, LARGEST_RASTER, SMALLEST_RASTER};
pub use error::ShapeMapError;
pub use input::{DEFAULT_MAX_PIXELS, MAX_PIXELS};
pub use lettering::Lettering;
pub use map::ShapeMap;
pub use pattern::{Pattern, PatternOptions};
pub use storage::{Encoding, Storage};

/// Part of the time of [`bake`] that the distance transform takes (measured).
const TRANSFORM_SHARE: f64 = 0.7;

/// Computes the signed distance field of `pattern` and encodes it: in a
/// [`Storage`], or an [`Encoding`] with its scale.
///
/// `progress` is called from time to time, from any thread, with the fraction
/// done in 0…1, and ends at 1.
pub fn bake(pattern: &Pattern, encoding: impl Into<Encoding>, progress: &Progress<'_>) -> ShapeMap {
    let field = signed_distance_field(pattern, &|fraction| progress(fraction * TRANSFORM_SHARE));
    let map = ShapeMap::encode(&field, encoding);
    progress(1.0);
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn bake_encodes_the_distance_field_and_ends_its_progress_at_one() {
        let pattern = Pattern::from_fn(70, 33, |x, y| x / 9 == y / 7).unwrap();
        let fractions = Mutex::new(Vec::new());
        let map = bake(&pattern, Storage::R16, &|fraction| {
            fractions.lock().unwrap().push(fraction);
        });
        let field = signed_distance_field(&pattern, &|_| ());
        assert_eq!(map, ShapeMap::encode(&field, Storage::R16));
        let fractions = fractions.into_inner().unwrap();
        assert!(fractions.len() > 2);
        assert!(fractions.iter().all(|f| (0.0..=1.0).contains(f)));
        assert_eq!(fractions.last(), Some(&1.0));
    }
}
