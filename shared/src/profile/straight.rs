//! Growth at a constant rate: r(δ) = e + b · min(δ, c) (equations (4), (6) and (7)).

use super::{Growth, Profile};
use crate::Real;
use crate::arithmetic::min;

/// The profile of the paper's techniques.
pub struct Straight;

impl Growth for Straight {
    const NUMBER: u32 = 0;

    #[inline]
    fn radius(profile: &Profile, depth_fraction: Real) -> Real {
        profile.extension + profile.bevel * min(depth_fraction, profile.chamfer)
    }

    #[inline]
    fn slope(profile: &Profile, _: Real) -> Real {
        profile.bevel
    }

    #[inline]
    fn depth_of(profile: &Profile, distance: Real) -> Real {
        if distance <= profile.extension {
            0.0
        } else if distance <= profile.largest_radius() {
            (distance - profile.extension) * profile.inverse_bevel
        } else {
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::layout::Object;
    use crate::profile::Profile;

    fn profile(width: f32, extension: f32, bevel: f32, chamfer: f32) -> Profile {
        Profile::new(
            &Object {
                map_size: [width, 50.0],
                extension,
                bevel,
                chamfer,
                ..Object::default()
            }
            .complete(),
        )
    }

    #[test]
    fn the_four_extrusions() {
        assert_eq!(profile(100.0, 0.0, 0.0, 1.0).radius(0.7), 0.0);
        assert_eq!(profile(100.0, 0.25, 0.0, 1.0).radius(0.7), 25.0);
        assert_eq!(profile(100.0, 0.0, 0.5, 1.0).radius(0.5), 25.0);
        assert_eq!(profile(100.0, 0.25, 0.5, 0.5).radius(0.75), 50.0);
        assert_eq!(profile(100.0, 0.25, 0.5, 0.5).largest_radius(), 50.0);
    }

    #[test]
    fn the_radius_grows_down_to_the_chamfer_and_no_further() {
        let profile = profile(8.0, -0.375, 1.0, 0.25);
        assert_eq!(profile.radius(0.0), -3.0);
        assert_eq!(profile.radius(0.125), -2.0);
        for depth_fraction in [0.25, 0.5, 1.0] {
            assert_eq!(profile.radius(depth_fraction), -1.0);
        }
        assert_eq!(profile.largest_radius(), -1.0);
        // The other way round: solid from the top, from some depth on, never.
        assert_eq!(profile.depth_of(-3.5), 0.0);
        assert_eq!(profile.depth_of(-2.0), 0.125);
        assert_eq!(profile.depth_of(-0.5), 1.0);
    }

    #[test]
    fn without_a_bevel_a_point_is_solid_from_the_top_or_never() {
        let profile = profile(8.0, 0.25, 0.0, 1.0);
        assert_eq!(profile.depth_of(2.0), 0.0);
        assert_eq!(profile.depth_of(2.1), 1.0);
    }
}
