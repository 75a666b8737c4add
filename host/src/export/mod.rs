//! An object for another program: its shaders in the languages of GPUs, what
//! they read as bytes and as files that other tools open, and how to bind it.
//!
//! Everything is made in memory, and every shader is checked before the first
//! file is handed out.

mod bindings;
mod layout;
mod mesh;
mod readme;
mod shader;

use crate::prepare::{PreparedObject, PreparedScene};
use crate::render::RenderError;
use crate::render::gpu::{EntryPoints, Extent, Shaders, facet_bytes};
use crate::shape_map::Storage;
use relievo_bitwise::Module;
use shader::{Stage, spirv_bytes, translate};
use std::fmt;

/// The file with the arguments of an indirect draw.
const DRAW_FILE: &str = "draw.bin";

/// A language for GPUs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// Vulkan's.
    Spirv,
    /// WebGPU's.
    Wgsl,
    /// OpenGL's.
    Glsl,
    /// Direct3D's.
    Hlsl,
    /// Metal's.
    Msl,
}

impl Target {
    /// Every one.
    pub const ALL: [Target; 5] = [
        Target::Spirv,
        Target::Wgsl,
        Target::Glsl,
        Target::Hlsl,
        Target::Msl,
    ];

    /// What it is called, in small letters.
    pub fn name(self) -> &'static str {
        match self {
            Target::Spirv => "spirv",
            Target::Wgsl => "wgsl",
            Target::Glsl => "glsl",
            Target::Hlsl => "hlsl",
            Target::Msl => "msl",
        }
    }

    /// The file of a stage.
    fn file(self, stage: Stage) -> String {
        let extension = match (self, stage) {
            (Target::Spirv, _) => "spv",
            (Target::Wgsl, _) => "wgsl",
            (Target::Glsl, Stage::Vertex) => "vert",
            (Target::Glsl, Stage::Fragment) => "frag",
            (Target::Hlsl, _) => "hlsl",
            (Target::Msl, _) => "metal",
        };
        format!("{}.{extension}", stage.name())
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What the fragment shader writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Output {
    /// Linear RGB and an alpha of 1, as floats.
    #[default]
    Color,
    /// What our own renderer reads: the bits of linear RGB, and the class.
    Words,
}

impl Output {
    fn name(self) -> &'static str {
        match self {
            Output::Color => "color",
            Output::Words => "words",
        }
    }

    /// Formats of a target that fits, as WebGPU calls them.
    fn formats(self) -> &'static [&'static str] {
        match self {
            Output::Color => &["rgba32float", "rgba16float", "rgba8unorm-srgb"],
            Output::Words => &["rgba32uint"],
        }
    }

    fn about(self) -> &'static str {
        match self {
            Output::Color => "linear red, green, blue, and 1",
            Output::Words => {
                "the bits of linear red, green and blue as f32, and the class: 1 cap, 2 wall, 3 bevel, 4 floor"
            }
        }
    }
}

/// What to export.
#[derive(Clone, Debug)]
pub struct Options {
    /// In which languages.
    pub targets: Vec<Target>,
    /// What the fragment shaders write.
    pub output: Output,
    /// The objects of this name only.
    pub object: Option<String>,
}

impl Default for Options {
    /// Every object in every language.
    fn default() -> Options {
        Options {
            targets: Target::ALL.to_vec(),
            output: Output::Color,
            object: None,
        }
    }
}

/// A file, not yet written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportedFile {
    /// Its place in the folder, with `/` between the parts.
    pub name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

/// Names and contents, as [`crate::file::write_folder`] takes them.
pub fn contents(files: &[ExportedFile]) -> impl Iterator<Item = (&str, &[u8])> + Clone {
    files
        .iter()
        .map(|file| (file.name.as_str(), file.bytes.as_slice()))
}

/// What cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// There is no such object.
    #[error("the scene has no object {name:?}; name one of {known} (--object)")]
    NoObject {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A shader that is built in cannot be said in a language.
    #[error(
        "object {object:?}: the shader {shader} cannot be written as {target}: {message}; leave {target} out of --target"
    )]
    Shader {
        /// The object.
        object: String,
        /// The shader.
        shader: &'static str,
        /// The language.
        target: Target,
        /// Why.
        message: String,
    },
    /// The mesh does not fit a file.
    #[error("object {object:?}: its mesh cannot be written as glTF: {message}")]
    Mesh {
        /// The object.
        object: String,
        /// Why, and what to do.
        message: String,
    },
    /// The shape map does not fit a file.
    #[error("object {object:?}: its shape map cannot be written: {message}")]
    Map {
        /// The object.
        object: String,
        /// Why.
        message: String,
    },
    /// The shaders that are built in cannot be read.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// The shaders that exports are made of.
struct Sources {
    /// What every language can say.
    portable: Module,
    /// What our renderer gives to Vulkan, word for word: the SPIR-V of words.
    untouched: Option<Module>,
}

impl Sources {
    fn of(options: &Options) -> Result<Sources, RenderError> {
        let is_ours = options.output == Output::Words && options.targets.contains(&Target::Spirv);
        Ok(Sources {
            portable: Shaders::Portable.module()?,
            untouched: is_ours.then(|| Shaders::Fast.module()).transpose()?,
        })
    }
}

/// A shader among the files.
struct ShaderFile {
    file: String,
    target: Target,
    stage: Stage,
    entry_point: String,
}

