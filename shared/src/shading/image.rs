//! Filtered lookup of pictures. Texels are four linear numbers 0…1 of 16 bits each, in two
//! words; lookups are bilinear within a level and linear between two levels.

use super::layout::Image;
use crate::arithmetic::{abs, clamp, div, floor, floor_to_int, max, min, sqrt};
use crate::shape_map::Texels;
use crate::{Real, Vec2};
use glam::Vec4;

// The spread of a lookup is `FIRST`, and `SPREAD` times the area of what the pixel covers, texels². With 1 / 3 for
// `SPREAD`, a lookup has the variance of a pixel's mean. It has more weight far out than that mean, so that
// somewhat less differs least from many samples.
const FIRST: Real = 0.98;
const SPREAD: Real = 0.25;
/// Largest number of places at which a picture is looked up along a pixel.
const MOST_PLACES: Real = 8.0;

/// The parallelogram that a pixel covers: its sides, to the right and down, in any unit.
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    /// The side to the right.
    pub right: Vec2,
    /// The side down.
    pub down: Vec2,
}

impl Footprint {
    /// Returns a square footprint whose sides are `width` along each axis.
    #[inline]
    pub fn square(width: Vec2) -> Footprint {
        Footprint {
            right: Vec2::new(width.x, 0.0),
            down: Vec2::new(0.0, width.y),
        }
    }

    /// Returns it with each axis in another unit.
    #[inline]
    pub fn scaled(&self, scale: Vec2) -> Footprint {
        Footprint {
            right: self.right * scale,
            down: self.down * scale,
        }
    }

    /// Returns the lengths of its sides, to the right and down.
    #[inline]
    fn lengths(&self) -> (Real, Real) {
        let length = |side: Vec2| sqrt(side.dot(side));
        (length(self.right), length(self.down))
    }

    /// Returns the length of its longer side.
    #[inline]
    pub fn longest(&self) -> Real {
        let (right, down) = self.lengths();
        max(right, down)
    }

    /// Returns its area over the length of its longer side.
    #[inline]
    pub fn narrowest(&self) -> Real {
        let Footprint { right, down } = *self;
        let area = abs(right.x * down.y - right.y * down.x);
        div(area, max(self.longest(), 1e-12))
    }
}

/// Returns the texel at word `index`.
#[inline]
fn texel<T: Texels + ?Sized>(words: &T, index: u32) -> Vec4 {
    const STEP: Real = 1.0 / 65_535.0;
    let (first, second) = (words.word(index), words.word(index + 1));
    let part = |code: u32| (code & 0xffff) as i32 as Real;
    Vec4::new(
        part(first),
        part(first >> 16),
        part(second),
        part(second >> 16),
    ) * STEP
}

/// Returns the two texels beside `x` in a row of `size` that repeats, and how far `x` is
/// from the first to the second; `x` is 0…1.
#[inline]
fn beside(x: Real, size: u32) -> (u32, u32, Real) {
    let at = x * (size as i32 as Real) - 0.5;
    let low = floor(at);
    let index = low as i32;
    let last = size as i32 - 1;
    // Rounding may reach the size itself.
    let first = if index < 0 {
        last
    } else if index > last {
        0
    } else {
        index
    };
    let second = if first == last { 0 } else { first + 1 };
    (first as u32, second as u32, at - low)
}

/// Returns the picture at `at` (0…1) in the level of `width` × `height` texels whose first word
/// is `first`.
#[inline]
fn bilinear<T: Texels + ?Sized>(words: &T, first: u32, width: u32, height: u32, at: Vec2) -> Vec4 {
    let (left, right, across) = beside(at.x, width);
    let (upper, lower, down) = beside(at.y, height);
    let texel = |x: u32, y: u32| texel(words, first + 2 * (y * width + x));
    let row = |y: u32| texel(left, y) * (1.0 - across) + texel(right, y) * across;
    row(upper) * (1.0 - down) + row(lower) * down
}

/// Returns half of `side`, at least 1.
#[inline]
pub fn halved(side: u32) -> u32 {
    if side > 1 { side >> 1 } else { 1 }
}

/// Returns `image` at `at`, repeats from the upper left corner, in the level of detail n (0 for the first,
/// which is the largest), where `spread` is 4ⁿ. Between two levels, the variance of the lookup is linear in
/// `spread`.
///
/// In level n that variance is (4ⁿ − 1) / 12 + 4ⁿ / 6 texels²: the mean of texels, and the lookup between two.
#[inline]
pub fn sample<T: Texels + ?Sized>(words: &T, image: &Image, at: Vec2, spread: Real) -> Vec4 {
    const THIRD: Real = 1.0 / 3.0;
    // Of a number that is too large to have a fraction, rounding is all that is left.
    let fraction = |x: Real| clamp(x - floor(x), 0.0, 1.0);
    let at = Vec2::new(fraction(at.x), fraction(at.y));
    let (mut first, mut width, mut height) = (image.first, image.width, image.height);
    let (mut spread, mut share) = (spread, 1.0);
    let mut found = Vec4::ZERO;
    let mut rest = image.levels;
    while rest > 0 {
        if spread < 4.0 || rest == 1 {
            let value = bilinear(words, first, width, height, at);
            found += (value - found) * share;
            // Of the next level.
            share = clamp((spread - 1.0) * THIRD, 0.0, 1.0);
            if share == 0.0 {
                rest = 1;
            }
        }
        rest -= 1;
        spread *= 0.25;
        first += 2 * (width * height);
        width = halved(width);
        height = halved(height);
    }
    found
}

/// Returns the mean of `image` over a pixel that covers `footprint` around `at`, both in repeats:
/// lookups along the longer side, in the level of detail of the shorter one.
#[inline]
pub fn sample_over<T: Texels + ?Sized>(
    words: &T,
    image: &Image,
    at: Vec2,
    footprint: &Footprint,
) -> Vec4 {
    let size = Vec2::new(image.width as i32 as Real, image.height as i32 as Real);
    let (right, down) = footprint.scaled(size).lengths();
    let side = if right > down {
        footprint.right
    } else {
        footprint.down
    };
    let (long, short) = (max(right, down), min(right, down));
    let ratio = div(long, max(short, 1e-6));
    let places = floor(clamp(ratio + 0.5, 1.0, MOST_PLACES));
    let part = div(1.0, places);
    let wide = clamp(long * part, 0.0, 1e6);
    // Pictures that are seen from near are looked up in their first level only.
    let spread = max(FIRST + SPREAD * (wide * wide), 1.0);
    let step = side * part;
    let mut rest = floor_to_int(places);
    let mut place = at - step * (0.5 * places - 0.5);
    let mut sum = Vec4::ZERO;
    while rest > 0 {
        sum += sample(words, image, place, spread);
        place += step;
        rest -= 1;
    }
    sum * part
}
