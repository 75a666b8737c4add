//! `relievo export`.

use super::session::{Loaded, inputs, load, say_plans};
use super::{ExportArguments, Language, Written, say};
use relievo::Error;
use relievo::export::{ExportedFile, Options, Output, Target, contents, export};
use relievo::file::write_folder;
use relievo::scene::Scene;
use std::path::Path;

pub fn run(arguments: &ExportArguments) -> anyhow::Result<()> {
    let limits = arguments.limits.limits();
    let Loaded { scene, prepared } = load(&arguments.scene, arguments.size, &limits)?;
    say_plans(&prepared)?;
    let options = Options {
        targets: targets(&arguments.target),
        output: match arguments.write {
            Written::Color => Output::Color,
            Written::Words => Output::Words,
        },
        object: arguments.object.clone(),
    };
    let files = export(&prepared, &options).map_err(Error::from)?;
    let folder = &arguments.output;
    check_inputs(&scene, folder, &files)?;
    write_folder(folder, contents(&files))?;
    let bytes: usize = files.iter().map(|file| file.bytes.len()).sum();
    say(format_args!(
        "{}: {} files, {bytes} bytes; see {}",
        folder.display(),
        files.len(),
        folder.join("README.md").display()
    ))
}

/// The languages asked for.
fn targets(asked: &[Language]) -> Vec<Target> {
    if asked.is_empty() {
        return Target::ALL.to_vec();
    }
    let target = |language: &Language| match language {
        Language::Spirv => Target::Spirv,
        Language::Wgsl => Target::Wgsl,
        Language::Glsl => Target::Glsl,
        Language::Hlsl => Target::Hlsl,
        Language::Msl => Target::Msl,
    };
    asked.iter().map(target).collect()
}

/// What is written must not be what was read.
fn check_inputs(scene: &Scene, folder: &Path, files: &[ExportedFile]) -> anyhow::Result<()> {
    let inputs = inputs(scene);
    for file in files {
        let path = folder.join(&file.name);
        if path.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
            anyhow::bail!(
                "{} is a file that the scene reads; choose another folder for the output",
                path.display()
            );
        }
    }
    Ok(())
}
