//! `relievo gallery`.

use super::progress::Bar;
use super::session::choose_renderer;
use super::{GalleryArguments, say};
use anyhow::bail;
use relievo::gallery::{FIGURES, Gallery, write};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

pub fn run(arguments: &GalleryArguments) -> anyhow::Result<()> {
    let gallery = Gallery {
        assets: find_assets(arguments.assets.as_deref())?,
        output: arguments.output.clone(),
        size: arguments.size,
    };
    let bar = Bar::new();
    let renderer_line = RefCell::new(None);
    let page = write(
        &gallery,
        FIGURES,
        &|scene| {
            let (renderer, line) = choose_renderer(arguments.backend, None, scene)?;
            renderer_line.borrow_mut().get_or_insert(line);
            Ok(renderer)
        },
        &|what, fraction| bar.show(what.to_string(), fraction),
    )?;
    drop(bar);
    if let Some(line) = renderer_line.take() {
        say(format_args!("{line}"))?;
    }
    say(format_args!("{}", page.display()))
}

/// The folder with meshes and patterns: as named, or the checkout's.
fn find_assets(named: Option<&Path>) -> anyhow::Result<PathBuf> {
    let assets = named.map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets"),
        Path::to_path_buf,
    );
    for folder in ["meshes", "patterns"] {
        if !assets.join(folder).is_dir() {
            bail!(
                "{} has no folder {folder}; name this project's assets folder with --assets DIR",
                assets.display()
            );
        }
    }
    Ok(assets)
}
