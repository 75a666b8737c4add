//! By how much the pattern is grown at a depth: the four extrusions in one formula.

use crate::Real;
use crate::arithmetic::{div, min};
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
    /// 1 / b, or 0 without a bevel.
    inverse_bevel: Real,
    /// Whether the radius depends on δ at all.
    pub grows: bool,
}

impl Profile {
    /// The profile of `object`, from width units to texels.
    #[inline]
    pub fn new(object: &Object) -> Profile {
        let bevel = object.bevel * object.map_size[0];
        Profile {
            extension: object.extension * object.map_size[0],
            bevel,
            chamfer: object.chamfer,
            inverse_bevel: if bevel > 1e-12 { div(1.0, bevel) } else { 0.0 },
            // Asked of the object, of which it may be known.
            grows: object.bevel != 0.0,
        }
    }

    /// r(δ), texels.
    #[inline]
    pub fn radius(&self, depth_fraction: Real) -> Real {
        self.extension + self.bevel * min(depth_fraction, self.chamfer)
    }

    /// The depth fraction at which a point `distance` texels from the pattern
    /// becomes solid: the profile the other way round; 1 where it never does.
    #[inline]
    pub fn depth_of(&self, distance: Real) -> Real {
        if distance <= self.extension {
            0.0
        } else if distance <= self.largest_radius() {
            (distance - self.extension) * self.inverse_bevel
        } else {
            1.0
        }
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
        let profile = Profile::new(&Object {
            map_size: [8.0, 4.0],
            extension: -0.375,
            bevel: 1.0,
            chamfer: 0.25,
            ..Object::default()
        });
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
        let profile = Profile::new(&Object {
            map_size: [8.0, 8.0],
            extension: 0.25,
            chamfer: 1.0,
            ..Object::default()
        });
        assert_eq!(profile.depth_of(2.0), 0.0);
        assert_eq!(profile.depth_of(2.1), 1.0);
    }
}
