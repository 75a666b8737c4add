//! Sine, cosine and tangent.
//!
//! The angle is reduced to −π/4…π/4 and a number of quarter turns in whole numbers, with
//! as many digits of 2/π as it takes: exact for every f32, in radians.

use crate::basic::{abs, quotient};
use crate::bits::{IMPLICIT, MANTISSA, finite, with_sign};
use crate::pair::{fast_two_sum, product, two_product};

/// The digits of 2/π: 32 before the point, which are 0, and 192 after it.
const TWO_OVER_PI: [u32; 7] = [
    0,
    0xa2f9_836e,
    0x4e44_1529,
    0xfc27_57d1,
    0xf534_ddc0,
    0xdb62_9599,
    0x3c43_9041,
];

/// π/2.
const HALF_PI: (f32, f32) = (core::f32::consts::FRAC_PI_2, -4.371_139e-8);

/// An angle: `quarters` · π/2 + `high` + `low`.
struct Reduced {
    quarters: u32,
    high: f32,
    low: f32,
}

/// Returns the 64 digits of a product of 24 and 32 digits, 32 each.
#[inline]
fn wide_product(a: u32, b: u32) -> (u32, u32) {
    let (a_high, a_low) = (a >> 16, a & 0xffff);
    let (b_high, b_low) = (b >> 16, b & 0xffff);
    let low = a_low * b_low;
    let (first, second) = (a_low * b_high, a_high * b_low);
    let middle = (low >> 16) + (first & 0xffff) + (second & 0xffff);
    let high = a_high * b_high + (first >> 16) + (second >> 16) + (middle >> 16);
    (high, a.wrapping_mul(b))
}

/// Returns the words `first` and `second`, from digit `shift` (0…31) on.
#[inline]
fn window(first: u32, second: u32, shift: u32) -> u32 {
    // Shifted twice, since a shift by 32 is undefined.
    (first << shift) | ((second >> 1) >> (31 - shift))
}

/// Returns three words of the digits of 2/π, from digit `start` (0…159) on.
#[inline]
fn digits(start: u32) -> (u32, u32, u32) {
    let [a, b, c, d, e, f, g] = TWO_OVER_PI;
    // Words are moved by 4, 2 and 1: an array cannot be indexed in a register.
    let word = start >> 5;
    let (a, b, c, d, e, f, g) = if word & 4 != 0 {
        (e, f, g, 0, 0, 0, 0)
    } else {
        (a, b, c, d, e, f, g)
    };
    let (a, b, c, d, e) = if word & 2 != 0 {
        (c, d, e, f, g)
    } else {
        (a, b, c, d, e)
    };
    let (a, b, c, d) = if word & 1 != 0 {
        (b, c, d, e)
    } else {
        (a, b, c, d)
    };
    let shift = start & 31;
    (
        window(a, b, shift),
        window(b, c, shift),
        window(c, d, shift),
    )
}

/// Returns the angle of the magnitude of `x`, which is finite.
#[inline]
fn reduce(x: f32) -> Reduced {
    let magnitude = abs(x);
    if magnitude < core::f32::consts::FRAC_PI_4 {
        return Reduced {
            quarters: 0,
            high: magnitude,
            low: 0.0,
        };
    }
    // |x| = mantissa 2^(exponent − 150), exponent ≥ 126. Digits of 2/π that give multiples
    // of four quarters are left out; digits are counted from the 32nd before the point.
    let exponent = magnitude.to_bits() >> 23;
    let mantissa = magnitude.to_bits() & MANTISSA | IMPLICIT;
    let (first, second, third) = digits(exponent - 120);
    let (carry_high, middle) = wide_product(mantissa, second);
    let (carry_low, _) = wide_product(mantissa, third);
    let low = middle.wrapping_add(carry_low);
    let carry = if low < middle { 1 } else { 0 };
    let high = mantissa
        .wrapping_mul(first)
        .wrapping_add(carry_high)
        .wrapping_add(carry);
    // The upper two digits count quarters. The nearest number of them leaves a fraction in
    // −½…½.
    let quarters = high.wrapping_add(1 << 29) >> 30;
    let signed = high.wrapping_sub(quarters << 30);
    let negative = (signed >> 31) != 0;
    // The magnitude of the fraction, in units of 2⁻⁶².
    let (high, low) = if negative {
        let borrow = if low == 0 { 1 } else { 0 };
        ((!signed).wrapping_add(borrow), low.wrapping_neg())
    } else {
        (signed, low)
    };
    // Conversions of at most 24 digits are exact.
    let a = (high >> 8) as f32 * 2.384_185_8e-7;
    let b = ((high & 0xff) << 12 | low >> 20) as f32 * 2.273_736_8e-13;
    let c = (low & 0x000f_ffff) as f32 * 2.168_404_3e-19;
    let (sum, rest) = fast_two_sum(a, b);
    let (high, low) = product(fast_two_sum(sum, rest + c), HALF_PI);
    Reduced {
        quarters,
        high: if negative { -high } else { high },
        low: if negative { -low } else { low },
    }
}

