//! The paper's shape map: normal, distance and shape in the four channels of an
//! 8-bit picture.
//!
//! Source: the paper, section 3, Figure 4, equations (4) and (5); section 3 of
//! docs/algorithm.md.

use super::super::distance::DistanceField;
use super::form::{Coding, File, Form, Valid};
use png::{BitDepth, ColorType};
use rayon::prelude::*;
use relievo_shared::layout::FORMAT_PAPER;

pub(super) const RGBA8: Form = Form {
    name: "rgba8",
    summary: "The paper's shape map: normal, distance and shape, 8 bits each (PNG)",
    bits: 32,
    map_bits: None,
    larger: "r16",
    shader_format: FORMAT_PAPER,
    file: File::Png(ColorType::Rgba, BitDepth::Eight),
    encode,
    decode,
    range: |coding, _| (decode(coding, 0), decode(coding, u32::MAX)),
    normal: decode_normal,
    check,
    check_texel: Some(check_texel),
};

/// Bits of a step's significand, of f32's 24. The other 8 are left to the blue
/// channel, so that their product is exact.
const STEP_BITS: u32 = 16;

/// Half the span of the central differences of a gradient, in texels. A binary
/// pattern's outline is a staircase; a shorter span would follow its steps.
const REACH: usize = 2;

/// Returns the unsigned distance, in texels, to the nearest centre of the
/// pattern: 0 on it. In an empty pattern it is the length of the map's diagonal,
/// which `signed` holds.
fn pattern_distance(signed: f32, pattern_is_empty: bool) -> f64 {
    if signed < 0.0 {
        0.0
    } else if pattern_is_empty {
        f64::from(signed)
    } else {
        f64::from(signed) + 0.5
    }
}

/// Encodes a field as R | G << 8 | B << 16 | A << 24.
fn encode(field: &DistanceField, scale: f32) -> (Coding, Vec<u32>) {
    let (min, max) = field.range();
    let pattern_is_empty = min > 0.0;
    let largest = pattern_distance(max, pattern_is_empty) as f32;
    let coding = choose(scale, largest);
    let (width, height) = (field.width() as usize, field.height() as usize);
    let row = |y: usize| &field.values()[y * width..][..width];
    let mut words = vec![0; width * height];
    words
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, words)| {
            let [above, below] = around(y, height).map(row);
            let middle = row(y);
            for (x, word) in words.iter_mut().enumerate() {
                let [left, right] = around(x, width).map(|x| middle[x]);
                let signed = middle[x];
                let [red, green] = normal_codes([right - left, below[x] - above[x]]);
                let blue = encode_blue(coding, pattern_distance(signed, pattern_is_empty));
                let alpha = if signed < 0.0 { 0 } else { 255 };
                *word = u32::from_le_bytes([red, green, blue as u8, alpha]);
            }
        });
    (coding, words)
}

/// Chooses the coding for distances up to `largest`.
fn choose(scale: f32, largest: f32) -> Coding {
    Coding {
        bias: 0,
        step: step(scale, f64::from(largest)),
        scale,
        saturated: scale < 1.0,
    }
}

/// Returns f · max(EDT) / 255, rounded down to [`STEP_BITS`] bits: the product
/// with an 8-bit integer is exact in f32, fused or not, and the largest distance
/// gets the code 255. A full pattern has no distances; its step is 1.
fn step(scale: f32, largest_distance: f64) -> f32 {
    if largest_distance <= 0.0 {
        return 1.0;
    }
    let exact = f64::from(scale) * largest_distance / 255.0;
    let dropped = f64::MANTISSA_DIGITS - STEP_BITS;
    let rounded = f64::from_bits(exact.to_bits() >> dropped << dropped);
    (rounded as f32).max(f32::MIN_POSITIVE)
}

/// Encodes a distance to the nearest centre of the pattern for the blue channel:
/// rounded down, and saturated.
fn encode_blue(coding: Coding, pattern_distance: f64) -> u32 {
    (pattern_distance / f64::from(coding.step)).min(255.0) as u32
}

fn decode(coding: Coding, texel: u32) -> f32 {
    match texel.to_le_bytes() {
        [_, _, _, 0] => -0.5,
        // Texels outside the pattern are at least a texel away from its centres.
        [_, _, blue, _] => (f32::from(blue) * coding.step - 0.5).max(0.5),
    }
}

/// Within these bounds every distance is a normal number.
fn check(coding: &Coding) -> Valid {
    let significand = coding.step.to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1);
    Valid {
        bias: coding.bias == 0,
        step: significand.trailing_zeros() >= f32::MANTISSA_DIGITS - STEP_BITS
            && (f32::MIN_POSITIVE..=65536.0).contains(&coding.step),
        scale: coding.scale > 0.0 && coding.scale <= 1.0,
        saturated: coding.saturated == (coding.scale < 1.0),
    }
}

fn check_texel(texel: u32, _: f32) -> Result<(), String> {
    let [.., alpha] = texel.to_le_bytes();
    if [0, 255].contains(&alpha) {
        Ok(())
    } else {
        Err(format!("an alpha of {alpha}, neither 0 nor 255"))
    }
}

/// Returns the indices [`REACH`] before and after `i` on a circle of `size`.
fn around(i: usize, size: usize) -> [usize; 2] {
    [(i + size - REACH % size) % size, (i + REACH) % size]
}

/// Normalises a gradient and maps it from −1…1 to 0…255, rounded; a zero
/// gradient gives 128.
fn normal_codes(gradient: [f32; 2]) -> [u8; 2] {
    let [x, y] = gradient.map(f64::from);
    let length = x.hypot(y);
    let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
    [x, y].map(|side| ((side * inverse * 0.5 + 0.5) * 255.0).round() as u8)
}

