//! Correctly rounded division and square root by sums that are fused: rounded once.
//!
//! The device's own results are estimates of numbers between ½ and 2, as for
//! [`rounding`](crate::rounding). A fused sum gives the exact residual of an estimate, and
//! Newton's method makes it good. This takes a quarter of the instructions of
//! whole numbers, but a device must fuse: the canary `fused` shows whether it does.
//! The results are those of [`Division::rounded`] and [`Root::rounded`].
//!
//! Division: with the nearest reciprocal, the first correction of a quotient gives one of
//! the two nearest numbers, and the second the nearest (Markstein; Muller et al., Handbook
//! of Floating-Point Arithmetic, section 4.7). The tests try what the theorem leaves out. Root: one correction gives one of the two nearest
//! numbers, and the signs of two residuals tell which.

use crate::bits::{EXPONENT, LARGEST, MANTISSA, SIGN, SMALLEST_SQUARE};
use crate::native::native_fma;
#[cfg(target_arch = "spirv")]
use crate::native::{native_div, native_sqrt};
use crate::rounding::{Division, Root};

/// Returns 1 / `y` from an `estimate`: rounded to nearest, but for 32 of 2²³ mantissas,
/// and for powers of two, where the next number serves as well.
#[inline]
fn reciprocal(y: f32, estimate: f32) -> f32 {
    let error = native_fma(-y, estimate, 1.0);
    let bits = native_fma(native_fma(error, error, error), estimate, estimate).to_bits();
    // The largest mantissa's would be ½ else: 1 divided by it would be wrong.
    f32::from_bits(bits + (bits & MANTISSA == 0) as u32)
}

/// Returns `x` / `y`, rounded to nearest, from an `estimate` of 1 / `y`, where nothing is
/// denormal or too large.
#[inline]
fn quotient(x: f32, y: f32, estimate: f32) -> f32 {
    let reciprocal = reciprocal(y, estimate);
    let q = x * reciprocal;
    let q = native_fma(native_fma(-y, q, x), reciprocal, q);
    native_fma(native_fma(-y, q, x), reciprocal, q)
}

/// Returns √`x`, rounded to nearest, from an `estimate` and the `half` of its reciprocal,
/// where nothing is denormal or too large.
#[inline]
fn root(x: f32, estimate: f32, half: f32) -> f32 {
    let root = native_fma(native_fma(-estimate, estimate, x), half, estimate);
    // It is the nearest number r if r (r − u) < x ≤ r (r + u), u its last digit (Tuckerman).
    let below = f32::from_bits(root.to_bits().wrapping_sub(1));
    let above = f32::from_bits(root.to_bits().wrapping_add(1));
    let is_above = native_fma(-root, above, x) > 0.0;
    let is_below = native_fma(-root, below, x) <= 0.0;
    let nearest = if is_above { above } else { root };
    if is_below { below } else { nearest }
}

/// Returns `a / b` for operands of any size, as [`Division::rounded`] does.
#[cfg(target_arch = "spirv")]
#[inline]
pub(crate) fn div(a: f32, b: f32) -> f32 {
    let (_, y) = Division::new(a, b).mantissas();
    any_quotient(a, b, native_div(1.0, y))
}

/// Returns `a / b` from an `estimate` of the reciprocal of the mantissa of `b`.
#[inline]
fn any_quotient(a: f32, b: f32, estimate: f32) -> f32 {
    let (x, y) = Division::new(a, b).mantissas();
    let q = quotient(x, y, estimate).to_bits();
    // No quotient of mantissas is rounded up to 1 or 2: its exponent is the last word.
    let (a, b) = (a.to_bits(), b.to_bits());
    let (high_a, high_b) = ((a >> 23) & 255, (b >> 23) & 255);
    let difference = high_a as i32 - high_b as i32;
    let exponent = (q >> 23) as i32 + difference;
    let bits = q.wrapping_add((difference << 23) as u32);
    // Without branches.
    let is_large = (exponent >= 255) | (high_b == 0);
    let is_zero = (exponent <= 0) | (high_a == 0);
    let magnitude = if is_large { LARGEST } else { bits };
    f32::from_bits((a ^ b) & SIGN | if is_zero { 0 } else { magnitude })
}

/// Returns √`x` for `x` ≥ 0 of any size, as [`Root::rounded`] does.
#[cfg(target_arch = "spirv")]
#[inline]
pub(crate) fn sqrt(x: f32) -> f32 {
    let estimate = native_sqrt(Root::new(x).operand());
    any_root(x, estimate, native_div(0.5, estimate))
}

