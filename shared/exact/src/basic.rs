//! Division, roots, limits and rounding to whole numbers.

#[cfg(not(any(feature = "corrected", target_arch = "spirv")))]
use crate::bits::SIGN;
use crate::bits::{LARGEST_BELOW_ONE, finite, scaled};
#[cfg(feature = "corrected")]
use crate::correction;
#[cfg(not(feature = "corrected"))]
use crate::native::{native_div, native_sqrt};
use crate::pair::two_product;
#[cfg(not(any(feature = "corrected", target_arch = "spirv")))]
use crate::rounding::Division;
use crate::rounding::Root;

/// Returns `a / b`, rounded to nearest. A quotient that is not a normal number is 0
/// (too small, or `a` is 0) or ±`f32::MAX` (too large, or `b` is 0).
///
/// ```
/// use relievo_exact::div;
///
/// assert_eq!(div(1.0, 3.0), 1.0 / 3.0);
/// assert_eq!((div(-1.0, 0.0), div(0.0, 0.0)), (-f32::MAX, 0.0));
/// ```
#[inline]
pub fn div(a: f32, b: f32) -> f32 {
    #[cfg(feature = "corrected")]
    {
        correction::div(a, b)
    }
    #[cfg(not(feature = "corrected"))]
    saturate(native_div(a, b), a, b)
}

/// Returns `quotient`, or the result of [`div`] if it or an operand is not a normal number.
#[cfg(not(any(feature = "corrected", target_arch = "spirv")))]
#[inline]
fn saturate(quotient: f32, a: f32, b: f32) -> f32 {
    let magnitude = |x: f32| f32::from_bits(x.to_bits() & !SIGN);
    let is_normal = magnitude(quotient) > f32::MIN_POSITIVE && magnitude(quotient) <= f32::MAX;
    if is_normal && min(magnitude(a), magnitude(b)) >= f32::MIN_POSITIVE {
        quotient
    } else {
        unusual(a, b)
    }
}

/// The corrected quotient, out of the way of the usual case.
#[cfg(not(any(feature = "corrected", target_arch = "spirv")))]
#[cold]
#[inline(never)]
fn unusual(a: f32, b: f32) -> f32 {
    if a == 0.0 {
        // By far the most of them.
        Division::new(a, b).saturated()
    } else {
        crate::rounding::div(a, b)
    }
}

#[cfg(all(target_arch = "spirv", not(feature = "corrected")))]
#[inline]
fn saturate(quotient: f32, _: f32, _: f32) -> f32 {
    quotient
}

/// Returns the quotient of two pairs as a pair. The low parts are less than half a unit of
/// the high ones.
#[inline]
pub(crate) fn quotient((a, a_low): (f32, f32), (b, b_low): (f32, f32)) -> (f32, f32) {
    let high = div(a, b);
    let (back, back_low) = two_product(high, b);
    let rest = ((a - back) - back_low) + (a_low - high * b_low);
    (high, div(rest, b))
}

/// Returns the square root of `x`, rounded to nearest; 0 for a negative `x`.
///
/// ```
/// use relievo_exact::sqrt;
///
/// assert_eq!((sqrt(2.0), sqrt(-1.0)), (2.0_f32.sqrt(), 0.0));
/// ```
#[inline]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(feature = "corrected")]
    {
        correction::sqrt(max(x, 0.0))
    }
    #[cfg(all(target_arch = "spirv", not(feature = "corrected")))]
    {
        native_sqrt(max(x, 0.0))
    }
    // An infinity counts as 2¹²⁸, as for a corrected root.
    #[cfg(not(any(feature = "corrected", target_arch = "spirv")))]
    if x >= f32::MIN_POSITIVE {
        min(native_sqrt(x), 18_446_744_073_709_551_616.0)
    } else {
        0.0
    }
}

/// Returns 1 / √`x`; `f32::MAX` for 0 and for a negative `x`.
///
/// ```
/// use relievo_exact::recip_sqrt;
///
/// assert_eq!((recip_sqrt(4.0), recip_sqrt(0.0)), (0.5, f32::MAX));
/// ```
#[inline]
pub fn recip_sqrt(x: f32) -> f32 {
    let x = finite(x);
    if x <= 0.0 {
        return f32::MAX;
    }
    // x = m 4ᵏ, 1 ≤ m < 4.
    let m = Root::new(x).operand();
    let k = ((x.to_bits() >> 23) as i32 - (m.to_bits() >> 23) as i32) >> 1;
    let y = div(1.0, sqrt(m));
    // One step of Newton's method: y + ½ y (1 − m y²).
    let (p, p_low) = two_product(m, y);
    let (q, q_low) = two_product(p, y);
    let residual = (1.0 - q) - q_low - p_low * y;
    scaled(y + 0.5 * y * residual, -k)
}

/// Returns the smaller of two numbers that are not NaN.
#[inline]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the larger of two numbers that are not NaN.
#[inline]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns `x` limited to `low..=high`; `low` for NaN.
#[inline]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    let x = if x > low { x } else { low };
    min(x, high)
}

/// Returns the absolute value of `x`.
#[inline]
pub fn abs(x: f32) -> f32 {
    if x < 0.0 { -x } else { x }
}

/// Magnitudes from here on are whole numbers: 2²³.
const WHOLE: f32 = 8_388_608.0;

/// Returns `x` rounded toward zero.
#[inline]
pub fn trunc(x: f32) -> f32 {
    let x = finite(x);
    // A conversion out of range is undefined on GPUs.
    let is_whole = abs(x) >= WHOLE;
    let whole = (if is_whole { 0.0 } else { x }) as i32 as f32;
    if is_whole { x } else { whole }
}

/// Returns the largest whole number not above `x`.
///
/// ```
/// use relievo_exact::floor;
///
/// assert_eq!((floor(-0.5), floor(1e30)), (-1.0, 1e30));
/// ```
#[inline]
pub fn floor(x: f32) -> f32 {
    let x = finite(x);
    let whole = trunc(x);
    if whole > x { whole - 1.0 } else { whole }
}

/// Returns the smallest whole number not below `x`.
#[inline]
pub fn ceil(x: f32) -> f32 {
    // The sign of NaN would not be turned everywhere.
    -floor(-finite(x))
}

/// Returns the nearest whole number; halves are rounded away from zero, as by
/// `f32::round`.
///
/// ```
/// use relievo_exact::round;
///
/// assert_eq!((round(2.5), round(-2.5), round(0.499_999_97)), (3.0, -3.0, 0.0));
/// ```
#[inline]
pub fn round(x: f32) -> f32 {
    let x = finite(x);
    let whole = trunc(x);
    let rest = x - whole;
    if rest >= 0.5 {
        whole + 1.0
    } else if rest <= -0.5 {
        whole - 1.0
    } else {
        whole
    }
}

/// Returns `x` − [`floor`]\(`x`\), at least 0 and less than 1.
///
/// ```
/// use relievo_exact::fract;
///
/// assert_eq!((fract(-0.25), fract(-1e-9)), (0.75, 0.999_999_94));
/// ```
#[inline]
pub fn fract(x: f32) -> f32 {
    let x = finite(x);
    min(x - floor(x), LARGEST_BELOW_ONE)
}
