//! `relievo render`.

use super::Backend;
use super::limits::LimitArguments;
use super::parse_budget;
use super::parse_size;
use super::session::{Loaded, choose_renderer, load_view, refuse_input, say_plans};
use super::{refuse_adapter, say};
use clap::Args;
use relievo::Error;
use relievo::aov::{PIXEL_BYTES, save_exr};
use relievo::limits::Account;
use relievo::picture::Picture;
use relievo::scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub struct RenderArguments {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Output picture [default: the scene's name with .png, in the current folder]
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,
    /// Renderer
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// Use the adapter whose name contains this (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the picture instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Write what was hit as well: t, u, v, delta, class, N
    #[arg(long, value_name = "OUT.exr")]
    aov: Option<PathBuf>,
    /// Largest error, such as 0.5px: finds the cheapest tier, steps and map that keep it
    #[arg(long, value_name = "PX", value_parser = parse_budget)]
    budget: Option<f64>,
    #[command(flatten)]
    limits: LimitArguments,
}

pub fn run(arguments: &RenderArguments) -> anyhow::Result<()> {
    if arguments.backend == Backend::Cpu && arguments.adapter.is_some() {
        refuse_adapter();
    }
    let limits = arguments.limits.limits();
    let loaded = load_view(&arguments.scene, arguments.size, &limits, |scene| {
        scene.set_budget(arguments.budget);
    })?;
    let Loaded {
        scene,
        prepared,
        plans,
    } = &loaded;
    let output = arguments.output.clone().unwrap_or_else(|| {
        let mut name = arguments.scene.file_stem().unwrap_or_default().to_owned();
        name.push(".png");
        PathBuf::from(name)
    });
    check_outputs(scene, &output, arguments.aov.as_deref())?;
    if arguments.aov.is_some() {
        let pixels = scene.size.map(u64::from).iter().product();
        Account::new(&scene.path, &limits).take("--aov", pixels, PIXEL_BYTES)?;
    }
    let (mut renderer, line) = choose_renderer(
        arguments.backend,
        arguments.adapter.as_deref(),
        prepared,
        plans,
    )
    .map_err(Error::from)?;
    say(format_args!("{line}"))?;
    say_plans(&loaded)?;

    let factor = prepared.supersampling;
    let start = Instant::now();
    let words = renderer
        .color(&prepared.frame_with_samples(factor))
        .map_err(Error::from)?;
    tracing::info!("rendered in {:.3} s", start.elapsed().as_secs_f64());
    let software = concat!("relievo ", env!("CARGO_PKG_VERSION"));
    Picture::develop(&words, factor)
        .map_err(Error::from)?
        .save_png(
            &output,
            &[("Software", software), ("relievo-scene", &scene.text)],
        )?;
    say(format_args!("{}", output.display()))?;

    if let Some(path) = &arguments.aov {
        let words = renderer.geometry(&prepared.frame).map_err(Error::from)?;
        save_exr(path, &words, scene, prepared)?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}

/// Refuses an output that is an input, or two outputs of one name.
fn check_outputs(scene: &Scene, output: &Path, aov: Option<&Path>) -> anyhow::Result<()> {
    for path in [Some(output), aov].into_iter().flatten() {
        refuse_input(scene, path)?;
    }
    if aov == Some(output) {
        anyhow::bail!(
            "{} cannot be both the picture and its --aov; choose another name for one of them",
            output.display()
        );
    }
    Ok(())
}
