//! `relievo tradeoff`.

use super::DeviceArguments;
use crate::cli::limits::LimitArguments;
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use crate::cli::say;
use anyhow::Context;
use clap::Args;
use relievo::Error;
use relievo::file::write_bytes;
use relievo::scene::Scene;
use relievo_studies::tradeoff::{
    Asked, Devices, FORMAT, Grid, Header, Machine, Report, Shard, Store, Subject, png, sweep,
};
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    after_help = "Each variant is on the disk as soon as it is measured: the same command goes on after an interruption.\nOn several machines: --shard 1/8 … --shard 8/8 with one folder, then --merge."
)]
pub struct TradeoffArguments {
    /// Scene file
    scene: PathBuf,
    /// Write measurements, tradeoff.csv, pareto.svg, pareto.png and tradeoff.md into this folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Measure a dozen settings instead of all
    #[arg(long)]
    quick: bool,
    /// Timed frames per variant, in turn with one reference, after one to warm up; up to four times
    /// as many where times vary
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    #[command(flatten)]
    devices: DeviceArguments,
    /// Size of the pictures instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Measure only this part of the variants, such as 2/8, and write no report
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    shard: Option<Shard>,
    /// Measure nothing; join the parts in the folder and write the report
    #[arg(long, conflicts_with_all = ["shard", "restart", "quick", "frames", "backend", "adapter", "size"])]
    merge: bool,
    /// Discard this shard's measurements in the folder, and those of sweeps with another number of
    /// shards
    #[arg(long)]
    restart: bool,
    #[command(flatten)]
    limits: LimitArguments,
}

/// Files of a report.
const CSV: &str = "tradeoff.csv";
const SVG: &str = "pareto.svg";
const PNG: &str = "pareto.png";
const PAGE: &str = "tradeoff.md";

pub fn run(arguments: &TradeoffArguments) -> anyhow::Result<()> {
    let mut scene =
        Scene::load_within(&arguments.scene, &arguments.limits.limits()).map_err(Error::from)?;
    if let Some(size) = arguments.size {
        scene.size = size;
    }
    let subject = Subject::new(scene)?;
    if arguments.merge {
        return report(&subject, arguments);
    }
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    measure(&subject, shard, arguments)?;
    if shard.count == 1 {
        return report(&subject, arguments);
    }
    say(format_args!(
        "when all {} shards are done: relievo tradeoff {} -o {} --merge",
        shard.count,
        arguments.scene.display(),
        arguments.output.display()
    ))
}

/// Measures the missing variants of `shard`.
fn measure(subject: &Subject, shard: Shard, arguments: &TradeoffArguments) -> anyhow::Result<()> {
    let adapter = arguments.devices.adapter()?;
    let devices = Devices {
        adapter: adapter.as_ref(),
    };
    let header = Header {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene: name_of(&arguments.scene),
        digest: subject.digest.clone(),
        size: subject.scene.size,
        frames: arguments.frames,
        grid: if arguments.quick {
            Grid::Quick
        } else {
            Grid::Full
        },
        renderings: devices.renderings(arguments.devices.has_cpu()),
        shard,
        machine: Machine {
            cpu: cpu(),
            adapter: adapter.as_ref().map(|adapter| adapter.describe()),
        },
    };
    let mut store = Store::open(&arguments.output, &header, arguments.restart)?;
    let kept = store.records.len();
    let bar = Bar::new();
    let done = sweep(
        subject,
        &header,
        &devices,
        &mut store,
        &|message, fraction| {
            bar.show(message, fraction);
        },
    )?;
    drop(bar);
    say(format_args!(
        "variants measured: {done}, kept from before: {kept}; {}",
        arguments.output.join(Store::name(shard)).display()
    ))
}

/// Writes the report of all measurements in the folder.
fn report(subject: &Subject, arguments: &TradeoffArguments) -> anyhow::Result<()> {
    let folder = &arguments.output;
    let report = Report::read(folder, subject)?;
    let encoding = |name: &str| {
        let path = folder.join(name);
        |message| Error::Encode { path, message }
    };
    let svg = report.to_svg().map_err(encoding(SVG))?;
    let picture = png(&svg).map_err(encoding(PNG))?;
    let command = command(arguments, &report)?;
    let asked = Asked {
        command: &command,
        csv: CSV,
        chart: SVG,
    };
    let page = report.to_markdown(subject, asked);
    for (name, bytes) in [
        (CSV, report.to_csv().as_bytes()),
        (SVG, svg.as_bytes()),
        (PNG, picture.as_slice()),
        (PAGE, page.as_bytes()),
    ] {
        let path = folder.join(name);
        write_bytes(&path, bytes).map_err(relievo::Error::from)?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}

/// Returns the command line of this measurement.
fn command(arguments: &TradeoffArguments, report: &Report) -> anyhow::Result<String> {
    let header = report
        .headers
        .first()
        .context("there are no measurements")?;
    let [width, height] = header.size;
    let mut words = format!(
        "relievo tradeoff {} -o {} --size {width}x{height} --frames {}",
        arguments.scene.display(),
        arguments.output.display(),
        header.frames
    );
    if header.grid == Grid::Quick {
        words += " --quick";
    }
    if header.shard.count > 1 {
        words += &format!(" --shard i/{}", header.shard.count);
    }
    Ok(words)
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Returns the CPU's model, if the system tells it, and number of threads.
fn cpu() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = known
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or("CPU", |(_, model)| model.trim());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {threads} threads")
}

/// Parses `2/8` as the second of eight shards.
pub fn parse_shard(text: &str) -> Result<Shard, String> {
    const MOST: u32 = 10_000;
    let numbers = text.split_once('/').and_then(|(number, count)| {
        let shard = Shard {
            number: number.parse().ok()?,
            count: count.parse().ok()?,
        };
        let is_one = (1..=MOST).contains(&shard.count) && (1..=shard.count).contains(&shard.number);
        is_one.then_some(shard)
    });
    numbers.ok_or_else(|| {
        format!("a shard is its number, from 1, of how many there are (up to {MOST}), such as 2/8")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards() {
        let shard = |number, count| Ok(Shard { number, count });
        assert_eq!(parse_shard("2/8"), shard(2, 8));
        assert_eq!(parse_shard("1/1"), shard(1, 1));
        for bad in ["", "2", "0/4", "5/4", "1/0", "-1/2", "a/b", "1/99999"] {
            assert!(parse_shard(bad).is_err(), "{bad}");
        }
    }
}
