//! Entry: where a ray comes into the shell through one prism.

use super::field::{Field, PrismList};
use super::step::{
    ARRIVED, CAP, NONE, OVERLAP, ROUNDS, THRESHOLD, Traveller, rise_or_near, until_without, weights,
};
use crate::arithmetic::{abs, div, max, min};
use crate::layout::{NO_NEIGHBOUR, PrismData, Slab, vec3};
use crate::prism::{Prism, State, is_open};
use crate::shape_map::Texels;
use crate::{FAR, Real, Vec3};

/// Error of a position, relative to its distance from the eye.
#[cfg(not(feature = "double"))]
const ROUNDING: Real = 1e-6;

/// Error of a position, relative to its distance from the eye.
#[cfg(feature = "double")]
const ROUNDING: Real = 1e-14;

/// Maximum distance outside the triangle, in weights, at which a ray may still enter
/// because it is not exactly at the opening.
const FURTHEST: Real = 0.01;

/// Number of attempts to reach an opening, after which [`THRESHOLD`] decides.
const TRIES: u32 = 6;

/// Maximum number of Newton iterations where the ray comes into the hull.
const FIRST_ROUNDS: u32 = 12;

/// Maximum number of steps until the ray comes in.
const OUTSIDE_STEPS: u32 = 32;

/// Error of the bend, relative to it, before a ray counts as passing by.
const BEND_DOUBT: Real = 0.25;

/// Error of the second order from end to end of a prism: in weights or δ, and relative
/// to the bend.
const DOUBT: Real = 0.05;

/// Maximum number of restarts of a search for an entrance that gets lost.
const RESTARTS: u32 = 6;

const THIRD: Real = 1.0 / 3.0;

/// Returns the smallest h > 0 where c + v h + ½ a h² crosses zero upward; [`FAR`] if it
/// clearly does not within `rest`.
///
/// Since terms of third order are missing, a near miss counts: then the result is the h
/// of its maximum.
#[inline]
fn until_opened(c: Real, v: Real, a: Real, rest: Real) -> Real {
    if c > 0.0 && v > 0.0 {
        return FAR;
    }
    rise_or_near(c, v, a, DOUBT * (1.0 + abs(a) * rest * rest))
}

/// Returns the opening after `opening`: the cap comes first, then the open sides, then
/// [`NONE`].
#[inline]
fn next_opening(neighbours: [u32; 3], opening: u32) -> u32 {
    let [first, second, third] = neighbours;
    if opening == CAP && first == NO_NEIGHBOUR {
        0
    } else if (opening == CAP || opening == 0) && second == NO_NEIGHBOUR {
        1
    } else if opening != 2 && third == NO_NEIGHBOUR {
        2
    } else {
        NONE
    }
}

impl State {
    /// Returns the distance from the nearest of the sides, the cap and the floor, in weights
    /// or δ; negative outside.
    #[inline]
    fn inset(&self) -> Real {
        let w = weights(self.x, 1.0);
        min(min(min(w.x, w.y), w.z), min(self.x.z, 1.0 - self.x.z))
    }

    /// Returns whether the ray enters the prism here through `opening`, with a margin of
    /// `overlap` in weights.
    #[inline]
    fn comes_in(&self, opening: u32, overlap: Real) -> bool {
        let (c, v, a) = self.within(opening);
        // On the way out, or to a maximum before the opening.
        if v <= 0.0 || (c < 0.0 && v * v < 2.0 * a * c) {
            return false;
        }
        // The opening is reached this much earlier or later.
        let early = abs(div(c, v));
        let w = weights(self.x, 1.0);
        let change = weights(self.velocity, 0.0);
        let slack = |w: Real, change: Real| w >= -overlap - min(abs(change) * early, FURTHEST);
        (opening == 0 || slack(w.x, change.x))
            && (opening == 1 || slack(w.y, change.y))
            && (opening == 2 || slack(w.z, change.z))
            && (opening == CAP || slack(self.x.z, self.velocity.z))
            && self.x.z < 1.0
    }

    /// Returns the time until the next opening is reached, and the opening; [`FAR`] if
    /// none is reached within `rest`. `passed` is the opening where the ray is.
    #[inline]
    fn first_opening(&self, neighbours: [u32; 3], passed: u32, rest: Real) -> (Real, u32) {
        let mut best = (FAR, NONE);
        let mut opening = CAP;
        while opening != NONE {
            best = self.earlier(opening, passed, rest, best);
            opening = next_opening(neighbours, opening);
        }
        best
    }

