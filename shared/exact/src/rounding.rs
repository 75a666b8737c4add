//! Correctly rounded division and square root from an estimate, on any device.
//!
//! Vulkan allows errors of 2.5 ULP for a division and about 3 ULP for a square root, and
//! some drivers use them. Here the device's result is only an estimate: its exact
//! residual, in wrapping u32 arithmetic, tells the error in units and how to round.
//! Results are those of IEEE 754 for operands and results that are normal numbers or
//! zero, whatever the last digits of the estimate. Others saturate: never an infinity, a
//! NaN or a denormal.
//!
//! ```
//! use relievo_exact::rounding::Division;
//!
//! let division = Division::new(1.0, 3.0);
//! let (a, b) = division.mantissas();
//! let estimate = (a / b) * (1.0 + 2.0 * f32::EPSILON);
//! assert_eq!(division.rounded(estimate), 1.0 / 3.0);
//! ```

#[cfg(feature = "corrected")]
use crate::bits::SMALLEST_SQUARE;
use crate::bits::{EXPONENT, IMPLICIT, LARGEST, MANTISSA, ONE, SIGN};
use crate::native::native_div;
#[cfg(feature = "corrected")]
use crate::native::native_sqrt;

/// Largest error of an estimate that is corrected, ULP.
pub const LARGEST_ERROR: u32 = 8;

/// Returns `a / b`.
#[cfg(any(
    not(target_arch = "spirv"),
    all(feature = "corrected", not(feature = "fused"))
))]
#[inline]
pub(crate) fn div(a: f32, b: f32) -> f32 {
    let division = Division::new(a, b);
    let (x, y) = division.mantissas();
    division.rounded(native_div(x, y))
}

/// Returns √`x`, `x` ≥ 0.
#[cfg(all(
    feature = "corrected",
    not(all(feature = "fused", target_arch = "spirv"))
))]
#[inline]
pub(crate) fn sqrt(x: f32) -> f32 {
    let root = Root::new(x);
    root.rounded(native_sqrt(root.operand()))
}

/// [`moderate::sqrt`](crate::moderate::sqrt).
#[cfg(all(
    feature = "corrected",
    not(all(feature = "fused", target_arch = "spirv"))
))]
#[inline]
pub(crate) fn moderate_sqrt(x: f32) -> f32 {
    let root = Root::new(x);
    let bits = root.bits(native_sqrt(root.operand()));
    f32::from_bits(if x >= SMALLEST_SQUARE { bits } else { 0 })
}

/// The operands of a division, which the device estimates without their exponents.
#[derive(Clone, Copy, Debug)]
pub struct Division {
    a: u32,
    b: u32,
}

impl Division {
    /// Returns the division `a / b`.
    #[inline]
    pub fn new(a: f32, b: f32) -> Division {
        Division {
            a: a.to_bits(),
            b: b.to_bits(),
        }
    }

    /// Returns the mantissas, 1…2, whose quotient the device estimates.
    #[inline]
    pub fn mantissas(self) -> (f32, f32) {
        (
            f32::from_bits(self.a & MANTISSA | ONE),
            f32::from_bits(self.b & MANTISSA | ONE),
        )
    }

    /// Returns `a / b`, rounded to nearest, from an `estimate` of the quotient of the
    /// mantissas within [`LARGEST_ERROR`].
    #[inline]
    pub fn rounded(self, estimate: f32) -> f32 {
        let sign = (self.a ^ self.b) & SIGN;
        let a = self.a & MANTISSA | IMPLICIT;
        let b = self.b & MANTISSA | IMPLICIT;
        // The quotient of the mantissas times 2^23, or 2^24 where it is below
        // one, has 24 bits before the point.
        let below_one = a.wrapping_sub(b) >> 31;
        let scale = f32::from_bits((127 + 23 + below_one) << 23);
        let mut quotient = (estimate * scale) as i32 as u32;
        let mut residual = ((a << 23) << below_one).wrapping_sub(quotient.wrapping_mul(b));
        let units = native_div(residual as i32 as f32, b as i32 as f32) as i32 as u32;
        quotient = quotient.wrapping_add(units);
        residual = residual.wrapping_sub(units.wrapping_mul(b));
        // The second estimate may be one unit off in either direction. A residual
        // slightly below zero then rounds correctly.
        let over = all_if_negative(residual);
        quotient = quotient.wrapping_add(over);
        residual = residual.wrapping_add(over & b);
        let under = !all_if_negative(residual.wrapping_sub(b));
        quotient = quotient.wrapping_sub(under);
        residual = residual.wrapping_sub(under & b);
        // Half a unit exactly is impossible: 2q + 1 would divide a power of two.
        quotient = quotient.wrapping_sub(all_if_negative(b.wrapping_sub(residual << 1)));

        let exponent = self.exponent();
        let has_zero = self.a & EXPONENT == 0 || self.b & EXPONENT == 0;
        if exponent > 0 && exponent < 255 && !has_zero {
            // A quotient that was rounded up to 2^24 raises the exponent.
            let bits = ((exponent as u32) << 23).wrapping_add(quotient - IMPLICIT);
            f32::from_bits(sign | if bits > LARGEST { LARGEST } else { bits })
        } else {
            self.saturated()
        }
    }

