//! The target's own division and square root, which no other file may contain.

/// Returns the target's own quotient.
#[inline]
pub(crate) fn native_div(a: f32, b: f32) -> f32 {
    a / b
}

/// Returns the target's own square root.
#[inline]
pub(crate) fn native_sqrt(x: f32) -> f32 {
    libm::sqrtf(x)
}
