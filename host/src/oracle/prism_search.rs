//! Searches a single prism in f64, for the oracle of arbitrary meshes: the ray is
//! followed through a hull of the whole prism, wherever it enters, independently
//! of the neighbours. It shares the prism's geometry with the renderers, but not
//! the search.

use glam::{DVec2, DVec3};
use relievo_shared_f64::FAR;
use relievo_shared_f64::arithmetic::{abs, clamp, div, max, min, sqrt};
use relievo_shared_f64::layout::PrismData;
use relievo_shared_f64::march::{END_CAP, END_FLOOR, END_MISS, END_SIDE, March, TOLERANCE};
use relievo_shared_f64::prism::{Jacobian, Prism, State, cap_hull, normal_hull};
use relievo_shared_f64::profile::Profile;
use relievo_shared_f64::shape_map::ShapeMap;
use relievo_shared_f64::stack::{Stack, Stacked};

/// Tolerance of the range of weights and δ: neighbouring prisms overlap by more
/// than rounding errors.
const OVERLAP: f64 = 1e-10;

/// Smallest δ of a point on the floor.
const FLOOR: f64 = 1.0 - 10.0 * OVERLAP;

/// Largest δ at which a ray that enters below the floor still hits it.
const BELOW: f64 = 1.0 + 1e-6;

/// A hit where the ray enters a prism is on the cap if it goes in and δ is at most this, also
/// if it enters through a side.
const CAP: f64 = 1e-3;

/// A ray's search of one prism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PrismHit {
    /// The end of the march; its `s` is t, the distance from the eye. The rest is
    /// undefined for a miss.
    pub march: March,
    /// (w1, w2, δ) at the hit.
    pub x: DVec3,
    /// Whether the ray was lost: the steps outside the prism ran out.
    pub lost: bool,
}

/// Maximum rounds of Newton's method: where the ray enters the hull, and from one
/// step to the next.
const FIRST_ROUNDS: u32 = 12;
const ROUNDS: u32 = 4;

/// Maximum number of steps outside the prism.
const OUTSIDE_STEPS: u32 = 96;

/// Maximum step outside, as a share of the path through the hull.
const STRIDE: f64 = 0.2;

/// Step where the prism folds or Newton's method fails, as a share of the path through
/// the hull: a prism does not fold inside.
const BLIND: f64 = 1.0 / 24.0;
/// Shortest step that is tried before such a step.
const LEAST_BLIND: f64 = 1e-4;

/// (w1, w2, δ) in the middle of a prism.
const CENTRE: DVec3 = DVec3::new(1.0 / 3.0, 1.0 / 3.0, 0.5);

/// Error bound of the second-order prediction of a weight or δ over the whole
/// prism, and relative to its acceleration.
const DOUBT: f64 = 0.05;

/// Bisections between the last point outside and the first one inside, if that is
/// further inside than [`DEEP`].
const ENTRY_BISECTIONS: u32 = 12;
const DEEP: f64 = 1e-4;

/// Bisections between the last point inside and the first one outside.
const FLOOR_BISECTIONS: u32 = 24;

/// Steps through the whole hull on the way out of the prism.
const STEPS: f64 = 256.0;
/// Bisections between the last point inside and the first one outside, where the ray came in.
const BISECTIONS: u32 = 30;
/// Longest step back to where the ray came in, as a share of the path through the hull.
const LONGEST_BACK: f64 = 1.0 / 16.0;

/// What a ray came through into a prism.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Opening {
    /// The side with this neighbour, as [`PrismData::neighbours`] has it.
    Side(u32),
    /// The floor, from below.
    Floor,
    /// The cap, a place where the prism folds, or nothing: the eye is in the prism.
    Other,
}

/// A point in a prism.
struct Place {
    /// (w1, w2, δ).
    x: DVec3,
    jacobian: Jacobian,
}

impl Place {
    /// Returns the distances from the sides, the cap and the floor, in weights or δ.
    fn insets(&self) -> [f64; 5] {
        let x = self.x;
        [1.0 - x.x - x.y, x.x, x.y, x.z, 1.0 - x.z]
    }
}

/// A prism with the hull in which it is searched.
pub(super) struct HulledPrism {
    prism: Prism,
    neighbours: [u32; 3],
    /// Points whose convex hull contains the prism, relative to its anchor.
    hull: [DVec3; 12],
    /// Slabs around the hull that clip a ray: along the facet, and along its sides.
    slabs: [Slab; 4],
}

