//! The accurate tier's search (section 6): a ray through curved prisms.
//!
//! A ray comes into the shell where it meets the smooth surface from outside,
//! where it meets a side beyond which the surface ends, or where the eye lies
//! in the shell. [`search`] looks for that in one prism, and follows the ray
//! from there through the pattern, from prism to prism, until it meets
//! something or leaves the shell. So each triangle answers for the rays that
//! come in through it, wherever they end, and no ray is followed twice.
//!
//! In between it marches along pieces of parabolas in (u, v, δ), as the fast
//! tier does along one: each is exact to second order at its start, where
//! Newton's method has put it, and ends before the third order is worth more
//! than [`Field::blur`] allows.

use crate::arithmetic::{abs, div, kept, kept3, max, min, sqrt};
use crate::layout::{NO_NEIGHBOUR, Shell, Slab, vec3};
use crate::march::{END_CAP, END_MISS, END_SIDE, Effort, March, Stop, advance, refine};
use crate::path::Path;
use crate::prism::{Prism, State, is_near, is_open};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::{FAR, Real, Vec2, Vec3};

/// Where the prisms of an object lie: a storage buffer, a slice.
pub trait Shells {
    /// The prism over triangle number `index`.
    fn shell(&self, index: u32) -> &Shell;
}

impl Shells for [Shell] {
    #[inline]
    fn shell(&self, index: u32) -> &Shell {
        &self[index as usize]
    }
}

/// How far a weight or δ may lie outside its range where a ray comes in, so
/// that it comes in somewhere.
#[cfg(not(feature = "double"))]
const OVERLAP: Real = 2e-5;
/// How far a weight or δ may lie outside its range where a ray comes in, so
/// that it comes in somewhere.
#[cfg(feature = "double")]
const OVERLAP: Real = 1e-10;

/// The error of a position, as a share of its distance from the eye.
#[cfg(not(feature = "double"))]
const ROUNDING: Real = 1e-6;
/// The error of a position, as a share of its distance from the eye.
#[cfg(feature = "double")]
const ROUNDING: Real = 1e-14;

/// A ray is at an opening where its weight, or δ for the cap, is this near to 0.
const ARRIVED: Real = OVERLAP;

/// How far beside the triangle a ray may seem to come in for that, at most.
const FURTHEST: Real = 0.01;

/// An opening is taken for reached after [`TRIES`] within this.
const THRESHOLD: Real = 1e-3;
const TRIES: u32 = 6;

/// Rounds of Newton's method, at most: where the ray comes into the hull, and
/// from one place to the next.
const FIRST_ROUNDS: u32 = 12;
const ROUNDS: u32 = 4;

/// Steps until the ray comes in, at most.
const OUTSIDE_STEPS: u32 = 32;

/// By how much of a weight, or of δ, the second order may be wrong from end to
/// end of a prism, and by which share of its own bend.
const DOUBT: Real = 0.05;

/// How often a ray comes in through one prism, at most.
const ENTRIES: u32 = 3;

/// Pieces of a ray, at most, beside one for each step.
const PIECES: u32 = 4096;

/// A piece is this much shorter than the one whose error is too large.
const SHORTER: Real = 0.7;

/// The side of a prism opposite to its first, second or third corner has that
/// corner's number; then come the cap and the floor.
const CAP: u32 = 3;
const FLOOR: u32 = 4;
/// Nothing of these.
const NONE: u32 = 5;

/// A ray's search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// How it ended; its `s` is the distance from the ray's origin, object
    /// units. The rest is meaningless for a miss.
    pub march: March,
    /// The prism of the hit.
    pub prism: u32,
    /// (w1, w2, δ) there.
    pub x: Vec3,
    /// Prisms that the ray went through.
    pub prisms: u32,
}

