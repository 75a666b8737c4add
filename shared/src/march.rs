//! The search for the first hit: one march for every path and every profile.

use crate::Real;
use crate::arithmetic::{clamp, div, max, min, sqrt};
use crate::path::Path;
use crate::profile::Profile;
use crate::shape_map::{SafeStep, ShapeMap, Texels};

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct March {
    /// One of the `END_` constants.
    pub end: u32,
    /// Where, as the path counts.
    pub s: Real,
    /// δ there, 0…1.
    pub depth_fraction: Real,
    /// Steps of the linear search.
    pub steps: u32,
}

/// The ray left the shell through the cap: silhouette.
pub const END_MISS: u32 = 0;
/// The ray was on the pattern where it entered.
pub const END_CAP: u32 = 1;
/// The ray met the side of the solid.
pub const END_SIDE: u32 = 2;
/// The ray reached δ = 1.
pub const END_FLOOR: u32 = 3;

/// A point this near to the solid, in texels, lies on it.
pub const TOLERANCE: Real = 1.0 / 128.0;

/// Step lengths that cannot skip the solid, for one ray.
///
/// Along the ray the distance f sinks by at most √2 ℓ per unit of s and the
/// radius grows by at most k = b · dδ/ds: with the gap f − r shared between
/// both, s may grow by gap / (√2 ℓ + k). The largest radius does not grow, so
/// the gap to it may be used up by ℓ alone.
struct StepLength {
    safe: SafeStep,
    near: Real,
    far: Real,
    flat: Real,
    largest_radius: Real,
}

impl StepLength {
    #[inline]
    fn after(&self, distance: Real, radius: Real) -> Real {
        let gap = distance - radius;
        let near = gap * self.near;
        let far = (gap - self.safe.margin) * self.far;
        let flat = (distance - self.largest_radius - self.safe.margin) * self.flat;
        // The second bound holds from 1.5 texels on.
        if distance >= 1.5 {
            max(near, max(far, flat))
        } else {
            near
        }
    }
}

/// Marches along `path` until the pattern grown by `profile` is met.
///
/// A hit is bracketed by the last two points and refined by `binary_steps`
/// bisections. If `linear_steps` run out inside the shell, the point reached
/// counts as a hit (section 4).
#[inline]
pub fn march<P: Path, T: Texels + ?Sized>(
    path: &P,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    linear_steps: u32,
    binary_steps: u32,
) -> March {
    let start = path.start();
    let end = path.end();
    let rate = path.uv_rate() * map.size;
    let speed = sqrt(rate.dot(rate));
    let growth = profile.bevel * path.depth_rate();
    let safe = SafeStep::new(map.step);
    // Reciprocals stay below 1e18, so that a step is never an infinity.
    let step_length = StepLength {
        near: div(safe.lipschitz, max(speed + safe.lipschitz * growth, 1e-18)),
        far: div(1.0, max(speed + growth, 1e-18)),
        flat: div(1.0, max(speed, 1e-18)),
        largest_radius: profile.largest_radius(),
        safe,
    };

    let mut s = start;
    let mut depth_fraction = clamp(path.depth_fraction(s), 0.0, 1.0);
    let mut distance = map.distance(texels, path.uv(s));
    let mut radius = profile.radius(depth_fraction);
    if distance <= radius {
        return March {
            end: if start > 0.0 { END_SIDE } else { END_CAP },
            s,
            depth_fraction,
            steps: 0,
        };
    }

    let mut before = s;
    let mut steps = 0;
    let mut met = false;
    let mut left = s >= end;
    while steps < linear_steps && !met && !left {
        before = s;
        s += step_length.after(distance, radius);
        steps += 1;
        if s >= end {
            left = true;
        } else {
            depth_fraction = clamp(path.depth_fraction(s), 0.0, 1.0);
            distance = map.distance(texels, path.uv(s));
            radius = profile.radius(depth_fraction);
            met = distance - radius <= TOLERANCE;
        }
    }
    if left {
        let on_floor = path.ends_on_floor();
        return March {
            end: if on_floor { END_FLOOR } else { END_MISS },
            s: end,
            depth_fraction: if on_floor { 1.0 } else { 0.0 },
            steps,
        };
    }

    let mut bisections = if met { binary_steps } else { 0 };
    while bisections > 0 {
        let middle = 0.5 * (before + s);
        let middle_depth = clamp(path.depth_fraction(middle), 0.0, 1.0);
        let gap = map.distance(texels, path.uv(middle)) - profile.radius(middle_depth);
        if gap <= TOLERANCE {
            s = middle;
            depth_fraction = middle_depth;
        } else {
            before = middle;
        }
        bisections -= 1;
    }
    March {
        end: END_SIDE,
        s: min(s, end),
        depth_fraction,
        steps,
    }
}
