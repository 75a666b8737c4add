//! Rasterises drawings and text.

use image::RgbaImage;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::Tree;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Minimum number of pixels on the longer side of a rasterised drawing or text.
pub const SMALLEST_RASTER: u32 = 8;
/// Maximum number of pixels on the longer side.
pub const LARGEST_RASTER: u32 = 32_768;
/// Default number of pixels on the longer side.
pub const DEFAULT_RASTER: u32 = 512;

/// Returns width and height in pixels for the aspect ratio of `size`: `raster`
/// pixels on the longer side, at least 1 on the other.
pub(super) fn sides([width, height]: [f64; 2], raster: u32) -> [u32; 2] {
    let scale = f64::from(raster) / width.max(height);
    // The conversion to an integer saturates.
    [width, height].map(|side| ((side * scale).round() as u32).clamp(1, raster))
}

/// Renders a drawing on white.
///
/// # Errors
/// The problem and the remedy, if the picture does not fit in memory or the
/// rasteriser panics.
pub(super) fn paint(
    tree: &Tree,
    [width, height]: [u32; 2],
    transform: Transform,
) -> Result<RgbaImage, String> {
    let too_large =
        || format!("{width} × {height} pixels do not fit in memory; make raster smaller");
    let mut picture = Pixmap::new(width, height).ok_or_else(too_large)?;
    picture.fill(Color::WHITE);
    // The rasteriser may panic at very large coordinates.
    catch_unwind(AssertUnwindSafe(|| {
        resvg::render(tree, transform, &mut picture.as_mut());
    }))
    .map_err(|_| "the rasteriser gave up; keep its shapes near the visible area")?;
    // All pixels are opaque, so premultiplied alpha makes no difference.
    RgbaImage::from_raw(width, height, picture.take()).ok_or_else(too_large)
}
