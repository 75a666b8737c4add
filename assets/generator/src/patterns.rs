//! The binary patterns. Extruded pixels are black (0), the others white (255).
//! Every pattern repeats in both directions without a seam.

use anyhow::{Context, Result};
use glam::DVec2;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, GrayImage, ImageEncoder, Luma};

use crate::glyphs::{Glyph, Letter};
use crate::sdf;

/// A pattern with its name.
pub struct Pattern {
    /// Name of the file, without extension.
    pub name: &'static str,
    /// The pixels, each 0 (extruded) or 255.
    pub image: GrayImage,
}

impl Pattern {
    /// Draws a pattern by evaluating `black` at the centre of every pixel, in pixels
    /// from the top left corner of the image, y down.
    fn draw(
        name: &'static str,
        (width, height): (u32, u32),
        black: impl Fn(DVec2) -> bool,
    ) -> Self {
        let image = GrayImage::from_fn(width, height, |x, y| {
            let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            Luma([if black(centre) { 0 } else { 255 }])
        });
        Self { name, image }
    }

    /// Returns the pattern as an 8-bit grayscale PNG file.
    ///
    /// # Errors
    ///
    /// If the encoder fails.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::NoFilter)
            .write_image(
                &self.image,
                self.image.width(),
                self.image.height(),
                ExtendedColorType::L8,
            )
            .with_context(|| format!("cannot encode the pattern {}", self.name))?;
        Ok(bytes)
    }
}

/// Returns all patterns.
pub fn all() -> Vec<Pattern> {
    vec![
        letters(),
        hexagons(),
        bricks(),
        discs(),
        windows(),
        lattice(),
        shingles(),
        panes(),
    ]
}

/// Returns `point` relative to the centre of its cell, in a grid of cells of `size`
/// that starts at the origin.
fn in_cell(point: DVec2, size: DVec2) -> DVec2 {
    point - ((point / size).floor() + 0.5) * size
}

/// The name of the project in two rows of equal width.
fn letters() -> Pattern {
    /// Half the width of the pen.
    const PEN: f64 = 36.0;
    /// Height of a letter's skeleton.
    const HEIGHT: f64 = 330.0;
    /// Tops of the skeletons in the upper and in the lower row.
    const UPPER: f64 = 106.0;
    const LOWER: f64 = 588.0;
    // Letter, left end, top and width of its skeleton.
    const LETTERS: [(Letter, f64, f64, f64); 7] = [
        (Letter::R, 96.0, UPPER, 208.0),
        (Letter::E, 446.0, UPPER, 172.0),
        (Letter::L, 760.0, UPPER, 168.0),
        (Letter::I, 96.0, LOWER, 0.0),
        (Letter::E, 206.0, LOWER, 140.0),
        (Letter::V, 456.0, LOWER, 190.0),
        (Letter::O, 756.0, LOWER, 172.0),
    ];
    let glyphs = LETTERS.map(|(letter, left, top, width)| {
        (
            DVec2::new(left, top),
            Glyph::new(letter, DVec2::new(width, HEIGHT)),
        )
    });
    Pattern::draw("letters", (1024, 1024), |point| {
        glyphs
            .iter()
            .any(|(origin, glyph)| glyph.distance(point - *origin) <= PEN)
    })
}

/// A honeycomb: the walls between hexagons with corners to the left and right.
fn hexagons() -> Pattern {
    // Two hexagons per cell, at its centre and at its corners. Regular hexagons
    // have cells of √3:1; 256:148 differs by 0.13 %, for a period of whole pixels.
    const CELL: DVec2 = DVec2::new(256.0, 148.0);
    const WALL: f64 = 28.0;
    let regular = DVec2::new(3.0_f64.sqrt() * CELL.y, CELL.y);
    Pattern::draw("hexagons", (1024, 592), |point| {
        [DVec2::ZERO, CELL / 2.0].into_iter().all(|shift| {
            let offset = in_cell(point + shift, CELL) / CELL * regular;
            sdf::hexagon(offset, (CELL.y - WALL) / 2.0) > 0.0
        })
    })
}

/// Bricks in running bond: every second row is shifted by half a brick.
fn bricks() -> Pattern {
    const CELL: DVec2 = DVec2::new(256.0, 128.0);
    const MORTAR: f64 = 20.0;
    const CORNER: f64 = 16.0;
    Pattern::draw("bricks", (1024, 1024), |point| {
        let odd_row = (point.y / CELL.y).floor() % 2.0;
        let shift = DVec2::new(odd_row * CELL.x / 2.0, 0.0);
        let offset = in_cell(point + shift, CELL);
        sdf::rounded_rectangle(offset, (CELL - MORTAR) / 2.0, CORNER) <= 0.0
    })
}

