//! A fillet at the cap's edge: r(δ) = e + b √(x (2c − x)) with x = min(δ, c), a quarter
//! of an ellipse that is b c wide and c deep: a fillet of radius b c, measured along the
//! surface. It is round where b widths of the pattern are as long as the shell is deep.

use super::{Growth, Profile, STEEP};
use crate::Real;
use crate::arithmetic::{div, max, min, sqrt};

/// The profile of the technique `rounded`.
pub struct Rounded;

/// Returns √(x (2c − x)): the growth, in units of b.
#[inline]
fn growth(profile: &Profile, depth_fraction: Real) -> Real {
    let x = min(max(depth_fraction, 0.0), profile.chamfer);
    sqrt(x * (2.0 * profile.chamfer - x))
}

impl Growth for Rounded {
    const NUMBER: u32 = 1;

    #[inline]
    fn radius(profile: &Profile, depth_fraction: Real) -> Real {
        profile.extension + profile.bevel * growth(profile, depth_fraction)
    }

    /// b (c − δ) / √(δ (2c − δ)), which is infinite at the cap.
    #[inline]
    fn slope(profile: &Profile, depth_fraction: Real) -> Real {
        let fall = max(profile.chamfer - depth_fraction, 0.0);
        let across = growth(profile, depth_fraction);
        min(profile.bevel * div(fall, max(across, 1e-9)), STEEP)
    }

    #[inline]
    fn depth_of(profile: &Profile, distance: Real) -> Real {
        if distance <= profile.extension {
            0.0
        } else if distance <= profile.largest_radius() {
            let across = (distance - profile.extension) * profile.inverse_bevel;
            let chamfer = profile.chamfer;
            chamfer - sqrt(max(chamfer * chamfer - across * across, 0.0))
        } else {
            1.0
        }
    }

    /// The distance to the ellipse in the plane of distance and b δ, where it is a
    /// circle around (e, b c): r itself changes too fast near the cap.
    #[inline]
    fn gap(profile: &Profile, distance: Real, depth_fraction: Real) -> Real {
        let across = max(distance - profile.extension, 0.0);
        let above = profile.bevel * max(profile.chamfer - depth_fraction, 0.0);
        sqrt(across * across + above * above) - profile.bevel * profile.chamfer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Object;

    fn profile() -> Profile {
        Profile::new(
            &Object {
                map_size: [100.0, 50.0],
                extension: 0.02,
                bevel: 0.5,
                chamfer: 0.4,
                profile: Rounded::NUMBER,
                ..Object::default()
            }
            .complete(),
        )
    }

    #[test]
    fn the_fillet_is_a_quarter_of_an_ellipse() {
        let profile = profile();
        for i in 0..=16 {
            let depth_fraction = i as f32 / 40.0;
            let across = (profile.radius(depth_fraction) - 2.0) / 20.0;
            let above = (0.4 - depth_fraction) / 0.4;
            assert!((across * across + above * above - 1.0).abs() < 1e-5);
        }
        assert_eq!(profile.radius(0.7), 22.0);
    }

    /// It leaves the cap along the cap, and meets the wall along the wall.
    #[test]
    fn the_fillet_has_no_edge() {
        let profile = profile();
        assert_eq!(profile.slope(0.0), STEEP);
        assert!(profile.slope(0.399) < 1.0);
        assert_eq!(profile.slope(0.4), 0.0);
    }

    #[test]
    fn points_straight_above_are_as_far_as_they_are_high() {
        let profile = profile();
        // The centre of the circle is 2 texels from the pattern, at 20 texels of depth.
        assert_eq!(profile.gap(2.0, 0.0), 0.0);
        assert_eq!(profile.gap(32.0, 0.4), 10.0);
        assert_eq!(profile.gap(17.0, 0.0), 5.0);
    }
}
