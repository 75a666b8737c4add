//! Exponential functions, logarithms and powers.

use crate::basic::{abs, quotient};
use crate::bits::{MANTISSA, finite, nearest, scaled};
use crate::pair::{fast_two_sum, product, two_product, two_sum};

/// log₂ e.
const LOG2_E: (f32, f32) = (core::f32::consts::LOG2_E, 1.925_963e-8);
/// ln 2, of which the first part has 15 digits: products with exponents are exact.
const LN_2: (f32, f32) = (0.693_145_75, 1.428_606_8e-6);

/// Returns 2ʳ, |r| ≤ ½, as a sum of two numbers, of which the second is less than 0.1.
#[inline]
fn exp2_pair(r: f32) -> (f32, f32) {
    /// ln 2.
    const FIRST: (f32, f32) = (core::f32::consts::LN_2, -1.904_654_2e-9);
    let tail = 0.240_226_5
        + r * (0.055_504_11
            + r * (0.009_618_083
                + r * (0.001_333_352_2 + r * (1.545_316_3e-4 + r * 1.529_094_9e-5))));
    let (high, low) = fast_two_sum(1.0, r * FIRST.0);
    (high, low + (r * r * tail + r * FIRST.1))
}

/// Returns 2ˣ; 0 if that is less than the smallest normal number, `f32::MAX` if it is too
/// large.
///
/// ```
/// use relievo_exact::exp2;
///
/// assert_eq!((exp2(0.5), exp2(-3.0), exp2(200.0)), (2.0_f32.sqrt(), 0.125, f32::MAX));
/// ```
#[inline]
pub fn exp2(x: f32) -> f32 {
    let x = finite(x);
    if x >= 128.0 {
        return f32::MAX;
    }
    if x < -126.0 {
        return 0.0;
    }
    let n = nearest(x);
    let (high, low) = exp2_pair(x - n);
    scaled(high + low, n as i32)
}

/// Returns eˣ; 0 if that is less than the smallest normal number, `f32::MAX` if it is too
/// large.
///
/// ```
/// use relievo_exact::exp;
///
/// assert_eq!((exp(0.0), exp(1.0), exp(-100.0)), (1.0, std::f32::consts::E, 0.0));
/// ```
#[inline]
pub fn exp(x: f32) -> f32 {
    let x = finite(x);
    if x > 88.722_84 {
        return f32::MAX;
    }
    if x < -87.336_55 {
        return 0.0;
    }
    let n = nearest(x * LOG2_E.0);
    let high = x - n * LN_2.0;
    let low = n * LN_2.1;
    let r = high - low;
    let error = (high - r) - low;
    let tail = 0.5
        + r * (0.166_666_67
            + r * (0.041_666_463
                + r * (0.008_333_31 + r * (0.001_393_367_4 + r * 1.989_101_7e-4))));
    let (high, low) = fast_two_sum(1.0, r);
    scaled(high + (low + (error + r * r * tail)), n as i32)
}

/// Returns the exponent e and f of `x` = (1 + f) 2ᵉ, √½ ≤ 1 + f < √2, for a normal `x` > 0.
#[inline]
fn split(x: f32) -> (f32, f32) {
    const ROOT_OF_HALF: u32 = 0x3f35_04f3;
    let shifted = x.to_bits().wrapping_sub(ROOT_OF_HALF);
    let exponent = (shifted as i32) >> 23;
    let mantissa = f32::from_bits((shifted & MANTISSA) + ROOT_OF_HALF);
    (exponent as f32, mantissa - 1.0)
}

/// Returns (ln (1 + f) − f + ½ f²) / f³.
#[inline]
fn log_tail(f: f32) -> f32 {
    0.333_333_34
        + f * (-0.249_999_9
            + f * (0.200_000_11
                + f * (-0.166_680_02
                    + f * (0.142_865_17
                        + f * (-0.124_507_13
                            + f * (0.110_379_085
                                + f * (-0.106_465_906
                                    + f * (0.105_302_1 + f * -0.061_996_534))))))))
}

/// Returns the natural logarithm of `x`; −`f32::MAX` for 0 and for a negative `x`.
///
/// ```
/// use relievo_exact::log;
///
/// assert_eq!((log(1.0), log(10.0), log(0.0)), (0.0, std::f32::consts::LN_10, -f32::MAX));
/// ```
#[inline]
pub fn log(x: f32) -> f32 {
    let x = finite(x);
    if x <= 0.0 {
        return -f32::MAX;
    }
    let (e, f) = split(x);
    let half_square = 0.5 * f * f;
    let (high, low) = two_sum(e * LN_2.0, f);
    high + ((low + e * LN_2.1) - (half_square - f * f * f * log_tail(f)))
}

