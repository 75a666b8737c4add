//! The accurate tier's search (section 6): a ray through curved prisms.
//!
//! A ray comes into the shell where it meets the smooth surface from outside,
//! where it meets a side beyond which the surface ends, or where the eye lies
//! in the shell. [`search`] looks for that in one prism, and follows the ray
//! from there through the pattern, from prism to prism, until it meets
//! something or leaves the shell. So each triangle answers for the rays that
//! come in through it, wherever they end, and no ray is followed twice.

use crate::arithmetic::{abs, clamp, div, max, min, sqrt};
use crate::layout::{NO_NEIGHBOUR, Shell, vec3};
use crate::march::{END_CAP, END_FLOOR, END_MISS, END_SIDE, March, TOLERANCE};
use crate::prism::{Prism, State, is_near};
use crate::profile::Profile;
use crate::shape_map::{SafeStep, ShapeMap, Texels};
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

/// A ray that goes out is outside where a weight or δ is less than this.
const SIDE: Real = 0.5 * OVERLAP;

/// From this δ on a point lies on the floor.
const FLOOR: Real = 1.0 - 10.0 * OVERLAP;

/// A ray is at an opening where its weight, or δ for the cap, is this near to 0.
const ARRIVED: Real = 5.0 * OVERLAP;

/// An opening is taken for reached after [`TRIES`] within this.
const THRESHOLD: Real = 1e-3;
const TRIES: u32 = 6;

/// Rounds of Newton's method, at most: where the ray comes into the hull, and
/// from one step to the next.
const FIRST_ROUNDS: u32 = 12;
const ROUNDS: u32 = 4;

/// Steps until the ray comes in, at most.
const OUTSIDE_STEPS: u32 = 32;

/// By how much of a weight, or of δ, the second order may be wrong from end to
/// end of a prism, and by which share of its own bend.
const DOUBT: Real = 0.05;

/// Steps that end at a side or on the floor go this much beyond it, so that
/// another one is not needed to get there.
const STRETCH: Real = 1.01;

/// Sides between prisms that one ray crosses, at most.
const CROSSINGS: u32 = 4096;

/// The cap among the openings; the sides have the numbers of their corners.
const CAP: u32 = 3;
/// No side, and no opening.
const NONE: u32 = 4;

