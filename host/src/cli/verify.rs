//! `relievo verify`.

use super::session::load;
use super::{ShaderChoice, VerifyArguments, say};
use anyhow::bail;
use relievo::Error;
use relievo::render::gpu::{Found, Shaders, choose};
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use relievo::verify::{Agreement, compare};

pub fn run(arguments: &VerifyArguments) -> anyhow::Result<()> {
    let found = choose(arguments.adapter.as_deref()).map_err(Error::from)?;
    say(format_args!("{}, against the CPU", found.describe()))?;
    let wanted = shaders(arguments.shaders, &found)?;
    let mut failed = Vec::new();
    for scene in &arguments.scenes {
        let loaded = load(scene, arguments.size)?;
        let frame = &loaded.prepared.frame;
        let mut cpu = CpuRenderer::new(&loaded.prepared);
        let cpu_color = cpu.color(frame).map_err(Error::from)?;
        let cpu_geometry = cpu.geometry(frame).map_err(Error::from)?;
        for &shaders in &wanted {
            let mut gpu = GpuRenderer::with_shaders(&loaded.prepared, &found, shaders)
                .map_err(Error::from)?;
            let gpu_color = gpu.color(frame).map_err(Error::from)?;
            let gpu_geometry = gpu.geometry(frame).map_err(Error::from)?;
            let agreement = compare([&gpu_color, &cpu_color], [&gpu_geometry, &cpu_geometry]);
            say(format_args!(
                "{}, {}: {}",
                scene.display(),
                shaders.describe(),
                describe(&agreement)
            ))?;
            if shaders == Shaders::Exact && !agreement.is_exact() {
                failed.push(scene.display().to_string());
            }
        }
    }
    if !failed.is_empty() {
        bail!(
            "the exact shaders differ from the CPU in {}",
            failed.join(", ")
        );
    }
    Ok(())
}

/// The shaders to compare: those asked for, or all that the adapter takes.
fn shaders(choice: ShaderChoice, found: &Found) -> anyhow::Result<Vec<Shaders>> {
    let wanted = match choice {
        ShaderChoice::All => vec![Shaders::Exact, Shaders::Fast, Shaders::Portable],
        ShaderChoice::Exact => vec![Shaders::Exact],
        ShaderChoice::Fast => vec![Shaders::Fast],
        ShaderChoice::Portable => vec![Shaders::Portable],
    };
    let possible: Vec<Shaders> = wanted
        .into_iter()
        .filter(|shaders| found.takes_spirv() || !shaders.is_untouched())
        .collect();
    if possible.is_empty() {
        bail!(
            "{} takes no SPIR-V untouched, which these shaders need; use --shaders portable",
            found.describe()
        );
    }
    Ok(possible)
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
