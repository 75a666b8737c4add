//! Division and roots of numbers of moderate size, with fewer instructions.
//!
//! Dividends are 0 or 2⁻⁷⁹…2⁷⁹ in magnitude, divisors 2⁻⁷⁹…2⁷⁹, and what a root is taken of
//! is at least 2⁻⁷⁹, or not above 0. So is most of what a program computes. The results
//! are those of [`crate::div`], [`crate::sqrt`] and [`crate::normalize_or`]; where a
//! device fuses sums (feature `fused`), half of their instructions are saved, which take
//! apart and put together exponents. For other operands, a device may differ from the CPU.
//!
//! ```
//! use relievo_exact::moderate::{div, sqrt};
//!
//! assert_eq!((div(1.0, 3.0), sqrt(2.0)), (1.0 / 3.0, 2.0_f32.sqrt()));
//! ```

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

/// Returns the square root of `x`, rounded to nearest; 0 for a negative `x`.
#[inline]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(feature = "fused", target_arch = "spirv"))]
    {
        crate::fused::moderate_sqrt(x)
    }
    #[cfg(not(all(feature = "fused", target_arch = "spirv")))]
    crate::basic::sqrt(x)
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
