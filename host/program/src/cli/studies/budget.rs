//! `relievo bench budget`.

use super::{Measured, measured_adapter};
use crate::cli::job::{Estimate, Part, Piece, Place, PlanArguments, Work};
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use crate::cli::say;
use clap::Args;
use relievo::Error;
use relievo::budget::{Held, Model, Promise, Recipe, Study, random_scene};
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Adapter, Shaders};
use relievo::scene::{MapOptions, Scene, Tier};
use relievo::shape_map::Storage;
use relievo_studies::bench::{Backend, Summary, Timed};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
pub struct BenchBudgetArguments {
    /// Number of random scenes
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..1_000_000))]
    scenes: u64,
    /// Series of random scenes; the model is fitted to series 1
    #[arg(long, value_name = "K", default_value_t = 2)]
    series: u64,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "200x150", value_parser = parse_size)]
    size: [u32; 2],
    /// Print the model fitted to these scenes instead
    #[arg(long, conflicts_with = "plan")]
    pub(super) fit: bool,
    /// Also time every plan against a sweep of variants
    #[arg(long, conflicts_with = "fit")]
    cost: bool,
    /// Timed frames per variant, after one to warm up
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    /// Devices to time
    #[arg(long, value_enum, default_value_t = Measured::Both)]
    backend: Measured,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Folder with this project's meshes and patterns
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
    #[command(flatten)]
    pub(super) plan: PlanArguments,
}

/// Error budgets to measure, pixels.
const BUDGETS: [f64; 3] = [0.1, 0.5, 2.0];

/// Results of a random scene with each of [`BUDGETS`].
#[derive(Serialize, Deserialize)]
struct OfScene {
    number: u64,
    budgets: [Outcome; BUDGETS.len()],
}

/// Result of a random scene with one error budget.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Outcome {
    is_kept: bool,
    is_promised: bool,
    /// Share of pixels that are worse; `None` without a reference.
    share_above: Option<f64>,
    /// Index of the tier that the plan has.
    tier: usize,
    /// Cost relative to the cheapest variant that keeps the budget: CPU, GPU.
    cost: [Option<f64>; 2],
}

impl BenchBudgetArguments {
    fn adapter(&self) -> Result<Option<Adapter>, Error> {
        measured_adapter(self.backend, self.adapter.as_deref())
    }

    fn study(&self, number: u64) -> Result<Study, Error> {
        Study::new(self.series, number, self.size, &self.assets)
    }

    /// Studies random scene `number`.
    fn of_scene(&self, number: u64, adapter: Option<&Adapter>) -> anyhow::Result<OfScene> {
        let study = self.study(number)?;
        let held = study.hold(&BUDGETS)?;
        let mut budgets: [Outcome; BUDGETS.len()] = Default::default();
        for (held, outcome) in held.iter().zip(&mut budgets) {
            let tier = held.plan.recipe.tier;
            *outcome = Outcome {
                is_kept: held.is_kept(),
                is_promised: held.plan.promise == Promise::Kept,
                share_above: held.share_above,
                tier: Tier::ALL
                    .iter()
                    .position(|known| *known == tier)
                    .unwrap_or(0),
                cost: [None; 2],
            };
        }
        if self.cost && study.has_truth() {
            cost(&study, &held, adapter, self, &mut budgets)?;
        }
        Ok(OfScene { number, budgets })
    }
}

/// Number of scenes that the time is estimated from.
const TRIAL_SCENES: u64 = 2;

