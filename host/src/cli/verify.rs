//! `relievo verify`.

use super::session::load;
use super::{VerifyArguments, say};
use anyhow::bail;
use relievo::Error;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Found, ShaderPath, choose};
use relievo::render::{CpuRenderer, GpuRenderer, RenderError, Renderer};
use relievo::verify::{Agreement, compare};

pub fn run(arguments: &VerifyArguments) -> anyhow::Result<()> {
    let found = choose(arguments.adapter.as_deref()).map_err(Error::from)?;
    let path = if found.takes_spirv() && !arguments.naga {
        ShaderPath::Passthrough
    } else {
        ShaderPath::Naga
    };
    say(format_args!(
        "{}, shaders {}, against the CPU",
        found.describe(),
        if path == ShaderPath::Passthrough {
            "untouched"
        } else {
            "through naga"
        }
    ))?;
    let mut failed = Vec::new();
    for scene in &arguments.scenes {
        let loaded = load(scene, arguments.size)?;
        let agreement = agreement(&loaded.prepared, &found, path).map_err(Error::from)?;
        say(format_args!(
            "{}: {}",
            scene.display(),
            describe(&agreement)
        ))?;
        if agreement.color_pixels as f64 > arguments.tolerate * agreement.pixels as f64 {
            failed.push(scene.display().to_string());
        }
    }
    if !failed.is_empty() {
        bail!(
            "more than {} of the pixels differ in {}",
            arguments.tolerate,
            failed.join(", ")
        );
    }
    Ok(())
}

/// Renders colours and geometry on both sides and compares.
fn agreement(
    scene: &PreparedScene,
    found: &Found,
    path: ShaderPath,
) -> Result<Agreement, RenderError> {
    let mut gpu = GpuRenderer::with_shader_path(scene, found, path)?;
    let mut cpu = CpuRenderer::new(scene);
    let frame = &scene.frame;
    let (gpu_color, gpu_geometry) = (gpu.color(frame)?, gpu.geometry(frame)?);
    let (cpu_color, cpu_geometry) = (cpu.color(frame)?, cpu.geometry(frame)?);
    Ok(compare(
        [&gpu_color, &cpu_color],
        [&gpu_geometry, &cpu_geometry],
    ))
}

fn describe(agreement: &Agreement) -> String {
    format!(
        "{} of {} pixels differ ({:.4} %), {} in class; words: {} of {} of colour, {} of {} of geometry; largest difference: colour {:.3e}, distance {:.3e} of itself",
        agreement.color_pixels,
        agreement.pixels,
        100.0 * agreement.color_pixels as f64 / agreement.pixels as f64,
        agreement.class_pixels,
        agreement.different_color_words,
        agreement.color_words,
        agreement.different_geometry_words,
        agreement.geometry_words,
        agreement.largest_color_difference,
        agreement.largest_distance_difference,
    )
}
