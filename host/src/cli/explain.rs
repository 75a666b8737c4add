//! `relievo explain`.

use super::session::load_view;
use super::{ExplainArguments, say};
use relievo::Error;
use relievo::explain::explain;

pub fn run(arguments: &ExplainArguments) -> anyhow::Result<()> {
    for path in &arguments.scenes {
        let loaded = load_view(path, arguments.size, &arguments.limits.limits(), |scene| {
            scene.set_budget(arguments.budget);
        })?;
        let explanation = explain(&loaded.prepared).map_err(Error::from)?;
        let [width, height] = loaded.prepared.size;
        say(format_args!(
            "{}, {width} × {height} pixels\n{explanation}",
            path.display()
        ))?;
    }
    Ok(())
}