/// What a ray is searched in.
#[derive(Clone, Copy)]
pub struct Field<'a, S: Shells + ?Sized, T: Texels + ?Sized> {
    /// The prisms.
    pub shells: &'a S,
    /// S_z, object units.
    pub depth: Real,
    /// How far beside its place the ray may be searched, per unit of its length.
    pub blur: Real,
    /// How far before the solid the search may end, texels per unit of the ray's
    /// length.
    pub slack: Real,
    /// The extrusion.
    pub profile: &'a Profile,
    /// The pattern.
    pub map: &'a ShapeMap,
    /// Its texels.
    pub texels: &'a T,
    /// Largest number of steps of the linear search.
    pub linear_steps: u32,
    /// Number of bisections after it.
    pub binary_steps: u32,
}

/// When c + v h + ½ a h² comes up through 0, h > 0; for c ≤ 0, or c about 0 and
/// v < 0. [`FAR`] if never.
#[inline]
fn rise(c: Real, v: Real, a: Real) -> Real {
    let radicand = v * v - 2.0 * a * c;
    if radicand < 0.0 || (v <= 0.0 && a <= 0.0) {
        return FAR;
    }
    let root = sqrt(radicand);
    let (over, under) = if v > 0.0 {
        (-2.0 * c, v + root)
    } else {
        (root - v, a)
    };
    div(over, under)
}

/// When c + v h + ½ a h² next comes up through 0; [`FAR`] if it clearly does not
/// within the time `rest`.
///
/// Terms of third order are left out, so that a near miss is no miss: its
/// highest point is the answer then.
#[inline]
fn until_opened(c: Real, v: Real, a: Real, rest: Real) -> Real {
    if c > 0.0 && v > 0.0 {
        return FAR;
    }
    let time = rise(c, v, a);
    if time < FAR || v <= 0.0 {
        return time;
    }
    let summit = div(-v, a);
    let doubt = DOUBT * (1.0 + abs(a) * rest * rest);
    if c + 0.5 * v * summit > -doubt {
        summit
    } else {
        FAR
    }
}

/// When the ray, which satisfies c ≥ 0, leaves.
#[inline]
fn until_without(c: Real, v: Real, a: Real) -> Real {
    rise(-max(c, 0.0), -v, -a)
}

/// Component `i` (0…2).
#[inline]
fn pick(v: Vec3, i: u32) -> Real {
    if i == 0 {
        v.x
    } else if i == 1 {
        v.y
    } else {
        v.z
    }
}

/// What lies beyond side `side`.
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

/// `i` + 1 in the order 0, 1, 2, 0.
#[inline]
fn next(i: u32) -> u32 {
    if i == 2 { 0 } else { i + 1 }
}

/// The three weights at (w1, w2, δ), or their derivatives, with their sum.
#[inline]
fn weights(x: Vec3, sum: Real) -> Vec3 {
    Vec3::new(sum - x.x - x.y, x.x, x.y)
}