impl Work for BenchBudgetArguments {
    fn unit(&self) -> &'static str {
        "scene"
    }

    fn count(&self) -> usize {
        self.scenes as usize
    }

    fn inputs(&self) -> anyhow::Result<Vec<PathBuf>> {
        let mut all = Vec::new();
        for number in 0..self.scenes {
            let scene = Scene::parse(
                &random_scene(self.series, number, self.size),
                &self.assets.join("scenes/random.toml"),
            );
            all.extend(scene.map_err(Error::from)?.named_files());
        }
        Ok(all)
    }

    fn estimate(&self) -> anyhow::Result<Estimate> {
        let adapter = self.adapter()?;
        let start = Instant::now();
        let trial = self.scenes.min(TRIAL_SCENES);
        for number in 0..trial {
            self.of_scene(number, adapter.as_ref())?;
        }
        let each = start.elapsed().as_secs_f64() / trial as f64;
        Ok(Estimate {
            setup: 0.0,
            units: vec![each; self.count()],
            ..Estimate::default()
        })
    }

    fn work(&self, piece: &Piece, _: Option<&Place<'_>>) -> anyhow::Result<Part> {
        let adapter = self.adapter()?;
        let bar = Bar::new();
        let units = piece.units();
        let mut all = Vec::new();
        for number in units.clone() {
            bar.show(
                format!("scene {} of {}", number + 1, self.scenes),
                (number - units.start) as f64 / units.len() as f64,
            );
            all.push(self.of_scene(number as u64, adapter.as_ref())?);
        }
        Ok(Part {
            result: serde_json::to_value(all)?,
            ..Part::default()
        })
    }

    fn merge(&self, parts: Vec<Part>) -> anyhow::Result<()> {
        let mut all = Vec::new();
        for part in parts {
            all.extend(serde_json::from_value::<Vec<OfScene>>(part.result)?);
        }
        for (index, budget) in BUDGETS.iter().enumerate() {
            let outcomes = all.iter().map(|of| (of.number, &of.budgets[index]));
            say_tally(*budget, self.series, &outcomes.collect::<Vec<_>>())?;
        }
        Ok(())
    }
}

/// Prints the results of one error budget.
fn say_tally(budget: f64, series: u64, outcomes: &[(u64, &Outcome)]) -> anyhow::Result<()> {
    let count = |is_counted: &dyn Fn(&Outcome) -> bool| {
        let counted = outcomes.iter().filter(|(_, outcome)| is_counted(outcome));
        counted.count()
    };
    let is_broken = |outcome: &Outcome| outcome.is_promised && !outcome.is_kept;
    let tiers: Vec<String> = (0..)
        .zip(Tier::ALL)
        .map(|(index, tier)| (tier, count(&|outcome| outcome.tier == index)))
        .filter(|(_, count)| *count > 0)
        .map(|(tier, count)| format!("{} {count}", tier.name()))
        .collect();
    say(format_args!(
        "budget {budget} px: kept in {} of {} random scenes; not promised in {}; promised and not kept in {}; drawn {}",
        count(&|outcome| outcome.is_kept),
        outcomes.len(),
        count(&|outcome| !outcome.is_promised),
        count(&is_broken),
        tiers.join(", "),
    ))?;
    for (number, outcome) in outcomes.iter().filter(|(_, outcome)| is_broken(outcome)) {
        say(format_args!(
            "  scene {number} of series {series}: {:.2} % of the pixels are worse",
            100.0 * outcome.share_above.unwrap_or(1.0)
        ))?;
    }
    for (backend, name) in ["CPU", "GPU"].into_iter().enumerate() {
        let ratios = outcomes
            .iter()
            .filter_map(|(_, outcome)| outcome.cost[backend]);
        let ratios: Vec<f64> = ratios.collect();
        if let Some(summary) = Summary::of(&ratios) {
            say(format_args!(
                "  {name}: a frame takes {:.2} times that of the cheapest variant that keeps the budget (median of {}; quartiles {:.2} to {:.2}, at most {:.2})",
                summary.median,
                ratios.len(),
                summary.lower_quartile,
                summary.upper_quartile,
                summary.maximum,
            ))?;
        }
    }
    Ok(())
}

/// Prints the models fitted to the scenes.
pub fn fit(arguments: &BenchBudgetArguments) -> anyhow::Result<()> {
    let tiers = [Tier::Planar, Tier::Fast];
    let recipes = tiers.map(|tier| Recipe::plain(tier, MapOptions::default()));
    let mut cases = [Vec::new(), Vec::new()];
    let bar = Bar::new();
    for number in 0..arguments.scenes {
        bar.show(
            format!("scene {} of {}", number + 1, arguments.scenes),
            number as f64 / arguments.scenes as f64,
        );
        let study = arguments.study(number)?;
        let metrics = study.metrics()?;
        if metrics.rays > 0 {
            for (error_px, cases) in study.errors_px(&recipes)?.into_iter().zip(&mut cases) {
                cases.push((metrics, error_px));
            }
        }
    }
    drop(bar);
    for (tier, cases) in tiers.iter().zip(&cases) {
        match Model::fit(cases) {
            Some(model) => say(format_args!(
                "{}, {} scenes: {model:?}",
                tier.name(),
                cases.len()
            ))?,
            None => say(format_args!("{}: too few scenes", tier.name()))?,
        }
    }
    Ok(())
}

