//! `relievo view`.

use super::ViewArguments;
use relievo::scene::Scene;
use relievo::viewer::native::{Options, run as open};
use std::path::Path;

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