/// One disc in the centre; its radius is 0.3 of the width.
fn discs() -> Pattern {
    const WIDTH: f64 = 512.0;
    Pattern::draw("discs", (512, 512), |point| {
        point.distance(DVec2::splat(WIDTH / 2.0)) <= 0.3 * WIDTH
    })
}

/// A facade: window frames with cross bars, on a ledge along each storey.
fn windows() -> Pattern {
    const CELL: DVec2 = DVec2::new(256.0, 256.0);
    /// Outer size of a frame.
    const FRAME: DVec2 = DVec2::new(168.0, 204.0);
    const FRAME_BAR: f64 = 24.0;
    const CROSS_BAR: f64 = 18.0;
    const LEDGE: f64 = 28.0;
    const CORNER: f64 = 6.0;
    let half_frame = FRAME / 2.0;
    // The horizontal bar divides the frame 1:2.
    let transom = -FRAME.y / 6.0;
    Pattern::draw("windows", (1024, 512), |point| {
        let offset = in_cell(point, CELL);
        let in_frame = sdf::rounded_rectangle(offset, half_frame, CORNER) <= 0.0;
        let in_opening = sdf::rounded_rectangle(offset, half_frame - FRAME_BAR, CORNER) < 0.0;
        let on_cross =
            offset.x.abs() <= CROSS_BAR / 2.0 || (offset.y - transom).abs() <= CROSS_BAR / 2.0;
        let on_ledge = (offset.y - half_frame.y).abs() <= LEDGE / 2.0;
        on_ledge || in_frame && (on_cross || !in_opening)
    })
}

/// A diagonal trellis with diamond-shaped holes.
fn lattice() -> Pattern {
    /// Distance between holes along a row; rows are half as far apart.
    const PERIOD: f64 = 256.0;
    const BAR: f64 = 46.0;
    const CORNER: f64 = 20.0;
    Pattern::draw("lattice", (1024, 1024), |point| {
        // Rotated by 45° and scaled by √2, the holes are squares on a square grid.
        let turned = DVec2::new(point.x + point.y, point.y - point.x);
        let offset = in_cell(turned, DVec2::splat(PERIOD)) / 2.0_f64.sqrt();
        let half_hole = DVec2::splat((PERIOD / 2.0_f64.sqrt() - BAR) / 2.0);
        sdf::rounded_rectangle(offset, half_hole, CORNER) > 0.0
    })
}

/// Shingles with round lower ends; every second row is shifted by half a shingle.
fn shingles() -> Pattern {
    const CELL: DVec2 = DVec2::new(128.0, 128.0);
    /// How far the round ends reach over the row below.
    const END: f64 = 44.0;
    const GAP: f64 = 5.0;
    Pattern::draw("shingles", (512, 512), |point| {
        let row = (point.y / CELL.y).floor();
        // From the centre of a shingle of row `row`, whose straight sides end at the row's top.
        let offset = |row: f64| {
            let shift = row.rem_euclid(2.0) * CELL.x / 2.0;
            in_cell(DVec2::new(point.x + shift, 0.0), CELL).x
        };
        let side = |x: f64| CELL.x / 2.0 - x.abs();
        let below = point.y - row * CELL.y;
        // The round end of a shingle of the row above, half an ellipse.
        let above = offset(row - 1.0);
        let round = DVec2::new(above / (CELL.x / 2.0), below / END).length();
        let from_end = (1.0 - round).abs() * END.min(CELL.x / 2.0);
        let is_above = round < 1.0;
        let from_side = if is_above {
            side(above)
        } else {
            side(offset(row))
        };
        from_end > GAP && (is_above || from_side > GAP)
    })
}

