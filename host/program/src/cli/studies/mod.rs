//! Commands that measure Relievo itself: `bench`, `bounds`, `tradeoff`, `report` and
//! `gallery`. They need the feature `studies`.

mod bench;
mod bounds;
mod budget;
mod gallery;
mod geometry;
mod report;
mod tradeoff;

use super::{Task, refuse_adapter, say};
use bench::Comparison;
use clap::{Args, Subcommand, ValueEnum};
use relievo::Error;
use relievo::file::write_bytes;
use relievo::render::gpu::{Adapter, choose};
use std::path::Path;

/// A command that needs the feature `studies`.
#[derive(Subcommand)]
pub enum Command {
    /// Measure the error of each function of the mathematics in f32, as tables
    Bounds(bounds::BoundsArguments),
    /// Measure frame times
    #[command(subcommand)]
    Bench(BenchCommand),
    /// Measure cost and error of many variants of a scene
    Tradeoff(tradeoff::TradeoffArguments),
    /// Report on a GPU: canaries, words, times, registers; a page to send, with nothing private
    Report(report::ReportArguments),
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
    /// Measure flicker, error and cost from near to 1,000 times as far, without and with smooth edges
    Distance(bench::BenchSceneArguments),
    /// Measure error and cost of smooth edges and of four samples a pixel
    Edges(bench::BenchSceneArguments),
    /// Time frames over the number of triangles, 2,000 to 2 million, and of copies, 1 to 100,000
    Scaling(bench::BenchScalingArguments),
    /// Measure the carving as plain triangles beside the extrusions: time, memory, preparation
    Geometry(geometry::BenchGeometryArguments),
}

impl Command {
    /// Returns what the command does, after checking its arguments.
    pub(super) fn task(self) -> anyhow::Result<Task> {
        Ok(match self {
            Command::Bounds(arguments) => {
                let plan = arguments.plan.clone();
                Task::pieces(arguments, plan)
            }
            Command::Bench(BenchCommand::Budget(arguments)) if !arguments.fit => {
                let plan = arguments.plan.clone();
                Task::pieces(arguments, plan)
            }
            Command::Bench(command) => Task::whole(move || bench(&command)),
            Command::Tradeoff(arguments) => {
                let plan = arguments.plan.clone();
                Task::pieces(tradeoff::Sweep::new(arguments)?, plan)
            }
            Command::Report(arguments) => Task::whole(move || report::run(&arguments)),
            Command::Gallery(arguments) => Task::whole(move || gallery::run(&arguments)),
        })
    }
}

/// Runs a benchmark that has no pieces.
fn bench(command: &BenchCommand) -> anyhow::Result<()> {
    match command {
        BenchCommand::Scene(arguments) => bench::scenes(arguments),
        BenchCommand::Exactness(arguments) => bench::compare(arguments, Comparison::Exactness),
        BenchCommand::Specialization(arguments) => {
            bench::compare(arguments, Comparison::Specialization)
        }
        BenchCommand::Budget(arguments) => budget::fit(arguments),
        BenchCommand::Table1(arguments) => bench::table1(arguments),
        BenchCommand::Distance(arguments) => bench::distance(arguments),
        BenchCommand::Edges(arguments) => bench::edges(arguments),
        BenchCommand::Scaling(arguments) => bench::scaling(arguments),
        BenchCommand::Geometry(arguments) => geometry::run(arguments),
    }
}

/// Results of a benchmark.
struct Study<'a> {
    /// Name of its files.
    name: &'static str,
    title: &'static str,
    /// What its chart shows.
    picture: &'static str,
    /// Markdown.
    text: String,
    csv: String,
    svg: &'a dyn Fn() -> Result<String, String>,
}

impl Study<'_> {
    /// Prints the text, and writes all into `folder` if there is one.
    fn write(&self, folder: Option<&Path>) -> anyhow::Result<()> {
        // Print first, so that a full disk does not lose the measurement.
        say(format_args!("{}", self.text.trim_end()))?;
        let Some(folder) = folder else {
            return Ok(());
        };
        let Study {
            name,
            title,
            picture,
            text,
            ..
        } = self;
        let file = |ending: &str| folder.join(format!("{name}.{ending}"));
        let svg = (self.svg)().map_err(|message| Error::Encode {
            path: file("svg"),
            message,
        })?;
        let page = format!(
            "# {title}\n\nMade by `relievo bench {name}`; all results are also in \
             [{name}.csv]({name}.csv).\n\n![{picture}]({name}.svg)\n\n{text}"
        );
        for (ending, content) in [("csv", &self.csv), ("svg", &svg), ("md", &page)] {
            let path = file(ending);
            write_bytes(&path, content.as_bytes()).map_err(Error::from)?;
            say(format_args!("{}", path.display()))?;
        }
        Ok(())
    }
}

/// The devices that a command measures.
#[derive(Args)]
pub struct DeviceArguments {
    /// Devices to measure
    #[arg(long, value_enum, default_value_t = Measured::Both)]
    backend: Measured,
    /// Use the adapter whose name contains this (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

impl DeviceArguments {
    /// Returns the adapter to measure, as [`measured_adapter`].
    fn adapter(&self) -> Result<Option<Adapter>, Error> {
        measured_adapter(self.backend, self.adapter.as_deref())
    }

    /// Returns whether the CPU is measured.
    fn has_cpu(&self) -> bool {
        self.backend != Measured::Gpu
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
