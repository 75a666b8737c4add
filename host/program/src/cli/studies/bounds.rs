//! `relievo bounds`.

use crate::cli::progress::Bar;
use crate::cli::say;
use anyhow::bail;
use clap::Args;
use relievo::file::write_bytes;
use relievo_studies::bounds::{functions, page};
use std::path::PathBuf;

#[derive(Args)]
pub struct BoundsArguments {
    /// Write the tables to this file, as Markdown [default: to standard output]
    #[arg(short, long, value_name = "OUT.md")]
    output: Option<PathBuf>,
    /// Inputs per row of a table
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    inputs: u32,
}

pub fn run(arguments: &BoundsArguments) -> anyhow::Result<()> {
    let inputs = arguments.inputs as usize;
    let bar = Bar::new();
    let total = functions().count();
    let measured: Vec<_> = functions()
        .enumerate()
        .map(|(index, function)| {
            bar.show(function.name.to_string(), index as f64 / total as f64);
            (function, function.measure(inputs))
        })
        .collect();
    drop(bar);
    let command = format!("relievo bounds --inputs {}", arguments.inputs);
    let text = page(&measured, &command, inputs);
    match &arguments.output {
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
