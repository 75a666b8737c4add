//! Exports an object for other programs: its shaders in five shading languages, the
//! buffers they read, mesh and shape map as files for other tools, and the bindings.
//!
//! All files are made in memory, and every shader is validated before any file is
//! returned.
//!
//! ```
//! use relievo::export::{Options, Target, export};
//! use relievo::prepare::prepare;
//! use relievo::scene::Scene;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = Scene::load(Path::new("../assets/scenes/plane.toml"))?;
//! let options = Options { targets: vec![Target::Wgsl], ..Options::default() };
//! let files = export(&prepare(&scene, &|_| ())?, &options)?;
//! assert!(files.iter().any(|file| file.name == "fragment.wgsl"));
//! # Ok(())
//! # }
//! ```

mod bindings;
mod engine;
mod error;
mod files;
mod hit;
mod hull;
mod interface;
mod layout;
mod map;
mod mesh;
mod readme;
mod shader;
mod target;

use crate::prepare::{PreparedObject, PreparedScene};
use crate::shaders::{EntryPoints, Extent, FAST, HITS, facet_bytes, words};
use files::{DRAW_FILE, ShaderFile, map_file};
use relievo_translate::{Written, memory_model, spirv_bytes};
use shader::translate;
use target::{Stage, file_name};

pub use engine::EngineHit;
pub use error::ExportError;
pub use interface::Interface;
pub use map::MapForm;
pub use relievo_translate::Target;
pub use target::Output;

/// Options of an export.
#[derive(Clone, Debug)]
pub struct Options {
    /// Shading languages.
    pub targets: Vec<Target>,
    /// Output of the fragment shaders.
    pub output: Output,
    /// Export only the objects with this name.
    pub object: Option<String>,
    /// Bindings, and the names of [`Output::Hit`].
    pub interface: Interface,
}

impl Default for Options {
    /// Exports every object in every language, with the output [`Output::Color`].
    fn default() -> Options {
        Options {
            targets: Target::ALL.to_vec(),
            output: Output::Color,
            object: None,
            interface: Interface::default(),
        }
    }
}

/// A file in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportedFile {
    /// Path in the export's folder, with `/` as separator.
    pub name: String,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// Returns names and contents in the form that [`crate::file::write_folder`] takes.
pub fn contents(files: &[ExportedFile]) -> impl Iterator<Item = (&str, &[u8])> + Clone {
    files
        .iter()
        .map(|file| (file.name.as_str(), file.bytes.as_slice()))
}

