//! The target's own division, square root and fused sum, which no other file may contain.

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

/// Returns `a b + c`, rounded once on devices that fuse.
#[cfg(any(all(feature = "fused", target_arch = "spirv"), test))]
#[inline]
pub(crate) fn native_fma(a: f32, b: f32, c: f32) -> f32 {
    libm::fmaf(a, b, c)
}
