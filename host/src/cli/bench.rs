//! `relievo bench`.

use super::progress::Bar;
use super::session::{load, load_with, measured_adapter};
use super::{BenchSceneArguments, BenchTable1Arguments, Measured, say};
use anyhow::bail;
use relievo::Error;
use relievo::bench::{Backend, Summary, Table1, measure};
use relievo::file::write_bytes;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Adapter, Choice, Extent, Shaders, choose};
use relievo::render::{CpuRenderer, GpuRenderer, RenderError, Renderer};
use relievo::scene::Tier;
use std::path::Path;
use std::time::Instant;

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
        // Such a scene has the CPU's figures all the same.
        Some(Err(error @ RenderError::Limit { .. })) => {
            say(format_args!("left out: {error}"))?;
            None
        }
        Some(Err(error)) => return Err(Error::from(error).into()),
        None => None,
    };
    // In turn, so that a noisy machine disturbs both alike; the first round warms up.
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
    let effort = cpu.effort(&scene.frame);
    let each = |count: u64| count as f64 / effort.hits.max(1) as f64;
    say(format_args!(
        "{} rays met something, after {:.2} steps and {:.2} prisms each",
        effort.hits,
        each(effort.steps),
        each(effort.prisms)
    ))?;
    match &gpu {
        Some(gpu) => {
            report(&gpu.name(), &gpu_times)?;
            report("its render pass, by its own clock", &pass_times)
        }
        None if found.is_none() => say(format_args!("no GPU adapter")),
        None => Ok(()),
    }
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

/// `relievo bench exactness`.
pub fn exactness(arguments: &BenchSceneArguments) -> anyhow::Result<()> {
    let found = choose(arguments.adapter.as_deref()).map_err(Error::from)?;
    if !found.takes_spirv() {
        bail!(
            "{} takes no SPIR-V untouched, so that there are no exact shaders to time",
            found.describe()
        );
    }
    say(format_args!("{}", found.describe()))?;
    for path in &arguments.scenes {
        for tier in Tier::ALL {
            exactness_of(path, arguments, &found, tier)?;
        }
    }
    Ok(())
}

/// Times the exact and the fast shaders on a scene whose objects are all of `tier`.
fn exactness_of(
    path: &Path,
    arguments: &BenchSceneArguments,
    found: &Adapter,
    tier: Tier,
) -> anyhow::Result<()> {
    let loaded = load_with(path, arguments.size, &arguments.limits.limits(), |scene| {
        for object in &mut scene.objects {
            object.tier = tier;
        }
    })?;
    let scene = &loaded.prepared;
    let renderer =
        |shaders| GpuRenderer::new(scene, found, Choice::These(shaders)).map_err(Error::from);
    let renderers = [renderer(Shaders::Exact)?, renderer(Shaders::Fast)?];
    let what = format!("{}, {} tier", path.display(), tier.name());
    in_turn(&what, scene, arguments.frames, ["exact", "fast"], renderers)
}

/// `relievo bench specialization`.
pub fn specialization(arguments: &BenchSceneArguments) -> anyhow::Result<()> {
    let found = choose(arguments.adapter.as_deref()).map_err(Error::from)?;
    say(format_args!("{}", found.describe()))?;
    for path in &arguments.scenes {
        let loaded = load(path, arguments.size, &arguments.limits.limits())?;
        let scene = &loaded.prepared;
        let renderer = |extent| {
            GpuRenderer::with_extent(scene, &found, Choice::Trusted, extent).map_err(Error::from)
        };
        let renderers = [renderer(Extent::Needed)?, renderer(Extent::Everything)?];
        let what = path.display().to_string();
        let names = ["special", "general"];
        in_turn(&what, scene, arguments.frames, names, renderers)?;
    }
    Ok(())
}

/// Times two renderers of one scene in turn, and says how they compare.
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
    let found = measured_adapter(arguments.backend, arguments.adapter.as_deref())?;
    let mut backends = Vec::new();
    if arguments.backend != Measured::Gpu {
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
    let table = table.map_err(|error| match error {
        Error::Mesh(_) | Error::ShapeMap(_) => {
            let assets = arguments.assets.display();
            anyhow::Error::from(error).context(format!(
                "{assets} does not hold this project's meshes and patterns; name the folder that does with --assets"
            ))
        }
        error => error.into(),
    })?;
    // First, so that a full disk does not lose the measurement.
    say(format_args!("{}", table.to_string().trim_end()))?;
    match &arguments.output {
        Some(folder) => write_files(&table, folder),
        None => Ok(()),
    }
}

fn write_files(table: &Table1, folder: &Path) -> anyhow::Result<()> {
    let plot = folder.join("table1.svg");
    let svg = table.to_svg().map_err(|message| Error::Encode {
        path: plot.clone(),
        message,
    })?;
    let text = format!(
        "# Table 1 of the paper, measured\n\n\
         Made by `relievo bench table1`; all figures also stand in \
         [table1.csv](table1.csv).\n\n![The times as bars](table1.svg)\n\n{table}"
    );
    for (path, content) in [
        (folder.join("table1.csv"), table.to_csv()),
        (plot, svg),
        (folder.join("table1.md"), text),
    ] {
        write_bytes(&path, content.as_bytes())?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}
