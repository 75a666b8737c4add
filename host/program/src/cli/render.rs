//! `relievo render`.

use super::Backend;
use super::job::PlanArguments;
use super::limits::LimitArguments;
use super::session::{Loaded, choose_renderer, load_view, refuse_input, say_plans};
use super::{parse_budget, parse_frames, parse_size, refuse_adapter, refuse_plan, say};
use clap::Args;
use relievo::Error;
use relievo::aov::{PIXEL_BYTES, save_exr};
use relievo::limits::Account;
use relievo::picture::Picture;
use relievo::prepare::{PreparedScene, View, finer};
use relievo::render::Renderer;
use relievo::scene::Scene;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(Args)]
pub struct RenderArguments {
    /// Scene file (TOML)
    pub(super) scene: PathBuf,
    /// Output picture [default: the scene's name with .png, or .%04d.png with --frames, in the
    /// current folder]
    #[arg(short, long, value_name = "OUT.png")]
    pub(super) output: Option<PathBuf>,
    /// Renderer
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub(super) backend: Backend,
    /// Use the adapter whose name contains this (see info)
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Size of the picture instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(super) size: Option<[u32; 2]>,
    /// Write what was hit as well: t, u, v, delta, class, N
    #[arg(long, value_name = "OUT.exr")]
    pub(super) aov: Option<PathBuf>,
    /// Largest error, such as 0.5px: finds the cheapest tier, steps and map that keep it
    #[arg(long, value_name = "PX", value_parser = parse_budget)]
    pub(super) budget: Option<f64>,
    /// Draw these frames of an animated scene, such as 0..48 (without 48) or 0..=47; -o is then
    /// such as out/%04d.png, or an animated picture.apng, and --aov such as out/%04d.exr, with
    /// motion vectors
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    pub(super) frames: Option<Range<u64>>,
    #[command(flatten)]
    pub(super) plan: PlanArguments,
    #[command(flatten)]
    pub(super) limits: LimitArguments,
}

/// The program's name and version, for the metadata of pictures.
pub(super) const SOFTWARE: &str = concat!("relievo ", env!("CARGO_PKG_VERSION"));

impl RenderArguments {
    /// Ends the program with code 2 if options exclude each other.
    pub(super) fn check(&self) {
        if self.backend == Backend::Cpu && self.adapter.is_some() {
            refuse_adapter();
        }
        if self.plan.plan.is_some() && self.frames.is_none() {
            refuse_plan();
        }
    }
}

/// Draws one picture of the scene.
pub fn run(arguments: &RenderArguments) -> anyhow::Result<()> {
    arguments.check();
    let limits = arguments.limits.limits();
    let loaded = load_view(&arguments.scene, arguments.size, &limits, |scene| {
        scene.set_budget(arguments.budget);
    })?;
    let Loaded {
        scene,
        prepared,
        plans,
    } = &loaded;
    let output = default_output(arguments, "png");
    check_outputs(scene, &output, arguments.aov.as_deref())?;
    if arguments.aov.is_some() {
        take_aov(scene, PIXEL_BYTES, &mut Account::new(&scene.path, &limits))?;
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

    let view = prepared.view();
    draw(prepared, &view, renderer.as_mut())?.save_png(
        &output,
        &[("Software", SOFTWARE), ("relievo-scene", &scene.text)],
    )?;
    say(format_args!("{}", output.display()))?;

    if let Some(path) = &arguments.aov {
        let words = renderer.geometry(&view.frame).map_err(Error::from)?;
        save_exr(path, &words, scene, prepared, &view, None)?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}

/// Returns the output that was asked for, or the scene's name with `ending`, in the current
/// folder.
pub(super) fn default_output(arguments: &RenderArguments, ending: &str) -> PathBuf {
    arguments.output.clone().unwrap_or_else(|| {
        let mut name = arguments.scene.file_stem().unwrap_or_default().to_owned();
        name.push(".");
        name.push(ending);
        PathBuf::from(name)
    })
}

/// Takes the memory of an EXR file with `bytes` per pixel.
pub(super) fn take_aov(scene: &Scene, bytes: u64, account: &mut Account<'_>) -> Result<(), Error> {
    let pixels = scene.size.map(u64::from).iter().product();
    Ok(account.take("--aov", pixels, bytes)?)
}

/// Draws `prepared` in `view`.
pub(super) fn draw(
    prepared: &PreparedScene,
    view: &View,
    renderer: &mut dyn Renderer,
) -> Result<Picture, Error> {
    let factor = prepared.supersampling;
    let start = Instant::now();
    let words = renderer.color(&finer(&view.frame, factor))?;
    log::info!("rendered in {:.3} s", start.elapsed().as_secs_f64());
    Ok(Picture::develop(&words, factor, &prepared.development)?)
}

/// Refuses an output that is an input, or two outputs of one name.
pub(super) fn check_outputs(
    scene: &Scene,
    output: &Path,
    aov: Option<&Path>,
) -> anyhow::Result<()> {
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
