//! Lengths of vectors. Sums, products, `dot`, `cross` and products with matrices are
//! exact as glam has them.

use crate::basic::{div, sqrt};
use glam::{Vec2, Vec3, Vec4};

/// A vector of f32.
pub trait Vector: Copy {
    /// Returns the dot product of `self` and `other`.
    fn inner(self, other: Self) -> f32;
    /// Returns `self` · `factor`.
    fn times(self, factor: f32) -> Self;
    /// Returns `self` − `other`.
    fn minus(self, other: Self) -> Self;
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
}

/// Returns the length of `v`. Components of magnitudes in 10⁻¹⁸…10¹⁸, or 0, have squares
/// that are normal numbers.
///
/// ```
/// use glam::Vec3;
/// use relievo_exact::length;
///
/// assert_eq!(length(Vec3::new(2.0, 3.0, 6.0)), 7.0);
/// ```
#[inline]
pub fn length<V: Vector>(v: V) -> f32 {
    sqrt(v.inner(v))
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
/// length is at most 10⁻³⁰. Smaller squares lose digits to underflow.
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
