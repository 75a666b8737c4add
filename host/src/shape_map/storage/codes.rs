//! Signed fixed-point codes of 8 and 16 bits.
//!
//! distance = (code − bias) · step, with a power of two as step.

use super::super::distance::DistanceField;
use super::form::{Coding, File, Form, Valid, largest_code, pack};
use png::{BitDepth, ColorType};
use relievo_shared::layout::FORMAT_CODES;

/// Finest step, in texels.
const FINEST_STEP: f64 = 1.0 / 256.0;

pub(super) const R8: Form = Form {
    name: "r8",
    summary: "8-bit signed distances (PNG)",
    bits: 8,
    map_bits: Some(8),
    larger: "r16",
    shader_format: FORMAT_CODES,
    file: File::Png(ColorType::Grayscale, BitDepth::Eight),
    encode: |field, _| encode(field, 8, 0.5),
    decode,
    range: |coding, _| range(coding, 8),
    normal: |_| None,
    check: |coding| check(coding, 8),
    check_texel: None,
};

pub(super) const R16: Form = Form {
    name: "r16",
    summary: "16-bit signed distances (PNG)",
    bits: 16,
    map_bits: Some(16),
    larger: "r32f",
    file: File::Png(ColorType::Grayscale, BitDepth::Sixteen),
    encode: |field, _| encode(field, 16, 1.0 / 32.0),
    range: |coding, _| range(coding, 16),
    check: |coding| check(coding, 16),
    ..R8
};

/// Encodes a field with the finest step that fits, at most `coarsest_step`.
fn encode(field: &DistanceField, bits: u32, coarsest_step: f64) -> (Coding, Vec<u32>) {
    let (min, max) = field.range();
    let coding = choose(bits, coarsest_step, min, max);
    let words = pack(bits, field.values(), |distance| {
        encode_one(coding, bits, distance)
    });
    (coding, words)
}

/// Chooses the finest codes that hold all of `min`…`max`, or else the coarsest
/// ones allowed, with at most half of the codes below zero.
fn choose(bits: u32, coarsest_step: f64, min: f32, max: f32) -> Coding {
    let mut step = FINEST_STEP;
    loop {
        // The conversion to an integer turns negative counts into 0.
        let below = -(f64::from(min) / step).floor() as u64;
        let above = (f64::from(max) / step).floor() as u64;
        let fits = below + above < 1 << bits;
        if fits || step >= coarsest_step {
            let half = 1 << (bits - 1);
            return Coding {
                bias: if fits { below } else { below.min(half) } as u32,
                step: step as f32,
                scale: 1.0,
                saturated: !fits,
            };
        }
        step *= 2.0;
    }
}

/// Encodes one distance: rounded down, and saturated.
fn encode_one(coding: Coding, bits: u32, distance: f32) -> u32 {
    let units = (f64::from(distance) / f64::from(coding.step)).floor();
    let largest = f64::from(largest_code(bits));
    (units + f64::from(coding.bias)).clamp(0.0, largest) as u32
}

fn decode(coding: Coding, texel: u32) -> f32 {
    (i64::from(texel) - i64::from(coding.bias)) as f32 * coding.step
}

fn range(coding: Coding, bits: u32) -> (f32, f32) {
    (decode(coding, 0), decode(coding, largest_code(bits)))
}

/// Within these bounds every distance is a normal number.
fn check(coding: &Coding, bits: u32) -> Valid {
    let significand = coding.step.to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1);
    Valid {
        bias: coding.bias <= largest_code(bits),
        step: significand == 0 && (1.0 / 65536.0..=65536.0).contains(&coding.step),
        scale: coding.scale == 1.0,
        saturated: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_the_finest_that_fits() {
        let r8 = |min, max| choose(8, 0.5, min, max).step;
        let r16 = |min, max| choose(16, 1.0 / 32.0, min, max).step;
        // 256 codes: −128…127 of 2⁻⁸ just fit.
        assert_eq!(r8(-0.5, 0.499), 1.0 / 256.0);
        assert_eq!(r8(-0.5, 0.5), 1.0 / 128.0);
        assert_eq!(r16(-100.0, 155.9), 1.0 / 256.0);
        assert_eq!(r16(-100.0, 156.0), 1.0 / 128.0);
        assert_eq!(r16(-0.5, 5000.0), 1.0 / 32.0);
    }
}
