//! `relievo bounds`.

use super::progress::Bar;
use super::{BoundsArguments, say};
use anyhow::bail;
use relievo::bounds::{functions, page};
use relievo::file::write_bytes;

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
        Some(path) => write_bytes(path, text.as_bytes())?,
        None => say(format_args!("{}", text.trim_end()))?,
    }
    let broken: Vec<&str> = measured
        .iter()
        .filter(|(function, rows)| !rows.iter().all(|row| function.holds(row)))
        .map(|(function, _)| function.name)
        .collect();
    if !broken.is_empty() {
        bail!("bounds that are not kept: {}", broken.join("; "));
    }
    Ok(())
}
