//! Commands that measure Relievo itself: `bench`, `bounds`, `tradeoff` and `gallery`. They need the
//! feature `studies`.

mod bench;
mod bounds;
mod budget;
mod gallery;
mod tradeoff;

use super::refuse_adapter;
use bench::Comparison;
use clap::{Subcommand, ValueEnum};
use relievo::Error;
use relievo::render::gpu::{Adapter, choose};

/// A command that needs the feature `studies`.
#[derive(Subcommand)]
pub enum Study {
    /// Measure the error of each function of the mathematics in f32, as tables
    Bounds(bounds::BoundsArguments),
    /// Measure frame times
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Measure cost and error of many variants of a scene
    Tradeoff(tradeoff::TradeoffArguments),
    /// Draw the paper's figures, with the paper's algorithms beside ours, as a page
    Gallery(gallery::GalleryArguments),
}

/// Benchmarks of `relievo bench`.
#[derive(Subcommand)]
pub enum BenchCommand {
    /// Time frames of scenes on CPU and GPU, in turn
    Scene(bench::BenchSceneArguments),
    /// Time the exact shaders against the fast ones, in every tier
    Exactness(bench::BenchSceneArguments),
    /// Time the shaders specialized for a scene against the general ones
    Specialization(bench::BenchSceneArguments),
    /// Measure whether plans keep error budgets on random scenes, and their cost
    Budget(budget::BenchBudgetArguments),
    /// Measure the paper's Table 1: extrusion against relief mapping, planar and curved
    Table1(bench::BenchTable1Arguments),
}

/// Runs the command.
pub fn run(study: Study) -> anyhow::Result<()> {
    match study {
        Study::Bounds(arguments) => bounds::run(&arguments),
        Study::Bench(BenchCommand::Scene(arguments)) => bench::scenes(&arguments),
        Study::Bench(BenchCommand::Exactness(arguments)) => {
            bench::compare(&arguments, Comparison::Exactness)
        }
        Study::Bench(BenchCommand::Specialization(arguments)) => {
            bench::compare(&arguments, Comparison::Specialization)
        }
        Study::Bench(BenchCommand::Budget(arguments)) => budget::run(&arguments),
        Study::Bench(BenchCommand::Table1(arguments)) => bench::table1(&arguments),
        Study::Tradeoff(arguments) => tradeoff::run(&arguments),
        Study::Gallery(arguments) => gallery::run(&arguments),
    }
}

/// Devices to measure on.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Measured {
    /// A GPU, or a software driver if there is none
    Gpu,
    /// The CPU
    Cpu,
    /// The CPU, and a GPU if there is one
    Both,
}

/// Returns the adapter to measure: the one with `wanted` in its name, or any. Fails without one if
/// it is named or nothing else is measured.
pub fn measured_adapter(
    measured: Measured,
    wanted: Option<&str>,
) -> Result<Option<Adapter>, Error> {
    if measured == Measured::Cpu {
        if wanted.is_some() {
            refuse_adapter();
        }
        return Ok(None);
    }
    match choose(wanted) {
        Ok(found) => Ok(Some(found)),
        Err(error) if measured == Measured::Gpu || wanted.is_some() => Err(error.into()),
        Err(_) => Ok(None),
    }
}