    /// Returns the quotient's biased exponent before rounding.
    #[inline]
    fn exponent(self) -> i32 {
        let (a, b) = (self.a & MANTISSA, self.b & MANTISSA);
        let (high_a, high_b) = ((self.a >> 23) & 255, (self.b >> 23) & 255);
        high_a as i32 - high_b as i32 + if a < b { 126 } else { 127 }
    }

    /// Returns the replacement for an `a / b` that is not a normal number: zero if `a` is
    /// zero or the quotient too small, ±`f32::MAX` if `b` is zero or the quotient too
    /// large.
    #[inline]
    pub fn saturated(self) -> f32 {
        let sign = (self.a ^ self.b) & SIGN;
        let zero_a = self.a & EXPONENT == 0;
        let zero_b = self.b & EXPONENT == 0;
        let magnitude = if zero_a || (!zero_b && self.exponent() <= 0) {
            0
        } else {
            LARGEST
        };
        f32::from_bits(sign | magnitude)
    }
}

/// Returns all bits set if the number in two's complement is negative, else 0: a selection
/// without a branch.
#[inline]
fn all_if_negative(x: u32) -> u32 {
    (x as i32 >> 31) as u32
}

/// The operand of a square root, which the device estimates with the exponent 0 or 1.
#[derive(Clone, Copy, Debug)]
pub struct Root {
    x: u32,
}

impl Root {
    /// Returns the root √x, x ≥ 0.
    #[inline]
    pub fn new(x: f32) -> Root {
        Root { x: x.to_bits() }
    }

    /// Returns 1 if x is a mantissa times an odd power of two, else 0.
    #[inline]
    fn odd(self) -> u32 {
        // The exponent's bias is odd.
        !(self.x >> 23) & 1
    }

    /// Returns the number, 1…4, whose root the device estimates.
    #[inline]
    pub fn operand(self) -> f32 {
        f32::from_bits(self.x & MANTISSA | (ONE + (self.odd() << 23)))
    }

    /// Returns √x, rounded to nearest, from an `estimate` of the operand's root within
    /// [`LARGEST_ERROR`]; 0 for a denormal x.
    #[inline]
    pub fn rounded(self, estimate: f32) -> f32 {
        let is_zero = self.x & EXPONENT == 0;
        f32::from_bits(if is_zero { 0 } else { self.bits(estimate) })
    }

