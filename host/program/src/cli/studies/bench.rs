//! `relievo bench`.

use super::{DeviceArguments, Measured, Study, measured_adapter};
use crate::cli::limits::LimitArguments;
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use crate::cli::say;
use crate::cli::session::{Loaded, load, load_with};
use anyhow::bail;
use clap::Args;
use relievo::Error;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Adapter, Choice, Extent, Shaders, choose};
use relievo::render::{CpuRenderer, GpuRenderer, RenderError, Renderer};
use relievo::scene::Tier;
use relievo_studies::bench::{Backend, Summary, measure, scaling as measure_scaling};
use relievo_studies::{distance, edges};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub struct BenchSceneArguments {
    /// Scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Take the adapter with this in its name (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the picture instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Timed frames per renderer, after one to warm up
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    #[command(flatten)]
    limits: LimitArguments,
}

#[derive(Args)]
pub struct BenchTable1Arguments {
    /// Write table1.csv, table1.svg and table1.md into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Timed frames for each method and shape map, after one to warm up
    #[arg(long, default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    #[command(flatten)]
    devices: DeviceArguments,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size)]
    size: [u32; 2],
    /// Folder with this project's meshes and patterns
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
}

#[derive(Args)]
pub struct BenchScalingArguments {
    /// Write scaling.csv, scaling.svg and scaling.md into this folder
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Timed frames for each scene and tier, after one to warm up
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..100_000))]
    frames: u32,
    #[command(flatten)]
    devices: DeviceArguments,
    /// Size of the large pictures; the small ones have a tenth of it
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size)]
    size: [u32; 2],
    /// Folder with this project's meshes and patterns
    #[arg(long, value_name = "DIR", default_value = "assets")]
    assets: PathBuf,
}

/// `relievo bench scene`.
pub fn scenes(arguments: &BenchSceneArguments) -> anyhow::Result<()> {
    let found = measured_adapter(Measured::Both, arguments.adapter.as_deref())?;
    for path in &arguments.scenes {
        scene(path, arguments, found.as_ref())?;
    }
    Ok(())
}

fn scene(
    path: &Path,
    arguments: &BenchSceneArguments,
    found: Option<&Adapter>,
) -> anyhow::Result<()> {
    let loaded = load(path, arguments.size, &arguments.limits.limits())?;
    let scene = &loaded.prepared;
    say(format_args!(
        "{}: {} × {} pixels, {} triangles; prepared in {:.1} ms",
        path.display(),
        scene.size[0],
        scene.size[1],
        scene.triangle_count(),
        1e3 * scene.preparation.as_secs_f64()
    ))?;
    let mut cpu = CpuRenderer::new(scene);
    let mut gpu = match found.map(|found| GpuRenderer::new(scene, found, Choice::Trusted)) {
        Some(Ok(gpu)) => Some(gpu),
        // Report the CPU's times all the same.
        Some(Err(error @ RenderError::Limit { .. })) => {
            say(format_args!("left out: {error}"))?;
            None
        }
        Some(Err(error)) => return Err(Error::from(error).into()),
        None => None,
    };
    // Alternate, so that noise affects both alike; the first round warms up.
    let (mut cpu_times, mut gpu_times, mut pass_times) = (Vec::new(), Vec::new(), Vec::new());
    for round in 0..=arguments.frames {
        let start = Instant::now();
        cpu.color(&scene.frame).map_err(Error::from)?;
        let cpu_time = start.elapsed();
        if round > 0 {
            cpu_times.push(1e3 * cpu_time.as_secs_f64());
        }
        if let Some(gpu) = &mut gpu {
            let gpu_time = gpu.time_color(&scene.frame).map_err(Error::from)?;
            if round > 0 {
                gpu_times.push(1e3 * gpu_time.wall.as_secs_f64());
                pass_times.extend(gpu_time.pass.map(|pass| 1e3 * pass.as_secs_f64()));
            }
        }
    }
    report(&cpu.name(), &cpu_times)?;
    let work = cpu.statistics(&scene.frame);
    let each = |count: u64| count as f64 / work.hits.max(1) as f64;
    say(format_args!(
        "{} rays hit, after {:.2} steps and {:.2} prisms each",
        work.hits,
        each(work.steps),
        each(work.prisms)
    ))?;
    match &gpu {
        Some(gpu) => {
            report(&gpu.name(), &gpu_times)?;
            report("its render pass, by device timestamps", &pass_times)
        }
        None if found.is_none() => say(format_args!("no GPU adapter")),
        None => Ok(()),
    }
}

/// Loads the scene at `path` without and with smooth edges.
fn without_and_with_smooth_edges(
    path: &Path,
    arguments: &BenchSceneArguments,
) -> Result<[Loaded; 2], Error> {
    let loaded = |is_smooth| {
        load_with(path, arguments.size, &arguments.limits.limits(), |scene| {
            scene.smooth_edges = is_smooth;
        })
    };
    Ok([loaded(false)?, loaded(true)?])
}

