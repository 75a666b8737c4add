//! Command line, output and exit codes.

#[cfg(not(all(feature = "viewer", feature = "studies")))]
mod absent;
mod accuracy;
mod bake;
mod explain;
mod export;
mod info;
mod interrupt;
mod job;
mod limits;
mod progress;
mod render;
mod sequence;
mod session;
#[cfg(feature = "studies")]
mod studies;
mod verify;
#[cfg(feature = "viewer")]
mod view;

use anyhow::Context;
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};
use job::{PlanArguments, Work};
use log::{LevelFilter, Log, Metadata, Record};
use std::fmt;
use std::io::{self, Write};
use std::ops::Range;
use std::process::ExitCode;

/// Carve patterns into meshes, outline included, without one extra triangle.
#[derive(Parser)]
#[command(
    name = "relievo",
    version,
    after_help = "Exit codes: 0 success, 1 invalid input, 2 wrong usage, 3 machine failure (no adapter, out of memory, disk full)."
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Log more: -v progress, -vv details
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene
    Render(render::RenderArguments),
    /// Open a window on a scene, with sliders for every parameter
    #[cfg(feature = "viewer")]
    View(view::ViewArguments),
    /// Open a window on a scene (needs the feature `viewer`)
    #[cfg(not(feature = "viewer"))]
    View(absent::Absent),
    /// Convert a pattern to a shape map file (a distance field) for scenes
    Bake(bake::BakeArguments),
    /// Show the contents of a scene and the adapters of this machine
    Info(info::InfoArguments),
    /// Show which parts of the model scenes need, with instructions and bytes
    Explain(explain::ExplainArguments),
    /// Compare GPU and CPU bit for bit: each function, and pictures of scenes
    Verify(verify::VerifyArguments),
    /// Measure the errors of rendered scenes: holes, extra pixels, distances
    Accuracy(accuracy::AccuracyArguments),
    /// Export the shaders of objects and their inputs for other programs
    Export(export::ExportArguments),
    /// Do or join the pieces of a job that --plan has written
    Job(job::JobArguments),
    /// Submit the pieces of a job, and their merge, to Slurm
    Submit(job::SubmitArguments),
    #[cfg(feature = "studies")]
    #[command(flatten)]
    Study(studies::Command),
    /// Measure the error of each function of the mathematics (needs the feature `studies`)
    #[cfg(not(feature = "studies"))]
    Bounds(absent::Absent),
    /// Measure frame times (needs the feature `studies`)
    #[cfg(not(feature = "studies"))]
    Bench(absent::Absent),
    /// Measure cost and error of many variants of a scene (needs the feature `studies`)
    #[cfg(not(feature = "studies"))]
    Tradeoff(absent::Absent),
    /// Report on a GPU (needs the feature `studies`)
    #[cfg(not(feature = "studies"))]
    Report(absent::Absent),
    /// Draw the paper's figures (needs the feature `studies`)
    #[cfg(not(feature = "studies"))]
    Gallery(absent::Absent),
}

/// Selects the renderer.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// A GPU if there is one, otherwise the CPU
    Auto,
    /// A GPU, or a software driver if there is none
    Gpu,
    /// The CPU
    Cpu,
}

/// Runs the command, prints errors, and returns the exit code.
pub fn run(arguments: Arguments) -> ExitCode {
    log::set_max_level(match arguments.verbose {
        0 => LevelFilter::Warn,
        1 => LevelFilter::Info,
        _ => LevelFilter::Debug,
    });
    log::set_logger(&StandardError).expect("nothing else logs");
    interrupt::watch();
    let result = match arguments.command.task() {
        Ok(Task::Pieces(work, plan)) => job::run(work.as_ref(), &plan),
        Ok(Task::Whole(run)) => run(),
        Err(error) => Err(error),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Standard error may be closed; the exit code is enough.
            let _ = writeln!(io::stderr(), "error: {}", describe(&error));
            let machine = error
                .downcast_ref::<relievo::Error>()
                .is_some_and(relievo::Error::is_machine);
            ExitCode::from(if machine { 3 } else { 1 })
        }
    }
}

/// Writes messages to standard error.
struct StandardError;

impl Log for StandardError {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        // It may be closed.
        let _ = writeln!(io::stderr(), "{:>5} {}", record.level(), record.args());
    }

    fn flush(&self) {}
}

/// What a command does.
enum Task {
    /// Work that can be cut into pieces, and how to plan it.
    Pieces(Box<dyn Work>, PlanArguments),
    /// Anything else.
    Whole(Box<dyn FnOnce() -> anyhow::Result<()>>),
}

impl Task {
    fn pieces(work: impl Work + 'static, plan: PlanArguments) -> Task {
        Task::Pieces(Box::new(work), plan)
    }

    fn whole(run: impl FnOnce() -> anyhow::Result<()> + 'static) -> Task {
        Task::Whole(Box::new(run))
    }
}

