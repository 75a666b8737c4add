//! The search for the first hit along a path, by steps that cannot skip the solid
//! (section 4): one march for every path and every profile.

use crate::arithmetic::{clamp, div, max, min, sqrt};
use crate::path::Path;
use crate::profile::Profile;
use crate::shape_map::{SafeStep, ShapeMap, Texels};
use crate::stack::Stack;
use crate::{Real, Vec2};

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct March {
    /// One of the `END_` constants.
    pub end: u32,
    /// The path's parameter there, object units.
    pub s: Real,
    /// Texture coordinates there, repeats.
    pub uv: Vec2,
    /// δ there, 0…1.
    pub depth_fraction: Real,
    /// Steps of the linear search.
    pub steps: u32,
}

/// The ray left the shell through the cap: a silhouette.
pub const END_MISS: u32 = 0;
/// The ray was on the pattern where it entered.
pub const END_CAP: u32 = 1;
/// The ray hit the side of the solid.
pub const END_SIDE: u32 = 2;
/// The ray reached δ = 1.
pub const END_FLOOR: u32 = 3;

/// A point within this distance of the solid counts as on it, texels.
pub const TOLERANCE: Real = 1.0 / 128.0;

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Maximum number of steps of the linear search.
    pub linear_steps: u32,
    /// Maximum number of bisections after it.
    pub binary_steps: u32,
    /// Largest distance before the solid at which the search may end, texels; at least
    /// [`TOLERANCE`] is used.
    pub slack: Real,
}

/// Step lengths that cannot skip the solid, for one ray.
///
/// Per unit of s, the distance f falls by at most √2 ℓ and the solid comes nearer by at
/// most k, its largest slope times dδ/ds. The gap g closes after g / (√2 ℓ + k) at the
/// earliest. The gap to the largest radius, which does not grow, closes by ℓ alone.
///
/// ℓ is the larger of its values at both ends. Where it is less from s on, steps are
/// longer by the factor `ease` + s `gain`: the norm is convex, so that ℓ lies below
/// the line between its ends, and 1 / ℓ above its tangent.
struct StepLength {
    safe: SafeStep,
    ease: Real,
    gain: Real,
    near: Real,
    far: Real,
    flat: Real,
    largest_radius: Real,
    /// Whether `ease` is 1 and `gain` is 0.
    is_even: bool,
    /// Whether `far` differs from `flat`.
    grows: bool,
}

impl StepLength {
    #[inline]
    fn after(&self, s: Real, distance: Real, gap: Real) -> Real {
        let near = gap * self.near;
        let far = (gap - self.safe.margin) * self.far;
        let flat = if self.grows {
            (distance - self.largest_radius - self.safe.margin) * self.flat
        } else {
            far
        };
        // The second bound holds from 1.5 texels on.
        let step = if distance >= 1.5 {
            max(near, max(far, flat))
        } else {
            near
        };
        if self.is_even {
            step
        } else {
            step * (self.ease + self.gain * s)
        }
    }
}

/// Returns the distances to the pattern and to the solid at `s` of `path`, texels.
#[inline]
fn gaps_at<P: Path, T: Texels + ?Sized>(
    path: &P,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    s: Real,
) -> (Real, Real) {
    let uv = path.uv(s);
    if T::IS_STACK {
        let depth_fraction = clamp(path.depth_fraction(s), 0.0, 1.0);
        return Stack::new(profile, map).gaps(texels, uv, depth_fraction);
    }
    let distance = map.distance(texels, uv);
    let gap = if profile.grows {
        profile.gap(distance, clamp(path.depth_fraction(s), 0.0, 1.0))
    } else {
        profile.upright_gap(distance)
    };
    (distance, gap)
}

/// End of a linear search, before it is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// One of the `END_` constants.
    pub end: u32,
    /// The path's parameter there, object units.
    pub s: Real,
    /// The last s before, where the solid was not reached yet, object units.
    pub before: Real,
    /// Steps of the linear search.
    pub steps: u32,
    /// Intervals of s shorter than this are not refined, object units.
    pub least: Real,
}

