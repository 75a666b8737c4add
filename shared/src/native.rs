//! The target's own division and square root, which no other file may contain.

use crate::Real;

/// The target's own division.
#[inline]
pub(crate) fn native_div(a: Real, b: Real) -> Real {
    a / b
}

/// The target's own square root.
#[inline]
pub(crate) fn native_sqrt(x: Real) -> Real {
    #[cfg(not(feature = "double"))]
    let root = libm::sqrtf(x);
    #[cfg(feature = "double")]
    let root = libm::sqrt(x);
    root
}