/// The files of the objects of `scene` that are asked for: those of one object
/// by themselves, those of several each in a folder `1-name`, `2-name`, … with
/// a list of them.
///
/// # Errors
/// [`ExportError`].
pub fn export(scene: &PreparedScene, options: &Options) -> Result<Vec<ExportedFile>, ExportError> {
    let is_wanted = |object: &&PreparedObject| {
        let wanted = options.object.as_ref();
        wanted.is_none_or(|name| *name == object.name)
    };
    let objects: Vec<&PreparedObject> = scene.objects.iter().filter(is_wanted).collect();
    if let (Some(name), []) = (&options.object, objects.as_slice()) {
        let known: Vec<String> = scene
            .objects
            .iter()
            .map(|object| format!("{:?}", object.name))
            .collect();
        return Err(ExportError::NoObject {
            name: name.clone(),
            known: known.join(", "),
        });
    }
    let sources = Sources::of(options)?;
    if let [object] = objects.as_slice() {
        return export_object(scene, object, options, &sources);
    }
    let mut files = Vec::new();
    let mut folders = Vec::new();
    for object in objects {
        let folder = folder_name(object);
        for file in export_object(scene, object, options, &sources)? {
            files.push(ExportedFile {
                name: format!("{folder}/{}", file.name),
                ..file
            });
        }
        folders.push((folder, object));
    }
    files.push(text(readme::FILE, readme::list(&folders)));
    Ok(files)
}

/// A folder for an object: its number makes it the only one, and no name that a
/// system reserves.
fn folder_name(object: &PreparedObject) -> String {
    const LONGEST: usize = 60;
    let plain = |letter: char| match letter {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' => letter,
        _ => '-',
    };
    let name: String = object.name.chars().take(LONGEST).map(plain).collect();
    let number = object.number + 1;
    match name.trim_matches('-') {
        "" => number.to_string(),
        name => format!("{number}-{name}"),
    }
}

fn text(name: &str, text: String) -> ExportedFile {
    ExportedFile {
        name: name.to_string(),
        bytes: text.into_bytes(),
    }
}

/// The files of one object.
fn export_object(
    scene: &PreparedScene,
    object: &PreparedObject,
    options: &Options,
    sources: &Sources,
) -> Result<Vec<ExportedFile>, ExportError> {
    let entry_points = EntryPoints::of(&object.parameters, Extent::Needed);
    let mut files = Vec::new();
    let mut shaders = Vec::new();
    let mut targets = options.targets.clone();
    targets.sort();
    targets.dedup();
    for target in targets {
        for stage in [Stage::Vertex, Stage::Fragment] {
            let shader =
                write_shader(object, entry_points, stage, options.output, target, sources)?;
            let file = target.file(stage);
            files.push(ExportedFile {
                name: file.clone(),
                bytes: shader.bytes,
            });
            shaders.push(ShaderFile {
                file,
                target,
                stage,
                entry_point: shader.entry_point,
            });
        }
    }
    let json = bindings::json(scene, object, entry_points, options.output, &shaders);
    files.push(text("layout.json", json));
    files.push(text(
        "bindings.rs",
        bindings::rust(entry_points, options.output),
    ));
    let draw = [6 * object.triangles.len() as u32, 1, 0, 0];
    let buffers: [(&str, &[u8]); 5] = [
        ("frame.bin", bytemuck::bytes_of(&scene.frame)),
        ("object.bin", bytemuck::bytes_of(&object.parameters)),
        ("facets.bin", &facet_bytes(object, entry_points.facets)),
        ("map.bin", bytemuck::cast_slice(object.map.words())),
        (DRAW_FILE, bytemuck::cast_slice(&draw)),
    ];
    files.extend(buffers.map(|(name, bytes)| ExportedFile {
        name: name.to_string(),
        bytes: bytes.to_vec(),
    }));
    files.push(ExportedFile {
        name: "mesh.glb".to_string(),
        bytes: mesh::glb(object, scene.origin)?,
    });
    let map_file = map_file(object.map.storage());
    files.push(ExportedFile {
        name: map_file.to_string(),
        bytes: object.map.to_bytes().map_err(|error| ExportError::Map {
            object: object.name.clone(),
            message: error.to_string(),
        })?,
    });
    files.push(text(
        readme::FILE,
        readme::object(scene, object, entry_points, options.output, &shaders),
    ));
    Ok(files)
}

/// The file of a shape map.
fn map_file(storage: Storage) -> &'static str {
    match storage {
        Storage::R8 | Storage::R16 | Storage::Rgba8 => "shape_map.png",
        Storage::R32F => "shape_map.exr",
    }
}

/// A stage of an object's shaders, in one language.
fn write_shader(
    object: &PreparedObject,
    entry_points: EntryPoints,
    stage: Stage,
    output: Output,
    target: Target,
    sources: &Sources,
) -> Result<shader::Written, ExportError> {
    let name = match stage {
        Stage::Vertex => entry_points.vertex,
        Stage::Fragment => entry_points.color,
    };
    let failed = |message: String| ExportError::Shader {
        object: object.name.clone(),
        shader: name,
        target,
        message,
    };
    let missing = || failed("it is not built in".to_string());
    // Checked in every case: it is the same source.
    let words = sources.portable.spirv(name).ok_or_else(missing)?;
    let bindings = layout::bindings(entry_points.facets);
    let structs = layout::structs(entry_points.facets);
    let written = translate(&words, stage, &bindings, &structs, output, target).map_err(failed)?;
    let Some(untouched) = sources
        .untouched
        .as_ref()
        .filter(|_| target == Target::Spirv)
    else {
        return Ok(written);
    };
    let words = untouched.spirv(name).ok_or_else(missing)?;
    Ok(shader::Written {
        bytes: spirv_bytes(&words),
        entry_point: name.to_string(),
    })
}
