//! `relievo submit`: the missing pieces of a job as an array of Slurm, and their merge after it.

use super::piece;
use super::plan::{Job, folder};
use crate::cli::say;
use anyhow::{Context, bail};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::Command;

#[derive(Args)]
#[command(
    after_help = "What follows -- goes to sbatch, such as -- --partition=gpu --gres=gpu:1.\nAfter failed pieces, submit again: only what is missing is done."
)]
pub struct SubmitArguments {
    /// Job file, made by --plan
    job: PathBuf,
    /// Submit to Slurm, with sbatch
    #[arg(long, required = true)]
    slurm: bool,
    /// Print the commands, and submit nothing
    #[arg(long)]
    dry_run: bool,
    /// Options for sbatch
    #[arg(last = true, value_name = "SBATCH OPTIONS")]
    options: Vec<String>,
}

/// The time limit of a piece is its estimate times this, for slower machines, and so many minutes.
const TIMES: f64 = 3.0;
const MORE_MINUTES: f64 = 5.0;

pub fn submit(arguments: &SubmitArguments) -> anyhow::Result<()> {
    let path = std::path::absolute(&arguments.job).context("there is no current folder")?;
    let (job, missing) = piece::missing(&arguments.job)?;
    let program = std::env::current_exe().context("this program has no file")?;
    let relievo = format!("{} job {}", quoted(text(&program)?), quoted(text(&path)?));
    let logs = folder(&path);
    if !arguments.dry_run {
        // Slurm does not make the folder of its output.
        std::fs::create_dir_all(&logs)
            .with_context(|| format!("cannot make {}", logs.display()))?;
    }
    let mut dependency = Vec::new();
    if !missing.is_empty() {
        let mut command = sbatch(&job, &logs, job.memory, &arguments.options);
        command
            .arg(format!("--array={}", piece::ranges(&missing)))
            .arg("--requeue")
            .arg(format!(
                "--wrap=exec {relievo} --piece \"$SLURM_ARRAY_TASK_ID\""
            ));
        let array = run(command, arguments.dry_run)?;
        say(format_args!("pieces {}: {array}", piece::ranges(&missing)))?;
        // After failures, too: the merge says which pieces are missing.
        dependency.push(format!("--dependency=afterany:{array}"));
    }
    let mut command = sbatch(&job, &logs, job.merge_memory, &arguments.options);
    command
        .args(dependency)
        .arg(format!("--wrap=exec {relievo} --merge"));
    let merge = run(command, arguments.dry_run)?;
    say(format_args!(
        "merge: {merge}; the output is in {}",
        logs.join(log(&merge)).display()
    ))
}

/// Returns the name of the file of a job's output.
fn log(job: &str) -> String {
    format!("slurm-{job}.txt")
}

/// Returns sbatch with the resources of the job, this memory (bytes), and the output in `logs`.
fn sbatch(job: &Job, logs: &Path, memory: u64, options: &[String]) -> Command {
    let longest = job.pieces.iter().map(|piece| piece.seconds);
    let longest = longest.fold(0.0, f64::max);
    let minutes = (TIMES * longest / 60.0 + MORE_MINUTES).ceil();
    // Slurm expands a % in the name.
    let logs = logs.display().to_string().replace('%', "%%");
    let mut command = Command::new("sbatch");
    command
        .arg("--parsable")
        .arg("--job-name=relievo")
        .arg(format!("--cpus-per-task={}", job.threads))
        .arg(format!("--mem={}M", memory.div_ceil(1 << 20)))
        .arg(format!("--time={minutes}"))
        .arg(format!("--output={logs}/{}", log("%j")))
        .arg("--open-mode=append")
        .args(options);
    command
}

/// Runs sbatch, and returns the number of the job.
fn run(mut sbatch: Command, dry_run: bool) -> anyhow::Result<String> {
    if dry_run {
        let words = sbatch
            .get_args()
            .map(|word| quoted(&word.to_string_lossy()));
        say(format_args!(
            "sbatch {}",
            words.collect::<Vec<_>>().join(" ")
        ))?;
        return Ok("JOB".to_string());
    }
    let output = sbatch.output();
    let output = output.context("cannot run sbatch; run this on a machine of a Slurm cluster")?;
    if !output.status.success() {
        bail!("sbatch: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    let number = String::from_utf8_lossy(&output.stdout);
    // With several clusters, its name follows.
    Ok(number
        .trim()
        .split(';')
        .next()
        .unwrap_or_default()
        .to_string())
}

/// Returns a path as text.
fn text(path: &Path) -> anyhow::Result<&str> {
    let text = path.to_str();
    text.with_context(|| format!("{} is not Unicode", path.display()))
}

/// Returns a word of a shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}
