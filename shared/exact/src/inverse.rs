//! Inverse trigonometric functions.

use crate::basic::{abs, div, max, min, quotient, sqrt};
use crate::bits::{finite, with_sign};
use crate::pair::{two_product, two_sum};

/// π/4, of which the first part has 20 digits: products with 2, 3 and 4 are exact.
const QUARTER_PI: (f32, f32) = (0.785_398_5, -3.198_789_2e-7);

/// Returns the arc sine of x less x, over x³, of `z` = x², |x| ≤ ½.
#[inline]
fn asin_tail(z: f32) -> f32 {
    0.166_666_67
        + z * (0.074_999_92
            + z * (0.044_647_664
                + z * (0.030_269_139
                    + z * (0.023_611_818 + z * (0.010_574_415 + z * 0.030_974_54)))))
}

/// Returns `quarters` · π/4 + `high` + `low`, where |high| ≤ π/4, or `quarters` = 0.
#[inline]
fn turned(quarters: f32, high: f32, low: f32) -> f32 {
    let (sum, rest) = two_sum(quarters * QUARTER_PI.0, high);
    sum + (rest + (low + quarters * QUARTER_PI.1))
}

/// Returns the arc sine of √z as a pair, z ≤ ¼.
#[inline]
fn asin_of_root(z: f32) -> (f32, f32) {
    let root = sqrt(z);
    let (square, square_low) = two_product(root, root);
    let rest = (z - square) - square_low;
    let root_low = div(rest, max(2.0 * root, f32::MIN_POSITIVE));
    (root, root_low + root * z * asin_tail(z))
}

/// Returns the arc sine of `x`, −π/2…π/2 radians. `x` is limited to −1…1.
///
/// ```
/// use relievo_exact::asin;
///
/// assert_eq!((asin(0.5), asin(2.0)), (0.523_598_8, std::f32::consts::FRAC_PI_2));
/// ```
#[inline]
pub fn asin(x: f32) -> f32 {
    let x = finite(x);
    let magnitude = min(abs(x), 1.0);
    let result = if magnitude <= 0.5 {
        magnitude + magnitude * (magnitude * magnitude) * asin_tail(magnitude * magnitude)
    } else {
        let (high, low) = asin_of_root(0.5 * (1.0 - magnitude));
        turned(2.0, -2.0 * high, -2.0 * low)
    };
    with_sign(result, x)
}

/// Returns the arc cosine of `x`, 0…π radians. `x` is limited to −1…1.
///
/// ```
/// use relievo_exact::acos;
///
/// assert_eq!((acos(1.0), acos(-1.0)), (0.0, std::f32::consts::PI));
/// ```
#[inline]
pub fn acos(x: f32) -> f32 {
    let x = finite(x);
    let magnitude = min(abs(x), 1.0);
    if magnitude <= 0.5 {
        let square = magnitude * magnitude;
        let sine = with_sign(1.0, x);
        return turned(
            2.0,
            -sine * magnitude,
            -sine * (magnitude * square * asin_tail(square)),
        );
    }
    let (high, low) = asin_of_root(0.5 * (1.0 - magnitude));
    if x > 0.0 {
        2.0 * high + 2.0 * low
    } else {
        turned(4.0, -2.0 * high, -2.0 * low)
    }
}

/// Returns the arc tangent of `over` / `under` as quarters · π/4 + high + low, for
/// 0 ≤ over ≤ under, 0 < under.
#[inline]
fn atan_of(over: f32, under: f32) -> (f32, f32, f32) {
    /// tan (π/8): from here on π/4 is subtracted.
    const TURN: f32 = 0.414_213_57;
    let ratio = div(over, under);
    // A small quotient is the angle.
    if ratio < 1e-6 {
        return (0.0, ratio, 0.0);
    }
    // The same quotient of moderate numbers.
    let (over, under) = normal_quotient(over, under);
    let is_turned = ratio > TURN;
    let (a, b) = if is_turned {
        (two_sum(over, -under), two_sum(over, under))
    } else {
        ((over, 0.0), (under, 0.0))
    };
    let (u, u_low) = quotient(a, b);
    let z = u * u;
    let tail = -0.333_333_34
        + z * (0.2
            + z * (-0.142_856_12
                + z * (0.111_074_95
                    + z * (-0.090_289_77 + z * (0.071_352_88 + z * -0.040_431_455)))));
    (if is_turned { 1.0 } else { 0.0 }, u, u_low + u * z * tail)
}

/// Scales both numbers so that `under` is in 1…2; `over` / `under` is at least 2⁻²⁰.
#[inline]
fn normal_quotient(over: f32, under: f32) -> (f32, f32) {
    let exponent = under.to_bits() >> 23;
    // In two steps: a factor of 2¹²⁷ or 2⁻¹²⁷ is not a normal number for both.
    let half = exponent >> 1;
    let first = f32::from_bits((190 - half) << 23);
    let second = f32::from_bits((191 - (exponent - half)) << 23);
    (over * first * second, under * first * second)
}

/// Returns the arc tangent of `x`, −π/2…π/2 radians.
///
/// ```
/// use relievo_exact::atan;
///
/// assert_eq!((atan(1.0), atan(-1e30)), (std::f32::consts::FRAC_PI_4, -std::f32::consts::FRAC_PI_2));
/// ```
#[inline]
pub fn atan(x: f32) -> f32 {
    atan2(x, 1.0)
}

/// Returns the angle of the vector (`x`, `y`) from the x axis, −π…π radians; 0 for the
/// zero vector. The sign of a zero is not used: the angle of (−1, ±0) is π.
///
/// ```
/// use relievo_exact::atan2;
///
/// assert_eq!((atan2(1.0, 0.0), atan2(0.0, -1.0)), (std::f32::consts::FRAC_PI_2, std::f32::consts::PI));
/// ```
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (x, y) = (finite(x), finite(y));
    let (width, height) = (abs(x), abs(y));
    if max(width, height) == 0.0 {
        return 0.0;
    }
    let (quarters, high, low) = atan_of(min(width, height), max(width, height));
    // π/2 − angle, π − angle.
    let (quarters, sign) = if height > width {
        (2.0 - quarters, -1.0)
    } else {
        (quarters, 1.0)
    };
    let (quarters, sign) = if x < 0.0 {
        (4.0 - quarters, -sign)
    } else {
        (quarters, sign)
    };
    with_sign(turned(quarters, sign * high, sign * low), y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bits::EXPONENT;

    #[test]
    fn scaled_quotients_are_exact() {
        for exponent in 1..255 {
            let under = f32::from_bits(exponent << 23 | 0x5a_5a5b);
            let (one, more) = normal_quotient(under, under);
            assert!(one == more && (1.0..2.0).contains(&one), "{exponent}");
            assert_eq!(one.to_bits() & !EXPONENT, 0x5a_5a5b);
        }
    }
}