    /// Returns the bits of [`Root::rounded`] for an x that is not denormal.
    #[inline]
    fn bits(self, estimate: f32) -> u32 {
        let mantissa = self.x & MANTISSA | IMPLICIT;
        // q² + residual = mantissa · 2^23 or 2^24, of up to 48 bits: the low 32
        // of both are enough, since their difference is small.
        let mut root = (estimate * 8_388_608.0) as i32 as u32;
        let mut residual = ((mantissa << 23) << self.odd()).wrapping_sub(root.wrapping_mul(root));
        let units = native_div(residual as i32 as f32, (2 * root) as i32 as f32) as i32 as u32;
        residual = residual.wrapping_sub(units.wrapping_mul((2 * root).wrapping_add(units)));
        root = root.wrapping_add(units);
        // As above.
        let over = all_if_negative(residual);
        root = root.wrapping_add(over);
        residual = residual.wrapping_add(over & (2 * root + 1));
        let under = !all_if_negative(residual.wrapping_sub(2 * root + 1));
        residual = residual.wrapping_sub(under & (2 * root + 1));
        root = root.wrapping_sub(under);
        // (q + ½)² = q² + q + ¼.
        root = root.wrapping_sub(all_if_negative(root.wrapping_sub(residual)));

        // Half the exponent, with the bias put back: (e − 127) / 2 + 127.
        let exponent = (self.x >> 23) & 255;
        let half = (exponent + 127) >> 1;
        (half << 23).wrapping_add(root - IMPLICIT)
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // The standard library's operators are the reference.
mod tests {
    use super::*;
    use fastrand::Rng;

    /// `x` moved by `ulp` representable numbers.
    fn disturbed(x: f32, ulp: i32) -> f32 {
        f32::from_bits((x.to_bits() as i32 + ulp) as u32)
    }

    fn divide(a: f32, b: f32, ulp: i32) -> f32 {
        let division = Division::new(a, b);
        let (x, y) = division.mantissas();
        division.rounded(disturbed(x / y, ulp))
    }

    fn root(x: f32, ulp: i32) -> f32 {
        let root = Root::new(x);
        root.rounded(disturbed(root.operand().sqrt(), ulp))
    }

    fn assert_quotient(a: f32, b: f32, ulp: i32) {
        let found = divide(a, b, ulp);
        assert_eq!(
            found.to_bits(),
            (a / b).to_bits(),
            "{a:e} / {b:e} from an estimate off by {ulp}: {found:e}"
        );
    }

    /// Mantissas where rounding is decided by the last digits: all ones and
    /// all zeros from either end, one bit, and random ones.
    fn mantissas(random: &mut Rng) -> Vec<u32> {
        let mut all = vec![0, MANTISSA, 0x2a_aaaa, 0x55_5555];
        for bit in 0..23 {
            let one = 1 << bit;
            all.extend([one, one - 1, MANTISSA ^ one, MANTISSA ^ (one - 1)]);
        }
        all.extend((0..160).map(|_| random.u32(0..=MANTISSA)));
        all.sort_unstable();
        all.dedup();
        all
    }

    #[test]
    fn quotients_of_every_class_of_mantissas_are_the_cpus() {
        let mantissas = mantissas(&mut Rng::with_seed(3));
        assert!(mantissas.len() > 200);
        for &a in &mantissas {
            for &b in &mantissas {
                let (x, y) = (f32::from_bits(a | ONE), f32::from_bits(b | ONE));
                for ulp in -8..=8 {
                    assert_quotient(x, y, ulp);
                }
            }
        }
    }

    /// The quotients nearest to the middle between two numbers: for every
    /// divisor, the dividend with the smallest distance of 2a·2^k from an odd
    /// multiple of b is found by walking a few candidates around it.
    #[test]
    fn quotients_near_a_tie_are_the_cpus() {
        let mut random = Rng::with_seed(4);
        for _ in 0..200_000 {
            let b = random.u32(IMPLICIT..=2 * IMPLICIT - 1) | 1;
            let q = random.u32(IMPLICIT..=2 * IMPLICIT - 1);
            // a ≈ (q + ½) b / 2^23 or 2^24, whichever has 24 bits.
            let product = (2 * u64::from(q) + 1) * u64::from(b);
            let a = if product >> 24 < u64::from(2 * IMPLICIT) {
                product >> 24
            } else {
                product >> 25
            };
            for near in [a, a + 1] {
                let x = f32::from_bits(near as u32 & MANTISSA | ONE);
                let y = f32::from_bits(b & MANTISSA | ONE);
                for ulp in [-8, 0, 8] {
                    assert_quotient(x, y, ulp);
                }
            }
        }
    }

    #[test]
    fn quotients_of_any_exponents_and_signs_are_the_cpus() {
        let mut random = Rng::with_seed(5);
        let mut normal = 0;
        for _ in 0..4_000_000 {
            let [a, b] = [(); 2].map(|_| f32::from_bits(random.u32(..)));
            if !a.is_normal() || !b.is_normal() {
                continue;
            }
            let expected = a / b;
            let found = divide(a, b, random.u32(0..=16) as i32 - 8);
            if expected.is_normal() && expected.abs() > f32::MIN_POSITIVE {
                normal += 1;
                assert_eq!(found.to_bits(), expected.to_bits(), "{a:e} / {b:e}");
            } else if expected.is_infinite() {
                assert_eq!(found, f32::MAX.copysign(expected));
            } else {
                // Denormal results vanish.
                assert!(
                    found == 0.0 || found.abs() == f32::MIN_POSITIVE,
                    "{a:e} / {b:e}: {found:e}"
                );
            }
        }
        assert!(normal > 2_000_000);
    }

    #[test]
    fn quotients_saturate() {
        assert_eq!(divide(0.0, 3.0, 0), 0.0);
        assert_eq!(divide(0.0, 0.0, 0), 0.0);
        assert_eq!(divide(1.0, 0.0, 0), f32::MAX);
        assert_eq!(divide(-1.0, 0.0, 0), -f32::MAX);
        assert_eq!(divide(1e30, 1e-30, 0), f32::MAX);
        assert_eq!(divide(1e-30, 1e30, 0), 0.0);
    }

    /// Every number of two binades, which is every mantissa with either parity
    /// of the exponent, estimated rightly and as wrongly as allowed.
    #[test]
    fn roots_of_two_binades_are_the_cpus() {
        for bits in ONE..ONE + 2 * IMPLICIT {
            let x = f32::from_bits(bits);
            let expected = x.sqrt().to_bits();
            for ulp in [-8, -3, 0, 1, 8] {
                assert_eq!(
                    root(x, ulp).to_bits(),
                    expected,
                    "√{x:e} from an estimate off by {ulp}"
                );
            }
        }
    }

    #[test]
    fn roots_of_any_exponent_are_the_cpus() {
        let mut random = Rng::with_seed(6);
        for _ in 0..4_000_000 {
            let x = f32::from_bits(random.u32(..) & !SIGN);
            if x.is_normal() {
                let found = root(x, random.u32(0..=16) as i32 - 8);
                assert_eq!(found.to_bits(), x.sqrt().to_bits(), "√{x:e}");
            }
        }
        assert_eq!(root(0.0, 0), 0.0);
        assert_eq!(root(1e-40, 0), 0.0);
    }

    /// The tests above can fail: an estimate off by more than is made good.
    #[test]
    fn worse_estimates_are_not_made_good() {
        assert_ne!(divide(1.5, 1.25, -1000), 1.5 / 1.25);
        assert_ne!(root(1.5, -1000), 1.5f32.sqrt());
    }
}