/// Decodes x and y of the normal, to ±1/255; `None` for 128, 128.
fn decode_normal(texel: u32) -> Option<[f32; 2]> {
    let [red, green, _, _] = texel.to_le_bytes();
    let side = |code: u8| f32::from(code) / 255.0 * 2.0 - 1.0;
    ([red, green] != [128, 128]).then(|| [side(red), side(green)])
}

#[cfg(test)]
mod tests {
    use super::super::super::{Pattern, ShapeMap, signed_distance_field};
    use super::super::{Encoding, Storage};
    use super::*;

    fn map(pattern: &Pattern, encoding: impl Into<Encoding>) -> ShapeMap {
        ShapeMap::encode(&signed_distance_field(pattern, &|_| ()), encoding)
    }

    #[test]
    fn normals_of_a_disc_point_away_from_its_centre() {
        // Neither square nor centred: the disc lies across the edges.
        let (width, height, radius) = (160, 140, 40.0);
        let from_centre = |x: u32, y: u32| {
            let around = |i: u32, centre: f64, size: u32| {
                let away = f64::from(i) - centre;
                away - (away / f64::from(size)).round() * f64::from(size)
            };
            [around(x, 10.3, width), around(y, 130.6, height)]
        };
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let disc =
            Pattern::from_fn(width, height, |x, y| length(from_centre(x, y)) < radius).unwrap();
        let map = map(&disc, Storage::Rgba8);
        let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0.0);
        for y in 0..height {
            for x in 0..width {
                let away = from_centre(x, y);
                let distance = length(away);
                // Not at the centre, nor where the next repeat is nearest.
                if !(10.0..=64.0).contains(&distance) {
                    continue;
                }
                let normal = map.normal(x, y).unwrap().map(f64::from);
                assert!((length(normal) - 1.0).abs() < 1.5 / 255.0);
                let cross = normal[0] * away[1] - normal[1] * away[0];
                let dot = normal[0] * away[0] + normal[1] * away[1];
                let angle = cross.atan2(dot).to_degrees().abs();
                worst = worst.max(angle);
                sum += angle;
                count += 1.0;
            }
        }
        // Measured: 2.4° and 13°. The distances to the staircase are exact; its
        // corners are what is seen.
        assert!(worst < 15.0, "{worst}");
        assert!(sum / count < 3.0, "{}", sum / count);
    }

    #[test]
    fn the_step_is_the_scaled_largest_distance_over_255() {
        for scale in [1.0, 0.7, 0.01, f32::MIN_POSITIVE] {
            for largest in [1.0, 2f64.sqrt(), 255.0, 181.02, 30_000.3] {
                let step = step(scale, largest);
                let exact = f64::from(scale) * largest / 255.0;
                let ratio = f64::from(step) / exact;
                assert!(step.is_normal());
                if scale > 0.001 {
                    assert!(ratio <= 1.0 && ratio > 1.0 - 1.0 / 32768.0, "{ratio}");
                }
                let coding = choose(scale, largest as f32);
                assert_eq!(encode_blue(coding, largest), 255);
                let valid = check(&coding);
                assert!(valid.bias && valid.step && valid.scale && valid.saturated);
                for blue in [1u8, 77, 171, 255] {
                    let product = f64::from(blue) * f64::from(step);
                    assert_eq!(f64::from(f32::from(blue) * step), product);
                }
            }
        }
        assert_eq!(step(0.5, 0.0), 1.0);
    }

    #[test]
    fn channels_of_a_stripe() {
        // Columns 0…3 of 16 are the pattern; the farthest column is 7 away.
        let stripe = Pattern::from_fn(16, 2, |x, _| x < 4).unwrap();
        let map = map(&stripe, Storage::Rgba8);
        let texel = |x| map.texel(x, 1).to_le_bytes();
        assert_eq!(texel(3), [255, 128, 0, 0]);
        assert_eq!(texel(4), [255, 128, 255 / 6, 255]);
        assert_eq!(texel(9), [255, 128, 255, 255]);
        assert_eq!(texel(10), [0, 128, 255, 255]);
        assert_eq!(texel(15), [0, 128, 255 / 6, 255]);
        assert_eq!(map.decode(2, 0), -0.5);
        assert_eq!(map.decode(4, 0), 0.5);
        assert!((map.decode(9, 0) - 5.5).abs() < 1e-3);
        assert!((map.tau().unwrap() - 6.0 / 16.0).abs() < 1e-4);
        assert_eq!(map.normal(4, 0).unwrap()[0], 1.0);

        let map = self::map(&stripe, Encoding::rgba8(0.5).unwrap());
        assert!(map.saturated());
        assert_eq!(map.scale(), 0.5);
        assert!((map.tau().unwrap() - 3.0 / 16.0).abs() < 1e-4);
        let blue = |x| map.texel(x, 0).to_le_bytes()[2];
        assert_eq!([blue(4), blue(6), blue(9)], [85, 255, 255]);
    }

    #[test]
    fn empty_and_full_patterns() {
        let empty = map(
            &Pattern::from_fn(30, 40, |_, _| false).unwrap(),
            Storage::Rgba8,
        );
        assert_eq!(empty.texel(3, 4).to_le_bytes(), [128, 128, 255, 255]);
        assert!((empty.tau().unwrap() - 50.0 / 30.0).abs() < 1e-4);
        assert!((empty.decode(3, 4) - 49.5).abs() < 2e-3);
        assert_eq!(empty.normal(3, 4), None);

        let full = map(
            &Pattern::from_fn(30, 40, |_, _| true).unwrap(),
            Storage::Rgba8,
        );
        assert_eq!(full.texel(3, 4).to_le_bytes(), [128, 128, 0, 0]);
        assert_eq!((full.decode(3, 4), full.step()), (-0.5, 1.0));
    }
}