/// The eye is looked at.
const AT_EYE: u32 = 0;
/// The ray is looked for where it comes in.
const SEEKING: u32 = 1;
/// The ray is in the shell.
const FOLLOWING: u32 = 2;

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
    /// By how much the ray may be off its place in the prisms while it is
    /// followed, object units; where it ends is exact.
    pub precision: Real,
    /// What is added to that per unit of distance from the ray's origin.
    pub blur: Real,
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
    /// What becomes 0 at opening `opening`, and its two derivatives.
    #[inline]
    fn at_opening(&self, opening: u32) -> (Real, Real, Real) {
        if opening == CAP {
            return (self.x.z, self.velocity.z, self.acceleration.z);
        }
        (
            pick(weights(self.x, 1.0), opening),
            pick(weights(self.velocity, 0.0), opening),
            pick(weights(self.acceleration, 0.0), opening),
        )
    }

    /// Whether the ray comes into the prism here, through `opening`, up to
    /// `overlap`.
    #[inline]
    fn comes_in(&self, opening: u32, overlap: Real) -> bool {
        let (c, v, _) = self.at_opening(opening);
        if v <= 0.0 {
            return false;
        }
        // The opening is not quite where this is.
        let early = abs(div(c, v));
        let w = weights(self.x, 1.0);
        let change = weights(self.velocity, 0.0);
        let slack = |w: Real, change: Real| w >= -overlap - abs(change) * early;
        (opening == 0 || slack(w.x, change.x))
            && (opening == 1 || slack(w.y, change.y))
            && (opening == 2 || slack(w.z, change.z))
            && (opening == CAP || slack(self.x.z, self.velocity.z))
            && self.x.z < FLOOR
    }

    /// The time until the next opening is reached, and which it is; [`FAR`] if
    /// none is within the time `rest`. `passed` is the one where the ray is.
    #[inline]
    fn next_opening(&self, neighbours: [u32; 3], passed: u32, rest: Real) -> (Real, u32) {
        let mut time = FAR;
        let mut opening = NONE;
        if passed != CAP || self.velocity.z <= 0.0 {
            let (c, v, a) = self.at_opening(CAP);
            time = until_opened(c, v, a, rest);
            opening = CAP;
        }
        let [first, second, third] = neighbours;
        if first == NO_NEIGHBOUR {
            (time, opening) = self.earlier(0, passed, rest, (time, opening));
        }
        if second == NO_NEIGHBOUR {
            (time, opening) = self.earlier(1, passed, rest, (time, opening));
        }
        if third == NO_NEIGHBOUR {
            (time, opening) = self.earlier(2, passed, rest, (time, opening));
        }
        (time, opening)
    }

    /// `best`, or `side` if that is reached earlier.
    #[inline]
    fn earlier(&self, side: u32, passed: u32, rest: Real, best: (Real, u32)) -> (Real, u32) {
        let (c, v, a) = self.at_opening(side);
        if passed == side && v > 0.0 {
            return best;
        }
        let time = until_opened(c, v, a, rest);
        if time < best.0 { (time, side) } else { best }
    }

    /// Whether the ray is clearly beside the triangle after the time `h`.
    #[inline]
    fn passes_by(&self, h: Real) -> bool {
        let x = self.predicted(h);
        let w = weights(x, 1.0);
        let a = weights(self.acceleration, 0.0);
        let doubt = |a: Real| DOUBT * (1.0 + abs(a) * h * h);
        w.x < -doubt(a.x) || w.y < -doubt(a.y) || w.z < -doubt(a.z)
    }

    /// How far inside the nearest of the sides and the cap.
    #[inline]
    fn inset(&self) -> Real {
        let w = weights(self.x, 1.0);
        min(min(w.x, w.y), min(w.z, self.x.z))
    }

    /// The condition that x violates most, as something that ought to be
    /// positive, and its two derivatives.
    #[inline]
    fn most_violated(&self, x: Vec3) -> (Real, Vec3) {
        let w = weights(x, 1.0);
        let mut least = w.x;
        let mut which = Vec3::new(
            1.0 - self.x.x - self.x.y,
            -self.velocity.x - self.velocity.y,
            -self.acceleration.x - self.acceleration.y,
        );
        if w.y < least {
            least = w.y;
            which = Vec3::new(self.x.x, self.velocity.x, self.acceleration.x);
        }
        if w.z < least {
            least = w.z;
            which = Vec3::new(self.x.y, self.velocity.y, self.acceleration.y);
        }
        if x.z < least {
            least = x.z;
            which = Vec3::new(self.x.z, self.velocity.z, self.acceleration.z);
        }
        if 1.0 - x.z < least {
            least = 1.0 - x.z;
            which = Vec3::new(1.0 - self.x.z, -self.velocity.z, -self.acceleration.z);
        }
        (least, which)
    }

    /// `time`, or a little more than the time until a side, the cap or the
    /// floor is reached from inside.
    #[inline]
    fn until_outside(&self, time: Real) -> Real {
        let mut h = time;
        // Over the deepest point, which may lie on the floor.
        if self.velocity.z > 0.0 && self.velocity.z + self.acceleration.z * h < 0.0 {
            h = div(-self.velocity.z, self.acceleration.z);
        }
        let mut rest = 4;
        let mut stretch = 1.0;
        while rest > 0 {
            let (least, which) = self.most_violated(self.predicted(h));
            rest -= 1;
            if least < -SIDE {
                h = min(h, until_without(which.x, which.y, which.z));
                stretch = STRETCH;
            } else {
                rest = 0;
            }
        }
        h * stretch
    }

    /// The side through which the ray goes out, if it is there, but not `but`.
    #[inline]
    fn side_left(&self, but: u32) -> u32 {
        let w = weights(self.x, 1.0);
        let v = weights(self.velocity, 0.0);
        let mut side = NONE;
        let mut least = SIDE;
        if w.x < least && v.x < 0.0 && but != 0 {
            side = 0;
            least = w.x;
        }
        if w.y < least && v.y < 0.0 && but != 1 {
            side = 1;
            least = w.y;
        }
        if w.z < least && v.z < 0.0 && but != 2 {
            side = 2;
        }
        side
    }

    /// Whether the ray was on the floor already where it went out through `side`.
    #[inline]
    fn was_on_floor(&self, side: u32) -> bool {
        let (w, v, _) = self.at_opening(side);
        let then = self.x.z - self.velocity.z * div(w, v);
        self.velocity.z >= 0.0 && then >= FLOOR
    }

    /// x after the time `h`, in second order.
    #[inline]
    fn predicted(&self, h: Real) -> Vec3 {
        self.x + (self.velocity + self.acceleration * (0.5 * h)) * h
    }
}