impl HulledPrism {
    /// Makes the prism of `data`, `depth` object units deep.
    pub fn new(data: &PrismData, depth: f64) -> HulledPrism {
        let (cap, normal) = (cap_hull(data), normal_hull(data));
        let facet = DVec3::from(data.facet);
        let (b, c) = (cap[1], cap[2]);
        let hull = std::array::from_fn(|i| match i {
            0..6 => cap[i],
            _ => cap[i - 6] - normal[i - 6] * depth,
        });
        let axes = [facet, facet.cross(b), facet.cross(c - b), facet.cross(-c)];
        HulledPrism {
            prism: Prism::new(data, depth),
            neighbours: data.neighbours,
            hull,
            slabs: axes.map(|axis| Slab::around(&hull, axis)),
        }
    }

    /// Returns the corners of an axis-aligned bounding box, relative to the scene's
    /// origin.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let low = self.hull.into_iter().fold(self.hull[0], DVec3::min);
        let high = self.hull.into_iter().fold(self.hull[0], DVec3::max);
        (self.prism.anchor + low, self.prism.anchor + high)
    }

    /// Returns the distances at which the ray from `eye` along `direction` enters and leaves a
    /// tight hull of the prism; for a miss the first is not smaller.
    pub fn range(&self, eye: DVec3, direction: DVec3) -> (f64, f64) {
        let origin = eye - self.prism.anchor;
        let slabs = self.slabs.iter();
        slabs.fold((0.0, FAR), |range, slab| {
            slab.clip(range, origin, direction)
        })
    }

    /// Returns what the ray from `eye` along `direction` came through into this prism, in
    /// which it is at the distance `t`, and its distance there.
    pub fn opening(&self, eye: DVec3, direction: DVec3, t: f64) -> (Opening, f64) {
        let (enter, leave) = self.range(eye, direction);
        let Some(mut place) = self.inside(eye + direction * t, CENTRE, FIRST_ROUNDS) else {
            return (Opening::Other, t);
        };
        let span = leave - enter;
        // The predicted way back out of the prism, and half a step more.
        let back = |place: &Place| {
            let state = self.prism.motion(place.x, &place.jacobian, -direction);
            let way = state.until_outside().min(LONGEST_BACK * span);
            way + 0.5 * span / STEPS
        };
        let (mut inside, mut outside) = (t, t - back(&place));
        while let Some(found) = self.inside(eye + direction * outside, place.x, ROUNDS) {
            if outside < enter {
                return (Opening::Other, enter);
            }
            place = found;
            (inside, outside) = (outside, outside - back(&place));
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            if let Some(found) = self.inside(eye + direction * middle, place.x, ROUNDS) {
                place = found;
                inside = middle;
            } else {
                outside = middle;
            }
        }
        let insets = place.insets();
        let nearest = insets.iter().copied().fold(FAR, f64::min);
        let opening = match insets.iter().position(|inset| *inset == nearest) {
            Some(side @ 0..=2) => Opening::Side(self.neighbours[side]),
            Some(4) if place.jacobian.solve(direction).z < 0.0 => Opening::Floor,
            _ => Opening::Other,
        };
        (opening, inside)
    }

    /// Returns a distance at which the ray from `eye` along `direction` has just left this
    /// prism, in which it is at the distance `t`.
    pub fn beyond(&self, eye: DVec3, direction: DVec3, t: f64) -> f64 {
        let (enter, leave) = self.range(eye, direction);
        let step = (leave - enter) / STEPS;
        let mut beyond = t + step;
        let mut guess = CENTRE;
        while let Some(place) = self.inside(eye + direction * beyond, guess, FIRST_ROUNDS)
            && beyond < leave
        {
            guess = place.x;
            beyond += step;
        }
        beyond
    }

    /// Returns the place of `point` in the prism; `None` outside.
    fn inside(&self, point: DVec3, guess: DVec3, rounds: u32) -> Option<Place> {
        let (x, jacobian) = self.prism.solve(point - self.prism.anchor, guess, rounds);
        let place = Place { x, jacobian };
        let is_inside = jacobian.regular && place.insets().iter().all(|inset| *inset >= -1e-6);
        is_inside.then_some(place)
    }
}

/// The space between two parallel planes.
struct Slab {
    axis: DVec3,
    /// The least and the largest p · `axis` in it.
    low: f64,
    high: f64,
}

impl Slab {
    /// Returns the slab around `points`, with a margin for rounding.
    fn around(points: &[DVec3; 12], axis: DVec3) -> Slab {
        let along = points.iter().map(|point| point.dot(axis));
        let (low, high) = along.fold((FAR, -FAR), |(low, high), at| (low.min(at), high.max(at)));
        let margin = 1e-3 * (high - low);
        Slab {
            axis,
            low: low - margin,
            high: high + margin,
        }
    }

