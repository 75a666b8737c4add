//! Ways to draw an object, from cheap to dear.

use super::{FAST, PLANAR, View};
use crate::scene::{MapOptions, SceneObject, Tier};
use crate::shape_map::Storage;
use std::fmt;

/// A share of the budget that a search may end before its place by. Where rays
/// graze, that is seen several times as large.
const SLACK: f64 = 0.04;
/// A share of the budget that a texel's stored distance may be wrong by.
const QUANTUM: f64 = 0.1;
/// Largest step of 8-bit codes, texels.
const COARSEST_STEP: f64 = 0.5;
/// A share of the budget that rays may be searched beside their places by.
const TOLERANCE: f64 = 0.25;
/// The accurate tier at its most careful: its tolerance, pixels.
const CAREFUL: f64 = 0.01;
/// Texels that the shorter side of a reduced map keeps.
const LEAST_SIDE: u32 = 16;

/// What decides how wrong an object is, and what it costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// The model of the surface.
    pub tier: Tier,
    /// How far beside its place a ray may be searched, in the accurate tier, pixels.
    pub tolerance: f64,
    /// How far before its place a search may end, pixels.
    pub slack: f64,
    /// Largest number of steps of the linear search.
    pub steps: u32,
    /// Bisections after it, at most.
    pub bisections: u32,
    /// How the pattern is stored.
    pub map: MapOptions,
}

impl Recipe {
    /// `tier` as it is where nobody chooses.
    pub fn plain(tier: Tier, map: MapOptions) -> Recipe {
        let (steps, bisections) = tier.default_effort();
        Recipe {
            tier,
            tolerance: CAREFUL,
            slack: 0.0,
            steps,
            bisections,
            map,
        }
    }

    /// `object`, drawn so.
    pub fn of(&self, object: &SceneObject) -> SceneObject {
        SceneObject {
            tier: self.tier,
            tolerance: self.tolerance,
            slack: self.slack,
            steps: self.steps,
            bisections: self.bisections,
            map: self.map,
            budget: None,
            clamp_depth: false,
            ..object.clone()
        }
    }
}

impl fmt::Display for Recipe {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "tier {}", self.tier.name())?;
        if self.tier == Tier::Accurate {
            write!(formatter, ", tolerance {} px", self.tolerance)?;
        }
        write!(
            formatter,
            ", slack {} px, at most {} steps and {} bisections, map {}",
            self.slack, self.steps, self.bisections, self.map.storage
        )?;
        if self.map.reduction > 1 {
            write!(formatter, " at 1/{}", self.map.reduction)?;
        }
        Ok(())
    }
}

/// What is worth a trial for `budget` pixels where `view` is shown: each tier,
/// first as sloppy as the budget may allow, then as careful as it can be.
/// `map` is the size of a plain pattern's map, texels; none where the map is
/// baked and taken as it is.
pub(super) fn recipes(view: &View, budget: f64, map: Option<[u32; 2]>) -> Vec<Recipe> {
    let plain_map = MapOptions::default();
    let sloppy_map = map.map_or(plain_map, |size| sloppy_map(view, budget, size));
    let tiers = [
        (Tier::Planar, PLANAR.may_keep(view, budget)),
        (Tier::Fast, FAST.may_keep(view, budget)),
        (Tier::Accurate, true),
    ];
    let worthy = tiers.into_iter().filter(|(_, may_keep)| *may_keep);
    worthy
        .flat_map(|(tier, _)| {
            let careful = Recipe::plain(tier, plain_map);
            let slack = SLACK * budget;
            let sloppy = Recipe {
                tolerance: (TOLERANCE * budget).clamp(1e-4, 16.0),
                slack,
                map: sloppy_map,
                ..careful
            };
            let less = Recipe {
                tolerance: (0.5 * TOLERANCE * budget).clamp(1e-4, 16.0),
                slack: 0.2 * slack,
                ..careful
            };
            [sloppy, less, careful]
        })
        .collect()
}

/// The smallest map whose texels are told apart finely enough.
fn sloppy_map(view: &View, budget: f64, size: [u32; 2]) -> MapOptions {
    let is_fine = |reduction: u32| {
        COARSEST_STEP * f64::from(reduction) * view.texel_px <= QUANTUM * budget
            && size
                .iter()
                .all(|side| side.is_multiple_of(reduction) && side / reduction >= LEAST_SIDE)
    };
    let reductions = (0..12).map(|power| 1 << power);
    match reductions
        .take_while(|reduction| is_fine(*reduction))
        .last()
    {
        Some(reduction) => MapOptions {
            storage: Storage::R8,
            reduction,
        },
        None => MapOptions::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(texel_px: f64) -> View {
        View {
            rays: 100,
            facet_px: 0.01,
            way_px: 0.01,
            slant: 1.0,
            texel_px,
        }
    }

    #[test]
    fn the_dearest_choice_is_the_most_careful_and_always_there() {
        for budget in [0.01, 0.5, 100.0] {
            let all = recipes(&view(1.0), budget, Some([64, 64]));
            let last = all.last().unwrap();
            assert_eq!(*last, Recipe::plain(Tier::Accurate, MapOptions::default()));
        }
    }

    #[test]
    fn maps_shrink_as_texels_do() {
        let map = |texel_px, budget| sloppy_map(&view(texel_px), budget, [256, 64]);
        assert_eq!(map(1.0, 0.5), MapOptions::default());
        let eight = |reduction| MapOptions {
            storage: Storage::R8,
            reduction,
        };
        assert_eq!(map(0.1, 0.5), eight(1));
        assert_eq!(map(0.02, 0.5), eight(4));
        // No smaller than LEAST_SIDE.
        assert_eq!(map(1e-6, 0.5), eight(4));
        assert_eq!(sloppy_map(&view(0.01), 0.5, [255, 64]), eight(1));
    }
}
