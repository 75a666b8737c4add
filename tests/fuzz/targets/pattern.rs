//! Images: any bytes, with the extension of any format, give a pattern within
//! the limit or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::shape_map::{Pattern, PatternOptions, ShapeMapError};
use std::path::Path;

const MAX_PIXELS: u64 = 1 << 14;

fuzz_target!(|bytes: &[u8]| {
    let options = PatternOptions {
        max_pixels: MAX_PIXELS,
        ..PatternOptions::default()
    };
    // The content determines the format, otherwise the name.
    for name in ["pattern.png", "pattern.tga"] {
        match Pattern::from_bytes(bytes, Path::new(name), &options) {
            Ok(pattern) => {
                let pixels = u64::from(pattern.width()) * u64::from(pattern.height());
                assert!((1..=MAX_PIXELS).contains(&pixels));
                assert_eq!(pattern.solid().len() as u64, pixels);
            }
            Err(ShapeMapError::TooLarge { width, height, .. }) => {
                assert!(u64::from(width) * u64::from(height) > MAX_PIXELS);
            }
            Err(error) => assert!(error.to_string().contains(name)),
        }
    }
});
