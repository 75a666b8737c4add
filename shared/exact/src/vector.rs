//! Lengths of vectors. Sums, products, `dot`, `cross` and products with matrices are
//! exact as glam has them.

use crate::basic::{abs, div, max, sqrt};
use crate::bits::finite;
use glam::{Vec2, Vec3, Vec4};

/// A vector of f32.
pub trait Vector: Copy {
    /// Returns the dot product of `self` and `other`.
    fn inner(self, other: Self) -> f32;
    /// Returns `self` · `factor`.
    fn times(self, factor: f32) -> Self;
    /// Returns `self` − `other`.
    fn minus(self, other: Self) -> Self;
    /// Returns [`finite`] of each component.
    fn finite(self) -> Self;
    /// Returns the largest magnitude of a component.
    fn largest(self) -> f32;
}

impl Vector for Vec2 {
    #[inline]
    fn inner(self, other: Vec2) -> f32 {
        self.dot(other)
    }

    #[inline]
    fn times(self, factor: f32) -> Vec2 {
        self * factor
    }

    #[inline]
    fn minus(self, other: Vec2) -> Vec2 {
        self - other
    }

    #[inline]
    fn finite(self) -> Vec2 {
        Vec2::new(finite(self.x), finite(self.y))
    }

    #[inline]
    fn largest(self) -> f32 {
        max(abs(self.x), abs(self.y))
    }
}

impl Vector for Vec3 {
    #[inline]
    fn inner(self, other: Vec3) -> f32 {
        self.dot(other)
    }

    #[inline]
    fn times(self, factor: f32) -> Vec3 {
        self * factor
    }

    #[inline]
    fn minus(self, other: Vec3) -> Vec3 {
        self - other
    }

    #[inline]
    fn finite(self) -> Vec3 {
        Vec3::new(finite(self.x), finite(self.y), finite(self.z))
    }

    #[inline]
    fn largest(self) -> f32 {
        max(max(abs(self.x), abs(self.y)), abs(self.z))
    }
}

impl Vector for Vec4 {
    #[inline]
    fn inner(self, other: Vec4) -> f32 {
        self.dot(other)
    }

    #[inline]
    fn times(self, factor: f32) -> Vec4 {
        self * factor
    }

    #[inline]
    fn minus(self, other: Vec4) -> Vec4 {
        self - other
    }

    #[inline]
    fn finite(self) -> Vec4 {
        Vec4::new(
            finite(self.x),
            finite(self.y),
            finite(self.z),
            finite(self.w),
        )
    }

    #[inline]
    fn largest(self) -> f32 {
        max(max(max(abs(self.x), abs(self.y)), abs(self.z)), abs(self.w))
    }
}

/// Returns the length of `v`.
///
/// ```
/// use glam::Vec3;
/// use relievo_exact::length;
///
/// assert_eq!(length(Vec3::new(2.0, 3.0, 6.0)), 7.0);
/// assert_eq!(length(Vec3::new(3e-30, 0.0, 4e-30)), 5e-30);
/// ```
#[inline]
pub fn length<V: Vector>(v: V) -> f32 {
    const UP: f32 = 1.267_650_6e30; // 2¹⁰⁰
    const DOWN: f32 = 7.888_609e-31; // 2⁻¹⁰⁰
    const SMALL: f32 = 9.094_947e-13; // 2⁻⁴⁰
    const LARGE: f32 = 1.152_921_5e18; // 2⁶⁰
    let v = v.finite();
    let largest = v.largest();
    // Else squares that are denormal or too large would decide the sum's last digits.
    let (scale, back) = if largest < SMALL {
        (UP, DOWN)
    } else if largest > LARGE {
        (DOWN, UP)
    } else {
        (1.0, 1.0)
    };
    let scaled = v.times(scale);
    finite(sqrt(scaled.inner(scaled)) * back)
}

/// Returns the length of `b` − `a`, as [`length`] does.
///
/// ```
/// use glam::Vec2;
/// use relievo_exact::distance;
///
/// assert_eq!(distance(Vec2::new(1.0, 1.0), Vec2::new(4.0, 5.0)), 5.0);
/// ```
#[inline]
pub fn distance<V: Vector>(a: V, b: V) -> f32 {
    length(b.minus(a))
}

/// Returns `v` scaled to length 1, or `fallback` if `v` is too short: if the square of its
/// length is at most 10⁻³⁰. Smaller squares lose digits to underflow. Components are at most
/// 10¹⁸ in magnitude.
///
/// ```
/// use glam::Vec3;
/// use relievo_exact::normalize_or;
///
/// assert_eq!(normalize_or(Vec3::new(0.0, 0.0, 3.0), Vec3::X), Vec3::Z);
/// assert_eq!(normalize_or(Vec3::ZERO, Vec3::X), Vec3::X);
/// ```
#[inline]
pub fn normalize_or<V: Vector>(v: V, fallback: V) -> V {
    let squared = v.inner(v);
    if squared > 1e-30 {
        v.times(div(1.0, sqrt(squared)))
    } else {
        fallback
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_keep_their_digits_at_any_size() {
        let v = Vec4::new(1.0, -1e-3, 0.25, 3.0);
        let at_one = length(v);
        for exponent in [-115, -90, -60, -41, -40, -39, 0, 39, 40, 41, 60, 100, 124] {
            let scale = crate::bits::scaled(1.0, exponent);
            assert_eq!(length(v * scale), at_one * scale, "2^{exponent}");
        }
        assert_eq!(length(Vec2::new(1e-40, 0.0)), 0.0);
        assert_eq!(length(Vec3::splat(f32::MAX)), f32::MAX);
    }

    #[test]
    fn squares_that_are_denormal_change_nothing() {
        // Of such a distance, devices that flush them once gave 7 ULP less.
        let a = Vec3::new(3.4268045e-17, -9.081522e-19, 5.874983e-18);
        let b = Vec3::new(8.673618e-19, -8.673618e-19, -8.673618e-19);
        let parts = [b.x - a.x, b.y - a.y, b.z - a.z].map(f64::from);
        let exact = parts.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error = (f64::from(distance(a, b)) - exact) / exact;
        assert!(error.abs() < 1e-7, "{error}");
    }
}