/// Returns the logarithm of `x` to base 2; −`f32::MAX` for 0 and for a negative `x`.
///
/// ```
/// use relievo_exact::log2;
///
/// assert_eq!((log2(8.0), log2(0.25), log2(-1.0)), (3.0, -2.0, -f32::MAX));
/// ```
#[inline]
pub fn log2(x: f32) -> f32 {
    let x = finite(x);
    if x <= 0.0 {
        return -f32::MAX;
    }
    let (e, f) = split(x);
    let (square, square_low) = two_product(f, f);
    let (high, low) = fast_two_sum(f, -0.5 * square);
    let low = low + (f * f * f * log_tail(f) - 0.5 * square_low);
    let (high, low) = product(fast_two_sum(high, low), LOG2_E);
    let (high, rest) = two_sum(e, high);
    high + (rest + low)
}

/// Returns the logarithm of a normal number `x` > 0 to base 2 as a pair, with an error of
/// about 2⁻³⁵ of it.
#[inline]
fn log2_pair(x: f32) -> (f32, f32) {
    let (e, f) = split(x);
    // ln (1 + f) = 2 artanh s, s = f / (2 + f).
    let s = quotient((f, 0.0), fast_two_sum(2.0, f));
    let z = product(s, s);
    // 2 artanh s = 2 s + s z (2/3 + 2/5 z + …).
    let tail = z.0 * (0.4 + z.0 * (0.285_715_3 + z.0 * (0.222_047_63 + z.0 * 0.191_204_49)));
    let (high, low) = fast_two_sum(0.666_666_7, tail);
    let series = product(product(s, z), (high, low - 1.986_821_6e-8));
    let (high, low) = fast_two_sum(2.0 * s.0, series.0);
    let natural = fast_two_sum(high, low + (2.0 * s.1 + series.1));
    let (high, low) = product(natural, LOG2_E);
    let (sum, error) = two_sum(e, high);
    fast_two_sum(sum, error + low)
}

/// Returns `x` to the power `y`; 0 if that is less than the smallest normal number,
/// `f32::MAX` if it is too large. A negative `x` counts as 0; 0 to the power 0 is 1.
///
/// ```
/// use relievo_exact::pow;
///
/// assert_eq!((pow(3.0, 4.0), pow(4.0, -0.5), pow(0.0, 2.0)), (81.0, 0.5, 0.0));
/// ```
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    /// Smaller exponents give 1: 128 · 2⁻⁴⁰ is too little to change it.
    const SMALLEST: f32 = 9.094_947e-13;
    /// Larger exponents give 1, 0 or `f32::MAX`.
    const LARGEST: f32 = 1.099_511_6e12;
    let (x, y) = (finite(x), finite(y));
    if x <= 0.0 && y != 0.0 {
        return if y > 0.0 { 0.0 } else { f32::MAX };
    }
    if abs(y) < SMALLEST || x == 1.0 {
        return 1.0;
    }
    let logarithm = log2_pair(x);
    let estimate = logarithm.0 * y;
    if abs(y) > LARGEST || abs(estimate) > 256.0 {
        return if estimate > 0.0 { f32::MAX } else { 0.0 };
    }
    let (high, low) = product(logarithm, (y, 0.0));
    let n = nearest(high);
    if n < -126.0 {
        return 0.0;
    }
    let (power, power_low) = exp2_pair(high - n);
    // The low part stands for a factor of 1 + low ln 2.
    let factor = low * core::f32::consts::LN_2;
    scaled(power + (power_low + factor * (power + power_low)), n as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_saturates() {
        assert_eq!((log(f32::INFINITY), log2(f32::NAN)), (log(f32::MAX), 128.0));
        assert_eq!(
            (exp(f32::NEG_INFINITY), exp2(f32::INFINITY)),
            (0.0, f32::MAX)
        );
        assert_eq!(
            (pow(0.0, -1.0), pow(-2.0, 2.0), pow(0.0, 0.0)),
            (f32::MAX, 0.0, 1.0)
        );
        assert_eq!(
            (pow(2.0, 1e30), pow(0.5, 1e30), pow(1.0, f32::MAX)),
            (f32::MAX, 0.0, 1.0)
        );
    }
}
