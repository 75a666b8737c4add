//! `relievo gallery`.

use crate::cli::Backend;
use crate::cli::parse_size;
use crate::cli::progress::Bar;
use crate::cli::say;
use crate::cli::session::choose_renderer;
use anyhow::bail;
use clap::Args;
use relievo_studies::gallery::{FIGURES, Gallery, write};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct GalleryArguments {
    /// Write index.md, pictures and scenes into this folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "400x300", value_parser = parse_size)]
    size: [u32; 2],
    /// Renderer
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// Folder with this project's meshes and patterns [default: the checkout's]
    #[arg(long, value_name = "DIR")]
    assets: Option<PathBuf>,
}

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
            let (renderer, line) = choose_renderer(arguments.backend, None, scene, &[])?;
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

/// Returns the folder with meshes and patterns: as named, or the checkout's.
fn find_assets(named: Option<&Path>) -> anyhow::Result<PathBuf> {
    let assets = named.map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets"),
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
