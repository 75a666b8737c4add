//! The value contract: a range of numbers that no device flushes or saturates.
//!
//! Numbers in layouts, and numbers that one stage passes to the next, are 0 or have
//! a magnitude in 2⁻⁶⁰…2⁶⁰. Sums of products of two such numbers are 0 or have a
//! magnitude of at least 2⁻¹²⁰, which is a normal number. There are no infinities
//! and no NaN, and the sign of zero is never used. Debug builds check values between
//! stages; `tests/variants.rs` checks every operation.
//!
//! ```
//! use relievo_shared::contract::holds;
//!
//! assert!(holds(0.0) && holds(-1e18) && !holds(1e-40) && !holds(f32::NAN));
//! ```

use crate::arithmetic::abs;
use crate::{Real, Vec2, Vec3};

/// Smallest magnitude of a sum of products: 2⁻¹²⁰.
pub const SMALLEST_PRODUCT: Real = 7.523_164e-37;
/// Largest magnitude: 2⁶⁰.
pub const LARGEST: Real = 1.152_921_5e18;

/// Returns whether `x` keeps the contract.
#[inline]
pub fn holds(x: Real) -> bool {
    x == 0.0 || (abs(x) >= SMALLEST_PRODUCT && abs(x) <= LARGEST)
}

/// Panics in debug builds if `x` breaks the contract.
#[cfg(all(debug_assertions, not(target_arch = "spirv")))]
#[track_caller]
pub fn check(x: Real) {
    if !holds(x) {
        panic!("{x:e} breaks the value contract");
    }
}

/// Panics in debug builds if `x` breaks the contract.
#[cfg(not(all(debug_assertions, not(target_arch = "spirv"))))]
#[inline]
pub fn check(_: Real) {}

/// Applies [`check`] to both components.
#[inline]
#[cfg_attr(not(target_arch = "spirv"), track_caller)]
pub fn check2(v: Vec2) {
    check(v.x);
    check(v.y);
}

/// Applies [`check`] to all components.
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
