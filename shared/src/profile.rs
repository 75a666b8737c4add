//! By how much the pattern is grown at a depth: the four extrusions in one formula.

use crate::Real;
use crate::arithmetic::min;
use crate::layout::Object;

/// r(δ) = e + b · min(δ, c), here in texels (section 2; equations (4), (6) and (7)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// e, texels.
    pub extension: Real,
    /// b, texels per unit of δ, ≥ 0.
    pub bevel: Real,
    /// c, 0…1.
    pub chamfer: Real,
}

impl Profile {
    /// The profile of `object`, from width units to texels.
    #[inline]
    pub fn new(object: &Object) -> Profile {
        Profile {
            extension: object.extension * object.map_size[0],
            bevel: object.bevel * object.map_size[0],
            chamfer: object.chamfer,
        }
    }

    /// r(δ), texels.
    #[inline]
    pub fn radius(&self, depth_fraction: Real) -> Real {
        self.extension + self.bevel * min(depth_fraction, self.chamfer)
    }

    /// The largest radius at any depth, texels.
    #[inline]
    pub fn largest_radius(&self) -> Real {
        self.extension + self.bevel * self.chamfer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_extrusions() {
        let profile = |extension, bevel, chamfer| {
            Profile::new(&Object {
                map_size: [100.0, 50.0],
                extension,
                bevel,
                chamfer,
                ..Object::default()
            })
        };
        assert_eq!(profile(0.0, 0.0, 1.0).radius(0.7), 0.0);
        assert_eq!(profile(0.25, 0.0, 1.0).radius(0.7), 25.0);
        assert_eq!(profile(0.0, 0.5, 1.0).radius(0.5), 25.0);
        assert_eq!(profile(0.25, 0.5, 0.5).radius(0.75), 50.0);
        assert_eq!(profile(0.25, 0.5, 0.5).largest_radius(), 50.0);
    }

    #[test]
    fn the_radius_grows_down_to_the_chamfer_and_no_further() {
        let profile = Profile {
            extension: -3.0,
            bevel: 8.0,
            chamfer: 0.25,
        };
        assert_eq!(profile.radius(0.0), -3.0);
        assert_eq!(profile.radius(0.125), -2.0);
        for depth_fraction in [0.25, 0.5, 1.0] {
            assert_eq!(profile.radius(depth_fraction), -1.0);
        }
        assert_eq!(profile.largest_radius(), -1.0);
    }
}
