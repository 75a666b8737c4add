//! Numbers by their bits.

pub(crate) const SIGN: u32 = 0x8000_0000;
pub(crate) const EXPONENT: u32 = 0x7f80_0000;
pub(crate) const MANTISSA: u32 = 0x007f_ffff;
pub(crate) const IMPLICIT: u32 = 0x0080_0000;
pub(crate) const ONE: u32 = 0x3f80_0000;
pub(crate) const LARGEST: u32 = 0x7f7f_ffff;

/// The smallest number whose moderate root is not 0: 2⁻⁷⁹. The residuals of smaller roots
/// are not normal numbers.
#[cfg(any(feature = "corrected", not(target_arch = "spirv")))]
pub(crate) const SMALLEST_SQUARE: f32 = 1.654_361_2e-24;

/// The largest number below 1.
pub(crate) const LARGEST_BELOW_ONE: f32 = 0.999_999_94;

/// Returns `x` as every device has it: 0 for a denormal number, ±`f32::MAX` for an
/// infinity and for NaN.
///
/// ```
/// use relievo_exact::finite;
///
/// assert_eq!(finite(f32::NEG_INFINITY), -f32::MAX);
/// assert_eq!((finite(1e-40), finite(0.5)), (0.0, 0.5));
/// ```
#[inline]
pub fn finite(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = bits & EXPONENT;
    let finite = if exponent == EXPONENT {
        bits & SIGN | LARGEST
    } else {
        bits
    };
    f32::from_bits(if exponent == 0 { bits & SIGN } else { finite })
}

/// Returns `x` · 2ⁿ for a normal number `x` > 0; 0 or `f32::MAX` if that is not a normal
/// number. |n| is at most 2⁸.
#[inline]
pub(crate) fn scaled(x: f32, n: i32) -> f32 {
    let exponent = (x.to_bits() >> 23) as i32 + n;
    if exponent <= 0 {
        0.0
    } else if exponent >= 255 {
        f32::MAX
    } else {
        f32::from_bits(x.to_bits() & MANTISSA | (exponent as u32) << 23)
    }
}

/// Returns `x`, or −`x` if `sign` is negative.
#[inline]
pub(crate) fn with_sign(x: f32, sign: f32) -> f32 {
    if sign < 0.0 { -x } else { x }
}

/// Returns the nearest whole number of `x`, |x| < 2²²; halves are rounded to even.
#[inline]
pub(crate) fn nearest(x: f32) -> f32 {
    // The sum has no digits after the point.
    const SHIFT: f32 = 12_582_912.0;
    (x + SHIFT) - SHIFT
}