/// Returns √`x` from an `estimate` of the root of the operand, and the `half` of its
/// reciprocal.
#[inline]
fn any_root(x: f32, estimate: f32, half: f32) -> f32 {
    let operand = Root::new(x).operand();
    let root = root(operand, estimate, half);
    // The operand's exponent is 0 or 1, and that of `x` larger by twice the root's.
    let exponent = x.to_bits() & EXPONENT;
    let difference = exponent.wrapping_sub(operand.to_bits() & EXPONENT);
    let bits = root.to_bits().wrapping_add((difference as i32 >> 1) as u32);
    f32::from_bits(if exponent == 0 { 0 } else { bits })
}

/// [`moderate::div`](crate::moderate::div).
#[cfg(target_arch = "spirv")]
#[inline]
pub(crate) fn moderate_div(a: f32, b: f32) -> f32 {
    quotient(a, b, native_div(1.0, b))
}

/// [`moderate::sqrt`](crate::moderate::sqrt).
#[cfg(target_arch = "spirv")]
#[inline]
pub(crate) fn moderate_sqrt(x: f32) -> f32 {
    let estimate = native_sqrt(x);
    moderate_root(x, estimate, native_div(0.5, estimate))
}

/// Returns √`x` from an `estimate` and the `half` of its reciprocal; 0 if `x` is too small
/// for the residuals.
#[inline]
fn moderate_root(x: f32, estimate: f32, half: f32) -> f32 {
    let root = root(x, estimate, half);
    if x >= SMALLEST_SQUARE { root } else { 0.0 }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // The standard library's operators are the reference.
mod tests {
    use super::*;
    use crate::bits::{IMPLICIT, ONE};
    use fastrand::Rng;
    use std::collections::BTreeMap;

    /// Errors of estimates that are corrected, ULP.
    const ERRORS: core::ops::RangeInclusive<i32> = -8..=8;

    /// `x` moved by `ulp` representable numbers.
    fn disturbed(x: f32, ulp: i32) -> f32 {
        f32::from_bits((x.to_bits() as i32 + ulp) as u32)
    }

    fn mantissa(bits: u32) -> f32 {
        f32::from_bits(bits & MANTISSA | ONE)
    }

    fn divide(a: f32, b: f32, ulp: i32) -> f32 {
        let (_, y) = Division::new(a, b).mantissas();
        any_quotient(a, b, disturbed(1.0 / y, ulp))
    }

    fn assert_quotient(a: f32, b: f32, ulp: i32) {
        let found = divide(a, b, ulp);
        assert_eq!(
            found.to_bits(),
            (a / b).to_bits(),
            "{a:e} / {b:e} from an estimate off by {ulp}: {found:e}"
        );
    }

    /// Markstein's theorem asks for the nearest reciprocal. Where an estimate within 8 ULP
    /// leads to another, every dividend is tried.
    #[test]
    fn quotients_are_correct_where_the_theorem_says_nothing() {
        let mut others = BTreeMap::new();
        for y in (0..IMPLICIT).map(mantissa) {
            let nearest = 1.0 / y;
            for ulp in ERRORS {
                let found = reciprocal(y, disturbed(nearest, ulp));
                if found != nearest && nearest.to_bits() & MANTISSA != 0 {
                    others.insert((y.to_bits(), found.to_bits()), ulp);
                }
            }
        }
        assert_eq!(others.len(), 32);
        for ((y, _), ulp) in others {
            for bits in 0..IMPLICIT {
                assert_quotient(mantissa(bits), f32::from_bits(y), ulp);
            }
        }
    }

    /// The quotients nearest to the middle between two numbers.
    #[test]
    fn quotients_near_a_tie_are_correct() {
        let mut random = Rng::with_seed(4);
        for _ in 0..200_000 {
            let b = random.u32(IMPLICIT..2 * IMPLICIT) | 1;
            let q = random.u32(IMPLICIT..2 * IMPLICIT);
            // a ≈ (q + ½) b / 2^23 or 2^24, whichever has 24 bits.
            let product = (2 * u64::from(q) + 1) * u64::from(b);
            let a = product
                >> if product >> 24 < u64::from(2 * IMPLICIT) {
                    24
                } else {
                    25
                };
            for near in [a, a + 1] {
                for ulp in [-8, -2, 0, 2, 8] {
                    assert_quotient(mantissa(near as u32), mantissa(b), ulp);
                }
            }
        }
    }

    /// The same words as by whole numbers: of zeros, denormals, infinities and NaN, too.
    #[test]
    fn all_results_are_those_of_whole_numbers() {
        let mut random = Rng::with_seed(5);
        let mut special = [0.0, 1e-40, 1e-38, 3e38, f32::INFINITY, f32::NAN].to_vec();
        special.extend([-1.0, 1.0, f32::MIN_POSITIVE, f32::MAX, 1.5]);
        let number = |random: &mut Rng| {
            let special = *random.choice(&special).unwrap();
            if random.u32(0..20) == 0 {
                special
            } else {
                f32::from_bits(random.u32(..))
            }
        };
        for _ in 0..4_000_000 {
            let (a, b) = (number(&mut random), number(&mut random));
            let whole = Division::new(a, b);
            let (x, y) = whole.mantissas();
            let ulp = random.i32(ERRORS);
            let found = divide(a, b, ulp);
            assert_eq!(
                found.to_bits(),
                whole.rounded(x / y).to_bits(),
                "{a:e} / {b:e}, {ulp}"
            );
            let x = f32::from_bits(a.to_bits() & !SIGN);
            let found = disturbed_root(x, ulp, random.i32(ERRORS));
            let whole = Root::new(x);
            assert_eq!(
                found.to_bits(),
                whole.rounded(whole.operand().sqrt()).to_bits(),
                "√{x:e}"
            );
        }
    }

    fn disturbed_root(x: f32, ulp: i32, half_ulp: i32) -> f32 {
        let estimate = disturbed(Root::new(x).operand().sqrt(), ulp);
        any_root(x, estimate, disturbed(0.5 / estimate, half_ulp))
    }

    /// Every number of two binades, which is every mantissa with either parity of the
    /// exponent.
    #[test]
    fn roots_of_two_binades_are_correct() {
        for bits in ONE..ONE + 2 * IMPLICIT {
            let x = f32::from_bits(bits);
            let expected = x.sqrt();
            for (ulp, half_ulp) in [(-8, -8), (-8, 8), (-3, 2), (0, 0), (1, -1), (8, -8), (8, 8)] {
                assert_eq!(
                    disturbed_root(x, ulp, half_ulp),
                    expected,
                    "√{x:e}, {ulp} {half_ulp}"
                );
            }
        }
    }

    /// Operands of moderate size need no scaling: residuals are exact without it.
    #[test]
    fn moderate_operands_are_divided_as_they_are() {
        let mut random = Rng::with_seed(6);
        let moderate = |random: &mut Rng| {
            let exponent = random.u32(127 - 79..=127 + 79);
            let sign = random.u32(..) & SIGN;
            f32::from_bits(sign | exponent << 23 | random.u32(..) & MANTISSA)
        };
        for _ in 0..4_000_000 {
            let (a, b) = (moderate(&mut random), moderate(&mut random));
            if (a / b).is_normal() {
                let found = quotient(a, b, disturbed(1.0 / b, random.i32(ERRORS)));
                assert_eq!(found, a / b, "{a:e} / {b:e}");
            }
            let x = a.abs();
            let estimate = disturbed(x.sqrt(), random.i32(ERRORS));
            let half = disturbed(0.5 / estimate, random.i32(ERRORS));
            assert_eq!(root(x, estimate, half), x.sqrt(), "√{x:e}");
        }
        assert_eq!(quotient(0.0, 3.0, 1.0 / 3.0), 0.0);
    }

    /// A root of any finite number, of denormal numbers too, is that of the CPU.
    #[test]
    fn moderate_roots_are_those_of_the_cpu() {
        let mut random = Rng::with_seed(7);
        let edges = [SMALLEST_SQUARE, SMALLEST_SQUARE.next_down(), f32::MAX, 0.0];
        let others = core::iter::repeat_with(|| f32::from_bits(random.u32(..) & !SIGN));
        for x in edges.into_iter().chain(others.take(4_000_000)) {
            if !x.is_finite() {
                continue;
            }
            // A device may flush what it estimates, or its estimate.
            let x_or_0 = if x.is_normal() { x } else { 0.0 };
            for estimate in [x.sqrt(), disturbed(x_or_0.sqrt(), 3), 0.0] {
                if estimate == 0.0 && x >= SMALLEST_SQUARE {
                    continue;
                }
                let found = moderate_root(x, estimate, 0.5 / estimate);
                assert_eq!(
                    found.to_bits(),
                    crate::moderate::sqrt(x).to_bits(),
                    "√{x:e}"
                );
            }
        }
    }

    /// The tests above can fail: an estimate off by more than is made good.
    #[test]
    fn worse_estimates_are_not_made_good() {
        assert_ne!(divide(1.5, 1.25, -2_000_000), 1.5 / 1.25);
        assert_ne!(disturbed_root(1.5, -2_000_000, 0), 1.5f32.sqrt());
    }
}
