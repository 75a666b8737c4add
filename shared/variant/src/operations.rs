//! What the rewritten sources call in place of operators and of glam's
//! products: generic over numbers and vectors, in the order of glam's
//! `scalar-math`. Integers are left as they are.

use crate::scalar::{self, Operation, Sum};
use crate::{Site, audit};
use glam::{IVec2, Vec2, Vec3, Vec4};

/// A binary operator: the type of its right operand, and the operation.
pub trait Arithmetic<Right> {
    /// The result.
    type Output;
    /// `self` `operation` `right`.
    fn apply(self, operation: Operation, right: Right, site: Site) -> Self::Output;
}

/// What a product may be summed up with.
pub trait MultiplyAdd<Factor, Term> {
    /// The result.
    type Output;
    /// `self` · `factor`, and `term`.
    fn multiply_add(self, sum: Sum, factor: Factor, term: Term, site: Site) -> Self::Output;
}

impl Arithmetic<f32> for f32 {
    type Output = f32;
    #[inline]
    fn apply(self, operation: Operation, right: f32, site: Site) -> f32 {
        scalar::binary(operation, self, right, site)
    }
}

impl MultiplyAdd<f32, f32> for f32 {
    type Output = f32;
    #[inline]
    fn multiply_add(self, sum: Sum, factor: f32, term: f32, site: Site) -> f32 {
        scalar::multiply_add(sum, self, factor, term, site)
    }
}

/// Integers, as the operators have them.
macro_rules! integer {
    ($($integer:ty),*) => {$(
        impl Arithmetic<$integer> for $integer {
            type Output = $integer;
            #[inline]
            fn apply(self, operation: Operation, right: $integer, _: Site) -> $integer {
                match operation {
                    Operation::Add => self + right,
                    Operation::Subtract => self - right,
                    Operation::Multiply => self * right,
                    Operation::Divide => self / right,
                }
            }
        }

        impl MultiplyAdd<$integer, $integer> for $integer {
            type Output = $integer;
            #[inline]
            fn multiply_add(self, sum: Sum, factor: $integer, term: $integer, _: Site) -> $integer {
                match sum {
                    Sum::Plus => self * factor + term,
                    Sum::Minus => self * factor - term,
                    Sum::From => term - self * factor,
                }
            }
        }
    )*};
}

integer!(u8, u32, i32, u64, i64, usize, IVec2);

/// A vector's operations, a component after the other.
macro_rules! vector {
    ($vector:ident: $($lane:ident),*) => {
        impl Arithmetic<$vector> for $vector {
            type Output = $vector;
            #[inline]
            fn apply(self, operation: Operation, right: $vector, site: Site) -> $vector {
                $vector::new($(scalar::binary(operation, self.$lane, right.$lane, site)),*)
            }
        }

        impl Arithmetic<f32> for $vector {
            type Output = $vector;
            #[inline]
            fn apply(self, operation: Operation, right: f32, site: Site) -> $vector {
                self.apply(operation, $vector::splat(right), site)
            }
        }

        impl Arithmetic<$vector> for f32 {
            type Output = $vector;
            #[inline]
            fn apply(self, operation: Operation, right: $vector, site: Site) -> $vector {
                $vector::splat(self).apply(operation, right, site)
            }
        }

        impl MultiplyAdd<$vector, $vector> for $vector {
            type Output = $vector;
            #[inline]
            fn multiply_add(self, sum: Sum, factor: $vector, term: $vector, site: Site) -> $vector {
                $vector::new($(
                    scalar::multiply_add(sum, self.$lane, factor.$lane, term.$lane, site)
                ),*)
            }
        }

        impl MultiplyAdd<f32, $vector> for $vector {
            type Output = $vector;
            #[inline]
            fn multiply_add(self, sum: Sum, factor: f32, term: $vector, site: Site) -> $vector {
                self.multiply_add(sum, $vector::splat(factor), term, site)
            }
        }

        impl MultiplyAdd<$vector, $vector> for f32 {
            type Output = $vector;
            #[inline]
            fn multiply_add(self, sum: Sum, factor: $vector, term: $vector, site: Site) -> $vector {
                $vector::splat(self).multiply_add(sum, factor, term, site)
            }
        }
    };
}

vector!(Vec2: x, y);
vector!(Vec3: x, y, z);
vector!(Vec4: x, y, z, w);

/// `a + b`.
#[inline]
pub fn add<A: Arithmetic<B>, B>(a: A, b: B, site: Site) -> A::Output {
    a.apply(Operation::Add, b, site)
}

/// `a − b`.
#[inline]
pub fn subtract<A: Arithmetic<B>, B>(a: A, b: B, site: Site) -> A::Output {
    a.apply(Operation::Subtract, b, site)
}

/// `a · b`.
#[inline]
pub fn multiply<A: Arithmetic<B>, B>(a: A, b: B, site: Site) -> A::Output {
    a.apply(Operation::Multiply, b, site)
}

/// `a / b`.
#[inline]
pub fn divide<A: Arithmetic<B>, B>(a: A, b: B, site: Site) -> A::Output {
    a.apply(Operation::Divide, b, site)
}