/// A window: a frame around two by three panes.
fn panes() -> Pattern {
    const SIDE: f64 = 512.0;
    const FRAME: f64 = 36.0;
    const BAR: f64 = 9.0;
    Pattern::draw("panes", (512, 512), |point| {
        let from_border = point.min(DVec2::splat(SIDE) - point).min_element();
        let from_bar = [
            point.x - SIDE / 2.0,
            point.y - SIDE / 3.0,
            point.y - SIDE * 2.0 / 3.0,
        ];
        from_border < FRAME || from_bar.iter().any(|distance| distance.abs() < BAR)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> GrayImage {
        all()
            .into_iter()
            .find(|pattern| pattern.name == name)
            .unwrap()
            .image
    }

    fn blackness(image: &GrayImage) -> f64 {
        let black = image.pixels().filter(|pixel| pixel.0 == [0]).count();
        black as f64 / f64::from(image.width() * image.height())
    }

    #[test]
    fn sizes_and_fractions_of_black_are_as_designed() {
        // (name, size, smallest and largest fraction of black)
        let expected = [
            ("letters", (1024, 1024), 0.25, 0.45),
            ("hexagons", (1024, 592), 0.30, 0.40),
            ("bricks", (1024, 1024), 0.75, 0.80),
            ("discs", (512, 512), 0.2820, 0.2835),
            ("windows", (1024, 512), 0.35, 0.45),
            ("lattice", (1024, 1024), 0.40, 0.50),
            ("shingles", (512, 512), 0.80, 0.90),
            ("panes", (512, 512), 0.30, 0.40),
        ];
        let patterns = all();
        assert_eq!(patterns.len(), expected.len());
        for (pattern, (name, size, least, greatest)) in patterns.iter().zip(expected) {
            assert_eq!(pattern.name, name);
            assert_eq!(pattern.image.dimensions(), size, "{name}");
            let share = blackness(&pattern.image);
            assert!((least..greatest).contains(&share), "{name}: {share}");
        }
    }

    #[test]
    fn png_is_binary_eight_bit_grayscale() {
        for pattern in all() {
            let decoded = image::load_from_memory(&pattern.to_png().unwrap()).unwrap();
            assert_eq!(decoded.color(), image::ColorType::L8, "{}", pattern.name);
            let decoded = decoded.into_luma8();
            assert!(decoded == pattern.image, "{}", pattern.name);
            assert!(
                decoded.iter().all(|&value| value == 0 || value == 255),
                "{}",
                pattern.name
            );
        }
    }

    /// A pattern shifted by a vector of its lattice (wrapping around) is unchanged, so
    /// the seam looks like the middle of the image.
    #[test]
    fn lattice_patterns_repeat_across_the_seam() {
        let shifts = [
            ("hexagons", [(256, 0), (0, 148), (128, 74)]),
            ("bricks", [(256, 0), (0, 256), (128, 128)]),
            ("windows", [(256, 0), (0, 256), (512, 256)]),
            ("lattice", [(256, 0), (0, 256), (128, 128)]),
        ];
        for (name, shifts) in shifts {
            let image = named(name);
            let (width, height) = image.dimensions();
            for (dx, dy) in shifts {
                let differing = image
                    .enumerate_pixels()
                    .filter(|&(x, y, pixel)| {
                        image.get_pixel((x + dx) % width, (y + dy) % height) != pixel
                    })
                    .count();
                assert_eq!(differing, 0, "{name} shifted by ({dx}, {dy})");
            }
        }
    }

    #[test]
    fn single_figures_keep_a_white_margin() {
        for (name, margin) in [("letters", 60), ("discs", 100)] {
            let image = named(name);
            let (width, height) = image.dimensions();
            for (x, y, pixel) in image.enumerate_pixels() {
                let inside =
                    (margin..width - margin).contains(&x) && (margin..height - margin).contains(&y);
                assert!(inside || pixel.0 == [255], "{name}: ({x}, {y})");
            }
        }
    }

    /// Counts the four-connected black regions on the torus.
    fn black_regions(image: &GrayImage) -> usize {
        let (width, height) = image.dimensions();
        let mut unseen = GrayImage::from_fn(width, height, |x, y| *image.get_pixel(x, y));
        let mut regions = 0;
        for y in 0..height {
            for x in 0..width {
                let mut open = vec![(x, y)];
                let mut size = 0;
                while let Some((x, y)) = open.pop() {
                    let pixel = unseen.get_pixel_mut(x, y);
                    if pixel.0 == [0] {
                        pixel.0 = [255];
                        size += 1;
                        open.extend([
                            ((x + 1) % width, y),
                            ((x + width - 1) % width, y),
                            (x, (y + 1) % height),
                            (x, (y + height - 1) % height),
                        ]);
                    }
                }
                regions += usize::from(size > 0);
            }
        }
        regions
    }

    #[test]
    fn regions_are_the_figures() {
        for (name, regions) in [
            ("letters", 7),
            ("hexagons", 1),
            ("bricks", 32),
            ("discs", 1),
            ("windows", 2),
            ("lattice", 1),
        ] {
            assert_eq!(black_regions(&named(name)), regions, "{name}");
        }
    }
}