/// Exports the objects of `scene` that `options` select.
///
/// The files of a single object have no folder. Those of several objects are in
/// folders `1-name`, `2-name`, …, with a README that lists them.
///
/// # Errors
/// [`ExportError`] if there is no object with the wanted name, or a shader, mesh or
/// shape map cannot be written.
pub fn export(scene: &PreparedScene, options: &Options) -> Result<Vec<ExportedFile>, ExportError> {
    if scene.lighting.is_some() {
        log::warn!(
            "materials, lights and environment are not exported: the shaders have the colours of [object.material] and one directional light"
        );
    }
    let is_wanted = |object: &&PreparedObject| {
        let wanted = options.object.as_ref();
        // Instances have the same files.
        object.instance == 0 && wanted.is_none_or(|name| *name == object.name)
    };
    let objects: Vec<&PreparedObject> = scene.objects.iter().filter(is_wanted).collect();
    if let (Some(name), []) = (&options.object, objects.as_slice()) {
        let known: Vec<String> = scene
            .objects
            .iter()
            .filter(|object| object.instance == 0)
            .map(|object| format!("{:?}", object.name))
            .collect();
        return Err(ExportError::NoObject {
            name: name.clone(),
            known: known.join(", "),
        });
    }
    options.interface.check()?;
    if options.interface.map == MapForm::Texture && options.output != Output::Hit {
        return Err(ExportError::Interface {
            message:
                "only --write hit has its shape map in a texture; export a buffer (--map buffer)"
                    .to_string(),
        });
    }
    if let [object] = objects.as_slice() {
        return export_object(scene, object, options);
    }
    let mut files = Vec::new();
    let mut folders = Vec::new();
    for object in objects {
        let folder = folder_name(object);
        for file in export_object(scene, object, options)? {
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

/// Returns the name of an object's folder. The number makes it unique and keeps it
/// from being a name that an operating system reserves.
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

/// Exports one object.
fn export_object(
    scene: &PreparedScene,
    object: &PreparedObject,
    options: &Options,
) -> Result<Vec<ExportedFile>, ExportError> {
    let entry_points = EntryPoints::of(&object.parameters, Extent::Needed);
    let mut files = Vec::new();
    let mut shaders = Vec::new();
    let mut targets = options.targets.clone();
    targets.sort();
    targets.dedup();
    let function = (options.output == Output::Hit)
        .then(|| write_function(object, entry_points, &options.interface))
        .transpose()?;
    let mut sources = hit::Sources::default();
    for target in targets {
        let mut add = |stage: Stage, name: &str, shader: Written| {
            let file = file_name(target, stage, name);
            shaders.push(ShaderFile {
                file: file.clone(),
                target,
                stage,
                entry_point: shader.entry_point,
            });
            files.push(ExportedFile {
                name: file,
                bytes: shader.bytes,
            });
        };
        let shader = |stage| write_shader(object, entry_points, stage, options, target);
        add(Stage::Vertex, Stage::Vertex.name(), shader(Stage::Vertex)?);
        let Some(function) = &function else {
            add(
                Stage::Fragment,
                Stage::Fragment.name(),
                shader(Stage::Fragment)?,
            );
            continue;
        };
        let failed = |message| shader_error(object, entry_points.hit, target, message);
        for picture in &hit::PICTURES {
            let written = hit::picture(function, picture, target, &options.interface, &mut sources)
                .map_err(failed)?;
            add(Stage::Fragment, picture.file, written);
        }
        if let Some(text) =
            hit::in_language(function, target, &options.interface, &mut sources).map_err(failed)?
        {
            files.push(self::text(&hit::file_name(target), text));
        }
    }
    let hull = (options.output == Output::Hit).then(|| hull::hull(object, entry_points.facets));
    if let Some(hull) = &hull {
        let buffers: [(&str, &[u8]); 2] = [
            (hull::VERTICES_FILE, bytemuck::cast_slice(&hull.vertices)),
            (hull::INDICES_FILE, bytemuck::cast_slice(&hull.indices)),
        ];
        files.extend(buffers.map(|(name, bytes)| ExportedFile {
            name: name.to_string(),
            bytes: bytes.to_vec(),
        }));
    }
    let hull = hull.as_ref();
    let json = bindings::json(scene, object, entry_points, options, &shaders, hull);
    files.push(text("layout.json", json));
    files.push(text("bindings.rs", bindings::rust(entry_points, options)));
    let draw = [3 * object.triangles.len() as u32, 1, 0, 0];
    let frame = object.frame(&scene.frame);
    let parameters = match options.output {
        Output::Hit => engine::parameters(object),
        Output::Color | Output::Words => object.parameters,
    };
    let map = map_bytes(object, options.interface.map)?;
    let buffers: [(&str, &[u8]); 5] = [
        ("frame.bin", bytemuck::bytes_of(&*frame)),
        ("object.bin", bytemuck::bytes_of(&parameters)),
        ("facets.bin", &facet_bytes(object, entry_points.facets)),
        ("map.bin", &map),
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
        name: map_file.clone(),
        bytes: object.map.to_bytes().map_err(|error| ExportError::Map {
            object: object.name.clone(),
            message: error.to_string(),
        })?,
    });
    files.push(text(
        readme::FILE,
        readme::object(scene, object, entry_points, options, &shaders),
    ));
    Ok(files)
}

/// Why a shader is not there.
const NOT_BUILT_IN: &str = "it is not built in";

/// Returns the error for a shader that cannot be translated.
fn shader_error(
    object: &PreparedObject,
    shader: &'static str,
    target: Target,
    message: String,
) -> ExportError {
    ExportError::Shader {
        object: object.name.clone(),
        shader,
        target,
        message,
    }
}

/// Returns the contents of the buffer or the texture of an object's shape map.
fn map_bytes(object: &PreparedObject, form: MapForm) -> Result<Vec<u8>, ExportError> {
    let words = object.map.words();
    if !form.takes(words.len()) {
        return Err(ExportError::Map {
            object: object.name.clone(),
            message: format!(
                "{} words do not fit in a texture; give it fewer bits or pixels (map_bits, map_reduction), or export a buffer (--map buffer)",
                words.len()
            ),
        });
    }
    Ok(form.bytes(words))
}

/// Returns the function that finds what a ray hits on an object, in WGSL.
fn write_function(
    object: &PreparedObject,
    entry_points: EntryPoints,
    interface: &Interface,
) -> Result<String, ExportError> {
    let name = entry_points.hit;
    let failed = |message| shader_error(object, name, Target::Wgsl, message);
    let words = words(HITS, name).ok_or_else(|| failed(NOT_BUILT_IN.to_string()))?;
    let bindings = layout::bindings(entry_points.facets, MapForm::Buffer);
    let structs = layout::structs(entry_points.facets);
    hit::function(&words, &bindings, &structs, interface).map_err(failed)
}

/// Translates one stage of an object's shaders to one language.
fn write_shader(
    object: &PreparedObject,
    entry_points: EntryPoints,
    stage: Stage,
    options: &Options,
    target: Target,
) -> Result<Written, ExportError> {
    let Options {
        output, interface, ..
    } = options;
    let name = match stage {
        Stage::Vertex => entry_points.vertex,
        Stage::Fragment => entry_points.color,
    };
    // Exports have no picture of exits, and are translated without.
    let asks_for_exits = stage == Stage::Fragment && entry_points.asks_for_exits;
    let failed = |message| shader_error(object, name, target, message);
    let words = words(FAST, name).ok_or_else(|| failed(NOT_BUILT_IN.to_string()))?;
    let bindings = layout::bindings(entry_points.facets, MapForm::Buffer);
    let structs = layout::structs(entry_points.facets);
    let written = translate(
        &words, stage, &bindings, &structs, *output, target, interface,
    )
    .map_err(failed)?;
    // What our renderer gives to Vulkan; it was validated as translated.
    let is_untouched = *output == Output::Words
        && target == Target::Spirv
        && *interface == Interface::default()
        && !asks_for_exits;
    if !is_untouched {
        return Ok(written);
    }
    Ok(Written {
        bytes: spirv_bytes(&memory_model::plain(&words)),
        entry_point: name.to_string(),
        ..written
    })
}