/// `a · b + c`.
#[inline]
pub fn multiply_add<A: MultiplyAdd<B, C>, B, C>(a: A, b: B, c: C, site: Site) -> A::Output {
    a.multiply_add(Sum::Plus, b, c, site)
}

/// `a · b − c`.
#[inline]
pub fn multiply_subtract<A: MultiplyAdd<B, C>, B, C>(a: A, b: B, c: C, site: Site) -> A::Output {
    a.multiply_add(Sum::Minus, b, c, site)
}

/// `c − a · b`.
#[inline]
pub fn subtract_product<A: MultiplyAdd<B, C>, B, C>(a: A, b: B, c: C, site: Site) -> A::Output {
    a.multiply_add(Sum::From, b, c, site)
}

/// √x.
#[inline]
pub fn sqrt(x: f32, site: Site) -> f32 {
    scalar::sqrt(x, site)
}

/// `a · b + c`, rounded once.
#[inline]
pub fn fused(a: f32, b: f32, c: f32, _: Site) -> f32 {
    a.mul_add(b, c)
}

/// Vectors with a scalar product.
pub trait Dot {
    /// The scalar product.
    fn dot(self, right: Self, site: Site) -> f32;
}

impl Dot for Vec2 {
    #[inline]
    fn dot(self, right: Vec2, site: Site) -> f32 {
        let y = multiply(self.y, right.y, site);
        multiply_add(self.x, right.x, y, site)
    }
}

impl Dot for Vec3 {
    #[inline]
    fn dot(self, right: Vec3, site: Site) -> f32 {
        let xy = dot(self.truncate(), right.truncate(), site);
        multiply_add(self.z, right.z, xy, site)
    }
}

impl Dot for Vec4 {
    #[inline]
    fn dot(self, right: Vec4, site: Site) -> f32 {
        let xyz = dot(self.truncate(), right.truncate(), site);
        multiply_add(self.w, right.w, xyz, site)
    }
}

/// The scalar product.
#[inline]
pub fn dot<V: Dot>(a: V, b: V, site: Site) -> f32 {
    a.dot(b, site)
}

/// The vector product.
#[inline]
pub fn cross(a: Vec3, b: Vec3, site: Site) -> Vec3 {
    let difference = |p, q, r, s| multiply_subtract(p, q, multiply(r, s, site), site);
    Vec3::new(
        difference(a.y, b.z, b.y, a.z),
        difference(a.z, b.x, b.z, a.x),
        difference(a.x, b.y, b.x, a.y),
    )
}

/// The vector product's third component.
#[inline]
pub fn perp_dot(a: Vec2, b: Vec2, site: Site) -> f32 {
    multiply_subtract(a.x, b.y, multiply(a.y, b.x, site), site)
}

/// Calls a function of `arithmetic.rs`, for the audit's sake on behalf of `site`.
#[inline]
pub fn called_at<A, T>(site: Site, arguments: A, function: impl FnOnce(A) -> T) -> T {
    audit::called_at(site, || function(arguments))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mode, with_mode};

    #[test]
    fn products_are_glams_unless_fused() {
        let (mut dots, mut crosses, mut perps) = (0, 0, 0);
        for i in 0..200 {
            let t = i as f32;
            let a = Vec3::new(0.1 + t, 1.7 - t / 3.0, 1.0 / (t + 0.3));
            let b = Vec3::new(t / 7.0 - 3.0, 0.9 * t, 0.3 + t / 9.0);
            let (p, q) = (a.truncate(), b.truncate());
            let all = || {
                (
                    dot(a, b, "here"),
                    dot(p, q, "here"),
                    cross(a, b, "here"),
                    perp_dot(p, q, "here"),
                )
            };
            let glams = (a.dot(b), p.dot(q), a.cross(b), p.perp_dot(q));
            assert_eq!(all(), glams);
            let fused = with_mode(Mode::Fused, all);
            dots += usize::from(fused.0 != glams.0 && fused.1 != glams.1);
            crosses += usize::from(fused.2 != glams.2);
            perps += usize::from(fused.3 != glams.3);
        }
        assert!(
            dots > 5 && crosses > 50 && perps > 20,
            "{dots} {crosses} {perps}"
        );
    }

    #[test]
    fn vectors_and_integers_as_the_operators_have_them() {
        let (v, w) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(7.0, -0.7, 1.1));
        assert_eq!(add(v, w, "here"), v + w);
        assert_eq!(multiply(v, 0.7, "here"), v * 0.7);
        assert_eq!(multiply(0.7, v, "here"), 0.7 * v);
        assert_eq!(divide(v, 0.7, "here"), v / 0.7);
        assert_eq!(multiply_add(v, 0.7, w, "here"), v * 0.7 + w);
        assert_eq!(multiply_subtract(v, w, v, "here"), v * w - v);
        assert_eq!(subtract_product(0.7, v, w, "here"), w - 0.7 * v);
        assert_eq!(subtract(7_i32, 9, "here"), -2);
        assert_eq!(divide(7_u32, 2, "here"), 3);
        assert_eq!(multiply_add(2_i32, 3, 4, "here"), 10);
        assert_eq!(subtract_product(2_usize, 3, 10, "here"), 4);
    }
}
