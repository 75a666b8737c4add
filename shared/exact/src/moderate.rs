//! Division and roots of numbers of moderate size, with fewer instructions.
//!
//! A dividend must be 0 or have a magnitude of 2⁻⁷⁹ to 2⁷⁹, and a divisor such a magnitude.
//! With other operands of a division, a device may differ from the CPU. [`sqrt`] takes any
//! finite number, and returns 0 for numbers below 2⁻⁷⁹. Apart from that, the results are
//! those of [`crate::div`], [`crate::sqrt`] and [`crate::normalize_or`].
//!
//! Where a device fuses sums (feature `fused`), these functions take half of the
//! instructions, since they leave exponents as they are.
//!
//! ```
//! use relievo_exact::moderate::{div, sqrt};
//!
//! assert_eq!((div(1.0, 3.0), sqrt(2.0)), (1.0 / 3.0, 2.0_f32.sqrt()));
//! ```

#[cfg(feature = "corrected")]
use crate::correction;
use crate::vector::Vector;

/// Returns `a / b`, rounded to nearest, as [`crate::div`] does.
#[inline]
pub fn div(a: f32, b: f32) -> f32 {
    #[cfg(all(feature = "fused", target_arch = "spirv"))]
    {
        crate::fused::moderate_div(a, b)
    }
    #[cfg(not(all(feature = "fused", target_arch = "spirv")))]
    crate::basic::div(a, b)
}

/// Returns the square root of `x`, rounded to nearest; 0 if `x` < 2⁻⁷⁹.
///
/// ```
/// use relievo_exact::moderate::sqrt;
///
/// assert_eq!((sqrt(2.0), sqrt(1e-24), sqrt(-1.0)), (2.0_f32.sqrt(), 0.0, 0.0));
/// ```
#[inline]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(feature = "corrected")]
    {
        correction::moderate_sqrt(x)
    }
    #[cfg(all(target_arch = "spirv", not(feature = "corrected")))]
    {
        crate::basic::sqrt(x)
    }
    #[cfg(not(any(feature = "corrected", target_arch = "spirv")))]
    if x < crate::bits::SMALLEST_SQUARE {
        0.0
    } else {
        crate::basic::sqrt(x)
    }
}

/// Returns `v` scaled to length 1, or `fallback` if `v` is too short, as
/// [`crate::normalize_or`] does.
#[inline]
pub fn normalize_or<V: Vector>(v: V, fallback: V) -> V {
    let squared = v.inner(v);
    if squared > 1e-30 {
        // The square may be smaller than the bound.
        v.times(div(1.0, crate::basic::sqrt(squared)))
    } else {
        fallback
    }
}
