//! Computes a picture of the landscape on the CPU:
//! `cargo run --release -p terrain --example picture -- out/terrain.png`.

use glam::UVec2;
use image::{Rgb, RgbImage};
use rayon::prelude::*;
use std::path::Path;
use terrain::view::{View, color};

const SIZE: UVec2 = UVec2::new(640, 400);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).unwrap_or("terrain.png".to_string());
    let view = View::overlook(10.0);
    let pixels: Vec<_> = (0..SIZE.x * SIZE.y)
        .into_par_iter()
        .map(|i| color(UVec2::new(i % SIZE.x, i / SIZE.x), SIZE, &view))
        .collect();
    let picture = RgbImage::from_fn(SIZE.x, SIZE.y, |x, y| {
        let linear = pixels[(y * SIZE.x + x) as usize];
        Rgb([linear.x, linear.y, linear.z].map(|channel| (255.0 * encode(channel)).round() as u8))
    });
    if let Some(folder) = Path::new(&path).parent() {
        std::fs::create_dir_all(folder)?;
    }
    Ok(picture.save(path)?)
}

/// Returns the sRGB code of a linear channel.
fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}
