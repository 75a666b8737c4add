//! Ways to draw an object, from cheap to expensive.

use super::metrics::ScreenMetrics;
use super::model::{FAST, PLANAR};
use crate::scene::keys::TOLERANCES;
use crate::scene::{MapOptions, SceneObject, Tier};
use crate::shape_map::Storage;
use std::fmt;

/// Slack as a share of the budget. At grazing angles the error in the picture is
/// several times as large.
const SLACK: f64 = 0.04;
/// Quantisation error of a texel's distance as a share of the budget.
const QUANTUM: f64 = 0.1;
/// Largest step of 8-bit codes, texels.
const COARSEST_STEP: f64 = 0.5;
/// Tolerance as a share of the budget.
const TOLERANCE: f64 = 0.25;
/// Smallest tolerance of the accurate tier that is planned, pixels.
const LEAST_TOLERANCE: f64 = 0.01;
/// Minimum length of the shorter side of a reduced map, texels.
const LEAST_SIDE: u32 = 16;

/// The parameters of an object that decide its error and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// The model of the surface.
    pub tier: Tier,
    /// Tolerance of the accurate tier: how far beside its true position a ray may
    /// be traced, pixels.
    pub tolerance: f64,
    /// Slack: how far before the surface a search may end, pixels.
    pub slack: f64,
    /// Maximum number of steps of the linear search.
    pub steps: u32,
    /// Maximum number of bisections after it.
    pub bisections: u32,
    /// How the shape map is made of a plain pattern.
    pub map: MapOptions,
}

impl Recipe {
    /// Returns `tier` with the smallest tolerance, no slack and default steps.
    pub fn plain(tier: Tier, map: MapOptions) -> Recipe {
        let (steps, bisections) = tier.default_effort();
        Recipe {
            tier,
            tolerance: LEAST_TOLERANCE,
            slack: 0.0,
            steps,
            bisections,
            map,
        }
    }

    /// Returns `object` drawn by this recipe, without a budget.
    pub fn of(&self, object: &SceneObject) -> SceneObject {
        let mut drawn = object.clone();
        drawn.reset_planned();
        SceneObject {
            tier: self.tier,
            tolerance: self.tolerance,
            slack: self.slack,
            steps: self.steps,
            bisections: self.bisections,
            map: self.map,
            budget: None,
            ..drawn
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

/// Returns the recipes worth a trial for `budget` pixels, from cheap to
/// expensive: each tier with the largest tolerances that the budget may allow,
/// then with smaller ones, then with the smallest.
///
/// `map` is the size of a plain pattern's map, texels; `None` if the map is baked
/// and used as it is.
pub(super) fn recipes(metrics: &ScreenMetrics, budget: f64, map: Option<[u32; 2]>) -> Vec<Recipe> {
    let plain_map = MapOptions::default();
    let sloppy_map = map.map_or(plain_map, |size| sloppy_map(metrics, budget, size));
    let tiers = [
        (Tier::Planar, PLANAR.may_keep(metrics, budget)),
        (Tier::Fast, FAST.may_keep(metrics, budget)),
        (Tier::Accurate, true),
    ];
    let worthy = tiers.into_iter().filter(|(_, may_keep)| *may_keep);
    worthy
        .flat_map(|(tier, _)| {
            let careful = Recipe::plain(tier, plain_map);
            let slack = SLACK * budget;
            let tolerance = |share: f64| (share * budget).clamp(TOLERANCES.0, TOLERANCES.1);
            let sloppy = Recipe {
                tolerance: tolerance(TOLERANCE),
                slack,
                map: sloppy_map,
                ..careful
            };
            let less = Recipe {
                tolerance: tolerance(0.5 * TOLERANCE),
                slack: 0.2 * slack,
                ..careful
            };
            [sloppy, less, careful]
        })
        .collect()
}

/// Returns the smallest map whose quantisation error keeps within [`QUANTUM`].
fn sloppy_map(metrics: &ScreenMetrics, budget: f64, size: [u32; 2]) -> MapOptions {
    let is_fine = |reduction: u32| {
        COARSEST_STEP * f64::from(reduction) * metrics.texel_px <= QUANTUM * budget
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

    fn metrics(texel_px: f64) -> ScreenMetrics {
        ScreenMetrics {
            rays: 100,
            pixels: 100.0,
            facet_px: 0.01,
            way_px: 0.01,
            slant: 1.0,
            texel_px,
        }
    }

    #[test]
    fn the_dearest_choice_is_the_most_careful_and_always_there() {
        for budget in [0.01, 0.5, 100.0] {
            let all = recipes(&metrics(1.0), budget, Some([64, 64]));
            let last = all.last().unwrap();
            assert_eq!(*last, Recipe::plain(Tier::Accurate, MapOptions::default()));
        }
    }

    #[test]
    fn maps_shrink_as_texels_do() {
        let map = |texel_px, budget| sloppy_map(&metrics(texel_px), budget, [256, 64]);
        assert_eq!(map(1.0, 0.5), MapOptions::default());
        let eight = |reduction| MapOptions {
            storage: Storage::R8,
            reduction,
        };
        assert_eq!(map(0.1, 0.5), eight(1));
        assert_eq!(map(0.02, 0.5), eight(4));
        // No smaller than LEAST_SIDE.
        assert_eq!(map(1e-6, 0.5), eight(4));
        assert_eq!(sloppy_map(&metrics(0.01), 0.5, [255, 64]), eight(1));
    }
}