/// `range`, clipped to where the ray from `origin` is in the slab.
#[inline]
fn clip(
    range: (Real, Real),
    slab: &crate::layout::Slab,
    origin: Vec3,
    direction: Vec3,
) -> (Real, Real) {
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
    /// The error of the second order, object units, per cube of the time;
    /// [`FAR`] where it is not known.
    cubic: Real,
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
            },
            regular: false,
            since: 0.0,
            cubic: FAR,
        }
    }

    /// Moves to `t`, near the parameters `guess`, and is exact there.
    #[inline]
    fn go(&mut self, t: Real, guess: Vec3, rounds: u32) {
        let target = self.origin + self.direction * t;
        let found = self.prism.solve(target, guess, rounds);
        let time = self.since + abs(t - self.t);
        if time > 0.0 {
            let cubic = div(found.first, time * time * time);
            // One guess that was right by chance does not count for all.
            let known = if self.cubic < FAR { self.cubic } else { 0.0 };
            self.cubic = max(cubic, 0.5 * known);
        }
        self.t = t;
        self.state = self.prism.motion(found.x, &found.jacobian, self.direction);
        self.regular = found.jacobian.regular;
        self.since = 0.0;
    }

    /// Whether the second order is good enough after the time `h` more, with an
    /// error of at most `precision`.
    #[inline]
    fn may_glide(&self, h: Real, precision: Real) -> bool {
        let time = self.since + h;
        self.cubic * (time * time) * time <= precision
    }

    /// Moves on by `h` in second order.
    #[inline]
    fn glide(&mut self, h: Real) {
        self.t += h;
        self.since += h;
        self.state.x = self.state.predicted(h);
        self.state.velocity += self.state.acceleration * h;
    }
}

