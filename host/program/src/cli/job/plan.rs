//! Job files: what a command would do, cut into pieces.

use super::file::{DigestedFile, digest, own_digest};
use super::{Estimate, Work};
use crate::cli::say;
use anyhow::{Context, bail};
use clap::Args;
use relievo::file::{files_read, read_regular, write_bytes};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Options of commands that can be cut into pieces.
#[derive(Args, Clone)]
pub struct PlanArguments {
    /// Write a plan that cuts the work into pieces to this file, for relievo job
    #[arg(long, value_name = "JOB.json")]
    pub plan: Option<PathBuf>,
    /// Least estimated time of a piece, seconds; much shorter pieces overload schedulers. With 0 each
    /// unit of the work is a piece
    #[arg(long, value_name = "S", default_value_t = 30.0, requires = "plan", value_parser = parse_seconds)]
    pub piece_seconds: f64,
}

/// Options above, which are left out of the words of a job.
const OPTIONS: [&str; 2] = ["--plan", "--piece-seconds"];

/// Largest number of pieces: that of the tasks of an array in Slurm's default configuration.
const MOST_PIECES: usize = 1000;

/// Largest share of a piece that setting up takes, if there is enough work.
const LARGEST_SETUP: f64 = 0.2;

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok();
    seconds
        .filter(|seconds| (0.0..=1e6).contains(seconds))
        .ok_or_else(|| {
            "a piece takes a number of seconds from 0 to 1000000, such as 30".to_string()
        })
}

/// Version of the format.
const FORMAT: u32 = 1;

/// Largest size of a job file, bytes.
const LARGEST_FILE: u64 = 1 << 28;

/// A job file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// [`FORMAT`].
    format: u32,
    /// Version of the program.
    pub version: String,
    /// Digest of the program.
    pub program: String,
    /// The folder in which the command runs.
    pub folder: PathBuf,
    /// The words of the command.
    pub words: Vec<String>,
    /// The files that decide the results, with absolute paths.
    pub inputs: Vec<DigestedFile>,
    /// Name of a unit of the work, such as frame.
    pub unit: String,
    /// Threads of a piece.
    pub threads: usize,
    /// Memory of a piece by estimate, bytes.
    pub memory: u64,
    /// Memory of the merge by estimate, bytes.
    pub merge_memory: u64,
    /// The pieces.
    pub pieces: Vec<Piece>,
}

/// Units that are done together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Number of the first unit, from 0.
    pub first: usize,
    /// Number of the unit after the last one.
    pub end: usize,
    /// Time by estimate, seconds.
    pub seconds: f64,
}

impl Piece {
    /// Returns the numbers of the units.
    pub fn units(&self) -> Range<usize> {
        self.first..self.end
    }
}

/// Returns the folder of the pieces of the job file at `path`.
pub fn folder(path: &Path) -> PathBuf {
    path.with_extension("pieces")
}

/// Writes the plan of `work` to `path`.
pub fn write(work: &dyn Work, arguments: &PlanArguments, path: &Path) -> anyhow::Result<()> {
    if path.extension().is_none_or(|ending| ending != "json") {
        bail!(
            "--plan {} does not end in .json; choose another name",
            path.display()
        );
    }
    let pieces = folder(path);
    if pieces.exists() {
        bail!(
            "{} has pieces of an earlier plan; finish it with relievo job {}, or remove that folder to plan anew",
            pieces.display(),
            path.display()
        );
    }
    files_read();
    let estimate = work.estimate()?;
    // With the files that those name in turn: buffers of glTF, libraries of materials.
    let mut inputs = files_read();
    inputs.extend(work.inputs()?);
    let real = inputs.iter().map(|path| {
        path.canonicalize()
            .with_context(|| format!("cannot read {}", path.display()))
    });
    let inputs = real.collect::<anyhow::Result<BTreeSet<_>>>()?;
    if path.canonicalize().is_ok_and(|plan| inputs.contains(&plan)) {
        bail!(
            "{} is a file that the command reads; choose another name for the plan",
            path.display()
        );
    }
    let inputs = inputs.into_iter().map(DigestedFile::new);
    let inputs = inputs.collect::<anyhow::Result<Vec<_>>>()?;
    let memory = memory();
    let job = Job {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_string(),
        program: own_digest()?,
        folder: std::env::current_dir().context("there is no current folder")?,
        words: words(std::env::args_os().skip(1))?,
        inputs,
        unit: work.unit().to_string(),
        threads: estimate.threads,
        memory: memory + estimate.memory,
        merge_memory: memory + estimate.merge_memory,
        pieces: cut(&estimate, arguments.piece_seconds),
    };
    let mut text = serde_json::to_string_pretty(&job)?;
    text.push('\n');
    write_bytes(path, text.as_bytes()).map_err(relievo::Error::from)?;
    say(format_args!("{}: {}", path.display(), job.describe()))?;
    say(format_args!(
        "each piece: relievo job {0} --piece 1 … {1}; then: relievo job {0} --merge",
        path.display(),
        job.pieces.len()
    ))
}

impl Job {
    /// Reads the job file at `path`, and returns its digest as well.
    pub fn read(path: &Path) -> anyhow::Result<(Job, String)> {
        let bytes = read_regular(path, LARGEST_FILE)
            .with_context(|| format!("cannot read the job {}", path.display()))?;
        let job: Job = serde_json::from_slice(&bytes).with_context(|| {
            format!(
                "{} is no job file; make one with --plan {0}",
                path.display()
            )
        })?;
        if job.format != FORMAT {
            bail!(
                "{} has format {}, and this program knows {FORMAT}; plan again",
                path.display(),
                job.format
            );
        }
        Ok((job, digest(&bytes)))
    }

