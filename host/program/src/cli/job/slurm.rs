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

/// A piece gets this many times its estimate, and so many minutes more: machines differ.
const TIMES: f64 = 3.0;
const MORE_MINUTES: f64 = 5.0;

pub fn submit(arguments: &SubmitArguments) -> anyhow::Result<()> {
    let path = std::path::absolute(&arguments.job).context("there is no current folder")?;
    let (job, missing) = piece::missing(&arguments.job)?;
    let program = std::env::current_exe().context("this program has no file")?;
    let relievo = format!("{} job {}", quoted(&program)?, quoted(&path)?);
    if !arguments.dry_run {
        // Slurm does not make the folder of its output.
        let logs = folder(&path);
        std::fs::create_dir_all(&logs)
            .with_context(|| format!("cannot make {}", logs.display()))?;
    }
    let mut dependency = Vec::new();
    if !missing.is_empty() {
        let mut command = sbatch(&job, &path, job.memory, &arguments.options);
        command
            .arg(format!("--array={}", piece::ranges(&missing)))
            .arg("--requeue")
            .arg(format!(
                "--wrap=exec {relievo} --piece \"$SLURM_ARRAY_TASK_ID\""
            ));
        let array = run(&command, arguments.dry_run)?;
        say(format_args!("pieces {}: {array}", piece::ranges(&missing)))?;
        // After failures, too: the merge says which pieces are missing.
        dependency.push(format!("--dependency=afterany:{array}"));
    }
    let mut command = sbatch(&job, &path, job.merge_memory, &arguments.options);
    command
        .args(dependency)
        .arg(format!("--wrap=exec {relievo} --merge"));
    let merge = run(&command, arguments.dry_run)?;
    say(format_args!(
        "merge: {merge}; the output is in {}",
        log(&path, &merge).display()
    ))
}

/// Returns the file of the output of a job.
fn log(path: &Path, name: &str) -> PathBuf {
    folder(path).join(format!("slurm-{name}.txt"))
}

/// Returns sbatch with the resources of the job and this memory, bytes.
fn sbatch(job: &Job, path: &Path, memory: u64, options: &[String]) -> Command {
    let longest = job.pieces.iter().map(|piece| piece.seconds);
    let longest = longest.fold(0.0, f64::max);
    let minutes = (TIMES * longest / 60.0 + MORE_MINUTES).ceil();
    // In names of files a % is Slurm's.
    let logs = folder(path).display().to_string().replace('%', "%%");
    let output = format!("{logs}/slurm-%j.txt");
    let mut command = Command::new("sbatch");
    command
        .arg("--parsable")
        .arg("--job-name=relievo")
        .arg(format!("--cpus-per-task={}", job.threads))
        .arg(format!("--mem={}M", memory.div_ceil(1 << 20)))
        .arg(format!("--time={minutes}"))
        .arg(format!("--output={output}"))
        .arg("--open-mode=append")
        .args(options);
    command
}

/// Runs sbatch, and returns the number of the job.
fn run(command: &Command, dry_run: bool) -> anyhow::Result<String> {
    let words = command.get_args().map(|word| word.to_string_lossy());
    if dry_run {
        let words: Vec<String> = words
            .map(|word| format!("'{}'", word.replace('\'', "'\\''")))
            .collect();
        say(format_args!("sbatch {}", words.join(" ")))?;
        return Ok("JOB".to_string());
    }
    let mut sbatch = Command::new(command.get_program());
    let output = sbatch.args(command.get_args()).output();
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

/// Returns a path for a shell.
fn quoted(path: &Path) -> anyhow::Result<String> {
    let text = path.to_str();
    let text = text.with_context(|| format!("{} is not Unicode", path.display()))?;
    Ok(format!("'{}'", text.replace('\'', "'\\''")))
}
