//! `relievo bake`.

use super::progress::Bar;
use super::{BakeArguments, say};
use relievo::Error;
use relievo::shape_map::{Pattern, PatternOptions, Storage, bake};
use std::time::Instant;

pub fn run(arguments: &BakeArguments) -> anyhow::Result<()> {
    let storage = if arguments.bits == "8" {
        Storage::Bits8
    } else {
        Storage::Bits16
    };
    let options = PatternOptions {
        threshold: arguments.threshold,
        invert: arguments.invert,
        ..PatternOptions::default()
    };
    let pattern = Pattern::load(&arguments.pattern, &options).map_err(Error::from)?;
    let start = Instant::now();
    let map = {
        let bar = Bar::new();
        bake(&pattern, storage, &|fraction| {
            bar.show("distances".to_string(), fraction);
        })
    };
    let seconds = start.elapsed().as_secs_f64();
    map.save_png(&arguments.output).map_err(Error::from)?;
    say(format_args!(
        "{}: {} × {} texels, {} bits, distances from {} to {} texels in steps of {}{}, baked in {seconds:.3} s",
        arguments.output.display(),
        map.width(),
        map.height(),
        arguments.bits,
        map.min_distance(),
        map.max_distance(),
        map.step(),
        if map.saturated() {
            " (farther ones saturate)"
        } else {
            ""
        },
    ))?;
    Ok(())
}