    /// Fails unless the program and the files are those of the plan.
    pub fn check(&self, path: &Path) -> anyhow::Result<()> {
        let own = env!("CARGO_PKG_VERSION");
        if self.version != own || self.program != own_digest()? {
            bail!(
                "{} was planned by another build of relievo ({}; this is {own}); run that one, or plan again",
                path.display(),
                self.version,
            );
        }
        std::env::set_current_dir(&self.folder).with_context(|| {
            format!(
                "{} was planned in {}, which this machine cannot enter; plan in a folder that all machines share",
                path.display(),
                self.folder.display()
            )
        })?;
        for input in &self.inputs {
            if !input.is_same()? {
                bail!(
                    "{} has changed since {} was planned; plan again",
                    input.path.display(),
                    path.display()
                );
            }
        }
        Ok(())
    }

    /// Returns the number of units.
    pub fn count(&self) -> usize {
        self.pieces.last().map_or(0, |piece| piece.end)
    }

    /// Returns its size, time and memory in a line.
    pub fn describe(&self) -> String {
        let seconds = self.pieces.iter().map(|piece| piece.seconds);
        let longest = seconds.clone().fold(0.0, f64::max);
        let count = self.count();
        format!(
            "{} in {}, each up to {} and {} MB by estimate, with {}; {} in all",
            counted(count, &self.unit),
            counted(self.pieces.len(), "piece"),
            duration(longest),
            self.memory.div_ceil(1_000_000),
            counted(self.threads, "thread"),
            duration(seconds.sum()),
        )
    }
}

/// Returns a number of things.
pub fn counted(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// Returns a time as people say it.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Returns the words of a command line without the options of plans.
fn words(all: impl Iterator<Item = OsString>) -> anyhow::Result<Vec<String>> {
    let mut words = Vec::new();
    let mut is_value = false;
    for word in all {
        let word = word.into_string().map_err(|word| {
            anyhow::anyhow!("{} is not Unicode; a plan cannot hold it", word.display())
        })?;
        let name = word.split('=').next().unwrap_or_default();
        if std::mem::take(&mut is_value) {
        } else if OPTIONS.contains(&name) {
            is_value = name == word;
        } else {
            words.push(word);
        }
    }
    Ok(words)
}

/// Cuts the work into pieces of at least `least` seconds that are about as long as each other.
fn cut(estimate: &Estimate, least: f64) -> Vec<Piece> {
    let total: f64 = estimate.units.iter().sum();
    let most = estimate.units.len().clamp(1, MOST_PIECES);
    let count = if least > 0.0 {
        let least = (least - estimate.setup).max(estimate.setup * (1.0 / LARGEST_SETUP - 1.0));
        ((total / least.max(1e-9)) as usize).clamp(1, most)
    } else {
        most
    };
    let mut pieces = Vec::with_capacity(count);
    let (mut first, mut done) = (0, 0.0);
    for piece in 1..=count {
        let goal = total * piece as f64 / count as f64;
        let mut seconds = 0.0;
        let mut end = first;
        // Each of the pieces after this one needs a unit.
        let last = estimate.units.len() - (count - piece);
        while end < last {
            let unit = estimate.units[end];
            let is_beyond = done + seconds + 0.5 * unit > goal;
            if end > first && is_beyond && piece < count {
                break;
            }
            seconds += unit;
            end += 1;
        }
        done += seconds;
        pieces.push(Piece {
            first,
            end,
            seconds: estimate.setup + seconds,
        });
        first = end;
    }
    pieces
}

/// Returns the largest memory that this process has had, with room for more, bytes.
fn memory() -> u64 {
    /// What is asked for where the system does not tell.
    const UNKNOWN: u64 = 4_000_000_000;
    const ROOM: u64 = 200_000_000;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| {
        let kilobytes = line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?;
        kilobytes.parse::<u64>().ok()
    });
    peak.map_or(UNKNOWN, |kilobytes| kilobytes * 1024 * 5 / 4 + ROOM)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(setup: f64, units: &[f64], least: f64) -> Vec<Range<usize>> {
        let units = units.to_vec();
        let pieces = cut(
            &Estimate {
                setup,
                units,
                ..Estimate::default()
            },
            least,
        );
        pieces.iter().map(Piece::units).collect()
    }

    #[test]
    fn pieces_are_as_long_as_each_other() {
        assert_eq!(pieces(0.0, &[1.0; 10], 5.0), [0..5, 5..10]);
        assert_eq!(pieces(0.0, &[1.0; 10], 4.0), [0..5, 5..10]);
        assert_eq!(pieces(0.0, &[8.0, 1.0, 1.0, 1.0, 1.0], 5.0), [0..1, 1..5]);
        // Not more than there are units, and one if they are short.
        assert_eq!(pieces(0.0, &[9.0; 3], 1.0), [0..1, 1..2, 2..3]);
        assert_eq!(pieces(0.0, &[1.0; 3], 30.0).len(), 1);
        assert_eq!(pieces(9.0, &[0.0; 3], 0.0), [0..1, 1..2, 2..3]);
        assert_eq!(pieces(0.0, &[1.0; 5000], 0.1).len(), MOST_PIECES);
        // 1 s of setting up needs 4 s of work.
        assert_eq!(pieces(1.0, &[1.0; 12], 2.0), [0..4, 4..8, 8..12]);
    }

    #[test]
    fn a_job_has_the_words_of_its_command() {
        let words = |text: &str| {
            words(text.split(' ').map(OsString::from))
                .unwrap()
                .join(" ")
        };
        assert_eq!(
            words("render a --plan job.json -o b --piece-seconds=3 --frames 0..9"),
            "render a -o b --frames 0..9"
        );
    }
}
