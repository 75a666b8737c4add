//! Work in pieces, on one machine or many: `--plan`, `relievo job` and `relievo submit`.
//!
//! ```text
//! file    files that must not change
//! plan    job files: the command, its files, and its pieces
//! piece   doing a piece, and joining all
//! slurm   submitting the pieces to Slurm
//! ```

mod file;
mod piece;
mod plan;
mod slurm;

use super::{Arguments, Task};
use clap::{Args, Parser};
use serde_json::Value;
use std::path::{Path, PathBuf};

pub use plan::{Piece, PlanArguments};
pub use slurm::SubmitArguments;

/// A command whose work consists of units that can be done in any order, and on any machine.
pub trait Work {
    /// Returns what a unit is called, such as "frame".
    fn unit(&self) -> &'static str;

    /// Returns the number of units.
    fn count(&self) -> usize;

    /// Returns the files that decide the results.
    fn inputs(&self) -> anyhow::Result<Vec<PathBuf>>;

    /// Does a little of the work, without outputs, and returns how long all of it takes.
    fn estimate(&self) -> anyhow::Result<Estimate>;

    /// Does the units of `piece`, also if they were done before. `place` is the place of the piece in
    /// a job; `None` if there is no job.
    fn work(&self, piece: &Piece, place: Option<&Place<'_>>) -> anyhow::Result<Part>;

    /// Joins the parts of all pieces, in order.
    fn merge(&self, parts: Vec<Part>) -> anyhow::Result<()>;
}

/// What a piece has made.
#[derive(Default)]
pub struct Part {
    /// Its results.
    pub result: Value,
    /// The files that it has written.
    pub files: Vec<PathBuf>,
}

/// The place of a piece in a job.
// Only sweeps want the numbers.
#[cfg_attr(not(feature = "studies"), allow(dead_code))]
pub struct Place<'a> {
    /// Its number, from 1.
    pub number: usize,
    /// Number of pieces.
    pub count: usize,
    /// Folder for what is kept until the pieces are joined.
    pub folder: &'a Path,
}

/// What the work takes.
pub struct Estimate {
    /// What each piece takes before its first unit, seconds.
    pub setup: f64,
    /// Each unit, seconds.
    pub units: Vec<f64>,
    /// Threads that a piece uses.
    pub threads: usize,
    /// Memory of a piece beyond what the estimate took, bytes.
    pub memory: u64,
    /// Memory of the merge, likewise.
    pub merge_memory: u64,
}

impl Default for Estimate {
    /// Nothing, on all threads.
    fn default() -> Estimate {
        Estimate {
            setup: 0.0,
            units: Vec::new(),
            threads: threads(),
            memory: 0,
            merge_memory: 0,
        }
    }
}

/// Returns the number of threads of this machine.
pub fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Does all of `work`, or writes the plan that was asked for.
pub fn run(work: &dyn Work, arguments: &PlanArguments) -> anyhow::Result<()> {
    if let Some(path) = &arguments.plan {
        return plan::write(work, arguments, path);
    }
    let all = Piece {
        first: 0,
        end: work.count(),
        seconds: 0.0,
    };
    let part = work.work(&all, None)?;
    work.merge(vec![part])
}

/// Returns the work of a command line; `None` if its command cannot be cut into pieces.
fn work_of(words: &[String]) -> anyhow::Result<Option<Box<dyn Work>>> {
    let words = std::iter::once("relievo").chain(words.iter().map(String::as_str));
    let arguments = Arguments::try_parse_from(words)?;
    Ok(match arguments.command.task()? {
        Task::Pieces(work, _) => Some(work),
        Task::Whole(_) => None,
    })
}

#[derive(Args)]
#[command(
    after_help = "Without --piece and --merge it tells which pieces are done.\nJob files are made by --plan of render --frames, verify, tradeoff, bounds and bench budget."
)]
pub struct JobArguments {
    /// Job file
    job: PathBuf,
    /// Do this piece, from 1, unless it is done
    #[arg(long, value_name = "I")]
    piece: Option<usize>,
    /// Join all pieces: write or print the result of the command
    #[arg(long, conflicts_with = "piece")]
    merge: bool,
}

/// `relievo job`.
pub fn job(arguments: &JobArguments) -> anyhow::Result<()> {
    match arguments.piece {
        Some(piece) => piece::run(&arguments.job, piece),
        None if arguments.merge => piece::merge(&arguments.job),
        None => piece::status(&arguments.job),
    }
}

/// `relievo submit`.
pub fn submit(arguments: &SubmitArguments) -> anyhow::Result<()> {
    slurm::submit(arguments)
}
