//! Compiles the shader crates of a project to SPIR-V with rust-gpu, and writes the modules
//! and their manifest to the project's shader folder. `cargo relievo build` calls it.
//!
//! ```text
//! relievo-shader-builder --manifest-path PATH [--check] [--target-folder DIR]
//! ```
//!
//! PATH is the `Cargo.toml` that names the shader crates. With `--check` it writes nothing,
//! and fails if the files differ from the output. DIR is for what cargo builds.

use anyhow::{Context, Result, bail};
use relievo_shader_builder::folder;
use relievo_shader_manifest::Project;
use std::path::PathBuf;
use std::process::ExitCode;

/// What to call the program with.
const USAGE: &str = "relievo-shader-builder --manifest-path PATH [--check] [--target-folder DIR]";

/// The program's arguments.
struct Arguments {
    manifest_path: PathBuf,
    check: bool,
    target_folder: PathBuf,
}

impl Arguments {
    fn read(mut arguments: impl Iterator<Item = std::ffi::OsString>) -> Result<Arguments> {
        let (mut manifest_path, mut target_folder, mut check) = (None, None, false);
        while let Some(argument) = arguments.next() {
            let mut path = || {
                let path = arguments.next().map(PathBuf::from);
                path.with_context(|| format!("{} needs a path: {USAGE}", argument.display()))
            };
            match argument.to_str() {
                Some("--manifest-path") => manifest_path = Some(path()?),
                Some("--target-folder") => target_folder = Some(path()?),
                Some("--check") => check = true,
                _ => bail!("unknown argument {argument:?}: {USAGE}"),
            }
        }
        Ok(Arguments {
            manifest_path: manifest_path
                .with_context(|| format!("--manifest-path is missing: {USAGE}"))?,
            check,
            target_folder: match target_folder {
                Some(folder) => folder,
                // Beside the builder's own target folder: both are worth caching.
                None => std::env::current_exe()?
                    .ancestors()
                    .nth(2)
                    .context("the program lies in a target folder; name one with --target-folder")?
                    .join("spirv"),
            },
        })
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let arguments = Arguments::read(std::env::args_os().skip(1))?;
    let project = Project::load(&arguments.manifest_path)?;
    let files = folder::compile(&project, &arguments.target_folder)?;
    let shaders = &project.shaders;
    if arguments.check {
        let wrong = folder::differences(&project, &files)?;
        if !wrong.is_empty() {
            bail!(
                "not what the sources give: {}; run `cargo relievo build` and commit {shaders}",
                wrong.join(", ")
            );
        }
        println!(
            "{} files in {shaders} are what the sources give",
            files.len()
        );
    } else {
        folder::write(&project, &files)?;
        let bytes: usize = files.values().map(Vec::len).sum();
        println!("{shaders}: {} files, {bytes} bytes", files.len());
    }
    Ok(())
}