/// Marches along `path` until the pattern grown by `profile` is reached. If the
/// linear steps of `limits` run out inside the shell, the point reached counts as a
/// hit (section 4).
#[inline]
pub fn advance<P: Path, T: Texels + ?Sized>(
    path: &P,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    limits: &Limits,
) -> Stop {
    let start = path.start();
    let end = path.end();
    let (first, last) = path.uv_rates();
    let (first, last) = (first * map.size, last * map.size);
    let first = sqrt(first.dot(first));
    let last = if path.is_even() {
        first
    } else {
        sqrt(last.dot(last))
    };
    let speed = if path.is_even() {
        first
    } else {
        max(first, last)
    };
    let growth = if profile.grows {
        profile.largest_slope() * path.depth_rate()
    } else {
        0.0
    };
    let safe = map.safe;
    // From s on, ℓ is at most the mean of its values on the line at s and at the
    // end if it grows, and its value at s if it falls.
    let change = if path.is_even() {
        0.0
    } else {
        div(last - first, max(end * (speed + growth), 1e-18))
    };
    // Reciprocals stay near 1e18 and below, so that a step is never an infinity.
    let near = div(1.0, max(safe.steepest * speed + growth, 1e-18));
    let flat = if profile.grows {
        div(1.0, max(speed, 1e-18))
    } else {
        near * safe.steepest
    };
    let step_length = StepLength {
        ease: if change > 0.0 {
            1.0 + 0.5 * change * end
        } else {
            1.0
        },
        gain: if change > 0.0 { -0.5 * change } else { -change },
        near,
        far: if profile.grows {
            div(1.0, max(speed + growth, 1e-18))
        } else {
            flat
        },
        flat,
        is_even: path.is_even(),
        grows: profile.grows,
        largest_radius: profile.largest_radius(),
        safe,
    };

    let tolerance = max(TOLERANCE, limits.slack);
    let mut s = start;
    let mut before = s;
    let mut steps = 0;
    let mut met = false;
    let mut left = false;
    let mut gap = 0.0;
    while !met && !left {
        let distance;
        (distance, gap) = gaps_at(path, profile, map, texels, s);
        // Where the path starts, only the solid itself counts.
        let near = if steps == 0 { 0.0 } else { tolerance };
        met = gap <= near || steps >= limits.linear_steps;
        left = !met && s >= end;
        if !met && !left {
            before = s;
            s += step_length.after(s, distance, gap);
            steps += 1;
            left = s >= end;
        }
    }
    Stop {
        end: if left {
            if path.ends_on_floor() {
                END_FLOOR
            } else {
                END_MISS
            }
        } else if steps == 0 && gap <= 0.0 && start <= 0.0 {
            END_CAP
        } else {
            END_SIDE
        },
        s: if left { end } else { s },
        before,
        steps,
        least: limits.slack * flat,
    }
}

/// Refines a hit on the side of the solid by bisections; returns its s.
#[inline]
pub fn refine<P: Path, T: Texels + ?Sized>(
    path: &P,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    stop: &Stop,
    limits: &Limits,
) -> Real {
    let tolerance = max(TOLERANCE, limits.slack);
    let mut s = stop.s;
    let mut before = stop.before;
    let mut bisections = limits.binary_steps;
    while bisections > 0 && before + stop.least < s {
        let middle = 0.5 * (before + s);
        let (_, gap) = gaps_at(path, profile, map, texels, middle);
        if gap <= tolerance {
            s = middle;
        } else {
            before = middle;
        }
        bisections -= 1;
    }
    min(s, path.end())
}

/// Marches along `path` to the first hit: [`advance`], then [`refine`].
#[inline]
pub fn march<P: Path, T: Texels + ?Sized>(
    path: &P,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    limits: &Limits,
) -> March {
    let stop = advance(path, profile, map, texels, limits);
    let s = if stop.end == END_SIDE {
        refine(path, profile, map, texels, &stop, limits)
    } else {
        stop.s
    };
    March {
        end: stop.end,
        s,
        uv: path.uv(s),
        depth_fraction: if stop.end == END_FLOOR {
            1.0
        } else if stop.end == END_MISS {
            0.0
        } else {
            clamp(path.depth_fraction(s), 0.0, 1.0)
        },
        steps: stop.steps,
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // References are computed in f64, by the standard library.
mod tests;
