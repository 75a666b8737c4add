//! Shape maps: from a binary image to the distances through which a renderer
//! marches.
//!
//! | step | module | result |
//! |---|---|---|
//! | 1. threshold an image, a drawing or text; choose pieces | [`pattern`] | [`Pattern`]: the pixels that are extruded |
//! | 2. distance transform | [`distance`] | [`DistanceField`]: exact, toroidal, signed, in texels |
//! | 3. encode | [`storage`], [`map`] | [`ShapeMap`]: packed texels in one of four forms |
//! | 4. save (optional) | [`mod@file`] | a PNG or OpenEXR file with its description |
//!
//! [`bake`] does steps 2 and 3. The map repeats in both directions, so distances
//! are measured on the torus. Their unit is one texel (divide by the map's width
//! for the renderer's width units, wu).
//!
//! Source: sections 1 and 3 of docs/algorithm.md.
//!
//! ```
//! use relievo::shape_map::{Pattern, Storage, bake};
//!
//! let disc = Pattern::from_fn(64, 64, |x, y| {
//!     (f64::from(x) - 31.5).hypot(f64::from(y) - 31.5) < 20.0
//! })?;
//! let map = bake(&disc, Storage::R16, &|_| ());
//! assert!((map.decode(31, 31) + 20.0).abs() < 2.0);
//! assert!(!map.saturated());
//! # Ok::<(), relievo::shape_map::ShapeMapError>(())
//! ```

pub mod distance;
mod drawing;
mod error;
pub mod file;
mod fonts;
mod input;
mod lettering;
mod limits;
pub mod map;
pub mod pattern;
mod picture;
mod pieces;
mod raster;
pub mod storage;

pub use distance::{DistanceField, Progress, signed_distance_field};
pub use error::ShapeMapError;
pub use lettering::Lettering;
pub use limits::{DEFAULT_MAX_PIXELS, MAX_PIXELS};
pub use map::ShapeMap;
pub use pattern::{Pattern, PatternOptions};
pub(crate) use picture::load_picture;
pub(crate) use pieces::neighbours;
pub use raster::{DEFAULT_RASTER, LARGEST_RASTER, SMALLEST_RASTER};
pub use storage::{Encoding, Storage};

/// Fraction of the time of [`bake`] for the distance transform (measured).
const TRANSFORM_SHARE: f64 = 0.7;

/// Computes the signed distance field of `pattern` and encodes it in a
/// [`Storage`], or an [`Encoding`] with its scale.
///
/// `progress` is called from time to time, from any thread, with the fraction of
/// the work that is done, 0…1; the last call is with 1.
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
