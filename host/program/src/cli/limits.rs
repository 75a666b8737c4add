//! Flags that raise the resource limits of scenes.

use clap::Args;
use relievo::Limits;
use relievo::shape_map::{DEFAULT_MAX_PIXELS, MAX_PIXELS};

/// Resource limits of a scene.
#[derive(Args, Clone)]
#[command(next_help_heading = "Limits (docs/limits.md)")]
pub struct LimitArguments {
    /// Maximum number of objects in a scene
    #[arg(long, value_name = "N", default_value_t = Limits::default().objects)]
    max_objects: usize,
    /// Maximum number of triangles of all objects
    #[arg(long, value_name = "N", default_value_t = Limits::default().triangles)]
    max_triangles: usize,
    #[command(flatten)]
    pixels: PixelArguments,
    /// Maximum estimated memory of meshes, shape maps and picture, such as 500M or 16G
    #[arg(long, value_name = "BYTES", default_value = "8G", value_parser = parse_bytes)]
    max_memory: u64,
    /// Let scenes read files outside their folder (or the folder around it, if it is called scenes)
    #[arg(long)]
    allow_outside: bool,
}

/// Size limit of images.
#[derive(Args, Clone)]
pub struct PixelArguments {
    /// Maximum number of pixels of a pattern or a shape map
    #[arg(long, value_name = "N", default_value_t = DEFAULT_MAX_PIXELS, value_parser = clap::value_parser!(u64).range(1..=MAX_PIXELS))]
    pub max_pixels: u64,
}

impl LimitArguments {
    /// Returns the requested limits.
    pub fn limits(&self) -> Limits {
        Limits {
            objects: self.max_objects,
            triangles: self.max_triangles,
            pixels: self.pixels.max_pixels,
            memory: self.max_memory,
            outside: self.allow_outside,
        }
    }
}

/// `500M` → 500 · 2²⁰.
fn parse_bytes(text: &str) -> Result<u64, String> {
    let units = [("K", 10), ("M", 20), ("G", 30), ("T", 40)];
    let (number, shift) = units
        .iter()
        .find_map(|(unit, shift)| Some((text.strip_suffix(unit)?, *shift)))
        .unwrap_or((text, 0));
    number
        .parse()
        .ok()
        .and_then(|number: u64| number.checked_mul(1 << shift))
        .ok_or_else(|| "an amount of memory is a number of bytes, such as 500M or 16G".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_of_memory() {
        for (text, bytes) in [
            ("0", 0),
            ("1000", 1000),
            ("3K", 3 << 10),
            ("500M", 500 << 20),
            ("16G", 16 << 30),
            ("2T", 2 << 40),
        ] {
            assert_eq!(parse_bytes(text), Ok(bytes), "{text}");
        }
        for bad in ["", "G", "-1", "1.5G", "16 G", "16GB", "99999999999T"] {
            assert!(parse_bytes(bad).is_err(), "{bad}");
        }
    }
}
