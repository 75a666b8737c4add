//! The functions of `relievo-exact` in f64, for the f64 twin.

use glam::DVec3;

/// Returns `a / b`.
#[inline]
pub fn div(a: f64, b: f64) -> f64 {
    a / b
}

/// Returns the square root of `x`; 0 for a negative `x`.
#[inline]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(max(x, 0.0))
}

/// Returns the smaller of two numbers that are not NaN.
#[inline]
pub fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the larger of two numbers that are not NaN.
#[inline]
pub fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns `x` limited to `low..=high`; `low` for NaN.
#[inline]
pub fn clamp(x: f64, low: f64, high: f64) -> f64 {
    let x = if x > low { x } else { low };
    min(x, high)
}

/// Returns the absolute value of `x`.
#[inline]
pub fn abs(x: f64) -> f64 {
    if x < 0.0 { -x } else { x }
}

/// Returns `v` scaled to length 1, or `fallback` if `v` is too short.
#[inline]
pub fn normalize_or(v: DVec3, fallback: DVec3) -> DVec3 {
    let squared = v.dot(v);
    if squared > 1e-30 {
        v * div(1.0, sqrt(squared))
    } else {
        fallback
    }
}