/// `relievo bench edges`.
pub fn edges(arguments: &BenchSceneArguments) -> anyhow::Result<()> {
    let found = measured_adapter(Measured::Both, arguments.adapter.as_deref())?;
    let gpu_name = found
        .as_ref()
        .map_or("no GPU".to_string(), Adapter::describe);
    say(format_args!(
        "errors against {} samples a pixel, in brackets with perfect edges and with exact coverage; times as multiples of those of one sample: CPU, {gpu_name}",
        edges::REFERENCE.pow(2)
    ))?;
    for path in &arguments.scenes {
        let [plain, smooth] = without_and_with_smooth_edges(path, arguments)?;
        let (plain, smooth) = (plain.prepared, smooth.prepared);
        let renderer = |scene| {
            found
                .as_ref()
                .map(|found| GpuRenderer::new(scene, found, Choice::Trusted))
                .transpose()
                .map_err(Error::from)
        };
        let mut gpu = renderer(&plain)?.zip(renderer(&smooth)?);
        let gpu = gpu
            .as_mut()
            .map(|(plain, smooth)| [plain as &mut dyn Renderer, smooth]);
        let rows = {
            let bar = Bar::new();
            let progress = |message: &str, fraction| bar.show(message.to_string(), fraction);
            edges::measure([&plain, &smooth], gpu, arguments.frames, &progress)?
        };
        let [width, height] = plain.size;
        say(format_args!("{}, {width} × {height}", path.display()))?;
        for ((factor, is_smooth), row) in edges::VARIANTS.into_iter().zip(rows) {
            let ratio = |summary: Option<Summary>| match summary {
                Some(summary) => format!("{:.2}", summary.median),
                None => "-".to_string(),
            };
            say(format_args!(
                "  {} a pixel{}: FLIP {:.4} ({:.4}, {:.4}), RMSE {:.2} of 255, time {} and {}",
                match factor {
                    1 => "1 sample".to_string(),
                    _ => format!("{} samples", factor * factor),
                },
                if is_smooth { ", smooth edges" } else { "" },
                row.flip,
                row.inside,
                row.covered,
                row.rmse,
                ratio(row.ratios[0]),
                ratio(row.ratios[1])
            ))?;
        }
    }
    Ok(())
}

/// `relievo bench distance`.
pub fn distance(arguments: &BenchSceneArguments) -> anyhow::Result<()> {
    say(format_args!(
        "on the CPU, each number without and with smooth edges\n\
         flicker: FLIP between frames of a camera that moves by {} pixels a frame, minus that of {samples} samples a pixel\n\
         in brackets: flicker with exact coverage, each class in the colour of the nearest sample\n\
         error: FLIP from {samples} samples a pixel\n\
         time: microseconds per pixel with a hit",
        distance::STEP,
        samples = edges::REFERENCE.pow(2)
    ))?;
    for path in &arguments.scenes {
        let [plain, smooth] = without_and_with_smooth_edges(path, arguments)?;
        let rows = {
            let bar = Bar::new();
            let progress = |message: &str, fraction| bar.show(message.to_string(), fraction);
            let prepared = [&plain.prepared, &smooth.prepared];
            let size = plain.prepared.size;
            distance::measure(&plain.scene, prepared, size, arguments.frames, &progress)?
        };
        say(format_args!("{}", path.display()))?;
        for row in rows {
            let [width, height] = row.size;
            let [flicker, smooth_flicker] = row.flicker;
            let [error, smooth_error] = row.error;
            let [time, smooth_time] = row.time;
            say(format_args!(
                "  {:>5} times as far, {width} × {height}: flicker {flicker:.5} {smooth_flicker:.5} ({:.5}), error {error:.4} {smooth_error:.4}, time {time:.2} {smooth_time:.2}",
                row.distance, row.covered
            ))?;
        }
    }
    Ok(())
}

fn report(name: &str, times: &[f64]) -> anyhow::Result<()> {
    let Some(time) = Summary::of(times) else {
        return Ok(());
    };
    say(format_args!(
        "{name}: median {:.2} ms a frame, from {:.2} to {:.2}, {} frames",
        time.median,
        time.minimum,
        time.maximum,
        times.len()
    ))
}

/// Shaders that are timed against each other.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Comparison {
    /// The exact shaders and the fast ones, in every tier.
    Exactness,
    /// The shaders specialized for the scene and the general ones.
    Specialization,
}