impl<S: Shells + ?Sized, T: Texels + ?Sized> Field<'_, S, T> {
    /// Distance to the pattern and its radius at `x`, texels.
    #[inline]
    fn distance_and_radius(&self, prism: &Prism, x: Vec3) -> (Real, Real) {
        (
            self.map.distance(self.texels, prism.uv(x.x, x.y)),
            self.profile.radius(clamp(x.z, 0.0, 1.0)),
        )
    }

    /// The length in texels of a change of x.
    #[inline]
    fn texels(&self, prism: &Prism, change: Vec3) -> Real {
        let texels = prism.uv_change(change) * self.map.size;
        sqrt(texels.dot(texels))
    }

    /// A time within which the pattern cannot be met, if x keeps to its second
    /// order; where the prism is left before, not much longer than until then.
    ///
    /// The bounds are those of the straight march, with the texels per object
    /// unit and the growth of the radius at their largest within that time.
    #[inline]
    fn safe_time(
        &self,
        safe: &SafeStep,
        traveller: &Traveller,
        distance: Real,
        radius: Real,
        least: Real,
    ) -> Real {
        let state = &traveller.state;
        let gap = distance - radius;
        let near = gap * safe.lipschitz;
        let (far, flat) = if distance >= 1.5 {
            (
                gap - safe.margin,
                distance - self.profile.largest_radius() - safe.margin,
            )
        } else {
            (0.0, 0.0)
        };
        let speed = max(self.texels(&traveller.prism, state.velocity), 1e-18);
        let slowness = div(1.0, speed);
        let reach = max(max(near, far), flat);
        let h = max(state.until_outside(reach * slowness), least);
        // The speed at the end, at most, is (1 + faster) times that at the start.
        let texels = traveller.prism.uv_change(state.acceleration) * self.map.size;
        let faster = (abs(texels.x) + abs(texels.y)) * h * slowness;
        let slowness = if faster < 0.25 {
            slowness * (1.0 - faster)
        } else {
            div(slowness, 1.0 + faster)
        };
        let step = if self.profile.bevel > 0.0 {
            let down = max(state.velocity.z + abs(state.acceleration.z) * h, 0.0);
            let growth = self.profile.bevel * down * slowness;
            max(
                max(
                    div(near * slowness, 1.0 + safe.lipschitz * growth),
                    div(far * slowness, 1.0 + growth),
                ),
                flat * slowness,
            )
        } else {
            reach * slowness
        };
        max(min(step, h), least)
    }

    /// Runs `start`, in the phase `phase` of its search, to its end; `hull` is
    /// that of [`hull_of`], if it is sought.
    ///
    /// All phases share one loop with one place where the ray moves, so that a
    /// shader holds Newton's method once.
    #[inline]
    fn run(&self, start: Traveller, phase: u32, hull: (Real, Real)) -> Found {
        let mut at = start;
        let mut phase = phase;
        let home = at.index;
        let shell = self.shells.shell(home);
        let distance = abs(at.origin.x) + abs(at.origin.y) + abs(at.origin.z);
        let overlap = OVERLAP + ROUNDING * distance * shell.inverse_altitude;
        let safe = SafeStep::new(self.map.quantum);
        let third: Real = 1.0 / 3.0;

        // Where the ray goes next, and near which parameters that is.
        let mut t = 0.0;
        let mut guess = at.state.x;
        let mut rounds = ROUNDS;
        // Where times count from, and the time in the hull.
        let (mut enter, mut span) = hull;
        let mut in_shell = false;
        let mut over = false;
        let mut glides = false;
        if phase == AT_EYE {
            guess = Vec3::new(third, third, 0.5);
            rounds = FIRST_ROUNDS;
        } else if phase == SEEKING {
            // Times count from there, to save digits.
            at.origin += at.direction * enter;
            guess = Vec3::new(third, third, 0.0);
            rounds = FIRST_ROUNDS;
        }

        // While it is sought.
        let mut opening = NONE;
        let mut tries = 0;
        // While it is followed.
        let least = OVERLAP * shell.radius;
        let mut before = 0.0;
        let mut came_through = NONE;
        let mut steps = 0;
        let mut prisms = 0;
        let mut first = true;

        let mut met = false;
        let mut turns = 0;
        while !over {
            if glides {
                at.glide(t - at.t);
            } else {
                at.go(t, guess, rounds);
            }
            glides = false;
            rounds = ROUNDS;
            turns += 1;
            let mut h = 0.0;
            let mut moves = true;
            if phase == AT_EYE {
                in_shell = at.regular && at.state.inset() >= -overlap && at.state.x.z < FLOOR;
                if in_shell {
                    phase = FOLLOWING;
                } else {
                    (enter, span) = hull_of(shell, at.origin, at.direction);
                    over = span <= 0.0;
                    at.origin += at.direction * enter;
                    phase = SEEKING;
                    at.cubic = FAR;
                    moves = false;
                    t = 0.0;
                    guess = Vec3::new(third, third, 0.0);
                    rounds = FIRST_ROUNDS;
                }
            } else if !at.regular {
                over = true;
            } else if phase == SEEKING {
                let (c, v, a) = at.state.at_opening(opening);
                let off = if tries < TRIES { ARRIVED } else { THRESHOLD };
                let arrived = opening != NONE && abs(c) <= off;
                // Steps this short make no progress.
                let shortest = span * OVERLAP;
                // There by the second order, if it was passed within the hull.
                let there = if opening == NONE || arrived {
                    FAR
                } else if c > 0.0 {
                    -until_without(c, -v, a)
                } else {
                    until_opened(c, v, a, span - at.t)
                };
                let near = at.t + there > -shortest && there < FAR;
                if arrived && at.state.comes_in(opening, overlap) {
                    phase = FOLLOWING;
                    turns = 0;
                } else if opening != NONE && !arrived && tries < TRIES && near {
                    tries += 1;
                    h = there;
                } else {
                    let passed = if arrived { opening } else { NONE };
                    (h, opening) = at.state.next_opening(shell.neighbours, passed, span - at.t);
                    tries = 0;
                }
                over = phase == SEEKING
                    && (turns > OUTSIDE_STEPS
                        || at.t + h > span
                        || (opening == CAP && at.state.passes_by(h)));
                h = if abs(h) < shortest { shortest } else { h };
            }

            if !over && phase == FOLLOWING {
                let side = at.state.side_left(came_through);
                let x = at.state.x;
                let is_exact = at.since <= 0.0;
                let link = link_of(self.shells.shell(at.index).neighbours, side);
                if side != NONE && link != NO_NEIGHBOUR {
                    came_through = link & 3;
                    at.index = link >> 2;
                    let prism = Prism::new(self.shells.shell(at.index), self.depth);
                    at.origin += at.prism.anchor - prism.anchor;
                    at.prism = prism;
                    prisms += 1;
                    moves = false;
                    t = at.t;
                    guess = across(x, side, came_through);
                    at.since = 0.0;
                    // Parameters mean nothing behind the side.
                    before = t;
                    met = turns > self.linear_steps + CROSSINGS;
                    over = met;
                } else if side != NONE || (x.z < SIDE && at.state.velocity.z < 0.0) {
                    // Steps go a little too far: the floor may have come first.
                    met = is_exact && side != NONE && at.state.was_on_floor(side);
                    over = is_exact;
                } else if x.z >= FLOOR && at.state.velocity.z >= 0.0 {
                    met = is_exact;
                    over = is_exact;
                } else {
                    let (distance, radius) = self.distance_and_radius(&at.prism, x);
                    let tolerance = if first { 0.0 } else { TOLERANCE };
                    let near = distance - radius <= tolerance || steps >= self.linear_steps;
                    met = near && is_exact;
                    over = met;
                    if !near {
                        steps += 1;
                        first = false;
                        h = self.safe_time(&safe, &at, distance, radius, least);
                        before = at.t;
                        came_through = NONE;
                        glides = at.may_glide(h, self.precision + self.blur * (enter + at.t));
                    }
                }
            }
            if moves {
                t = at.t + h;
                guess = at.state.predicted(h);
            }
        }

        let mut t = at.t;
        let on_floor = met && at.state.x.z >= FLOOR;
        if on_floor {
            let (z, v, a) = (at.state.x.z, at.state.velocity.z, at.state.acceleration.z);
            // Back to where it was reached, or the little on.
            let back = rise(1.0 - z, v, -a);
            if back < FAR {
                t -= clamp(back, -least, max(t - before, 0.0));
            }
        }
        let mut bisections = if met && !first && !on_floor {
            self.binary_steps
        } else {
            0
        };
        while bisections > 0 {
            let middle = 0.5 * (before + t);
            let x = at.state.predicted(middle - at.t);
            let (distance, radius) = self.distance_and_radius(&at.prism, x);
            if distance - radius <= TOLERANCE {
                t = middle;
            } else {
                before = middle;
            }
            bisections -= 1;
        }
        let x = at.state.predicted(t - at.t);
        // Inside a column the eye sees no cap.
        let on_cap = first && !in_shell && x.z <= THRESHOLD;
        Found {
            march: March {
                end: if !met {
                    END_MISS
                } else if on_floor {
                    END_FLOOR
                } else if on_cap {
                    END_CAP
                } else {
                    END_SIDE
                },
                s: enter + t,
                uv: at.prism.uv(x.x, x.y),
                depth_fraction: clamp(x.z, 0.0, 1.0),
                steps,
            },
            prism: at.index,
            x,
            prisms: prisms + 1,
        }
    }
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
    let mut phase = AT_EYE;
    let mut hull = (0.0, 0.0);
    if !is_near(shell, origin) {
        phase = SEEKING;
        hull = hull_of(shell, origin, direction);
        if hull.1 <= 0.0 {
            return Found {
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
        }
    }
    let prism = Prism::new(shell, field.depth);
    let start = Traveller::new(home, prism, origin, direction, Vec3::ZERO);
    field.run(start, phase, hull)
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
    let start = Traveller::new(home, prism, origin, direction, x);
    field.run(start, FOLLOWING, (0.0, 0.0)).march.end == END_MISS
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::layout::{FORMAT_FLOAT, Object};
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
            precision: 1e-5,
            blur: 0.0,
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