/// Returns the variants that plans are compared with.
fn sweep() -> Vec<Recipe> {
    let maps = [
        MapOptions::default(),
        MapOptions {
            storage: Storage::R8,
            reduction: 4,
        },
    ];
    let mut all = Vec::new();
    for tier in [Tier::Planar, Tier::Fast, Tier::Accurate] {
        let tolerances: &[f64] = if tier == Tier::Accurate {
            &[0.02, 0.25]
        } else {
            &[0.02]
        };
        for map in maps {
            let plain = Recipe::plain(tier, map);
            for tolerance in tolerances {
                for slack in [0.0, 0.02, 0.1] {
                    all.push(Recipe {
                        tolerance: *tolerance,
                        slack,
                        ..plain
                    });
                }
            }
        }
    }
    all
}

/// Times the plans of a scene and the variants of the sweep in turn.
fn cost(
    study: &Study,
    held: &[Held],
    adapter: Option<&Adapter>,
    arguments: &BenchBudgetArguments,
    budgets: &mut [Outcome],
) -> anyhow::Result<()> {
    let sweep = sweep();
    let kept = study.kept(&sweep, &BUDGETS)?;
    let variants: Vec<(Recipe, f64)> = sweep
        .into_iter()
        .zip(kept)
        .filter(|(_, least)| least.is_finite())
        .collect();
    let recipes = variants
        .iter()
        .map(|(recipe, _)| *recipe)
        .chain(held.iter().map(|held| held.plan.recipe));
    let scenes = recipes
        .map(|recipe| study.drawn(&recipe))
        .collect::<Result<Vec<_>, _>>()?;
    let mut times = Vec::new();
    if arguments.backend != Measured::Gpu {
        times.push((0, times_of(&scenes, &Backend::Cpu, arguments.frames)?));
    }
    if let Some(adapter) = adapter {
        let shaders = if adapter.takes_spirv() {
            Shaders::Fast
        } else {
            Shaders::Portable
        };
        let backend = Backend::Gpu(adapter, shaders);
        times.push((1, times_of(&scenes, &backend, arguments.frames)?));
    }
    for (backend, times) in times {
        let (of_variants, of_plans) = times.split_at(variants.len());
        for ((budget, outcome), (held, time)) in BUDGETS
            .iter()
            .zip(&mut *budgets)
            .zip(held.iter().zip(of_plans))
        {
            let keepers = variants.iter().zip(of_variants);
            let cheapest = keepers
                .filter(|((_, least), _)| least <= budget)
                .map(|(_, time)| *time)
                .reduce(f64::min);
            // The plan itself may be the cheapest.
            if let Some(cheapest) = cheapest.filter(|_| held.is_kept()) {
                outcome.cost[backend] = Some(time / cheapest.min(*time));
            }
        }
    }
    Ok(())
}

/// Returns the median frame time of each of `scenes`, milliseconds, measured in turn.
fn times_of(
    scenes: &[PreparedScene],
    backend: &Backend<'_>,
    frames: u32,
) -> Result<Vec<f64>, Error> {
    let renderers = scenes.iter().map(|scene| Timed::new(scene, backend));
    let mut renderers = renderers.collect::<Result<Vec<_>, _>>()?;
    let mut times = vec![Vec::new(); scenes.len()];
    for round in 0..=frames {
        for ((renderer, scene), times) in renderers.iter_mut().zip(scenes).zip(&mut times) {
            let (time, _) = renderer.time(&scene.frame)?;
            if round > 0 {
                times.push(time);
            }
        }
    }
    let median = |times: &Vec<f64>| Summary::of(times).map_or(0.0, |summary| summary.median);
    Ok(times.iter().map(median).collect())
}
