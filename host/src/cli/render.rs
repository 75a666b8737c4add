//! `relievo render`.

use super::session::{Loaded, choose_renderer, load};
use super::{RenderArguments, say};
use relievo::Error;
use relievo::aov::save_exr;
use relievo::picture::Picture;
use std::path::PathBuf;
use std::time::Instant;

pub fn run(arguments: &RenderArguments) -> anyhow::Result<()> {
    let Loaded { scene, prepared } = load(&arguments.scene, arguments.size)?;
    let (mut renderer, line) =
        choose_renderer(arguments.backend, arguments.adapter.as_deref(), &prepared)
            .map_err(Error::from)?;
    say(format_args!("{line}"))?;

    let output = arguments.output.clone().unwrap_or_else(|| {
        let mut name = arguments.scene.file_stem().unwrap_or_default().to_owned();
        name.push(".png");
        PathBuf::from(name)
    });
    let factor = prepared.supersampling;
    let start = Instant::now();
    let words = renderer
        .color(&prepared.frame_with_samples(factor))
        .map_err(Error::from)?;
    tracing::info!("rendered in {:.3} s", start.elapsed().as_secs_f64());
    let software = concat!("relievo ", env!("CARGO_PKG_VERSION"));
    Picture::develop(&words, factor).save_png(
        &output,
        &[("Software", software), ("relievo-scene", &scene.text)],
    )?;
    say(format_args!("{}", output.display()))?;

    if let Some(path) = &arguments.aov {
        let words = renderer.geometry(&prepared.frame).map_err(Error::from)?;
        save_exr(path, &words, &scene, &prepared)?;
        say(format_args!("{}", path.display()))?;
    }
    Ok(())
}