    /// Returns `best`, or `opening` if that is reached earlier.
    #[inline]
    fn earlier(&self, opening: u32, passed: u32, rest: Real, best: (Real, u32)) -> (Real, u32) {
        let (c, v, a) = self.within(opening);
        if passed == opening && v > 0.0 {
            return best;
        }
        let time = until_opened(c, v, a, rest);
        if time < best.0 { (time, opening) } else { best }
    }

    /// Returns whether the ray is clearly beside the triangle after the time `h`.
    #[inline]
    fn passes_by(&self, h: Real, inverse_altitude: Real) -> bool {
        let w = weights(self.predicted(h), 1.0);
        let a = weights(self.acceleration, 0.0);
        let third_order = self.third_order * inverse_altitude * h;
        let doubt = |a: Real| DOUBT + (BEND_DOUBT * abs(a) + third_order) * h * h;
        w.x < -doubt(a.x) || w.y < -doubt(a.y) || w.z < -doubt(a.z)
    }
}

/// Clips `range` to where the ray from `origin` is in the slab.
#[inline]
fn clip(range: (Real, Real), slab: &Slab, origin: Vec3, direction: Vec3) -> (Real, Real) {
    let axis = vec3(slab.axis);
    let at = origin.dot(axis);
    let speed = direction.dot(axis);
    if abs(speed) * FAR <= slab.high - slab.low {
        // Parallel to the slab: in it for ever, or never. A slab of zeros, which a device may
        // read for pixels that it does not draw, is missed.
        return if at > slab.low && at < slab.high {
            range
        } else {
            (1.0, 0.0)
        };
    }
    let slowness = div(1.0, speed);
    let to_low = (slab.low - at) * slowness;
    let to_high = (slab.high - at) * slowness;
    (
        max(range.0, min(to_low, to_high)),
        min(range.1, max(to_low, to_high)),
    )
}

/// Returns the distance at which the ray from `origin`, relative to the anchor of `data`,
/// enters the hull, and the length of its interval in the hull, ≤ 0 if it misses it.
#[inline]
pub(super) fn hull_of(data: &PrismData, origin: Vec3, direction: Vec3) -> (Real, Real) {
    let mut range = (0.0, FAR);
    range = clip(range, &data.slabs[0], origin, direction);
    range = clip(range, &data.slabs[1], origin, direction);
    range = clip(range, &data.slabs[2], origin, direction);
    range = clip(range, &data.slabs[3], origin, direction);
    (range.0, range.1 - range.0)
}

/// Estimates (w1, w2, δ) at `point` on the cap, relative to the anchor of `data`: the slabs
/// along the sides are as wide as the weights.
#[inline]
fn rough_parameters(data: &PrismData, point: Vec3) -> Vec3 {
    let share = |slab: &Slab| {
        let share = point.dot(vec3(slab.axis)) - slab.low;
        min(max(share, 0.0), 1.0)
    };
    Vec3::new(share(&data.slabs[2]), share(&data.slabs[3]), 0.0)
}

/// Where a search for the entrance starts.
#[derive(Clone, Copy)]
pub(super) struct Start {
    /// The time since the ray has entered the hull.
    pub(super) t: Real,
    /// Distance from where the search before got lost; 0 if there was none.
    step: Real,
    /// Whether the search before knew its place in the prism, or had gone too far.
    is_known: bool,
}

impl Start {
    /// Starts at the time `t`.
    #[inline]
    pub(super) fn new(t: Real) -> Start {
        Start {
            t,
            step: 0.0,
            is_known: false,
        }
    }
}

/// Result of [`Field::seek`].
pub(super) struct Entrance {
    /// The ray where it enters.
    pub(super) at: Traveller,
    /// Offset of its times: distance from the eye, object units.
    pub(super) enter: Real,
    /// Whether the ray enters.
    pub(super) found: bool,
    /// Whether the ray starts in the shell.
    pub(super) in_shell: bool,
    /// Whether the search got lost, and may start again.
    pub(super) lost: bool,
    /// The new start, if so.
    pub(super) again: Start,
}

