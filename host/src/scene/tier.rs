//! Tiers of accuracy, and how hits are searched for.

use relievo_shared::shaders::{TIERS, TierRow};

/// How the surface is modelled along a ray: chooses between speed and accuracy. In the
/// order of [`TIERS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// Flat: extrusion mapping without silhouettes.
    Planar,
    /// Follows the local quadric, with the depth of the facet.
    #[default]
    Fast,
    /// The paper's algorithms as printed, mistakes included.
    Paper,
    /// Goes from prism to prism through the shell: no holes.
    Accurate,
}

impl Tier {
    /// All tiers.
    pub const ALL: [Tier; 4] = [Tier::Planar, Tier::Fast, Tier::Paper, Tier::Accurate];

    /// Returns its row in the list of searches, which also names its shaders.
    fn row(self) -> &'static TierRow {
        &TIERS[self as usize]
    }

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Returns the default number of steps of the linear search, and of
    /// bisections after it.
    pub fn default_effort(self) -> (u32, u32) {
        self.row().effort
    }

    /// Returns the `TIER_` constant of the shared layouts.
    pub fn code(self) -> u32 {
        self.row().tier
    }
}

/// How the first hit on a ray is searched for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Search {
    /// By steps through the distance map that cannot skip the pattern.
    #[default]
    Extrusion,
    /// Relief mapping: by equal steps through a depth map of the same pattern.
    Relief,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiers_are_those_of_the_list() {
        assert_eq!(Tier::ALL.len(), TIERS.len());
        for tier in Tier::ALL {
            assert_eq!(format!("{tier:?}").to_lowercase(), tier.name());
        }
    }
}
