//! Operations that devices may round differently, and small helpers.
//!
//! Those of f32 are `relievo-exact`'s: division and square root are called only from
//! there. On the CPU they are the native ones; in the exact shaders (feature `corrected`)
//! the device's results are corrected; in the fast shaders they are the device's own.
//!
//! ```
//! use relievo_shared::arithmetic::{div, floor, sqrt};
//!
//! assert_eq!(div(1.0, 3.0), 1.0 / 3.0);
//! assert_eq!((sqrt(-1.0), floor(-0.5)), (0.0, -1.0));
//! ```

#[cfg(feature = "double")]
pub use crate::double::{abs, clamp, div, max, min, normalize_or, sqrt};
use crate::{Real, Vec3};
#[cfg(not(feature = "double"))]
pub use relievo_exact::moderate::{div, normalize_or, sqrt};
#[cfg(not(feature = "double"))]
pub use relievo_exact::{abs, clamp, max, min};

/// Returns the largest integer not above `x`, for |x| < 2³⁰; larger magnitudes
/// saturate near ±2³⁰.
#[inline]
pub fn floor_to_int(x: Real) -> i32 {
    // Clamped, because a conversion out of range is undefined on GPUs. The
    // bounds are powers of two, exact in f32.
    let truncated = clamp(x, -1_073_741_824.0, 1_073_741_824.0) as i32;
    if truncated as Real > x {
        truncated - 1
    } else {
        truncated
    }
}

/// Returns the largest integer not above `x`, for |x| < 2³⁰.
#[inline]
pub fn floor(x: Real) -> Real {
    floor_to_int(x) as Real
}

/// Magnitudes below this (2⁻⁶⁰) are treated as zero, so that products of two numbers
/// are normal: no device flushes them to zero.
pub const SMALLEST: Real = 8.673_617e-19;

/// Returns `x` (0…1) to the power `exponent` (0…127), by repeated squaring; 0 if that
/// is below [`SMALLEST`].
#[inline]
pub fn power(x: Real, exponent: u32) -> Real {
    let mut result = 1.0;
    let mut square = x;
    let mut rest = exponent;
    let mut bit = 0;
    while bit < 7 {
        if rest & 1 == 1 {
            result = kept(result * square);
        }
        square = kept(square * square);
        rest >>= 1;
        bit += 1;
    }
    result
}

/// Returns `x`, or 0 if its magnitude is below `least`.
#[inline]
pub fn zero_below(x: Real, least: Real) -> Real {
    // By bits: one comparison. The bits of numbers ≥ 0 have the order of the numbers.
    if x.to_bits() & (!0 >> 1) < least.to_bits() {
        0.0
    } else {
        x
    }
}

/// Returns `x`, or 0 if its magnitude is below [`SMALLEST`].
#[inline]
pub fn kept(x: Real) -> Real {
    zero_below(x, SMALLEST)
}

/// Applies [`kept`] to each component.
#[inline]
pub fn kept3(v: Vec3) -> Vec3 {
    Vec3::new(kept(v.x), kept(v.y), kept(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn floor_agrees_with_std(x in -1e6f32..1e6) {
            prop_assert_eq!(floor(x), x.floor());
        }

        #[test]
        fn power_agrees_with_f64(x in 0.0f32..1.0, exponent in 0u32..128) {
            let expected = f64::from(x).powi(exponent as i32);
            prop_assert!((f64::from(power(x, exponent)) - expected).abs() <= 1e-5 * expected + f64::from(SMALLEST));
        }

        #[test]
        fn normalized_vectors_have_length_one(x in -1e6f32..1e6, y in -1e6f32..1e6, z in -1e6f32..1e6) {
            prop_assume!(x * x + y * y + z * z > 1e-12);
            let n = normalize_or(Vec3::new(x, y, z), Vec3::X);
            prop_assert!((n.dot(n) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn edges_of_the_domain() {
        assert_eq!(floor(-0.5), -1.0);
        assert_eq!(floor_to_int(-0.5), -1);
        assert_eq!(floor_to_int(-1.0), -1);
        assert_eq!(floor_to_int(1e30), 1_073_741_824);
        assert_eq!(floor_to_int(-1e30), -1_073_741_825);
        assert_eq!(sqrt(-1.0), 0.0);
        assert_eq!(clamp(Real::NAN, 0.0, 1.0), 0.0);
        assert_eq!(normalize_or(Vec3::ZERO, Vec3::Z), Vec3::Z);
        assert_eq!(normalize_or(Vec3::splat(1e-20), Vec3::Z), Vec3::Z);
        assert_eq!(power(0.0, 0), 1.0);
        assert_eq!(power(0.1, 127), 0.0);
        assert_eq!(div(1.0, 0.0), Real::MAX);
        assert_eq!(div(0.0, 0.0), 0.0);
        assert_eq!(div(-1e30, 1e-30), -Real::MAX);
        assert_eq!(div(1e-30, 1e30), 0.0);
    }
}
