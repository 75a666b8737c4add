//! The variants of a sweep, and the part of a shard.

use super::Subject;
use super::variant::{Model, Rendering, SelfShadow, Settings, Steps, Variant};
use relievo::scene::{MapOptions, Search, Tier};
use relievo::shape_map::Storage;
use serde::{Deserialize, Serialize};

/// Size of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grid {
    /// All combinations of tier, steps and map; of tier and slack; and of tier,
    /// shadow and samples.
    Full,
    /// A dozen settings, for a first look and for tests.
    Quick,
}

/// One part of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// Number, from 1.
    pub number: u32,
    /// Number of shards.
    pub count: u32,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Shard = Shard {
        number: 1,
        count: 1,
    };

    /// Selects every [`count`](Shard::count)th settings, starting with its own.
    /// Renderers of the same settings stay together, because they share
    /// pictures.
    pub fn of<T>(self, all: Vec<T>, settings: impl Fn(&T) -> usize) -> Vec<T> {
        let count = self.count.max(1) as usize;
        let own = self.number.saturating_sub(1) as usize;
        let mut all = all;
        all.retain(|item| settings(item) % count == own);
        all
    }
}

/// Default search bounds of scenes.
const DEFAULT_STEPS: Steps = steps(96, 8);
/// Default search bounds in the accurate tier.
const DEFAULT_STEPS_ACCURATE: Steps = steps(256, 10);

const fn steps(linear: u32, bisections: u32) -> Steps {
    Steps { linear, bisections }
}

const fn model(tier: Tier) -> Model {
    Model {
        tier,
        tolerance: None,
    }
}

const fn accurate(tolerance: f64) -> Model {
    Model {
        tier: Tier::Accurate,
        tolerance: Some(tolerance),
    }
}

/// Returns the settings that every variant is timed against: the fast tier with
/// defaults.
pub fn reference(subject: &Subject) -> Settings {
    Settings {
        model: model(Tier::Fast),
        steps: DEFAULT_STEPS,
        slack: 0.0,
        map: (!subject.is_all_baked()).then(MapOptions::default),
        supersampling: 1,
        self_shadow: subject.self_shadow(),
    }
}

/// Returns the finest settings that scenes allow: the reference of the
/// perceptual difference, and the source of the oracle's prisms.
pub fn finest(subject: &Subject) -> Settings {
    Settings {
        model: accurate(1e-4),
        steps: steps(4096, 60),
        slack: 0.0,
        map: (!subject.is_all_baked()).then_some(MapOptions::FINEST),
        supersampling: 2,
        self_shadow: subject.self_shadow(),
    }
}

/// Returns every variant once; renderers of the same settings follow each
/// other.
pub fn variants(subject: &Subject, grid: Grid, renderings: &[Rendering]) -> Vec<Variant> {
    let settings = match grid {
        Grid::Full => full(subject),
        Grid::Quick => quick(subject),
    };
    let mut variants = Vec::new();
    for settings in settings {
        for &rendering in renderings {
            let variant = Variant {
                settings,
                rendering,
            };
            if !variants.contains(&variant) {
                variants.push(variant);
            }
        }
    }
    variants
}

/// Returns the variants of `shard`.
pub fn part(variants: &[Variant], shard: Shard) -> Vec<Variant> {
    let mut number = 0;
    let mut numbered = Vec::with_capacity(variants.len());
    for (index, variant) in variants.iter().enumerate() {
        if index > 0 && variants[index - 1].settings != variant.settings {
            number += 1;
        }
        numbered.push((number, *variant));
    }
    let own = shard.of(numbered, |(number, _)| *number);
    own.into_iter().map(|(_, variant)| variant).collect()
}

/// Returns the tiers that can draw the subject.
fn models(subject: &Subject, tolerances: &[f64]) -> Vec<Model> {
    let mut models = vec![model(Tier::Planar), model(Tier::Fast)];
    // These tiers have no relief mapping.
    if !has_relief(subject) {
        models.push(model(Tier::Paper));
        models.extend(tolerances.iter().map(|tolerance| accurate(*tolerance)));
    }
    models
}

/// Returns whether any object uses relief mapping.
fn has_relief(subject: &Subject) -> bool {
    let mut objects = subject.scene.objects.iter();
    objects.any(|object| object.search == Search::Relief)
}

/// Returns the default search bounds of a tier.
fn default_steps(model: Model) -> Steps {
    match model.tier {
        Tier::Accurate => DEFAULT_STEPS_ACCURATE,
        Tier::Planar | Tier::Fast | Tier::Paper => DEFAULT_STEPS,
    }
}

