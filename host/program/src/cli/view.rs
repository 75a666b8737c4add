//! `relievo view`.

use super::limits::LimitArguments;
use super::parse_size;
use clap::Args;
use relievo::scene::Scene;
use relievo_viewer::native::{Options, run as open};
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct ViewArguments {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for saved pictures and scenes [default: the scene's]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Use the adapter whose name contains this (see info)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Size of the window, points
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1200x760")]
    window: [u32; 2],
    /// Write the state of the window to this file as JSON, for tests
    #[arg(long, value_name = "FILE.json", hide = true)]
    probe: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArguments,
}

pub fn run(arguments: &ViewArguments) -> anyhow::Result<()> {
    let scene = Scene::load_within(&arguments.scene, &arguments.limits.limits())
        .map_err(relievo::Error::from)?;
    let beside = arguments.scene.parent().unwrap_or(Path::new(""));
    let folder = arguments.output.as_deref().unwrap_or(beside);
    let [width, height] = arguments.window;
    open(
        scene,
        &Options {
            folder: folder.to_path_buf(),
            adapter: arguments.adapter.clone(),
            size: [width as f32, height as f32],
            probe: arguments.probe.clone(),
        },
    )?;
    Ok(())
}