impl Command {
    /// Returns what the command does, after checking its arguments.
    fn task(self) -> anyhow::Result<Task> {
        Ok(match self {
            #[cfg(feature = "viewer")]
            Command::View(arguments) => Task::whole(move || view::run(&arguments)),
            #[cfg(not(feature = "viewer"))]
            Command::View(absent) => Task::whole(move || absent.refuse("view", "viewer")),
            Command::Render(arguments) => match arguments.frames.clone() {
                Some(frames) => {
                    let plan = arguments.plan.clone();
                    Task::pieces(sequence::Animation::new(arguments, frames)?, plan)
                }
                None => Task::whole(move || render::run(&arguments)),
            },
            Command::Bake(arguments) => Task::whole(move || bake::run(&arguments)),
            Command::Info(arguments) => Task::whole(move || info::run(&arguments)),
            Command::Explain(arguments) => Task::whole(move || explain::run(&arguments)),
            Command::Verify(arguments) => {
                let plan = arguments.plan.clone();
                Task::pieces(verify::Verification::new(arguments)?, plan)
            }
            Command::Accuracy(arguments) => Task::whole(move || accuracy::run(&arguments)),
            #[cfg(feature = "studies")]
            Command::Study(study) => study.task()?,
            #[cfg(not(feature = "studies"))]
            Command::Bounds(absent) => Task::whole(move || absent.refuse("bounds", "studies")),
            #[cfg(not(feature = "studies"))]
            Command::Bench(absent) => Task::whole(move || absent.refuse("bench", "studies")),
            #[cfg(not(feature = "studies"))]
            Command::Tradeoff(absent) => Task::whole(move || absent.refuse("tradeoff", "studies")),
            #[cfg(not(feature = "studies"))]
            Command::Report(absent) => Task::whole(move || absent.refuse("report", "studies")),
            #[cfg(not(feature = "studies"))]
            Command::Gallery(absent) => Task::whole(move || absent.refuse("gallery", "studies")),
            Command::Export(arguments) => Task::whole(move || export::run(&arguments)),
            Command::Job(arguments) => Task::whole(move || job::job(&arguments)),
            Command::Submit(arguments) => Task::whole(move || job::submit(&arguments)),
        })
    }
}

/// Exits with an error: an adapter was named for the CPU.
fn refuse_adapter() -> ! {
    let message = "--adapter names a GPU; leave it out, or leave out --backend cpu";
    Arguments::command()
        .error(ErrorKind::ArgumentConflict, message)
        .exit();
}

/// Exits with an error: a plan was asked for a single picture.
fn refuse_plan() -> ! {
    let message = "--plan cuts a sequence of frames into pieces; name --frames, or leave it out";
    Arguments::command()
        .error(ErrorKind::MissingRequiredArgument, message)
        .exit();
}

/// Formats the error with its causes, except those that it includes already.
fn describe(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Writes a line to standard output. A closed pipe, as in `relievo info | head -1`, is not an
/// error.
fn say(line: fmt::Arguments<'_>) -> anyhow::Result<()> {
    match writeln!(io::stdout(), "{line}") {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result.context("cannot write to standard output"),
    }
}

/// Parses `800x600` as [800, 600].
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let limit = relievo::scene::LARGEST_PICTURE_SIDE;
    let side = |text: &str| {
        text.parse()
            .ok()
            .filter(|side| (1..=limit).contains(side))
            .ok_or_else(|| {
                format!("a size is WIDTHxHEIGHT, such as 800x600, each from 1 to {limit}")
            })
    };
    let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, ""));
    Ok([side(width)?, side(height)?])
}

/// Parses a number of line heights.
fn parse_margin(text: &str) -> Result<f64, String> {
    let margin = text.parse().ok();
    margin
        .filter(|margin| (0.0..=10.0).contains(margin))
        .ok_or_else(|| "a margin is a number of line heights from 0 to 10, such as 0.2".to_string())
}

/// Largest number of frames of one run.
const MOST_FRAMES: u64 = 1_000_000;

/// Parses `0..48` (without 48) or `0..=47`.
fn parse_frames(text: &str) -> Result<Range<u64>, String> {
    let wrong = || {
        "frames are FIRST..END without the frame END, such as 0..48, or FIRST..=LAST".to_string()
    };
    let (first, end) = text.split_once("..").ok_or_else(wrong)?;
    let (end, is_inclusive) = match end.strip_prefix('=') {
        Some(last) => (last, true),
        None => (end, false),
    };
    let number = |text: &str| text.parse::<u64>().map_err(|_| wrong());
    let (first, end) = (number(first)?, number(end)?);
    let end = end.saturating_add(is_inclusive.into());
    match end.checked_sub(first) {
        None | Some(0) => Err(format!(
            "there is no frame in {text}; the end comes after the first"
        )),
        Some(count) if count > MOST_FRAMES => Err(format!(
            "{text} are {count} frames; draw at most {MOST_FRAMES} at once"
        )),
        Some(_) => Ok(first..end),
    }
}

/// Parses `0.5px` or `0.5` as 0.5.
fn parse_budget(text: &str) -> Result<f64, String> {
    let (least, largest) = relievo::scene::BUDGETS;
    let number = text.strip_suffix("px").unwrap_or(text).trim();
    let budget = number.parse().ok();
    budget
        .filter(|budget| (least..=largest).contains(budget))
        .ok_or_else(|| {
            format!("a budget is a number of pixels from {least} to {largest}, such as 0.5px")
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn budgets() {
        assert_eq!(parse_budget("0.5px"), Ok(0.5));
        assert_eq!(parse_budget("2"), Ok(2.0));
        for bad in ["", "px", "0", "-1px", "nan", "1000px", "0.5 pt"] {
            assert!(parse_budget(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn ranges_of_frames() {
        assert_eq!(parse_frames("0..48"), Ok(0..48));
        assert_eq!(parse_frames("7..=9"), Ok(7..10));
        for bad in [
            "",
            "5",
            "5..5",
            "9..3",
            "-1..3",
            "a..b",
            "0..",
            "0..2000000",
        ] {
            assert!(parse_frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(parse_size("800x600"), Ok([800, 600]));
        for bad in ["", "800", "0x600", "800x", "800x-1", "99999x1", "axb"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}
