//! SVG files: any text gives a pattern of the requested size or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::shape_map::{Pattern, PatternOptions};
use std::path::Path;

const RASTER: u32 = 32;

fuzz_target!(|text: &str| {
    let options = PatternOptions {
        raster: RASTER,
        ..PatternOptions::default()
    };
    match Pattern::from_bytes(text.as_bytes(), Path::new("drawing.svg"), &options) {
        Ok(pattern) => {
            let sides = [pattern.width(), pattern.height()];
            assert!(sides.iter().max() == Some(&RASTER) && sides.iter().all(|side| *side > 0));
        }
        Err(error) => assert!(error.to_string().contains("drawing.svg")),
    }
});