    /// Clips `range` to where the ray is in the slab.
    fn clip(&self, range: (f64, f64), origin: DVec3, direction: DVec3) -> (f64, f64) {
        let at = origin.dot(self.axis);
        let speed = direction.dot(self.axis);
        if abs(speed) * FAR <= self.high - self.low {
            // Parallel to the slab: always inside or always outside.
            return if at >= self.low && at <= self.high {
                range
            } else {
                (1.0, 0.0)
            };
        }
        let to_low = div(self.low - at, speed);
        let to_high = div(self.high - at, speed);
        (
            max(range.0, min(to_low, to_high)),
            min(range.1, max(to_low, to_high)),
        )
    }
}

/// Returns the smallest h > 0 where the quadratic c + v h + ½ a h² crosses zero
/// upward, for c ≤ 0, or c about 0 and v < 0; [`FAR`] if there is none.
fn rise(c: f64, v: f64, a: f64) -> f64 {
    let radicand = v * v - 2.0 * a * c;
    let root = sqrt(radicand);
    if radicand < 0.0 {
        FAR
    } else if v > 0.0 {
        div(-2.0 * c, v + root)
    } else if a > 0.0 {
        div(root - v, a)
    } else {
        FAR
    }
}

/// Returns the time until c ≥ 0 holds: 0 if it does, [`FAR`] if it clearly does not
/// within the time `rest`.
///
/// Third-order terms are ignored, so a near miss is tested again after `stride`,
/// as is anything further away.
fn until_within(c: f64, v: f64, a: f64, rest: f64, stride: f64) -> f64 {
    if c >= OVERLAP || (c >= -OVERLAP && v >= 0.0) {
        return 0.0;
    }
    let end = c + (v + 0.5 * a * rest) * rest;
    // The maximum, if it lies within `rest`.
    let turns = v > 0.0 && v + a * rest < 0.0;
    let highest = if turns {
        c - 0.5 * v * div(v, a)
    } else {
        max(c, end)
    };
    let doubt = DOUBT * (1.0 + abs(a) * rest * rest);
    if highest < -doubt {
        stride
    } else {
        min(rise(min(c, 0.0), v, a), stride)
    }
}

/// Returns the time until c ≥ 0 no longer holds.
fn until_without(c: f64, v: f64, a: f64) -> f64 {
    rise(-max(c, 0.0), -v, -a)
}

/// Extends [`State`] for this search.
trait Motion {
    /// Returns the time until the weights and δ are inside the sides and the cap;
    /// `rest` is the time left, `stride` the maximum except for [`FAR`].
    fn until_inside(&self, rest: f64, stride: f64) -> f64;
    /// Returns the distance to the nearest of the sides and the cap, positive inside.
    fn inset(&self) -> f64;
    /// Returns the time until a side, the cap or the floor is reached from inside.
    fn until_outside(&self) -> f64;
    /// Predicts x after the time `h`, to second order.
    fn predicted(&self, h: f64) -> DVec3;
}

impl Motion for State {
    fn until_inside(&self, rest: f64, stride: f64) -> f64 {
        let (x, v, a) = (self.x, self.velocity, self.acceleration);
        let w0 = until_within(1.0 - x.x - x.y, -v.x - v.y, -a.x - a.y, rest, stride);
        let w1 = until_within(x.x, v.x, a.x, rest, stride);
        let w2 = until_within(x.y, v.y, a.y, rest, stride);
        let cap = until_within(x.z, v.z, a.z, rest, stride);
        max(max(w0, w1), max(w2, cap))
    }

    fn inset(&self) -> f64 {
        min(
            min(1.0 - self.x.x - self.x.y, self.x.x),
            min(self.x.y, self.x.z),
        )
    }

    fn until_outside(&self) -> f64 {
        let (x, v, a) = (self.x, self.velocity, self.acceleration);
        let w0 = until_without(1.0 - x.x - x.y, -v.x - v.y, -a.x - a.y);
        let w1 = until_without(x.x, v.x, a.x);
        let w2 = until_without(x.y, v.y, a.y);
        let depth = min(
            until_without(x.z, v.z, a.z),
            until_without(1.0 - x.z, -v.z, -a.z),
        );
        min(min(w0, w1), min(w2, depth))
    }

    fn predicted(&self, h: f64) -> DVec3 {
        self.x + (self.velocity + self.acceleration * (0.5 * h)) * h
    }
}

/// The ray, the prism and the pattern of one search.
struct PrismRay<'a> {
    prism: &'a Prism,
    profile: &'a Profile,
    map: &'a ShapeMap,
    texels: &'a [u32],
    is_stack: bool,
    /// Where the ray enters the hull, relative to the anchor; times start there.
    origin: DVec3,
    direction: DVec3,
}