/// Returns the sine of `high` + `low`, |high| ≤ π/4, as a pair.
#[inline]
fn sine(high: f32, low: f32) -> (f32, f32) {
    let z = high * high;
    let tail = -0.166_666_67 + z * (0.008_333_332 + z * (-1.984_008_7e-4 + z * 2.724_99e-6));
    fast_two_sum(high, high * z * tail + (low - 0.5 * z * low))
}

/// Returns the cosine of `high` + `low`, |high| ≤ π/4, as a pair.
#[inline]
fn cosine(high: f32, low: f32) -> (f32, f32) {
    let (z, z_low) = two_product(high, high);
    let tail = 0.041_666_668 + z * (-0.001_388_888_8 + z * (2.480_06e-5 + z * -2.730_093_9e-7));
    let (one, rest) = fast_two_sum(1.0, -0.5 * z);
    fast_two_sum(one, rest + (z * z * tail - (0.5 * z_low + high * low)))
}

/// Returns the sine of `x`, radians.
///
/// ```
/// use relievo_exact::sin;
///
/// assert_eq!((sin(0.0), sin(0.5)), (0.0, 0.479_425_55));
/// assert_eq!(sin(1e30), f64::from(1e30_f32).sin() as f32);
/// ```
#[inline]
pub fn sin(x: f32) -> f32 {
    let x = finite(x);
    let angle = reduce(x);
    let (high, _) = if angle.quarters & 1 != 0 {
        cosine(angle.high, angle.low)
    } else {
        sine(angle.high, angle.low)
    };
    let sine = if angle.quarters & 2 != 0 { -high } else { high };
    with_sign(sine, x)
}

/// Returns the cosine of `x`, radians.
///
/// ```
/// use relievo_exact::cos;
///
/// assert_eq!((cos(0.0), cos(1.0)), (1.0, 0.540_302_3));
/// ```
#[inline]
pub fn cos(x: f32) -> f32 {
    let angle = reduce(finite(x));
    let (high, _) = if angle.quarters & 1 != 0 {
        sine(angle.high, angle.low)
    } else {
        cosine(angle.high, angle.low)
    };
    // Negative in the second and the third quarter.
    if angle.quarters.wrapping_add(1) & 2 != 0 {
        -high
    } else {
        high
    }
}

/// Returns the tangent of `x`, radians.
///
/// ```
/// use relievo_exact::tan;
///
/// assert_eq!((tan(0.0), tan(1.0)), (0.0, 1.557_407_7));
/// ```
#[inline]
pub fn tan(x: f32) -> f32 {
    let x = finite(x);
    let angle = reduce(x);
    let sine = sine(angle.high, angle.low);
    let cosine = cosine(angle.high, angle.low);
    let is_odd = angle.quarters & 1 != 0;
    let (over, under) = if is_odd {
        (cosine, sine)
    } else {
        (sine, cosine)
    };
    let (high, low) = quotient(over, under);
    let tangent = high + low;
    with_sign(if is_odd { -tangent } else { tangent }, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_64_digits() {
        let mut random = fastrand::Rng::with_seed(2);
        for _ in 0..100_000 {
            let (a, b) = (random.u32(..1 << 24), random.u32(..));
            let (high, low) = wide_product(a, b);
            let expected = u64::from(a) * u64::from(b);
            assert_eq!(u64::from(high) << 32 | u64::from(low), expected);
        }
    }

    #[test]
    fn windows_of_digits_are_those_of_a_long_number() {
        let bit = |i: u32| {
            TWO_OVER_PI
                .get(i as usize / 32)
                .map_or(0, |word| word >> (31 - i % 32) & 1)
        };
        for start in 0..135 {
            let (a, b, c) = digits(start);
            for i in 0..96 {
                let word = [a, b, c][i as usize / 32];
                assert_eq!(word >> (31 - i % 32) & 1, bit(start + i), "{start} {i}");
            }
        }
    }
}
