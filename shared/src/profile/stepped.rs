//! Terraces: n equal steps from the cap down to the chamfer's end, with
//! r(δ) = e + (b c / n) ⌊n δ / c⌋, and e + b c from δ = c on.

use super::{Growth, Profile, STEEP};
use crate::Real;
use crate::arithmetic::{div, floor, max, min};

/// The profile of the technique `stepped`; its parts are the terraces.
pub struct Stepped;

/// Returns how far the corner of step `step` is from a point: beside it, and above it
/// times b, texels. The larger one, where it is positive, is a distance to the solid.
#[inline]
fn corner(profile: &Profile, step: Real, distance: Real, depth_fraction: Real) -> (Real, Real) {
    let across = step * profile.part_width;
    let beside = distance - profile.extension - across;
    // Nothing is above the cap.
    let above = across - profile.bevel * depth_fraction;
    (beside, if step > 0.0 { above } else { beside })
}

/// Returns [`corner`] of the nearest step.
///
/// From step to step `beside` falls and `above` grows by the same amount, so that their
/// larger one is smallest next to where they are equal.
#[inline]
fn nearest(profile: &Profile, distance: Real, depth_fraction: Real) -> (Real, Real) {
    let last = profile.parts;
    let sum = distance - profile.extension + profile.bevel * depth_fraction;
    let equal = 0.5 * sum * profile.inverse_part_width;
    let before = floor(min(max(equal, 0.0), last));
    let a = corner(profile, before, distance, depth_fraction);
    let b = corner(profile, min(before + 1.0, last), distance, depth_fraction);
    if max(a.0, a.1) <= max(b.0, b.1) { a } else { b }
}

impl Growth for Stepped {
    const NUMBER: u32 = 2;

    #[inline]
    fn radius(profile: &Profile, depth_fraction: Real) -> Real {
        let step = if depth_fraction < profile.chamfer {
            let share = div(max(depth_fraction, 0.0), profile.chamfer);
            floor(profile.parts * share)
        } else {
            profile.parts
        };
        profile.extension + profile.part_width * step
    }

    /// Only terraces are asked for.
    #[inline]
    fn slope(_: &Profile, _: Real) -> Real {
        STEEP
    }

    #[inline]
    fn depth_of(profile: &Profile, distance: Real) -> Real {
        if distance <= profile.extension {
            0.0
        } else if distance <= profile.largest_radius() {
            let across = (distance - profile.extension) * profile.inverse_part_width;
            let step = -floor(-across);
            profile.chamfer * div(min(step, profile.parts), profile.parts)
        } else {
            1.0
        }
    }

    #[inline]
    fn gap(profile: &Profile, distance: Real, depth_fraction: Real) -> Real {
        let (beside, above) = nearest(profile, distance, depth_fraction);
        max(beside, above)
    }

    /// A terrace is hit from above, a step from beside.
    #[inline]
    fn is_growing(profile: &Profile, distance: Real, depth_fraction: Real) -> bool {
        let (beside, above) = nearest(profile, distance, depth_fraction);
        above > beside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Object;

    /// Four terraces of 5 texels, and as many steps of a tenth of the depth.
    fn profile() -> Profile {
        Profile::new(
            &Object {
                map_size: [100.0, 50.0],
                extension: 0.02,
                bevel: 0.5,
                chamfer: 0.4,
                profile: Stepped::NUMBER,
                parts: 4,
                ..Object::default()
            }
            .complete(),
        )
    }

    #[test]
    fn the_radius_grows_by_a_terrace_at_each_step() {
        let profile = profile();
        for (depth_fraction, radius) in [
            (0.0, 2.0),
            (0.09, 2.0),
            (0.11, 7.0),
            (0.19, 7.0),
            (0.21, 12.0),
            (0.39, 17.0),
            (0.4, 22.0),
            (1.0, 22.0),
        ] {
            assert_eq!(profile.radius(depth_fraction), radius, "{depth_fraction}");
        }
    }

    #[test]
    fn terraces_are_hit_from_above_and_steps_from_beside() {
        let profile = profile();
        // Just above the first terrace, in its middle: b δ is 5 texels there.
        assert!((profile.gap(4.5, 0.099) - 0.05).abs() < 1e-4);
        assert!(profile.is_growing(0.099, || 4.5));
        // Just beside the step from the first terrace up to the cap.
        assert!((profile.gap(2.05, 0.05) - 0.05).abs() < 1e-4);
        assert!(!profile.is_growing(0.05, || 2.05));
        // Beside the wall below the last terrace.
        assert!(!profile.is_growing(0.7, || 22.05));
    }
}
