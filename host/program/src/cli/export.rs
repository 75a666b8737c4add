//! `relievo export`.

use super::limits::LimitArguments;
use super::parse_size;
use super::say;
use super::session::{Loaded, inputs, load, say_plans};
use clap::{Args, ValueEnum};
use relievo::Error;
use relievo::export::{
    ExportedFile, Interface, MapForm, Options, Output, Target, contents, export,
};
use relievo::file::write_folder;
use relievo::scene::Scene;
use std::path::{Path, PathBuf};

/// Shader language.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// For Vulkan
    Spirv,
    /// For WebGPU
    Wgsl,
    /// For OpenGL, version 4.50
    Glsl,
    /// For Direct3D, shader model 5.1
    Hlsl,
    /// For Metal, version 2.0
    Msl,
}

/// How --write hit reads the shape map.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Map {
    /// In a storage buffer
    Buffer,
    /// In a texture of the format r32uint
    Texture,
}

/// Output of exported fragment shaders.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Written {
    /// Linear RGB and an alpha of 1, as floats
    Color,
    /// The bits of linear RGB and the class, as integers; the SPIR-V is Relievo's own, unchanged
    Words,
    /// What a ray hits, as a function for shaders of your own, and shaders that call it
    Hit,
}

#[derive(Args)]
#[command(
    after_help = "One object is written into DIR, several into folders of their own in it, such as DIR/1-torus.\nREADME.md there describes the bindings, and layout.json for programs (docs/export.md)."
)]
pub struct ExportArguments {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Write shaders, buffers, mesh, shape map and their description into this folder
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Shader languages [default: all]
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    target: Vec<Language>,
    /// Export only the object of this name
    #[arg(long, value_name = "NAME")]
    object: Option<String>,
    /// Output of the fragment shaders
    #[arg(long = "write", value_enum, value_name = "WHAT", default_value_t = Written::Color)]
    write: Written,
    /// Start of the names that --write hit gives: NAME_hit
    #[arg(long, value_name = "NAME", default_value = "relievo")]
    prefix: String,
    /// Group (set, space) of the buffers
    #[arg(long, value_name = "N", default_value_t = 0)]
    group: u32,
    /// Binding of the first of the four buffers
    #[arg(long, value_name = "N", default_value_t = 0)]
    first_binding: u32,
    /// How --write hit reads the shape map
    #[arg(long, value_enum, value_name = "FORM", default_value_t = Map::Buffer)]
    map: Map,
    /// Size of the picture instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    limits: LimitArguments,
}

pub fn run(arguments: &ExportArguments) -> anyhow::Result<()> {
    let limits = arguments.limits.limits();
    let loaded = load(&arguments.scene, arguments.size, &limits)?;
    say_plans(&loaded)?;
    let Loaded {
        scene, prepared, ..
    } = &loaded;
    let options = Options {
        targets: targets(&arguments.target),
        output: match arguments.write {
            Written::Color => Output::Color,
            Written::Words => Output::Words,
            Written::Hit => Output::Hit,
        },
        object: arguments.object.clone(),
        interface: Interface {
            prefix: arguments.prefix.clone(),
            group: arguments.group,
            first_binding: arguments.first_binding,
            map: match arguments.map {
                Map::Buffer => MapForm::Buffer,
                Map::Texture => MapForm::Texture,
            },
        },
    };
    let files = export(prepared, &options).map_err(Error::from)?;
    let folder = &arguments.output;
    check_inputs(scene, folder, &files)?;
    write_folder(folder, contents(&files)).map_err(Error::from)?;
    let bytes: usize = files.iter().map(|file| file.bytes.len()).sum();
    say(format_args!(
        "{}: {} files, {bytes} bytes; see {}",
        folder.display(),
        files.len(),
        folder.join("README.md").display()
    ))
}

/// Returns the requested languages.
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

/// Refuses outputs that are inputs.
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
