//! Traversal: from prism to prism through the pattern, to the first hit.

use super::field::{Field, Found, PrismList};
use super::step::{
    ARRIVED, CAP, FLOOR, NONE, OVERLAP, ROUNDS, THRESHOLD, Traveller, next, pick, until_without,
    weights,
};
use crate::arithmetic::{div, kept, kept3, max, min};
use crate::layout::{NO_NEIGHBOUR, PrismData, vec2, vec3};
use crate::march::{END_CAP, END_MISS, END_SIDE, Limits, March, Stop, advance, refine};
use crate::path::Path;
use crate::prism::{Prism, State};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::{Real, Vec2, Vec3};

/// Maximum number of pieces of a ray, beside one for each step.
const PIECES: u32 = 4096;

/// Factor by which a piece is shortened whose error is too large.
const SHORTER: Real = 0.7;

/// A ray that comes to the cap from below has left the shell if δ is less than this.
const LEFT: Real = 1e-4;

/// Returns the neighbour across side `side`.
#[inline]
fn link_of(neighbours: [u32; 3], side: u32) -> u32 {
    let [first, second, third] = neighbours;
    if side == 0 {
        first
    } else if side == 1 {
        second
    } else {
        third
    }
}

/// Converts parameters `x` at side `side` of a prism to those of the neighbour, whose
/// own side `other` it is: exact on the side, an estimate beyond it.
#[inline]
fn across(x: Vec3, side: u32, other: u32) -> Vec3 {
    let w = weights(x, 1.0);
    let out = pick(w, side);
    // As if the two were halves of a parallelogram. Their common edge has opposite
    // directions in them.
    let before = pick(w, next(side)) + out;
    let after = pick(w, next(next(side))) + out;
    let (first, second) = if other == 0 {
        (after, before)
    } else if other == 1 {
        (-out, after)
    } else {
        (before, -out)
    };
    Vec3::new(first, second, x.z)
}

impl State {
    /// Returns the bound, other than `but`, that `x` violates most, or [`NONE`].
    #[inline]
    fn most_violated(&self, x: Vec3, but: u32) -> u32 {
        let w = weights(x, 1.0);
        let mut least = -OVERLAP;
        let mut bound = NONE;
        if w.x < least && but != 0 {
            least = w.x;
            bound = 0;
        }
        if w.y < least && but != 1 {
            least = w.y;
            bound = 1;
        }
        if w.z < least && but != 2 {
            least = w.z;
            bound = 2;
        }
        if x.z < least && but != CAP {
            least = x.z;
            bound = CAP;
        }
        if 1.0 - x.z < least {
            bound = FLOOR;
        }
        bound
    }

    /// Returns the time until the prism is left, but not through `but`, and the bound; or
    /// `time` and [`NONE`] if that is earlier.
    #[inline]
    fn until_outside(&self, time: Real, but: u32) -> (Real, u32) {
        let mut h = time;
        let mut bound = NONE;
        // Not past the deepest point if that lies below the floor.
        if self.velocity.z > 0.0 && self.velocity.z + self.acceleration.z * h < 0.0 {
            let deepest = div(-self.velocity.z, self.acceleration.z);
            if self.x.z + 0.5 * self.velocity.z * deepest > 1.0 {
                h = deepest;
            }
        }
        let mut rest = 5;
        while rest > 0 {
            let violated = self.most_violated(self.predicted(h), but);
            rest -= 1;
            if violated == NONE {
                rest = 0;
            } else {
                let (c, v, a) = self.within(violated);
                let earlier = until_without(c, v, a);
                if earlier < h {
                    h = earlier;
                    bound = violated;
                } else {
                    rest = 0;
                }
            }
        }
        (h, bound)
    }
}

/// Texture coordinates at `x` in the prism of `data`, repeats.
#[inline]
fn uv_at(data: &PrismData, x: Vec3) -> Vec2 {
    let [uv, first, second] = data.uv;
    vec2(uv) + vec2(first) * x.x + vec2(second) * x.y
}

/// Returns the change of the texture coordinates for a change of x, repeats.
#[inline]
fn uv_change(data: &PrismData, change: Vec3) -> Vec2 {
    let [_, first, second] = data.uv;
    vec2(first) * change.x + vec2(second) * change.y
}

