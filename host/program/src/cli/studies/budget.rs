//! `relievo bench budget`.

use super::{Measured, measured_adapter};
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use crate::cli::say;
use clap::Args;
use relievo::Error;
use relievo::budget::{Held, Model, Recipe, Study};
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Adapter, Shaders};
use relievo::scene::{MapOptions, Tier};
use relievo::shape_map::Storage;
use relievo_studies::bench::{Backend, Summary, Timed};
use std::path::PathBuf;

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
    #[arg(long)]
    fit: bool,
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
}

/// Error budgets to measure, pixels.
const BUDGETS: [f64; 3] = [0.1, 0.5, 2.0];

pub fn run(arguments: &BenchBudgetArguments) -> anyhow::Result<()> {
    if arguments.fit {
        return fit(arguments);
    }
    let adapter = measured_adapter(arguments.backend, arguments.adapter.as_deref())?;
    let mut tally: [Tally; BUDGETS.len()] = Default::default();
    for_each_study(arguments, |number, study| {
        let held = study.hold(&BUDGETS)?;
        for (held, tally) in held.iter().zip(&mut tally) {
            tally.add(number, held);
        }
        if arguments.cost && study.has_truth() {
            cost(study, &held, adapter.as_ref(), arguments, &mut tally)?;
        }
        Ok(())
    })?;
    for (budget, tally) in BUDGETS.iter().zip(&tally) {
        tally.say(*budget, arguments.series)?;
    }
    Ok(())
}

/// Calls `visit` with the number and study of each random scene.
fn for_each_study(
    arguments: &BenchBudgetArguments,
    mut visit: impl FnMut(u64, &Study) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let bar = Bar::new();
    for number in 0..arguments.scenes {
        bar.show(
            format!("scene {} of {}", number + 1, arguments.scenes),
            number as f64 / arguments.scenes as f64,
        );
        let study = Study::new(arguments.series, number, arguments.size, &arguments.assets)?;
        visit(number, &study)?;
    }
    Ok(())
}

/// Prints the models fitted to the scenes.
fn fit(arguments: &BenchBudgetArguments) -> anyhow::Result<()> {
    let tiers = [Tier::Planar, Tier::Fast];
    let recipes = tiers.map(|tier| Recipe::plain(tier, MapOptions::default()));
    let mut cases = [Vec::new(), Vec::new()];
    for_each_study(arguments, |_, study| {
        let metrics = study.metrics()?;
        if metrics.rays > 0 {
            for (error_px, cases) in study.errors_px(&recipes)?.into_iter().zip(&mut cases) {
                cases.push((metrics, error_px));
            }
        }
        Ok(())
    })?;
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

/// Results of one error budget.
#[derive(Default)]
struct Tally {
    scenes: usize,
    kept: usize,
    /// Promised but not kept: scene, and fraction of wrong pixels.
    broken: Vec<(u64, f64)>,
    /// Number of scenes without a promise.
    doubted: usize,
    /// Number of scenes drawn in each tier.
    tiers: [usize; Tier::ALL.len()],
    /// Cost relative to the cheapest variant that keeps the budget: CPU, GPU.
    cost: [Vec<f64>; 2],
}

impl Tally {
    fn add(&mut self, number: u64, held: &Held) {
        self.scenes += 1;
        self.kept += usize::from(held.is_kept());
        self.doubted += usize::from(held.plan.promise != relievo::budget::Promise::Kept);
        if !held.is_honest() {
            self.broken.push((number, held.share_above.unwrap_or(1.0)));
        }
        let tier = Tier::ALL
            .iter()
            .position(|tier| *tier == held.plan.recipe.tier);
        self.tiers[tier.unwrap_or_default()] += 1;
    }

    fn say(&self, budget: f64, series: u64) -> anyhow::Result<()> {
        let Tally {
            scenes,
            kept,
            doubted,
            ..
        } = self;
        let tiers: Vec<String> = Tier::ALL
            .iter()
            .zip(self.tiers)
            .filter(|(_, count)| *count > 0)
            .map(|(tier, count)| format!("{} {count}", tier.name()))
            .collect();
        say(format_args!(
            "budget {budget} px: kept in {kept} of {scenes} random scenes; not promised in {doubted}; promised and not kept in {}; drawn {}",
            self.broken.len(),
            tiers.join(", "),
        ))?;
        for (number, share) in &self.broken {
            say(format_args!(
                "  scene {number} of series {series}: {:.2} % of the pixels are worse",
                100.0 * share
            ))?;
        }
        for (name, ratios) in ["CPU", "GPU"].iter().zip(&self.cost) {
            if let Some(summary) = Summary::of(ratios) {
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
    tally: &mut [Tally],
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
        for ((budget, tally), (held, time)) in BUDGETS
            .iter()
            .zip(&mut *tally)
            .zip(held.iter().zip(of_plans))
        {
            let keepers = variants.iter().zip(of_variants);
            let cheapest = keepers
                .filter(|((_, least), _)| least <= budget)
                .map(|(_, time)| *time)
                .reduce(f64::min);
            // The plan itself may be the cheapest.
            if let Some(cheapest) = cheapest.filter(|_| held.is_kept()) {
                tally.cost[backend].push(time / cheapest.min(*time));
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
