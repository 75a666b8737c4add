//! `relievo bench geometry`.

use super::{DeviceArguments, Study};
use crate::cli::limits::LimitArguments;
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use clap::Args;
use relievo::Error;
use relievo::scene::Scene;
use relievo_studies::geometry::{Comparison, check, measure, settings};
use std::path::PathBuf;

#[derive(Args)]
pub struct BenchGeometryArguments {
    /// Scene file with one object
    scene: PathBuf,
    /// Write geometry.csv, geometry.svg and geometry.md into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Most repeats of the pattern along u and v
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1024))]
    most: u32,
    /// Repeats at other distances and sizes of the picture
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=1024))]
    middle: u32,
    /// Timed frames for each method, after one to warm up
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    #[command(flatten)]
    devices: DeviceArguments,
    /// Size of the picture instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    limits: LimitArguments,
}

/// `relievo bench geometry`.
pub fn run(arguments: &BenchGeometryArguments) -> anyhow::Result<()> {
    let adapter = arguments.devices.adapter()?;
    let limits = arguments.limits.limits();
    let mut scene = Scene::load_within(&arguments.scene, &limits).map_err(Error::from)?;
    scene.size = arguments.size.unwrap_or(scene.size);
    check(&scene)?;
    let settings = settings(arguments.most, arguments.middle);
    let mut rows = Vec::new();
    {
        let bar = Bar::new();
        for (number, setting) in settings.iter().enumerate() {
            let done = number as f64 / settings.len() as f64;
            let progress = |what: &str| bar.show(format!("{}²: {what}", setting.repeat), done);
            let frames = arguments.frames;
            rows.push(measure(
                &scene,
                setting,
                adapter.as_ref(),
                frames,
                &progress,
            )?);
        }
    }
    let stem = arguments.scene.file_stem().unwrap_or_default();
    let comparison = Comparison {
        scene: stem.to_string_lossy().into_owned(),
        gpu: adapter.map(|adapter| adapter.describe()),
        frames: arguments.frames,
        rows,
    };
    Study {
        name: "geometry",
        title: "Triangles beside extrusions",
        picture: "Time, memory and preparation",
        text: comparison.to_string(),
        csv: comparison.to_csv(),
        svg: &|| comparison.to_svg(),
    }
    .write(arguments.output.as_deref())
}
