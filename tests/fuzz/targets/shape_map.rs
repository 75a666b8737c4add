//! Baked shape maps: any bytes give a valid map or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::shape_map::{ShapeMap, ShapeMapError, Storage};
use std::path::Path;

const MAX_PIXELS: u64 = 1 << 14;

fuzz_target!(|bytes: &[u8]| {
    match ShapeMap::from_bytes(bytes, Path::new("map"), MAX_PIXELS) {
        Ok(map) => {
            let pixels = u64::from(map.width()) * u64::from(map.height());
            assert!((1..=MAX_PIXELS).contains(&pixels));
            let per_word = u64::from(map.storage().texels_per_word());
            assert_eq!(map.words().len() as u64, pixels.div_ceil(per_word));
            let range = map.min_distance()..=map.max_distance();
            let first = map.decode(0, 0);
            assert!(range.contains(&first), "{first} is out of {range:?}");
            assert!(map.storage() != Storage::R32F || first.abs() >= 0.5);
        }
        Err(ShapeMapError::TooLarge { width, height, .. }) => {
            assert!(u64::from(width) * u64::from(height) > MAX_PIXELS);
        }
        Err(error) => assert!(error.to_string().contains("map")),
    }
});
