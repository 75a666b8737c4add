//! Step control: a ray's parameters (w1, w2, δ) as polynomials of second order in the
//! time, and how long these are exact enough. Time is distance along the ray, object
//! units.

use crate::arithmetic::{abs, div, kept, max, sqrt};
use crate::contract::LARGEST;
use crate::prism::{Prism, State};
use crate::{FAR, Real, Vec3};

/// Margin around the range of weights and δ where a ray enters, so that no ray slips
/// between two prisms.
#[cfg(not(feature = "double"))]
pub(super) const OVERLAP: Real = 2e-5;

/// Margin around the range of weights and δ where a ray enters, so that no ray slips
/// between two prisms.
#[cfg(feature = "double")]
pub(super) const OVERLAP: Real = 1e-10;

/// A ray is at a bound if its weight, or δ for the cap, is within this of 0.
pub(super) const ARRIVED: Real = OVERLAP;

/// Fallback for [`ARRIVED`] if steps do not come nearer to the bound.
pub(super) const THRESHOLD: Real = 1e-3;

/// Maximum number of Newton iterations from one point to the next.
pub(super) const ROUNDS: u32 = 4;

/// Bounds of a prism: 0, 1 and 2 are the sides opposite to those corners; then the cap and
/// the floor.
pub(super) const CAP: u32 = 3;
pub(super) const FLOOR: u32 = 4;
/// No bound.
pub(super) const NONE: u32 = 5;

/// Returns the numerator and the denominator of the smallest h > 0 where c + v h + ½ a h²
/// crosses zero upward, if there is one.
#[inline]
fn crossing(c: Real, v: Real, a: Real) -> (Real, Real) {
    let root = sqrt(v * v - 2.0 * a * c);
    if v > 0.0 {
        (-2.0 * c, v + root)
    } else {
        (root - v, a)
    }
}

/// Returns the quotient of two numbers ≥ 0, or [`FAR`] if it is too large.
#[inline]
fn time((over, under): (Real, Real)) -> Real {
    let under = kept(under);
    if over < under * LARGEST {
        div(over, under)
    } else {
        FAR
    }
}

/// Returns the smallest h > 0 where c + v h + ½ a h² crosses zero upward, for c ≤ 0, or c
/// about 0 and v < 0; [`FAR`] if there is none.
#[inline]
pub(super) fn rise(c: Real, v: Real, a: Real) -> Real {
    if v * v < 2.0 * a * c || (v <= 0.0 && a <= 0.0) {
        return FAR;
    }
    time(crossing(c, v, a))
}

/// Returns the result of [`rise`], or the h of the maximum of c + v h + ½ a h² if that is
/// less than `miss` below zero.
#[inline]
pub(super) fn rise_or_near(c: Real, v: Real, a: Real, miss: Real) -> Real {
    let misses = v * v < 2.0 * a * c;
    if v <= 0.0 && (misses || a <= 0.0) {
        return FAR;
    }
    let h = time(if misses { (v, -a) } else { crossing(c, v, a) });
    if misses && c + 0.5 * v * h <= -miss {
        FAR
    } else {
        h
    }
}

/// Returns the smallest h > 0 where c + v h + ½ a h² crosses zero downward, for c ≥ 0.
#[inline]
pub(super) fn until_without(c: Real, v: Real, a: Real) -> Real {
    rise(-max(c, 0.0), -v, -a)
}

/// Returns component `i` (0…2).
#[inline]
pub(super) fn pick(v: Vec3, i: u32) -> Real {
    if i == 0 {
        v.x
    } else if i == 1 {
        v.y
    } else {
        v.z
    }
}

/// Returns the successor of `i` in the cycle 0, 1, 2.
#[inline]
pub(super) fn next(i: u32) -> u32 {
    if i == 2 { 0 } else { i + 1 }
}

/// Returns the three weights at (w1, w2, δ), whose sum is 1, or their derivatives, whose
/// sum is 0.
#[inline]
pub(super) fn weights(x: Vec3, sum: Real) -> Vec3 {
    Vec3::new(sum - x.x - x.y, x.x, x.y)
}

impl State {
    /// Returns the weight or δ that is positive inside of `bound`, and its derivatives.
    #[inline]
    pub(super) fn within(&self, bound: u32) -> (Real, Real, Real) {
        if bound == CAP {
            (self.x.z, self.velocity.z, self.acceleration.z)
        } else if bound == FLOOR {
            (1.0 - self.x.z, -self.velocity.z, -self.acceleration.z)
        } else {
            (
                pick(weights(self.x, 1.0), bound),
                pick(weights(self.velocity, 0.0), bound),
                pick(weights(self.acceleration, 0.0), bound),
            )
        }
    }

    /// Returns x after the time `h`, to second order.
    #[inline]
    pub(super) fn predicted(&self, h: Real) -> Vec3 {
        self.x + (self.velocity + self.acceleration * (0.5 * h)) * h
    }

    /// Returns the state after the time `h`, to second order.
    #[inline]
    pub(super) fn after(&self, h: Real) -> State {
        State {
            x: self.predicted(h),
            velocity: self.velocity + self.acceleration * h,
            ..*self
        }
    }
}

/// A ray at a point of a prism.
#[derive(Clone, Copy)]
pub(super) struct Traveller {
    pub(super) index: u32,
    /// The ray's origin, relative to the prism's anchor.
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    /// Distance from `origin`, object units.
    pub(super) t: Real,
    pub(super) state: State,
    /// Whether the prism is not folded there.
    pub(super) regular: bool,
    /// Time since the state was exact, object units.
    pub(super) since: Real,
}

impl Traveller {
    /// Returns the ray before its first move, which starts from the parameters `x`.
    #[inline]
    pub(super) fn new(index: u32, origin: Vec3, direction: Vec3, x: Vec3) -> Traveller {
        Traveller {
            index,
            origin,
            direction,
            t: 0.0,
            state: State {
                x,
                velocity: Vec3::ZERO,
                acceleration: Vec3::ZERO,
                third_order: 0.0,
            },
            regular: false,
            since: 0.0,
        }
    }

    /// Moves to `t`, near the parameters `guess`, by Newton's method.
    #[inline]
    pub(super) fn go(&mut self, prism: &Prism, t: Real, guess: Vec3, rounds: u32) {
        let target = self.origin + self.direction * t;
        let (x, jacobian) = prism.solve(target, guess, rounds);
        self.t = t;
        self.state = prism.motion(x, &jacobian, self.direction);
        self.regular = jacobian.regular;
        self.since = 0.0;
    }

    /// Returns whether the second order has an error of at most `tolerance`, object units,
    /// after the time `h`.
    #[inline]
    pub(super) fn may_glide(&self, h: Real, tolerance: Real) -> bool {
        let time = self.since + h;
        abs(self.state.third_order * time * time * time) <= tolerance
    }

    /// Moves by the time `h`, to second order.
    #[inline]
    pub(super) fn glide(&mut self, h: Real) {
        self.t += h;
        self.since += h;
        self.state = self.state.after(h);
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;

    #[test]
    fn times_of_rising_are_roots() {
        // −1 + 2 h + ½ h²
        let h = rise(-1.0, 2.0, 1.0);
        assert!((-1.0 + 2.0 * h + 0.5 * h * h).abs() < 1e-6 && h > 0.0);
        // It falls back before it is up; it never rises; it comes back from below.
        assert_eq!(rise(-1.0, 1.0, -1.0), FAR);
        assert_eq!(rise(-1.0, -1.0, -1.0), FAR);
        assert!((rise(0.0, -1.0, 2.0) - 1.0).abs() < 1e-6);
    }
}
