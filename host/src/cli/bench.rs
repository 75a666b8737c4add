//! `relievo bench`.

use super::session::load;
use super::{BenchArguments, say};
use relievo::Error;
use relievo::render::gpu::choose;
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use std::time::Instant;

pub fn run(arguments: &BenchArguments) -> anyhow::Result<()> {
    let loaded = load(&arguments.scene, arguments.size)?;
    let scene = &loaded.prepared;
    say(format_args!(
        "{}: {} × {} pixels, {} triangles; prepared in {:.1} ms",
        arguments.scene.display(),
        scene.size[0],
        scene.size[1],
        scene.triangle_count(),
        1e3 * scene.preparation.as_secs_f64()
    ))?;
    let mut cpu = CpuRenderer::new(scene);
    let mut gpu = match choose(arguments.adapter.as_deref()) {
        Ok(found) => Some(GpuRenderer::new(scene, &found).map_err(Error::from)?),
        Err(error) if arguments.adapter.is_some() => return Err(Error::from(error).into()),
        Err(_) => None,
    };
    // In turn, so that a noisy machine disturbs both alike; the first round warms up.
    let (mut cpu_times, mut gpu_times) = (Vec::new(), Vec::new());
    for round in 0..=arguments.frames {
        let start = Instant::now();
        cpu.color(&scene.frame).map_err(Error::from)?;
        let cpu_time = start.elapsed();
        let start = Instant::now();
        if let Some(gpu) = &mut gpu {
            gpu.draw_color(&scene.frame).map_err(Error::from)?;
        }
        let gpu_time = start.elapsed();
        if round > 0 {
            cpu_times.push(1e3 * cpu_time.as_secs_f64());
            gpu_times.push(1e3 * gpu_time.as_secs_f64());
        }
    }
    report(&cpu.name(), &mut cpu_times)?;
    match &gpu {
        Some(gpu) => report(&gpu.name(), &mut gpu_times),
        None => say(format_args!("no GPU adapter")),
    }
}

fn report(name: &str, times: &mut [f64]) -> anyhow::Result<()> {
    times.sort_by(f64::total_cmp);
    say(format_args!(
        "{name}: median {:.2} ms a frame, from {:.2} to {:.2}, {} frames",
        times[times.len() / 2],
        times[0],
        times[times.len() - 1],
        times.len()
    ))
}