/// A piece of a ray to second order, from a [`Traveller`] on.
struct Piece {
    uv: Vec2,
    uv_velocity: Vec2,
    uv_acceleration: Vec2,
    depth: Vec3,
    /// An upper bound of dδ/ds.
    depth_rate: Real,
    end: Real,
    ends_on_floor: bool,
}

impl Piece {
    #[inline]
    fn new(at: &Traveller, data: &PrismData, end: Real, ends_on_floor: bool) -> Piece {
        let State {
            x,
            velocity,
            acceleration,
            ..
        } = at.state;
        let uv_velocity = uv_change(data, velocity);
        let uv_acceleration = uv_change(data, acceleration);
        Piece {
            uv: uv_at(data, x),
            uv_velocity,
            uv_acceleration: uv_acceleration * 0.5,
            depth: Vec3::new(x.z, velocity.z, 0.5 * acceleration.z),
            depth_rate: max(max(velocity.z, velocity.z + acceleration.z * end), 0.0),
            end,
            ends_on_floor,
        }
    }
}

impl Path for Piece {
    #[inline]
    fn uv(&self, s: Real) -> Vec2 {
        self.uv + (self.uv_velocity + self.uv_acceleration * s) * s
    }

    #[inline]
    fn depth_fraction(&self, s: Real) -> Real {
        self.depth.x + (self.depth.y + self.depth.z * s) * s
    }

    #[inline]
    fn uv_rates(&self) -> (Vec2, Vec2) {
        let last = self.uv_velocity + self.uv_acceleration * (2.0 * self.end);
        (self.uv_velocity, last)
    }

    #[inline]
    fn is_even(&self) -> bool {
        false
    }

    #[inline]
    fn depth_rate(&self) -> Real {
        self.depth_rate
    }

    #[inline]
    fn start(&self) -> Real {
        0.0
    }

    #[inline]
    fn end(&self) -> Real {
        self.end
    }

    #[inline]
    fn ends_on_floor(&self) -> bool {
        self.ends_on_floor
    }
}

