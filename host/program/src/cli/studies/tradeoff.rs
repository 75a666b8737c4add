//! `relievo tradeoff`.

use super::DeviceArguments;
use crate::cli::job::{Estimate, Part, Piece, Place, PlanArguments, Work, threads};
use crate::cli::limits::LimitArguments;
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use crate::cli::say;
use crate::cli::session::inputs;
use anyhow::Context;
use clap::Args;
use relievo::Error;
use relievo::file::write_bytes;
use relievo::scene::Scene;
use relievo_studies::tradeoff::{
    Asked, Devices, FORMAT, Grid, Header, Machine, Rendering, Report, Shard, Store, Subject, png,
    sweep, variants,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
#[command(
    after_help = "Each variant is on the disk as soon as it is measured: the same command goes on after an interruption.\nOn several machines: --plan (docs/cluster.md)."
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
    /// Discard measurements in the folder
    #[arg(long, conflicts_with = "plan")]
    restart: bool,
    #[command(flatten)]
    pub(super) plan: PlanArguments,
    #[command(flatten)]
    limits: LimitArguments,
}

/// Files of a report.
const CSV: &str = "tradeoff.csv";
const SVG: &str = "pareto.svg";
const PNG: &str = "pareto.png";
const PAGE: &str = "tradeoff.md";

/// A sweep. Its units are settings, each with all renderers.
pub struct Sweep {
    arguments: TradeoffArguments,
    subject: Subject,
}

impl Sweep {
    /// Reads the scene.
    pub fn new(arguments: TradeoffArguments) -> anyhow::Result<Sweep> {
        let scene = Scene::load_within(&arguments.scene, &arguments.limits.limits());
        let mut scene = scene.map_err(Error::from)?;
        if let Some(size) = arguments.size {
            scene.size = size;
        }
        let subject = Subject::new(scene)?;
        Ok(Sweep { arguments, subject })
    }

    fn grid(&self) -> Grid {
        match self.arguments.quick {
            true => Grid::Quick,
            false => Grid::Full,
        }
    }

    /// Measures the variants of `shard` that its file in `folder` lacks. Returns how many these are,
    /// and how many were there.
    fn measure(&self, shard: Shard, folder: &Path) -> anyhow::Result<[usize; 2]> {
        let Sweep { arguments, subject } = self;
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
            grid: self.grid(),
            renderings: devices.renderings(arguments.devices.has_cpu()),
            shard,
            machine: Machine {
                cpu: cpu(),
                adapter: adapter.as_ref().map(|adapter| adapter.describe()),
            },
        };
        let mut store = match Store::open(folder, &header, arguments.restart) {
            // A piece that was begun on another machine, or whose file is damaged, is begun again.
            Err(Error::Measurements { problem, .. })
                if shard.count > 1 && !problem.starts_with(Store::LOCKED) =>
            {
                log::warn!("measured anew: what is there {problem}");
                Store::open(folder, &header, true)?
            }
            opened => opened?,
        };
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
        Ok([done, kept])
    }

    /// Writes the report of all measurements in `measured`.
    fn report(&self, measured: &Path) -> anyhow::Result<()> {
        let Sweep { arguments, subject } = self;
        let folder = &arguments.output;
        let report = Report::read(measured, subject)?;
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
}

impl Work for Sweep {
    fn unit(&self) -> &'static str {
        "setting"
    }

    fn count(&self) -> usize {
        variants(&self.subject, self.grid(), &[Rendering::Cpu]).len()
    }

    fn inputs(&self) -> anyhow::Result<Vec<PathBuf>> {
        Ok(inputs(&self.subject.scene))
    }

    fn estimate(&self) -> anyhow::Result<Estimate> {
        let count = self.count();
        // The first of so many shards has `few` settings, from all parts of the sweep.
        let few = count.min(4);
        let time = |settings: usize| -> anyhow::Result<f64> {
            let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
            let shard = Shard {
                number: 1,
                count: count.div_ceil(settings) as u32,
            };
            let start = Instant::now();
            self.measure(shard, folder.path())?;
            Ok(start.elapsed().as_secs_f64())
        };
        let one = time(1)?;
        let (setup, unit) = if few > 1 {
            let unit = ((time(few)? - one) / (few - 1) as f64).max(0.0);
            ((one - unit).max(0.0), unit)
        } else {
            (0.0, one)
        };
        Ok(Estimate {
            setup,
            units: vec![unit; count],
            ..Estimate::default()
        })
    }

    fn work(&self, _: &Piece, place: Option<&Place<'_>>) -> anyhow::Result<Part> {
        let (folder, shard) = match place {
            Some(place) => (
                place.folder,
                Shard {
                    number: place.number as u32,
                    count: place.count as u32,
                },
            ),
            None => (self.arguments.output.as_path(), Shard::WHOLE),
        };
        let [done, kept] = self.measure(shard, folder)?;
        let file = folder.join(Store::name(shard));
        say(format_args!(
            "variants measured: {done}, kept from before: {kept}; {}",
            file.display()
        ))?;
        Ok(Part {
            files: vec![file],
            ..Part::default()
        })
    }

    fn merge(&self, parts: Vec<Part>) -> anyhow::Result<()> {
        // The files of all pieces are in one folder.
        let mut files = parts.iter().flat_map(|part| &part.files);
        let folder = files.next().and_then(|file| file.parent());
        self.report(folder.context("there are no measurements")?)
    }
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
    format!("{model}, {} threads", threads())
}