/// The opening that a search for the entrance heads for.
struct Aim {
    /// A side, the cap, or [`NONE`].
    opening: u32,
    /// Attempts to reach it so far.
    tries: u32,
}

impl Aim {
    /// Whether the opening is reached, where the ray is inside of it by `c`.
    #[inline]
    fn is_reached(&self, c: Real) -> bool {
        let near = if self.tries < TRIES {
            ARRIVED
        } else {
            THRESHOLD
        };
        self.opening != NONE && abs(c) <= near
    }

    /// Whether to make one more attempt to reach the opening.
    #[inline]
    fn may_try_again(&self) -> bool {
        self.opening != NONE && self.tries < TRIES
    }

    /// Counts one more attempt; returns the time until c + v h + ½ a h² reaches 0:
    /// < 0 if the opening was passed, [`FAR`] if it is never reached.
    #[inline]
    fn try_again(&mut self, (c, v, a): (Real, Real, Real), rest: Real) -> Real {
        self.tries += 1;
        if c > 0.0 {
            -until_without(c, -v, a)
        } else {
            until_opened(c, v, a, rest)
        }
    }
}

impl<S: PrismList + ?Sized, T: Texels + ?Sized> Field<'_, S, T> {
    /// Finds where `ray` enters from outside, or whether it starts in the shell, if
    /// `may_hold_eye`. `hull` is the result of [`hull_of`]. After [`RESTARTS`]
    /// restarts, the search goes on where it gets lost.
    ///
    /// Every turn of the loop moves the ray with Newton's method to where the turn
    /// before aimed: to the eye first, if the shell may hold it, then to one
    /// opening after the other.
    #[inline]
    pub(super) fn seek(
        &self,
        ray: Traveller,
        data: &PrismData,
        hull: (Real, Real),
        may_hold_eye: bool,
        start: Start,
        restarts: u32,
    ) -> Entrance {
        let mut at = ray;
        let prism = Prism::new(data, self.object.depth);
        let (enter, span) = hull;
        let distance = abs(at.origin.x) + abs(at.origin.y) + abs(at.origin.z);
        let overlap = OVERLAP + ROUNDING * distance * data.inverse_altitude;
        // Steps this short make no progress.
        let shortest = span * OVERLAP;
        let hull_origin = ray.origin + ray.direction * enter;
        let hull_guess = rough_parameters(data, hull_origin + ray.direction * start.t);

        // Where the next turn moves to.
        let mut t = 0.0;
        let mut guess = Vec3::new(THIRD, THIRD, 0.5);
        let mut rounds = FIRST_ROUNDS;
        let mut offset = 0.0;
        if !may_hold_eye {
            offset = enter;
            guess = hull_guess;
            t = start.t;
        }
        let is_restart = start.step > 0.0;
        let mut aim = Aim {
            opening: if is_restart { CAP } else { NONE },
            tries: TRIES,
        };
        let mut turns = 0;
        // The last step, and whether it started from a known place.
        let mut step = start.step;
        let mut is_known = start.is_known;
        let mut end = if may_hold_eye { AT_EYE } else { SEEKING };
        // From far away Newton's method misses the prism: start nearer. After a step
        // that was too long go back.
        let mut nearer = 0.0;
        while end <= AT_EYE {
            at.origin = ray.origin + ray.direction * offset;
            at.go(&prism, t, guess, rounds);
            if end == AT_EYE {
                let in_shell = at.regular && at.state.inset() >= -OVERLAP;
                end = if in_shell {
                    IN_SHELL
                } else if shortest <= 0.0 {
                    NOWHERE
                } else {
                    SEEKING
                };
                if end == SEEKING {
                    offset = enter;
                    guess = hull_guess;
                }
            } else {
                rounds = ROUNDS;
                turns += 1;
                let rest = span - at.t;
                let within = at.state.within(aim.opening);
                let arrived = at.regular && aim.is_reached(within.0);
                let mut h = FAR;
                if arrived {
                    if at.state.comes_in(aim.opening, overlap) {
                        end = FOUND;
                    }
                } else if aim.may_try_again() {
                    h = aim.try_again(within, rest);
                }
                let is_astray = h >= FAR || at.t + h < -shortest;
                let overshot = !arrived
                    && step > 0.0
                    && ((is_known && !at.regular) || (is_astray && within.0 > 0.0));
                if is_astray {
                    let passed = if arrived { aim.opening } else { NONE };
                    let (time, opening) = at.state.first_opening(data.neighbours, passed, rest);
                    h = time;
                    aim = Aim { opening, tries: 0 };
                }
                // Through an open side the ray may come in before: only if all else fails.
                let is_closed = !is_open(data);
                let mut lost = (overshot || !at.regular) && (is_closed || !is_known);
                if is_astray && is_closed && (h >= FAR || at.state.predicted(h).z < -DOUBT) {
                    // Only as far as the second order says so: its error grows with the
                    // cube of the way. Where it fails within a quarter, start nearer.
                    let scale = max(data.inverse_altitude, abs(at.state.velocity.z));
                    let error = at.state.third_order * scale * rest * rest * rest;
                    lost = lost || error > 64.0 * DOUBT;
                    if h >= FAR && error > DOUBT {
                        let share = if error > 8.0 * DOUBT { 0.25 } else { 0.5 };
                        h = max(share * rest, shortest);
                    }
                }
                // The ray cannot enter beyond the end of the hull. A prediction there
                // may be wrong, so the step is limited to that end.
                let h_inside = min(h, rest);
                if end == SEEKING && lost && restarts < RESTARTS {
                    end = LOST;
                    nearer = if overshot { -0.5 * step } else { 0.5 * rest };
                    is_known = at.regular || overshot;
                } else if end == SEEKING
                    && (!at.regular
                        || turns > OUTSIDE_STEPS
                        || h >= FAR
                        || (h > rest && rest <= shortest)
                        || (aim.opening == CAP
                            && is_closed
                            && at.state.passes_by(h_inside, data.inverse_altitude)))
                {
                    end = NOWHERE;
                }
                let tolerance = self.tolerance * (enter + at.t);
                if end == SEEKING && aim.opening != NONE && h <= rest && at.may_glide(h, tolerance)
                {
                    // The second order is exact enough at the opening: no more
                    // iterations. Its error may move the ray by one tolerance.
                    let mut there = at;
                    there.glide(h);
                    let (c, _, _) = there.state.within(aim.opening);
                    let overlap = overlap + tolerance * data.inverse_altitude;
                    if abs(c) <= ARRIVED && there.state.comes_in(aim.opening, overlap) {
                        at = there;
                        end = FOUND;
                    } else if is_closed && abs(c) <= ARRIVED {
                        // Nothing follows from a near miss.
                        end = NOWHERE;
                    }
                }
                if end == SEEKING {
                    let h = if abs(h_inside) < shortest {
                        shortest
                    } else {
                        h_inside
                    };
                    t = at.t + h;
                    guess = at.state.predicted(h);
                    step = abs(h);
                    is_known = true;
                }
            }
        }
        at.origin = ray.origin + ray.direction * offset;
        Entrance {
            enter: if end == IN_SHELL { 0.0 } else { enter },
            found: at.regular && (end == FOUND || end == IN_SHELL),
            in_shell: end == IN_SHELL,
            lost: end == LOST,
            again: Start {
                t: at.t + nearer,
                step: abs(nearer),
                is_known,
            },
            at,
        }
    }
}

/// The search goes on.
const SEEKING: u32 = 0;
/// It goes on, and looks at the eye first.
const AT_EYE: u32 = 1;
/// The ray enters.
const FOUND: u32 = 2;
/// The ray starts in the shell.
const IN_SHELL: u32 = 3;
/// Newton's method missed the prism, and may start from another place.
const LOST: u32 = 4;
/// The ray does not enter.
const NOWHERE: u32 = 5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_miss_of_an_opening_is_aimed_at_and_a_clear_one_is_not() {
        // Up through 0 at h = 1.
        assert_eq!(until_opened(-1.0, 1.0, 0.0, 10.0), 1.0);
        // On the way out.
        assert_eq!(until_opened(1.0, 1.0, 0.0, 10.0), FAR);
        // The highest point is 0.02 or 2 below 0.
        assert_eq!(until_opened(-0.52, 1.0, -1.0, 1.0), 1.0);
        assert_eq!(until_opened(-2.5, 1.0, -1.0, 1.0), FAR);
    }
}