impl<S: PrismList + ?Sized, T: Texels + ?Sized> Field<'_, S, T> {
    /// Returns a time in which the second order has an error of at most `tolerance`:
    /// `longest` times a power of [`SHORTER`], or less than `least`.
    #[inline]
    fn time_within(&self, at: &Traveller, tolerance: Real, longest: Real, least: Real) -> Real {
        let mut time = longest;
        while time > least && !at.may_glide(time, tolerance) {
            time *= SHORTER;
        }
        time
    }

    /// Follows the ray of `start` from where it is, in the shell, through the
    /// pattern. `enter` is added to its times; `on_cap` says whether a hit at once
    /// is one of the cap. The second result is the time when the ray left the first
    /// prism.
    ///
    /// Every turn of the loop marches along one piece, and moves the ray to its end. A
    /// piece ends where the second order is no longer exact enough, or where the ray
    /// leaves its prism.
    #[inline]
    pub(super) fn follow(&self, start: Traveller, enter: Real, on_cap: bool) -> (Found, Real) {
        // Read only here: during the search for the entrance they would occupy registers.
        let profile = Profile::new(self.object);
        let map = ShapeMap::new(self.object);
        let mut at = start;
        let mut left = at.t;
        let radius = self.prisms.prism(at.index).radius;
        // Pieces this short make no progress.
        let least = OVERLAP * radius;
        // The bound that the ray is on, which it does not leave through.
        let mut came_through = if on_cap { CAP } else { NONE };
        let mut steps = 0;
        let mut prisms = 1;
        let mut turns = 0;
        let mut end = 0.0;
        let mut ends_on_floor = false;
        let mut stop = Stop {
            end: END_MISS,
            s: 0.0,
            before: 0.0,
            steps: 0,
            least: 0.0,
        };
        let mut limits = Limits {
            linear_steps: self.object.linear_steps,
            binary_steps: self.binary_steps,
            slack: 0.0,
        };
        let mut over = !at.regular;
        while !over {
            turns += 1;
            // March along one piece.
            let tolerance = self.tolerance * (enter + at.t);
            let time = self.time_within(&at, tolerance, 2.0 * radius, least);
            let (time, bound) = at.state.until_outside(max(time, least), came_through);
            end = time;
            ends_on_floor = bound == FLOOR;
            let piece = Piece::new(&at, self.prisms.prism(at.index), end, ends_on_floor);
            limits.linear_steps = self.object.linear_steps - steps;
            limits.slack = self.slack * (enter + at.t);
            stop = advance(&piece, &profile, &map, self.texels, &limits);
            steps += stop.steps;
            // Only the first piece may start on the cap.
            if stop.end == END_CAP && (turns > 1 || came_through != CAP) {
                stop.end = END_SIDE;
            }
            over = stop.end != END_MISS;
            if !over {
                // Nothing was hit: move to the end of the piece, and into the
                // neighbour if that is on a side.
                let x = at.state.predicted(time);
                let t = at.t + time;
                left = if prisms == 1 { t } else { left };
                let mut guess = x;
                came_through = NONE;
                if bound < CAP {
                    let data = self.prisms.prism(at.index);
                    let link = link_of(data.neighbours, bound);
                    over = link == NO_NEIGHBOUR;
                    if !over {
                        came_through = link & 3;
                        let anchor = vec3(data.anchor);
                        at.index = link >> 2;
                        let data = self.prisms.prism(at.index);
                        at.origin += anchor - vec3(data.anchor);
                        prisms += 1;
                        guess = across(x, bound, came_through);
                    }
                }
                if !over {
                    let prism = Prism::new(self.prisms.prism(at.index), self.object.depth);
                    at.go(&prism, t, guess, ROUNDS);
                    // Through the cap, unless the ray only came near to it. Above the
                    // neighbour's cap: entry there is handled by the neighbouring prism.
                    let least = if bound == CAP { LEFT } else { -5.0 * ARRIVED };
                    let folds = !at.regular && bound != CAP;
                    over = if at.regular {
                        at.state.x.z < least
                    } else {
                        !folds
                    };
                    at.state.x = if folds { guess } else { at.state.x };
                }
                // Past the floor at a side, where the prism folds, or still in the shell: it
                // counts as a hit, as steps that run out do.
                let is_lost = !at.regular || at.state.x.z > 1.0 + THRESHOLD;
                if !over && (is_lost || turns > self.object.linear_steps + PIECES) {
                    over = true;
                    stop.end = END_SIDE;
                    stop.s = 0.0;
                }
            }
        }
        let mut s = stop.s;
        let data = self.prisms.prism(at.index);
        if stop.end == END_SIDE {
            let piece = Piece::new(&at, data, end, ends_on_floor);
            s = refine(&piece, &profile, &map, self.texels, &stop, &limits);
        }
        let x = kept3(at.state.predicted(s));
        let uv = uv_at(data, x);
        let found = Found {
            march: March {
                end: stop.end,
                s: enter + at.t + s,
                uv: Vec2::new(kept(uv.x), kept(uv.y)),
                depth_fraction: min(max(x.z, 0.0), 1.0),
                steps,
            },
            prism: at.index,
            x,
            prisms,
        };
        (found, left)
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::walk::tests::plane;

    #[test]
    fn parameters_go_round_the_common_side_the_other_way() {
        // The same point of the diagonal of triangles 0 and 1, and a little beyond.
        let prisms = plane();
        let prism = |index: usize| Prism::new(&prisms[index], 0.5);
        let x = Vec3::new(-1e-3, 0.3, 0.2);
        let there = prism(0).point(x) + prism(0).anchor;
        let beyond = across(x, 1, 2);
        let same = prism(1).point(beyond) + prism(1).anchor;
        assert!((there - same).length() < 2e-3, "{there} {same}");
        assert!(beyond.y > 0.0);
        // All three sides, there and back.
        for side in 0..3 {
            for other in 0..3 {
                let x = Vec3::new(0.2, 0.5, 0.7);
                let back = across(across(x, side, other), other, side);
                assert!((back - x).length() < 1e-6, "{back} {x}");
            }
        }
    }
}
