//! `relievo explain`.

use super::limits::LimitArguments;
use super::parse_budget;
use super::parse_size;
use super::say;
use super::session::load_view;
use clap::Args;
use relievo::Error;
use relievo::explain::explain;
use std::path::PathBuf;

#[derive(Args)]
pub struct ExplainArguments {
    /// Scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Largest error, such as 0.5px; chooses tier, steps and map
    #[arg(long, value_name = "PX", value_parser = parse_budget)]
    budget: Option<f64>,
    /// Size of the picture instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    limits: LimitArguments,
}

pub fn run(arguments: &ExplainArguments) -> anyhow::Result<()> {
    for path in &arguments.scenes {
        let loaded = load_view(path, arguments.size, &arguments.limits.limits(), |scene| {
            scene.set_budget(arguments.budget);
        })?;
        let explanation = explain(&loaded.prepared, &loaded.plans).map_err(Error::from)?;
        let [width, height] = loaded.prepared.size;
        say(format_args!(
            "{}, {width} × {height} pixels\n{explanation}",
            path.display()
        ))?;
    }
    Ok(())
}