fn full(subject: &Subject) -> Vec<Settings> {
    let start = reference(subject);
    let models = models(subject, &[0.02, 0.1, 0.5]);
    let mut maps = Vec::new();
    for storage in [Storage::R8, Storage::R16, Storage::R32F] {
        for reduction in [1, 2, 4] {
            maps.push(start.map.map(|_| MapOptions { storage, reduction }));
        }
    }
    let mut settings = Vec::new();
    for &model in &models {
        for steps in [steps(24, 4), DEFAULT_STEPS, DEFAULT_STEPS_ACCURATE] {
            for &map in &maps {
                settings.push(Settings {
                    model,
                    steps,
                    map,
                    ..start
                });
            }
        }
    }
    let has_slack = |model: &&Model| model.tier != Tier::Paper && !has_relief(subject);
    for &model in models.iter().filter(has_slack) {
        for slack in [0.02, 0.1, 0.5] {
            settings.push(Settings {
                model,
                steps: default_steps(model),
                slack,
                ..start
            });
        }
    }
    for &model in &models {
        for self_shadow in [SelfShadow::Off, SelfShadow::On] {
            for supersampling in [1, 2] {
                settings.push(Settings {
                    model,
                    steps: default_steps(model),
                    self_shadow,
                    supersampling,
                    ..start
                });
            }
        }
    }
    settings
}

fn quick(subject: &Subject) -> Vec<Settings> {
    let start = reference(subject);
    let mut settings = Vec::new();
    for model in models(subject, &[0.1]) {
        for steps in [steps(24, 4), DEFAULT_STEPS] {
            settings.push(Settings {
                model,
                steps,
                ..start
            });
        }
    }
    if start.map.is_some() {
        for (storage, reduction) in [(Storage::R8, 1), (Storage::R32F, 1), (Storage::R16, 2)] {
            let map = Some(MapOptions { storage, reduction });
            settings.push(Settings { map, ..start });
        }
    }
    if !has_relief(subject) {
        settings.push(Settings {
            slack: 0.1,
            ..start
        });
    }
    settings.push(Settings {
        self_shadow: match start.self_shadow {
            SelfShadow::On => SelfShadow::Off,
            SelfShadow::Off | SelfShadow::AsInScene => SelfShadow::On,
        },
        ..start
    });
    settings.push(Settings {
        supersampling: 2,
        ..start
    });
    settings
}

#[cfg(test)]
mod tests {
    use super::super::tests::subject;
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    const BOTH: [Rendering; 2] = [Rendering::Cpu, Rendering::GpuFast];

    #[test]
    fn no_variant_is_twice_in_a_grid() {
        let subject = subject("");
        for (grid, settings) in [(Grid::Full, 6 * 27 + 5 * 3 + 6 * 3), (Grid::Quick, 14)] {
            let variants = variants(&subject, grid, &BOTH);
            let keys: BTreeSet<String> = variants.iter().map(Variant::key).collect();
            assert_eq!((keys.len(), variants.len()), (2 * settings, 2 * settings));
            let start = reference(&subject);
            assert!(variants.iter().any(|variant| variant.settings == start));
        }
    }

    #[test]
    fn relief_mapping_has_no_other_search_and_a_baked_map_no_other_texels() {
        let relief = subject("technique = 'relief'");
        let drawn = variants(&relief, Grid::Full, &BOTH);
        let tiers = |tier| {
            drawn
                .iter()
                .any(|variant| variant.settings.model.tier == tier)
        };
        assert!(tiers(Tier::Fast) && tiers(Tier::Planar));
        assert!(!tiers(Tier::Paper) && !tiers(Tier::Accurate));
        assert!(drawn.iter().all(|variant| variant.settings.slack == 0.0));

        let mut baked = subject("");
        baked.is_baked = vec![true];
        let drawn = variants(&baked, Grid::Full, &BOTH);
        assert!(drawn.iter().all(|variant| variant.settings.map.is_none()));
        assert_eq!(drawn.len(), 2 * (6 * 3 + 5 * 3 + 6 * 3));
        assert!(drawn[0].key().contains("/baked/1:1/"), "{}", drawn[0].key());
    }

    #[test]
    fn keys_are_readable() {
        let variant = Variant {
            settings: Settings {
                model: accurate(0.1),
                steps: DEFAULT_STEPS_ACCURATE,
                slack: 0.0,
                map: Some(MapOptions {
                    storage: Storage::R16,
                    reduction: 2,
                }),
                supersampling: 1,
                self_shadow: SelfShadow::Off,
            },
            rendering: Rendering::GpuFast,
        };
        let key = "accurate-0.1px/256+10/slack-0px/r16/1:2/1x/no-shadow/gpu-fast";
        assert_eq!(variant.key(), key);
    }

    proptest! {
        #[test]
        fn shards_are_disjoint_and_together_everything(count in 1u32..40) {
            let all = variants(&subject(""), Grid::Quick, &BOTH);
            let mut found: Vec<String> = Vec::new();
            for number in 1..=count {
                let own = part(&all, Shard { number, count });
                // Renderers of the same settings stay together.
                prop_assert!(own.len().is_multiple_of(BOTH.len()));
                found.extend(own.iter().map(Variant::key));
            }
            let mut wanted: Vec<String> = all.iter().map(Variant::key).collect();
            wanted.sort();
            found.sort();
            prop_assert_eq!(found, wanted);
        }
    }
}