/// `relievo bench exactness` and `relievo bench specialization`.
pub fn compare(arguments: &BenchSceneArguments, comparison: Comparison) -> anyhow::Result<()> {
    let found = choose(arguments.adapter.as_deref()).map_err(Error::from)?;
    let (names, shaders, tiers) = match comparison {
        Comparison::Exactness if !found.takes_spirv() => bail!(
            "{} does not take SPIR-V untouched, so there are no exact shaders to time",
            found.describe()
        ),
        Comparison::Exactness => (
            ["exact", "fast"],
            [Shaders::Exact, Shaders::Fast].map(|shaders| (Choice::These(shaders), Extent::Needed)),
            Tier::ALL.map(Some).to_vec(),
        ),
        Comparison::Specialization => (
            ["special", "general"],
            [Extent::Needed, Extent::Everything].map(|extent| (Choice::Trusted, extent)),
            vec![None],
        ),
    };
    say(format_args!("{}", found.describe()))?;
    for path in &arguments.scenes {
        for tier in &tiers {
            let limits = arguments.limits.limits();
            let loaded = load_with(path, arguments.size, &limits, |scene| {
                for object in &mut scene.objects {
                    object.tier = tier.unwrap_or(object.tier);
                }
            })?;
            let scene = &loaded.prepared;
            let renderer = |(choice, extent)| {
                GpuRenderer::with_extent(scene, &found, choice, extent).map_err(Error::from)
            };
            let [first, second] = shaders;
            let renderers = [renderer(first)?, renderer(second)?];
            let what = match tier {
                Some(tier) => format!("{}, {} tier", path.display(), tier.name()),
                None => path.display().to_string(),
            };
            in_turn(&what, scene, arguments.frames, names, renderers)?;
        }
    }
    Ok(())
}

/// Times two renderers of one scene in turn, and prints the comparison.
fn in_turn(
    what: &str,
    scene: &PreparedScene,
    frames: u32,
    names: [&str; 2],
    mut renderers: [GpuRenderer; 2],
) -> anyhow::Result<()> {
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..=frames {
        for (renderer, times) in renderers.iter_mut().zip(&mut times) {
            let time = renderer.time_color(&scene.frame).map_err(Error::from)?;
            if round > 0 {
                times.push(1e3 * time.pass.unwrap_or(time.wall).as_secs_f64());
            }
        }
    }
    let [first, second] = &times;
    let summaries = (
        Summary::of(first),
        Summary::of(second),
        Summary::of_ratios(first, second),
    );
    if let (Some(first), Some(second), Some(ratio)) = summaries {
        let [one, other] = names;
        say(format_args!(
            "{what}, {} × {}: {one} {:.2} ms, {other} {:.2} ms (medians of {frames} frames in turn); {one} / {other} {:.3} (quartiles {:.3} to {:.3})",
            scene.size[0],
            scene.size[1],
            first.median,
            second.median,
            ratio.median,
            ratio.lower_quartile,
            ratio.upper_quartile,
        ))?;
    }
    Ok(())
}

/// `relievo bench table1`.
pub fn table1(arguments: &BenchTable1Arguments) -> anyhow::Result<()> {
    let found = arguments.devices.adapter()?;
    let mut backends = Vec::new();
    if arguments.devices.has_cpu() {
        backends.push(Backend::Cpu);
    }
    if let Some(found) = &found {
        let shaders: &[Shaders] = if found.takes_spirv() {
            &[Shaders::Exact, Shaders::Fast]
        } else {
            &[Shaders::Portable]
        };
        backends.extend(shaders.iter().map(|shaders| Backend::Gpu(found, *shaders)));
    }

    let table = {
        let bar = Bar::new();
        measure(
            &backends,
            arguments.size,
            arguments.frames,
            &arguments.assets,
            &|message, fraction| bar.show(message, fraction),
        )
    };
    let table = table.map_err(|error| about_assets(error, &arguments.assets))?;
    Study {
        name: "table1",
        title: "Table 1 of the paper, measured",
        picture: "The times as bars",
        text: table.to_string(),
        csv: table.to_csv(),
        svg: &|| table.to_svg(),
    }
    .write(arguments.output.as_deref())
}

/// `relievo bench scaling`.
pub fn scaling(arguments: &BenchScalingArguments) -> anyhow::Result<()> {
    let found = arguments.devices.adapter()?;
    let measured = {
        let bar = Bar::new();
        measure_scaling(
            found.as_ref(),
            arguments.size,
            arguments.frames,
            &arguments.assets,
            &|message, fraction| bar.show(message, fraction),
        )
    };
    let measured = measured.map_err(|error| about_assets(error, &arguments.assets))?;
    Study {
        name: "scaling",
        title: "Times over triangles and copies",
        picture: "The times as lines",
        text: measured.to_string(),
        csv: measured.to_csv(),
        svg: &|| measured.to_svg(),
    }
    .write(arguments.output.as_deref())
}

/// Adds to an error of reading where the project's files are expected.
pub fn about_assets(error: Error, assets: &Path) -> anyhow::Error {
    match error {
        Error::Mesh(_) | Error::ShapeMap(_) | Error::Scene(_) => {
            let assets = assets.display();
            anyhow::Error::from(error).context(format!(
                "{assets} does not hold this project's meshes, patterns and scenes; name the folder that does with --assets"
            ))
        }
        error => error.into(),
    }
}