impl PrismRay<'_> {
    /// Solves for the parameters at `t`, starting with `guess`; false if the prism
    /// folds there.
    fn at(&self, t: f64, guess: DVec3, rounds: u32) -> (State, bool) {
        let target = self.origin + self.direction * t;
        let (x, jacobian) = self.prism.solve(target, guess, rounds);
        let state = self.prism.motion(x, &jacobian, self.direction);
        (state, jacobian.regular)
    }

    /// Finds the first point inside between the times `outside` and `inside`, where
    /// the ray has the state `state`; returns its state and time.
    fn entry(&self, state: State, outside: f64, inside: f64) -> (State, f64) {
        let (mut state, mut outside, mut inside) = (state, outside, inside);
        let mut rest = ENTRY_BISECTIONS;
        while rest > 0 {
            let middle = 0.5 * (outside + inside);
            let (candidate, regular) = self.at(middle, state.predicted(middle - inside), ROUNDS);
            if regular && candidate.inset() >= -OVERLAP {
                state = candidate;
                inside = middle;
            } else {
                outside = middle;
            }
            rest -= 1;
        }
        (state, inside)
    }

    /// Finds the floor between the time `inside`, where the ray has the state `state`, and
    /// the time `outside`, where it has left the prism: returns its state and time there if
    /// it is reached before a side. The second-order prediction may go past both.
    fn floor_before(&self, state: State, inside: f64, outside: f64) -> Option<(State, f64)> {
        let (mut state, mut inside, mut outside) = (state, inside, outside);
        let mut found = None;
        for _ in 0..FLOOR_BISECTIONS {
            let middle = 0.5 * (inside + outside);
            let (candidate, regular) = self.at(middle, state.predicted(middle - inside), ROUNDS);
            let is_within = regular && candidate.inset() >= -OVERLAP;
            if is_within && candidate.x.z < FLOOR {
                (state, inside) = (candidate, middle);
            } else {
                outside = middle;
                found = is_within.then_some((candidate, middle));
            }
        }
        found
    }

    /// Returns the distances to the pattern and to the solid at `x`, texels.
    fn distance_and_gap(&self, x: DVec3) -> (f64, f64) {
        let (uv, depth_fraction) = (self.prism.uv(x.x, x.y), clamp(x.z, 0.0, 1.0));
        if self.is_stack {
            let stack = Stack::new(self.profile, self.map);
            return stack.gaps(&Stacked(self.texels), uv, depth_fraction);
        }
        let distance = self.map.distance(self.texels, uv);
        (distance, self.profile.gap(distance, depth_fraction))
    }

    /// Returns a time within which the pattern cannot be hit, if x follows its
    /// second-order prediction; at most `longest`.
    ///
    /// The bounds are those of the straight march, with the maxima within `longest`
    /// of the texels per object unit and of the growth of the radius.
    fn safe_time(&self, state: &State, distance: f64, gap: f64, longest: f64) -> f64 {
        let steepest = self.map.safe.steepest;
        let near = div(gap, steepest);
        let (far, flat) = if distance >= 1.5 {
            let margin = self.map.safe.margin;
            (
                gap - margin,
                distance - self.profile.largest_radius() - margin,
            )
        } else {
            (0.0, 0.0)
        };
        let speed = self.texels(state.velocity);
        let acceleration = self.texels(state.acceleration);
        let reach = max(max(near, far), flat);
        let h = min(longest, div(reach, max(speed, 1e-18)));
        let speed = speed + acceleration * h;
        let down = max(state.velocity.z + abs(state.acceleration.z) * h, 0.0);
        let growth = self.profile.largest_slope() * down;
        let step = max(
            max(
                div(gap, max(steepest * speed + growth, 1e-18)),
                div(far, max(speed + growth, 1e-18)),
            ),
            div(flat, max(speed, 1e-18)),
        );
        min(step, h)
    }

    /// Returns the length of a change of x, texels.
    fn texels(&self, change: DVec3) -> f64 {
        let texels = self.prism.uv_change(change) * self.map.size;
        sqrt(texels.dot(texels))
    }
}

