//! Relief mapping, the baseline of the paper's comparison: equal steps along the ray
//! through a depth map of the same pattern, then bisection (Policarpo, Oliveira, Comba,
//! 2005). On a bent path it is curved relief mapping (Oliveira and Policarpo, 2005).
//! Its steps may skip features that are thinner than a step.
//!
//! As published, every pixel takes every step: the linear search remembers the first
//! point below the map and continues; the bisection always follows.

use super::over_triangle::{OverTriangle, TriangleEntry, found_on};
use super::{Found, Ray};
use crate::Real;
use crate::arithmetic::{clamp, div};
use crate::layout::{TIER_FAST, Triangle};
use crate::march::{END_CAP, END_FLOOR, END_MISS, END_SIDE, March};
use crate::path::Path;
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};

/// Relief mapping, on the paths of the planar and the fast tier.
#[derive(Clone, Copy, Debug)]
pub struct Relief;

impl OverTriangle for Relief {
    #[inline]
    fn is_curved(ray: &Ray<'_>) -> bool {
        ray.object.tier == TIER_FAST
    }

    #[inline]
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        _: &Triangle,
        texels: &T,
        entry: &TriangleEntry,
    ) -> Found<Real> {
        let object = ray.object;
        let found = search(
            &entry.path,
            &Profile::new(object),
            &ShapeMap::new(object),
            texels,
            object.linear_steps,
            object.binary_steps,
        );
        found_on(entry, found)
    }
}

/// Hits from this δ on are on the floor.
const FLOOR: Real = 0.999;

/// Steps along `path` in `linear_steps` equal parts until it is below the depth map,
/// then bisects `binary_steps` times.
#[inline]
pub fn search<P: Path, T: Texels + ?Sized>(
    path: &P,
    profile: &Profile,
    map: &ShapeMap,
    texels: &T,
    linear_steps: u32,
    binary_steps: u32,
) -> March {
    let start = path.start();
    let end = path.end();
    let step = div(end - start, linear_steps as i32 as Real);
    let below = |s: Real| {
        let depth = map.relief_depth(texels, profile, path.uv(s));
        clamp(path.depth_fraction(s), 0.0, 1.0) >= depth
    };
    let at_start = below(start);
    let mut met = at_start;
    let mut before = start;
    let mut s = start;
    let mut steps = 0;
    while steps < linear_steps {
        steps += 1;
        let next = start + step * (steps as i32 as Real);
        // The last point of a path that leaves through the cap lies on the cap.
        let counts = (steps < linear_steps || path.ends_on_floor()) && next <= end;
        if below(next) && counts && !met {
            met = true;
            s = next;
        }
        if !met {
            before = next;
        }
    }
    if !met {
        let on_floor = path.ends_on_floor();
        return March {
            end: if on_floor { END_FLOOR } else { END_MISS },
            s: end,
            uv: path.uv(end),
            depth_fraction: if on_floor { 1.0 } else { 0.0 },
            steps,
        };
    }
    let mut bisections = binary_steps;
    while bisections > 0 {
        let middle = 0.5 * (before + s);
        if below(middle) {
            s = middle;
        } else {
            before = middle;
        }
        bisections -= 1;
    }
    let depth_fraction = clamp(path.depth_fraction(s), 0.0, 1.0);
    March {
        end: if at_start && start <= 0.0 {
            END_CAP
        } else if depth_fraction >= FLOOR {
            END_FLOOR
        } else {
            END_SIDE
        },
        s,
        uv: path.uv(s),
        depth_fraction,
        steps,
    }
}
