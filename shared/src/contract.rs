//! The value contract: within it, no device can flush, saturate or lose what
//! another keeps.
//!
//! What the host puts into layouts is 0 or of a magnitude in 2⁻⁶⁰…2⁶⁰, and so
//! is what one stage hands to the next; sums of products of two such numbers
//! are 0 or of a magnitude from 2⁻¹²⁰ on, and normal. Nothing is an infinity
//! or a NaN, and nobody looks at the sign of zero. Debug builds check it where
//! a value passes from stage to stage; the tests check every single operation.

use crate::arithmetic::abs;
use crate::{Real, Vec2, Vec3};

/// The smallest magnitude of a sum of products: 2⁻¹²⁰.
pub const SMALLEST_PRODUCT: Real = 7.523_164e-37;
/// The largest magnitude: 2⁶⁰.
pub const LARGEST: Real = 1.152_921_5e18;

/// Whether `x` keeps the contract.
#[inline]
pub fn holds(x: Real) -> bool {
    x == 0.0 || (abs(x) >= SMALLEST_PRODUCT && abs(x) <= LARGEST)
}

/// Panics in debug builds where `x` breaks the contract.
#[cfg(all(debug_assertions, not(target_arch = "spirv")))]
#[track_caller]
pub fn check(x: Real) {
    if !holds(x) {
        panic!("{x:e} breaks the value contract");
    }
}

/// Panics in debug builds where `x` breaks the contract.
#[cfg(not(all(debug_assertions, not(target_arch = "spirv"))))]
#[inline]
pub fn check(_: Real) {}

/// [`check`] for both components.
#[inline]
#[cfg_attr(not(target_arch = "spirv"), track_caller)]
pub fn check2(v: Vec2) {
    check(v.x);
    check(v.y);
}

/// [`check`] for all components.
#[inline]
#[cfg_attr(not(target_arch = "spirv"), track_caller)]
pub fn check3(v: Vec3) {
    check(v.x);
    check(v.y);
    check(v.z);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contract_is_zero_or_a_moderate_magnitude() {
        for kept in [0.0, -0.0, 1.0, -1e18, 1e-36] {
            assert!(holds(kept), "{kept:e}");
        }
        for broken in [
            Real::NAN,
            Real::INFINITY,
            -1e19,
            1e-37,
            Real::MIN_POSITIVE / 2.0,
        ] {
            assert!(!holds(broken), "{broken:e}");
        }
    }

    #[test]
    #[should_panic(expected = "value contract")]
    fn debug_builds_check_it() {
        // Tests are debug builds.
        check3(Vec3::new(0.0, 1.0, 1e-40));
    }
}