/// Searches `prism` for the first hit on the ray from `eye` along the unit
/// vector `direction`.
///
/// The floor is solid below: a ray that enters through a side at δ > 1 and goes
/// down hits the floor there. A ray that comes up from below the floor hits
/// nothing in this prism, since only front faces are visible.
#[allow(clippy::too_many_arguments)] // The parameters of the march, and the ray.
pub(super) fn search(
    hulled: &HulledPrism,
    profile: &Profile,
    map: &ShapeMap,
    texels: &[u32],
    is_stack: bool,
    eye: DVec3,
    direction: DVec3,
    linear_steps: u32,
    binary_steps: u32,
) -> PrismHit {
    let mut found = PrismHit {
        march: March {
            end: END_MISS,
            s: 0.0,
            uv: DVec2::ZERO,
            depth_fraction: 0.0,
            steps: 0,
        },
        x: DVec3::ZERO,
        lost: false,
    };
    let prism = &hulled.prism;
    let from_eye = eye - prism.anchor;
    let (enter, leave) = hulled.range(eye, direction);
    if enter >= leave {
        return found;
    }
    let span = leave - enter;
    let search = PrismRay {
        prism,
        profile,
        map,
        texels,
        is_stack,
        origin: from_eye + direction * enter,
        direction,
    };
    let (mut state, mut regular) = search.at(0.0, CENTRE, FIRST_ROUNDS);
    let mut t = 0.0;
    // The point before, and its state.
    let mut before = 0.0;
    let mut last = state;
    // Whether that was outside, and the ray was not lost there.
    let mut may_go_back = false;
    let mut outside_steps = 0;
    let mut steps = 0;
    // Whether the last point was inside, and brackets a hit.
    let mut inside = false;
    let mut met = false;
    let mut first = false;
    let mut over = false;
    // Steps this short make no progress.
    let least = span * OVERLAP;
    while !over {
        let mut h = 0.0;
        let wait = if regular {
            state.until_inside(span - t, STRIDE * span)
        } else {
            FAR
        };
        let floor = if inside && wait > 0.0 {
            search.floor_before(last, before, t)
        } else {
            None
        };
        if let Some(floor) = floor {
            (state, t) = floor;
            met = true;
            over = true;
        } else if wait > 0.0 {
            inside = false;
            outside_steps += 1;
            h = if regular {
                max(wait, least)
            } else {
                BLIND * span
            };
            found.lost = outside_steps > OUTSIDE_STEPS;
            over = found.lost || t + h > span;
        } else {
            first = !inside;
            inside = true;
            if first && t > 0.0 && state.inset() > DEEP {
                (state, t) = search.entry(state, before, t);
            }
            if state.x.z >= FLOOR {
                // Entering below the floor is a hit only where rounding missed
                // the floor between two prisms, and never from below.
                met = !first || (state.velocity.z >= 0.0 && state.x.z <= BELOW);
                over = true;
            } else {
                let (distance, gap) = search.distance_and_gap(state.x);
                let tolerance = if first { 0.0 } else { TOLERANCE };
                met = gap <= tolerance || steps >= linear_steps;
                over = met;
                if !met {
                    steps += 1;
                    let longest = max(min(state.until_outside(), span - t), least);
                    h = search.safe_time(&state, distance, gap, longest);
                    over = t >= span;
                }
            }
        }
        if !over && regular {
            (last, before) = (state, t);
            may_go_back = !inside;
            t = min(t + h, span);
            (state, regular) = search.at(t, state.predicted(h), ROUNDS);
        } else if !over && may_go_back && t - before > LEAST_BLIND * span {
            // The step was too long: the ray may have been inside in between.
            t = 0.5 * (before + t);
            (state, regular) = search.at(t, last.predicted(t - before), ROUNDS);
        } else if !over {
            may_go_back = false;
            t = min(t + h, span);
            (state, regular) = search.at(t, CENTRE, FIRST_ROUNDS);
        }
    }
    found.march.steps = steps;
    if !met {
        return found;
    }

    let in_eye = first && enter <= 0.0 && t <= 0.0;
    let goes_in = state.velocity.z > 0.0;
    let at_cap = first && !in_eye && goes_in && state.x.z <= CAP;
    let mut bisections = if first { 0 } else { binary_steps };
    while bisections > 0 {
        let middle = 0.5 * (before + t);
        let (candidate, regular) = search.at(middle, state.predicted(middle - t), ROUNDS);
        let (_, gap) = search.distance_and_gap(candidate.x);
        if regular && (gap <= TOLERANCE || candidate.x.z >= FLOOR) {
            t = middle;
            state = candidate;
        } else {
            before = middle;
        }
        bisections -= 1;
    }
    let x = state.x;
    found.x = x;
    found.march.s = enter + t;
    found.march.uv = prism.uv(x.x, x.y);
    found.march.depth_fraction = clamp(x.z, 0.0, 1.0);
    found.march.end = if x.z >= FLOOR {
        END_FLOOR
    } else if at_cap {
        END_CAP
    } else {
        END_SIDE
    };
    found
}
