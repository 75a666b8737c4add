//! `relievo bounds`.

use crate::cli::job::{Estimate, Part, Piece, Place, PlanArguments, Work, threads};
use crate::cli::progress::Bar;
use crate::cli::say;
use anyhow::bail;
use clap::Args;
use relievo::file::write_bytes;
use relievo_studies::bounds::{Row, functions, measure, page, rows};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args)]
pub struct BoundsArguments {
    /// Write the tables to this file, as Markdown [default: to standard output]
    #[arg(short, long, value_name = "OUT.md")]
    output: Option<PathBuf>,
    /// Inputs per row of a table
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    inputs: u32,
    #[command(flatten)]
    pub(super) plan: PlanArguments,
}

/// Measures rows `units` of all functions with `inputs` each.
fn measured(units: Range<usize>, inputs: u32) -> Vec<Row> {
    let bar = Bar::new();
    let progress = |name: &str, done: f64| bar.show(name.to_string(), done);
    measure(&rows()[units], inputs as usize, &progress)
}

/// Number of inputs that the time of a row is estimated from.
const TRIAL_INPUTS: u32 = 1000;

impl Work for BoundsArguments {
    fn unit(&self) -> &'static str {
        "row"
    }

    fn count(&self) -> usize {
        rows().len()
    }

    fn inputs(&self) -> anyhow::Result<Vec<PathBuf>> {
        Ok(Vec::new())
    }

    fn estimate(&self) -> anyhow::Result<Estimate> {
        let trial = TRIAL_INPUTS.min(self.inputs);
        let start = Instant::now();
        measured(0..self.count(), trial);
        let times = f64::from(self.inputs) / f64::from(trial);
        // A row takes one thread.
        let all = start.elapsed().as_secs_f64() * times * threads() as f64;
        Ok(Estimate {
            setup: 0.0,
            units: vec![all / self.count() as f64; self.count()],
            threads: 1,
            // Errors of a row are sorted.
            memory: 24 * u64::from(self.inputs),
            ..Estimate::default()
        })
    }

    fn work(&self, piece: &Piece, _: Option<&Place<'_>>) -> anyhow::Result<Part> {
        let rows = measured(piece.units(), self.inputs);
        Ok(Part {
            result: serde_json::to_value(rows)?,
            ..Part::default()
        })
    }

    fn merge(&self, parts: Vec<Part>) -> anyhow::Result<()> {
        let mut all = Vec::new();
        for part in parts {
            all.extend(serde_json::from_value::<Vec<Row>>(part.result)?);
        }
        let mut all = all.into_iter();
        let measured: Vec<_> = functions()
            .map(|function| {
                let rows: Vec<Row> = all.by_ref().take(function.rows().count()).collect();
                (function, rows)
            })
            .collect();
        let command = format!("relievo bounds --inputs {}", self.inputs);
        let text = page(&measured, &command, self.inputs as usize);
        match &self.output {
            Some(path) => write_bytes(path, text.as_bytes()).map_err(relievo::Error::from)?,
            None => say(format_args!("{}", text.trim_end()))?,
        }
        let broken: Vec<&str> = measured
            .iter()
            .filter(|(function, rows)| !rows.iter().all(|row| function.holds(row)))
            .map(|(function, _)| function.name)
            .collect();
        if !broken.is_empty() {
            bail!("bounds exceeded: {}", broken.join("; "));
        }
        Ok(())
    }
}