/// The parameters behind side `side` of a prism, beyond which a neighbour has
/// its own side `other`, as the neighbour counts: right on the side, and
/// roughly beyond it.
#[inline]
fn across(x: Vec3, side: u32, other: u32) -> Vec3 {
    let w = weights(x, 1.0);
    let out = pick(w, side);
    // As if the two were halves of a parallelogram; they go round their common
    // edge the other way.
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
    /// What is positive inside of side, cap or floor `bound`, and its derivatives.
    #[inline]
    fn within(&self, bound: u32) -> (Real, Real, Real) {
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

    /// x after the time `h`, in second order.
    #[inline]
    fn predicted(&self, h: Real) -> Vec3 {
        self.x + (self.velocity + self.acceleration * (0.5 * h)) * h
    }

    /// The state after the time `h`, in second order.
    #[inline]
    fn after(&self, h: Real) -> State {
        State {
            x: self.predicted(h),
            velocity: self.velocity + self.acceleration * h,
            ..*self
        }
    }

    /// How far inside the nearest of the sides, the cap and the floor.
    #[inline]
    fn inset(&self) -> Real {
        let w = weights(self.x, 1.0);
        min(min(min(w.x, w.y), w.z), min(self.x.z, 1.0 - self.x.z))
    }

    /// Whether the ray comes into the prism here, through `opening`, up to
    /// `overlap`.
    #[inline]
    fn comes_in(&self, opening: u32, overlap: Real) -> bool {
        let (c, v, a) = self.within(opening);
        // On the way out, or to a highest point before the opening.
        if v <= 0.0 || (c < 0.0 && v * v < 2.0 * a * c) {
            return false;
        }
        // The opening is not quite where this is.
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

    /// The time until the next opening is reached, and which it is; [`FAR`] if
    /// none is within the time `rest`. `passed` is the one where the ray is.
    #[inline]
    fn next_opening(&self, neighbours: [u32; 3], passed: u32, rest: Real) -> (Real, u32) {
        let mut best = (FAR, NONE);
        best = self.earlier(CAP, passed, rest, best);
        let [first, second, third] = neighbours;
        if first == NO_NEIGHBOUR {
            best = self.earlier(0, passed, rest, best);
        }
        if second == NO_NEIGHBOUR {
            best = self.earlier(1, passed, rest, best);
        }
        if third == NO_NEIGHBOUR {
            best = self.earlier(2, passed, rest, best);
        }
        best
    }

    /// `best`, or `opening` if that is reached earlier.
    #[inline]
    fn earlier(&self, opening: u32, passed: u32, rest: Real, best: (Real, u32)) -> (Real, u32) {
        let (c, v, a) = self.within(opening);
        if passed == opening && v > 0.0 {
            return best;
        }
        let time = until_opened(c, v, a, rest);
        if time < best.0 { (time, opening) } else { best }
    }

    /// Whether the ray is clearly beside the triangle after the time `h`.
    #[inline]
    fn passes_by(&self, h: Real) -> bool {
        let w = weights(self.predicted(h), 1.0);
        let a = weights(self.acceleration, 0.0);
        let doubt = |a: Real| DOUBT * (1.0 + abs(a) * h * h);
        w.x < -doubt(a.x) || w.y < -doubt(a.y) || w.z < -doubt(a.z)
    }

    /// The bound but `but` that `x` violates most, if it violates one.
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

    /// The time until the prism is left, but not through `but`, if that is
    /// before `time`, and through what.
    #[inline]
    fn until_outside(&self, time: Real, but: u32) -> (Real, u32) {
        let mut h = time;
        let mut bound = NONE;
        // Not over the deepest point if that lies below the floor.
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

/// `range`, clipped to where the ray from `origin` is in the slab.
#[inline]
fn clip(range: (Real, Real), slab: &Slab, origin: Vec3, direction: Vec3) -> (Real, Real) {
    let axis = vec3(slab.axis);
    let at = origin.dot(axis);
    let speed = direction.dot(axis);
    if abs(speed) * FAR <= slab.high - slab.low {
        // Parallel to the slab: in it for ever, or never.
        return if at >= slab.low && at <= slab.high {
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

/// Where the ray from `origin`, relative to the anchor of `shell`, comes into
/// the hull, and the length of its way there, which is not positive where it
/// misses the hull.
#[inline]
fn hull_of(shell: &Shell, origin: Vec3, direction: Vec3) -> (Real, Real) {
    let mut range = (0.0, FAR);
    range = clip(range, &shell.slabs[0], origin, direction);
    range = clip(range, &shell.slabs[1], origin, direction);
    range = clip(range, &shell.slabs[2], origin, direction);
    range = clip(range, &shell.slabs[3], origin, direction);
    (range.0, range.1 - range.0)
}

/// About the weights at `point`, relative to the anchor of `shell`, on its cap:
/// the slabs along the sides are as wide as the weights.
#[inline]
fn rough_parameters(shell: &Shell, point: Vec3) -> Vec3 {
    let share = |slab: &Slab| {
        let share = div(point.dot(vec3(slab.axis)) - slab.low, slab.high - slab.low);
        min(max(share, 0.0), 1.0)
    };
    Vec3::new(share(&shell.slabs[2]), share(&shell.slabs[3]), 0.0)
}

/// A ray where it is in a prism.
#[derive(Clone, Copy)]
struct Traveller {
    index: u32,
    prism: Prism,
    /// The ray's origin, relative to the prism's anchor.
    origin: Vec3,
    direction: Vec3,
    /// Distance from `origin`, object units.
    t: Real,
    state: State,
    /// Whether the prism can be followed there.
    regular: bool,
    /// Time since the state was exact.
    since: Real,
}

impl Traveller {
    /// Before the first move, which starts from the parameters `x`.
    #[inline]
    fn new(index: u32, prism: Prism, origin: Vec3, direction: Vec3, x: Vec3) -> Traveller {
        Traveller {
            index,
            prism,
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

    /// Moves to `t`, near the parameters `guess`, and is exact there.
    #[inline]
    fn go(&mut self, t: Real, guess: Vec3, rounds: u32) {
        let target = self.origin + self.direction * t;
        let (x, jacobian) = self.prism.solve(target, guess, rounds);
        self.t = t;
        self.state = self.prism.motion(x, &jacobian, self.direction);
        self.regular = jacobian.regular;
        self.since = 0.0;
    }

    /// Whether the second order is good enough after the time `h` more, with an
    /// error of at most `precision`.
    #[inline]
    fn may_glide(&self, h: Real, precision: Real) -> bool {
        let time = self.since + h;
        abs(self.state.third_order * time * time * time) <= precision
    }

    /// Moves on by `h` in second order.
    #[inline]
    fn glide(&mut self, h: Real) {
        self.t += h;
        self.since += h;
        self.state = self.state.after(h);
    }
}

/// Where a ray comes into the shell.
struct Entrance {
    at: Traveller,
    /// What is to be added to its times.
    enter: Real,
    /// Whether it does.
    found: bool,
    /// Whether it starts there.
    in_shell: bool,
}

/// A piece of a ray in second order, from where a [`Traveller`] is.
struct Piece {
    uv: Vec2,
    uv_velocity: Vec2,
    uv_acceleration: Vec2,
    depth: Vec3,
    /// A bound of the change of δ.
    depth_rate: Real,
    end: Real,
    ends_on_floor: bool,
}

impl Piece {
    #[inline]
    fn new(at: &Traveller, end: Real, ends_on_floor: bool) -> Piece {
        let State {
            x,
            velocity,
            acceleration,
            ..
        } = at.state;
        let uv_velocity = at.prism.uv_change(velocity);
        let uv_acceleration = at.prism.uv_change(acceleration);
        Piece {
            uv: at.prism.uv(x.x, x.y),
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

impl<S: Shells + ?Sized, T: Texels + ?Sized> Field<'_, S, T> {
    /// Looks for where the ray of `start` comes in from outside, or whether it
    /// starts in the shell, if `may_hold_eye`; `hull` is that of [`hull_of`], and
    /// `from` the time in it from which on to look.
    #[inline]
    fn seek(
        &self,
        start: Traveller,
        shell: &Shell,
        hull: (Real, Real),
        may_hold_eye: bool,
        from: Real,
    ) -> Entrance {
        let mut at = start;
        let (enter, span) = hull;
        let distance = abs(at.origin.x) + abs(at.origin.y) + abs(at.origin.z);
        let overlap = OVERLAP + ROUNDING * distance * shell.inverse_altitude;
        let is_closed = !is_open(shell);
        // Steps this short make no progress.
        let shortest = span * OVERLAP;
        let in_hull = at.origin + at.direction * enter;
        let rough = rough_parameters(shell, in_hull + at.direction * from);
        let third: Real = 1.0 / 3.0;
        let mut looks_at_eye = may_hold_eye;
        let mut guess = Vec3::new(third, third, 0.5);
        let mut t = 0.0;
        if !looks_at_eye {
            at.origin = in_hull;
            guess = rough;
            t = from;
        }
        let mut rounds = FIRST_ROUNDS;
        let mut opening = NONE;
        let mut tries = 0;
        let mut turns = 0;
        let mut found = false;
        let mut in_shell = false;
        let mut over = false;
        while !over {
            at.go(t, guess, rounds);
            if looks_at_eye {
                looks_at_eye = false;
                in_shell = at.regular && at.state.inset() >= -OVERLAP;
                over = in_shell || span <= 0.0;
                if !over {
                    at.origin = in_hull;
                    guess = rough;
                }
            } else {
                rounds = ROUNDS;
                turns += 1;
                let rest = span - at.t;
                let (c, v, a) = at.state.within(opening);
                let off = if tries < TRIES { ARRIVED } else { THRESHOLD };
                let arrived = opening != NONE && abs(c) <= off;
                // The way there by the second order, back if it was passed.
                let mut h = FAR;
                if arrived {
                    found = at.state.comes_in(opening, overlap);
                } else if opening != NONE && tries < TRIES {
                    tries += 1;
                    h = if c > 0.0 {
                        -until_without(c, -v, a)
                    } else {
                        until_opened(c, v, a, rest)
                    };
                }
                if h >= FAR || at.t + h < -shortest {
                    let passed = if arrived { opening } else { NONE };
                    (h, opening) = at.state.next_opening(shell.neighbours, passed, rest);
                    tries = 0;
                }
                over = found
                    || !at.regular
                    || turns > OUTSIDE_STEPS
                    || h >= FAR
                    || (h > rest && rest <= shortest)
                    || (opening == CAP && is_closed && at.state.passes_by(h));
                // Beyond the hull's end there is nothing: if it looks so, the
                // second order may be wrong.
                let h_inside = min(h, rest);
                let precision = self.blur * (enter + at.t);
                if !over && h <= rest && at.may_glide(h, precision) {
                    let mut there = at;
                    there.glide(h);
                    let (c, _, _) = there.state.within(opening);
                    // A neighbour may be off to the other side.
                    let overlap = overlap + 2.0 * precision * shell.inverse_altitude;
                    if abs(c) <= ARRIVED && there.state.comes_in(opening, overlap) {
                        at = there;
                        found = true;
                    }
                    over = found || is_closed;
                }
                let h = if abs(h_inside) < shortest {
                    shortest
                } else {
                    h_inside
                };
                t = at.t + h;
                guess = at.state.predicted(h);
            }
        }
        Entrance {
            at,
            enter: if in_shell { 0.0 } else { enter },
            found: at.regular && (found || in_shell),
            in_shell,
        }
    }

    /// Follows the ray of `start` from where it is, in the shell, through the
    /// pattern; `enter` is added to its times, and `on_cap` says whether a hit
    /// at once is one of the cap. The second answer is the time when the ray left
    /// the first prism.
    #[inline]
    fn follow(&self, start: Traveller, enter: Real, on_cap: bool) -> (Found, Real) {
        let mut at = start;
        let mut left = at.t;
        let radius = self.shells.shell(at.index).radius;
        // Pieces this short make no progress.
        let least = OVERLAP * radius;
        let mut came_through = if on_cap { CAP } else { NONE };
        let mut is_first = on_cap;
        let mut steps = 0;
        let mut prisms = 1;
        let mut turns = 0;
        let mut piece = Piece::new(&at, 0.0, false);
        let mut stop = Stop {
            end: END_MISS,
            s: 0.0,
            before: 0.0,
            steps: 0,
            least: 0.0,
        };
        let mut effort = Effort {
            linear_steps: self.linear_steps,
            binary_steps: self.binary_steps,
            slack: 0.0,
        };
        let mut over = !at.regular;
        while !over {
            turns += 1;
            let precision = self.blur * (enter + at.t);
            let mut time = 2.0 * radius;
            while time > least && !at.may_glide(time, precision) {
                time *= SHORTER;
            }
            let (time, bound) = at.state.until_outside(max(time, least), came_through);
            piece = Piece::new(&at, time, bound == FLOOR);
            effort.linear_steps = self.linear_steps - steps;
            effort.slack = self.slack * (enter + at.t);
            stop = advance(&piece, self.profile, self.map, self.texels, &effort);
            steps += stop.steps;
            if stop.end == END_CAP && !is_first {
                stop.end = END_SIDE;
            }
            over = stop.end != END_MISS;
            is_first = false;
            if !over {
                let x = at.state.predicted(time);
                let t = at.t + time;
                left = if prisms == 1 { t } else { left };
                let mut guess = x;
                came_through = NONE;
                if bound < CAP {
                    let link = link_of(self.shells.shell(at.index).neighbours, bound);
                    over = link == NO_NEIGHBOUR;
                    if !over {
                        came_through = link & 3;
                        at.index = link >> 2;
                        let prism = Prism::new(self.shells.shell(at.index), self.depth);
                        at.origin += at.prism.anchor - prism.anchor;
                        at.prism = prism;
                        prisms += 1;
                        guess = across(x, bound, came_through);
                    }
                } else {
                    over = bound == CAP;
                }
                if !over {
                    at.go(t, guess, ROUNDS);
                    // Above the neighbour's cap: if it comes in there, that is
                    // the neighbour's to find.
                    over = !at.regular || at.state.x.z < -5.0 * ARRIVED;
                }
                if !over && turns > self.linear_steps + PIECES {
                    // Still in the shell: it counts as a hit, as steps that run out do.
                    over = true;
                    stop.end = END_SIDE;
                    stop.s = 0.0;
                }
            }
        }
        let mut s = stop.s;
        if stop.end == END_SIDE {
            s = refine(&piece, self.profile, self.map, self.texels, &stop, &effort);
        }
        let x = at.state.predicted(s);
        let x = kept3(x);
        let uv = at.prism.uv(x.x, x.y);
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

/// Searches for the first hit on the ray from `eye` along the unit vector
/// `direction` that comes into the shell through prism number `home`.
#[inline]
pub fn search<S: Shells + ?Sized, T: Texels + ?Sized>(
    field: &Field<'_, S, T>,
    home: u32,
    eye: Vec3,
    direction: Vec3,
) -> Found {
    let shell = field.shells.shell(home);
    let origin = eye - vec3(shell.anchor);
    let nothing = Found {
        march: March {
            end: END_MISS,
            s: 0.0,
            uv: Vec2::ZERO,
            depth_fraction: 0.0,
            steps: 0,
        },
        prism: home,
        x: Vec3::ZERO,
        prisms: 0,
    };
    let hull = hull_of(shell, origin, direction);
    let may_hold_eye = is_near(shell, origin);
    if hull.1 <= 0.0 && !may_hold_eye {
        return nothing;
    }
    let prism = Prism::new(shell, field.depth);
    let start = Traveller::new(home, prism, origin, direction, Vec3::ZERO);
    let mut found = nothing;
    let mut from = 0.0;
    let mut entries = 0;
    while entries < ENTRIES {
        let at_eye = may_hold_eye && entries == 0;
        let entrance = field.seek(start, shell, hull, at_eye, from);
        entries += 1;
        if entrance.found {
            // Inside a column the eye sees no cap, and no more through an open side
            // or on the way up.
            let state = &entrance.at.state;
            let on_cap = !entrance.in_shell && state.x.z <= THRESHOLD && state.velocity.z > 0.0;
            let (ended, left) = field.follow(entrance.at, entrance.enter, on_cap);
            found = ended;
            // Out of a valley it may come in once more.
            from = max(left + entrance.enter - hull.0, 0.0);
        }
        if !entrance.found || found.march.end != END_MISS || hull.1 <= from {
            entries = ENTRIES;
        }
    }
    found
}

/// Whether a ray along the unit vector `direction` that starts in the shell, at
/// the parameters `x` of prism number `home` and from there by `offset` in
/// space, leaves it without meeting anything.
#[inline]
pub fn leaves<S: Shells + ?Sized, T: Texels + ?Sized>(
    field: &Field<'_, S, T>,
    home: u32,
    x: Vec3,
    offset: Vec3,
    direction: Vec3,
) -> bool {
    let prism = Prism::new(field.shells.shell(home), field.depth);
    let origin = prism.point(x) + offset;
    let mut at = Traveller::new(home, prism, origin, direction, x);
    at.go(0.0, x, ROUNDS);
    let (found, _) = field.follow(at, 0.0, false);
    found.march.end == END_MISS
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::layout::{FORMAT_FLOAT, Object};
    use crate::march::END_FLOOR;
    use crate::prism::tests::test_shell;

    /// The plane z = 0 over (0, 0) to (2, 1) in four triangles, half a unit deep,
    /// with one column: texels 0 and 1 of 4 along u = x.
    ///
    /// ```text
    /// (0, 1) ─── (1, 1) ─── (2, 1)
    ///   │  1   ╱   │   3  ╱   │
    ///   │   ╱   0  │  ╱    2  │
    /// (0, 0) ─── (1, 0) ─── (2, 0)
    /// ```
    fn plane() -> [Shell; 4] {
        let corner = |x: f32, y: f32| (Vec3::new(x, y, 0.0), Vec3::Z, Vec2::new(x, y));
        let triangle = |a, b, c| test_shell([a, b, c], 0.5);
        let [a, b, c] = [0.0, 1.0, 2.0].map(|x| corner(x, 0.0));
        let [d, e, f] = [0.0, 1.0, 2.0].map(|x| corner(x, 1.0));
        let mut shells = [
            triangle(a, b, e),
            triangle(a, e, d),
            triangle(b, c, f),
            triangle(b, f, e),
        ];
        let mut join = |(first, side): (u32, u32), (second, other): (u32, u32)| {
            shells[first as usize].neighbours[side as usize] = 4 * second + other;
            shells[second as usize].neighbours[other as usize] = 4 * first + side;
        };
        // Sides are counted by the corner opposite to them.
        join((0, 1), (1, 2));
        join((0, 0), (3, 1));
        join((2, 1), (3, 2));
        shells
    }

    fn object() -> Object {
        Object {
            map_size: [4.0, 1.0],
            map_step: 1.0,
            map_format: FORMAT_FLOAT,
            map_reach: 1.0,
            depth: 0.5,
            ..Object::default()
        }
    }

    const TEXELS: [f32; 4] = [-0.5, -0.5, 0.5, 0.5];

    fn with_field<R>(shells: &[Shell], run: impl Fn(&Field<'_, [Shell], [u32]>) -> R) -> R {
        let object = object();
        run(&Field {
            shells,
            depth: object.depth,
            blur: 1e-5,
            slack: 0.0,
            profile: &Profile::new(&object),
            map: &ShapeMap::new(&object),
            texels: &TEXELS.map(f32::to_bits)[..],
            linear_steps: 1000,
            binary_steps: 24,
        })
    }

    fn hit(home: u32, eye: [f32; 3], direction: [f32; 3]) -> Found {
        let direction = Vec3::from(direction).normalize();
        with_field(&plane(), |field| {
            search(field, home, Vec3::from(eye), direction)
        })
    }

    #[test]
    fn cap_and_floor_are_found_by_the_triangle_above_them_only() {
        let cap = hit(0, [0.25, 0.1, 2.0], [0.0, 0.0, -1.0]);
        assert_eq!(cap.march.end, END_CAP);
        assert!((cap.march.s - 2.0).abs() < 1e-4, "{cap:?}");
        let floor = hit(0, [0.75, 0.1, 2.0], [0.0, 0.0, -1.0]);
        assert_eq!(floor.march.end, END_FLOOR);
        assert!((floor.march.s - 2.5).abs() < 2e-4, "{floor:?}");
        for other in 1..4 {
            let nothing = hit(other, [0.25, 0.1, 2.0], [0.0, 0.0, -1.0]);
            assert_eq!(nothing.march.end, END_MISS);
        }
        // From below there is nothing.
        let below = hit(0, [0.75, 0.1, -2.0], [0.0, 0.0, 1.0]);
        assert_eq!(below.march.end, END_MISS);
    }

    #[test]
    fn a_ray_is_followed_into_the_neighbours() {
        // In over triangle 2 at x = 1.9, against the column's side at u = 1.5.
        let wall = hit(2, [2.1, 0.6, 0.2], [-1.0, 0.0, -1.0]);
        assert_eq!(wall.march.end, END_SIDE);
        assert!((wall.march.uv.x - 1.5).abs() < 1e-2, "{wall:?}");
        assert!((wall.march.depth_fraction - 0.8).abs() < 2e-2, "{wall:?}");
        assert_eq!((wall.prism, wall.prisms), (3, 2));
        // All the way along the trench between u = 0.5 and u = 1.
        let end = hit(3, [1.6, 0.9, 0.01], [0.1, -1.0, -0.1]);
        assert_eq!(end.march.end, END_MISS, "{end:?}");
        assert_eq!(end.prisms, 2);
        // Where the neighbours are unknown, the surface ends.
        let mut alone = plane();
        alone[2].neighbours = [NO_NEIGHBOUR; 3];
        let direction = Vec3::new(-1.0, 0.0, -1.0).normalize();
        let lost = with_field(&alone, |field| {
            search(field, 2, Vec3::new(2.1, 0.6, 0.2), direction)
        });
        assert_eq!(lost.march.end, END_MISS);
    }

    #[test]
    fn open_sides_and_the_eye_inside_let_rays_in() {
        // Through the cut at y = 0, below the cap, along the trench's floor.
        let cut = hit(0, [0.75, -1.0, -0.2], [0.0, 1.0, -0.05]);
        assert_eq!(cut.march.end, END_MISS);
        let cut = hit(0, [0.75, -1.0, -0.2], [0.0, 1.0, -0.25]);
        assert_eq!(cut.march.end, END_FLOOR);
        // Into the column's own cut: no cap.
        let cut = hit(0, [0.25, -1.0, -0.2], [0.0, 1.0, 0.0]);
        assert_eq!(cut.march.end, END_SIDE);
        assert!((cut.march.s - 1.0).abs() < 1e-3, "{cut:?}");
        // The side between two triangles lets nothing in by itself.
        let closed = hit(1, [0.75, -1.0, -0.2], [0.0, 1.0, -0.25]);
        assert_eq!(closed.march.end, END_MISS);
        // From within the trench against the column, and away from it.
        let inside = hit(0, [0.7, 0.1, -0.1], [-1.0, 0.0, 0.0]);
        assert_eq!(inside.march.end, END_SIDE);
        assert!((inside.march.s - 0.2).abs() < 1e-2, "{inside:?}");
        let away = hit(0, [0.7, 0.1, -0.1], [0.0, 0.0, 1.0]);
        assert_eq!(away.march.end, END_MISS);
    }

    #[test]
    fn light_comes_from_where_no_column_stands() {
        let shells = plane();
        // On the trench's floor at (0.6, 0.1): the column's edge is 0.1 away.
        let x = Vec3::new(0.5, 0.1, 1.0);
        let lit = |direction: Vec3| {
            with_field(&shells, |field| {
                leaves(field, 0, x, Vec3::ZERO, direction.normalize())
            })
        };
        assert!(lit(Vec3::Z));
        assert!(lit(Vec3::new(1.0, 0.0, 3.0)));
        assert!(!lit(Vec3::new(-1.0, 0.0, 1.0)));
        // Through the neighbour, against the next column at u = 1.
        assert!(!lit(Vec3::new(1.0, 0.0, 0.5)));
    }

    #[test]
    fn parameters_go_round_the_common_side_the_other_way() {
        // The same point of the diagonal of triangles 0 and 1, and a little beyond.
        let shells = plane();
        let prism = |index: usize| Prism::new(&shells[index], 0.5);
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
