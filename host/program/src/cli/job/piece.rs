//! The pieces of a job: doing one, and joining all.

use super::file::DigestedFile;
use super::plan::{Job, counted, duration, folder};
use super::{Part, Place, Work, work_of};
use crate::cli::say;
use anyhow::{Context, bail};
use relievo::file::{read_regular, write_bytes};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The file of a piece that is done.
#[derive(Serialize, Deserialize)]
struct Done {
    /// Digest of the job file.
    job: String,
    /// Number of the piece, from 1.
    piece: usize,
    /// Time, seconds.
    seconds: f64,
    /// [`Part::result`].
    result: Value,
    /// [`Part::files`].
    files: Vec<DigestedFile>,
}

impl Done {
    /// Fails if a file that the piece has written is gone or has changed.
    fn check(&self) -> anyhow::Result<()> {
        for file in &self.files {
            if !file.is_same()? {
                bail!("{} has changed", file.path.display());
            }
        }
        Ok(())
    }
}

/// Largest size of the file of a piece, bytes.
const LARGEST_FILE: u64 = 1 << 30;

/// A job, and where its files are.
struct Opened {
    job: Job,
    digest: String,
    path: PathBuf,
}

/// Returns the file of a piece.
pub fn path(job: &Path, piece: usize) -> PathBuf {
    folder(job).join(format!("{piece:04}.json"))
}

impl Opened {
    fn open(path: &Path) -> anyhow::Result<Opened> {
        let (job, digest) = Job::read(path)?;
        // The folder will be another one.
        let path = std::path::absolute(path).context("there is no current folder")?;
        Ok(Opened { job, digest, path })
    }

    /// Returns the command, with the program and the files of the plan.
    fn work(&self) -> anyhow::Result<Box<dyn Work>> {
        self.job.check(&self.path)?;
        work_of(&self.job.words)?.with_context(|| {
            format!(
                "{} has a command that has no pieces; plan again",
                self.path.display()
            )
        })
    }

    /// Returns what piece `number` has done; `None` if it is not done.
    ///
    /// # Errors
    /// If its file belongs to something else.
    fn done(&self, number: usize) -> anyhow::Result<Option<Done>> {
        let path = path(&self.path, number);
        let bytes = match read_regular(&path, LARGEST_FILE) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => bail!("cannot read {}: {error}", path.display()),
        };
        let again = format!("remove it and run piece {number} again");
        let done: Done = serde_json::from_slice(&bytes)
            .with_context(|| format!("{} is damaged; {again}", path.display()))?;
        if done.job != self.digest {
            bail!("{} is of another plan; {again}", path.display());
        }
        if done.piece != number {
            bail!(
                "{} is piece {}, a second time; {again}",
                path.display(),
                done.piece
            );
        }
        Ok(Some(done))
    }

    /// Returns the times of the pieces that are done, seconds, and the numbers of the others: also
    /// of those whose outputs are gone.
    fn survey(&self) -> anyhow::Result<(Vec<f64>, Vec<usize>)> {
        self.job.check(&self.path)?;
        let (mut times, mut missing) = (Vec::new(), Vec::new());
        for number in 1..=self.job.pieces.len() {
            match self.done(number)? {
                Some(done) if done.check().is_ok() => times.push(done.seconds),
                _ => missing.push(number),
            }
        }
        Ok((times, missing))
    }
}

/// Does piece `number` of the job, unless it is done.
pub fn run(job: &Path, number: usize) -> anyhow::Result<()> {
    let opened = Opened::open(job)?;
    let count = opened.job.pieces.len();
    let Some(piece) = number
        .checked_sub(1)
        .and_then(|index| opened.job.pieces.get(index))
    else {
        bail!(
            "{} has pieces 1 to {count}, and no piece {number}",
            job.display()
        );
    };
    let work = opened.work()?;
    let file = path(&opened.path, number);
    if let Some(done) = opened.done(number)?
        && done.check().is_ok()
    {
        return say(format_args!(
            "piece {number} of {count} was done before: {}",
            file.display()
        ));
    }
    let start = Instant::now();
    let folder = folder(&opened.path);
    let place = Place {
        number,
        count,
        folder: &folder,
    };
    let part = work.work(piece, Some(&place))?;
    let seconds = start.elapsed().as_secs_f64();
    let files = part.files.into_iter().map(DigestedFile::new);
    let done = Done {
        job: opened.digest,
        piece: number,
        seconds,
        result: part.result,
        files: files.collect::<anyhow::Result<_>>()?,
    };
    let mut text = serde_json::to_string(&done)?;
    text.push('\n');
    write_bytes(&file, text.as_bytes()).map_err(relievo::Error::from)?;
    say(format_args!(
        "piece {number} of {count}: {} in {}; {}",
        counted(piece.units().len(), &opened.job.unit),
        duration(done.seconds),
        file.display()
    ))
}

/// Joins the pieces of the job.
pub fn merge(job: &Path) -> anyhow::Result<()> {
    let opened = Opened::open(job)?;
    let work = opened.work()?;
    let (mut parts, mut missing, mut problems) = (Vec::new(), Vec::new(), Vec::new());
    for number in 1..=opened.job.pieces.len() {
        match opened.done(number) {
            Ok(Some(done)) => match done.check() {
                Ok(()) => parts.push(Part {
                    result: done.result,
                    files: done.files.into_iter().map(|file| file.path).collect(),
                }),
                Err(problem) => problems.push(format!("piece {number}: {problem:#}; run it again")),
            },
            Ok(None) => missing.push(number),
            Err(error) => problems.push(format!("{error:#}")),
        }
    }
    if !missing.is_empty() {
        problems.push(format!(
            "pieces are missing: {}; run each with relievo job {} --piece I",
            ranges(&missing),
            job.display()
        ));
    }
    if !problems.is_empty() {
        bail!("{}", problems.join("\n"));
    }
    work.merge(parts)
}

/// Says which pieces are done.
pub fn status(job: &Path) -> anyhow::Result<()> {
    let opened = Opened::open(job)?;
    let (times, missing) = opened.survey()?;
    say(format_args!("relievo {}", opened.job.words.join(" ")))?;
    say(format_args!("{}", opened.job.describe()))?;
    // The sum of no numbers is −0.
    let spent = duration(times.iter().sum::<f64>() + 0.0);
    if missing.is_empty() {
        return say(format_args!("all pieces are done, in {spent}"));
    }
    say(format_args!(
        "{} done, in {spent}; missing: {}",
        counted(times.len(), "piece"),
        ranges(&missing)
    ))
}

/// Returns the job, and the numbers of the pieces that are not done or whose outputs are gone.
pub fn missing(job: &Path) -> anyhow::Result<(Job, Vec<usize>)> {
    let opened = Opened::open(job)?;
    let (_, missing) = opened.survey()?;
    Ok((opened.job, missing))
}

/// Returns numbers in ascending order as `1-3,7`.
pub fn ranges(numbers: &[usize]) -> String {
    let mut text = String::new();
    for run in numbers.chunk_by(|a, b| a + 1 == *b) {
        if !text.is_empty() {
            text.push(',');
        }
        match run {
            [one] => text += &one.to_string(),
            [first, .., last] => text += &format!("{first}-{last}"),
            [] => {}
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_ranges() {
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
        assert_eq!(ranges(&[]), "");
    }
}
