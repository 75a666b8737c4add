//! Exports what a ray hits as a function, `relievo_hit`, and a picture's shaders that call it.

use super::interface::Interface;
use super::layout::{Binding, Struct};
use super::map::{MapForm, as_texture};
use super::shader::name;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Expression, Function, Module, Span, StructMember, Type, TypeInner};
use relievo_translate::{Target, Written, portable};

/// A name and its meaning.
pub(super) struct Described {
    pub(super) name: &'static str,
    pub(super) meaning: &'static str,
}

const fn described(name: &'static str, meaning: &'static str) -> Described {
    Described { name, meaning }
}

/// The arguments, in the order of the compiled shader's locations.
pub(super) const ARGUMENTS: [Described; 7] = [
    described(
        "origin",
        "Origin of the ray: the eye, or any other point. Object units.",
    ),
    described("direction", "Unit direction of the ray."),
    described(
        "forward",
        "Unit view axis of the camera; for a ray without a camera its direction.",
    ),
    described(
        "right",
        "Change of direction / dot(direction, forward) from one pixel to the next on its right.",
    ),
    described("down", "Its change from one pixel to the next below."),
    described(
        "near",
        "Distance of the near plane along forward, object units, > 0: nearer hits do not count.",
    ),
    described(
        "facet",
        "Index of the facet whose shell the ray is followed through.",
    ),
];

/// The fields of the result, in the order of the compiled shader's locations.
pub(super) const FIELDS: [Described; 11] = [
    described(
        "surface_class",
        "0 nothing, 1 cap, 2 wall, 3 bevel, 4 floor.",
    ),
    described(
        "t",
        "Distance from the origin, object units: the hit is at origin + t direction.",
    ),
    described("normal", "Unit normal of the carved surface."),
    described(
        "mesh_normal",
        "Unit normal of the mesh's smooth surface there.",
    ),
    described(
        "tangent",
        "Unit tangent: along growing u on cap and floor, along the outline on walls and bevels; w cross(normal, tangent) is the bitangent.",
    ),
    described(
        "uv",
        "Texture coordinates, repeats of the pattern, less a whole number per facet; v points down.",
    ),
    described("uv_right", "Change of uv to the pixel on the right."),
    described("uv_down", "Change of uv to the pixel below."),
    described("depth_fraction", "0 on the mesh's surface, 1 on the floor."),
    described(
        "object",
        "`finish` of the buffer of the object: as exported, its number in the scene, from 0.",
    ),
    described(
        "layer",
        "Number of the layer that is hit: 0 is the object's own pattern; on the floor, of the one that is nearest.",
    ),
];

/// A shader of a picture that calls the function.
pub(super) struct Picture {
    /// Name of its file, without extension.
    pub(super) file: &'static str,
    /// Its entry point.
    pub(super) entry_point: &'static str,
}

/// All of them.
pub(super) const PICTURES: [Picture; 4] = [
    Picture {
        file: "fragment",
        entry_point: "fs_main",
    },
    Picture {
        file: "depth",
        entry_point: "fs_depth",
    },
    Picture {
        file: "depth_orthographic",
        entry_point: "fs_depth_orthographic",
    },
    Picture {
        file: "geometry",
        entry_point: "fs_geometry",
    },
];

/// The shaders of [`PICTURES`], in WGSL.
const PICTURE: &str = include_str!("picture.wgsl");

/// Returns the function in WGSL, from the compiled shader in `words`.
///
/// # Errors
/// The reason why the compiled shader has another form, or cannot be translated.
pub(super) fn function(
    words: &[u32],
    bindings: &[Binding],
    structs: &[Struct],
    interface: &Interface,
) -> Result<String, String> {
    let mut module = portable::read(words)?;
    compact(&mut module, KeepUnused::No);
    name(&mut module, bindings, structs)?;
    interface.place(&mut module);
    interface.rename(&mut module);
    make_function(&mut module, interface)?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| format!("{:?}", error.as_inner()))?;
    let flags = naga::back::wgsl::WriterFlags::empty();
    let mut text =
        naga::back::wgsl::write_string(&module, &info, flags).map_err(|error| error.to_string())?;
    if interface.map == MapForm::Texture {
        text = as_texture(&text, &interface.map_names())?;
    }
    Ok(commented(&text, interface))
}

/// Returns the name of the file with the function in `target`.
pub(super) fn file_name(target: Target) -> String {
    let extension = match target {
        Target::Glsl => "glsl",
        _ => target.extension(naga::ShaderStage::Fragment),
    };
    format!("hit.{extension}")
}

/// Returns the file with the function in `target`: none in SPIR-V, which is not included.
///
/// # Errors
/// naga's reason why it cannot be written.
pub(super) fn in_language(
    function: &str,
    target: Target,
    interface: &Interface,
    sources: &mut Sources,
) -> Result<Option<String>, String> {
    let text = match target {
        Target::Spirv => return Ok(None),
        Target::Wgsl => function.to_string(),
        Target::Glsl | Target::Hlsl | Target::Msl => {
            // These are written with an entry point, which is cut off.
            let keep = format!(
                "{function}\n@compute @workgroup_size(1) fn keep_hit() {{ let hit = {}(vec3<f32>(), vec3<f32>(), vec3<f32>(), vec3<f32>(), vec3<f32>(), 0.0, 0u); }}\n",
                interface.value("hit")
            );
            let written = sources.translate(keep, "keep_hit", target)?;
            let text = String::from_utf8(written.bytes).map_err(|error| error.to_string())?;
            let text = without_entry_point(&text).ok_or("its entry point was not found")?;
            commented(&text, interface)
        }
    };
    Ok(Some(text))
}

/// Returns the lines of `text` before its entry point, without those that only files with an entry
/// point have.
fn without_entry_point(text: &str) -> Option<String> {
    let starts = ["void main()", "[numthreads(", "kernel void "];
    let lines: Vec<&str> = text.lines().collect();
    let end = lines
        .iter()
        .rposition(|line| starts.iter().any(|start| line.starts_with(start)))?;
    let is_of_entry_point =
        |line: &&str| line.starts_with("#version") || line.starts_with("layout(local_size_x");
    let kept: Vec<&str> = lines[..end]
        .iter()
        .filter(|line| !is_of_entry_point(line))
        .copied()
        .collect();
    Some(format!("{}\n", kept.join("\n").trim()))
}

/// Translates a shader of a picture that calls `function` (WGSL).
///
/// # Errors
/// naga's reason why it cannot be written.
pub(super) fn picture(
    function: &str,
    picture: &Picture,
    target: Target,
    interface: &Interface,
    sources: &mut Sources,
) -> Result<Written, String> {
    let mut shaders = interface.adapt(PICTURE);
    if target == Target::Glsl {
        shaders = shaders.replace("ROWS_UPWARDS = false", "ROWS_UPWARDS = true");
    }
    let source = format!("{function}\n{shaders}");
    if target != Target::Wgsl {
        return sources.translate(source, picture.entry_point, target);
    }
    // As it is, with comments and the other entry points.
    Ok(Written {
        bytes: source.into_bytes(),
        entry_point: picture.entry_point.to_string(),
        stage: naga::ShaderStage::Fragment,
    })
}

/// WGSL that was read for one target, kept for the others.
#[derive(Default)]
pub(super) struct Sources(Vec<(String, Module)>);

impl Sources {
    /// Translates one entry point of `source`.
    fn translate(
        &mut self,
        source: String,
        entry_point: &str,
        target: Target,
    ) -> Result<Written, String> {
        let place = match self.0.iter().position(|(known, _)| *known == source) {
            Some(place) => place,
            None => {
                let module = read(&source)?;
                self.0.push((source, module));
                self.0.len() - 1
            }
        };
        let mut module = self.0[place].1.clone();
        module
            .entry_points
            .retain(|entry| entry.name == entry_point);
        relievo_translate::finish(&mut module, target, relievo_translate::METAL_SIZES)
    }
}

/// A browser gets no functions: what reads WGSL would make its page larger by a tenth.
#[cfg(target_arch = "wasm32")]
fn read(_: &str) -> Result<Module, String> {
    Err(super::NOT_BUILT_IN.to_string())
}

/// Reads WGSL.
#[cfg(not(target_arch = "wasm32"))]
fn read(source: &str) -> Result<Module, String> {
    naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))
}

/// Turns the entry point into the function: locations become arguments, and fields of its result.
fn make_function(module: &mut Module, interface: &Interface) -> Result<(), String> {
    let [entry_point] = module.entry_points.as_mut_slice() else {
        return Err("it does not have exactly one entry point".to_string());
    };
    let mut function: Function = std::mem::take(&mut entry_point.function);
    module.entry_points.clear();
    function.name = Some(interface.value("hit"));

    // Arguments are sorted by their locations.
    let location = |binding: &Option<naga::Binding>| match binding {
        Some(naga::Binding::Location { location, .. }) => Some(*location as usize),
        _ => None,
    };
    let mut sorted = Vec::new();
    sorted.resize(function.arguments.len(), None);
    let mut places = Vec::new();
    for mut argument in std::mem::take(&mut function.arguments) {
        let place = location(&argument.binding).filter(|place| *place < sorted.len());
        let place = place.ok_or("an input has no location")?;
        let described = ARGUMENTS.get(place).ok_or("it has more inputs")?;
        argument.name = Some(described.name.to_string());
        argument.binding = None;
        sorted[place] = Some(argument);
        places.push(place as u32);
    }
    let sorted: Option<Vec<_>> = sorted.into_iter().collect();
    function.arguments = sorted.ok_or("two inputs have the same location")?;
    for (_, expression) in function.expressions.iter_mut() {
        if let Expression::FunctionArgument(index) = expression {
            *index = places[*index as usize];
        }
    }

    let result = function.result.as_mut().ok_or("it has no outputs")?;
    let TypeInner::Struct { members, .. } = module.types[result.ty].inner.clone() else {
        return Err("its outputs are not a struct".to_string());
    };
    if members.len() != FIELDS.len() {
        return Err(format!("it has {} outputs", members.len()));
    }
    let mut offset = 0;
    let mut fields = Vec::new();
    let mut order = Vec::new();
    for (place, field) in FIELDS.iter().enumerate() {
        let index = members
            .iter()
            .position(|member| location(&member.binding) == Some(place))
            .ok_or("an output has no location")?;
        let (size, alignment) = match module.types[members[index].ty].inner {
            TypeInner::Scalar(_) => (4, 4),
            TypeInner::Vector { size, .. } => {
                let count = size as u32;
                (4 * count, 4 * count.next_power_of_two())
            }
            _ => return Err("an output is neither a number nor a vector".to_string()),
        };
        offset = u32::next_multiple_of(offset, alignment);
        fields.push(StructMember {
            name: Some(field.name.to_string()),
            ty: members[index].ty,
            binding: None,
            offset,
        });
        order.push(index);
        offset += size;
    }
    let inner = TypeInner::Struct {
        members: fields,
        span: offset.next_multiple_of(16),
    };
    let name = Some(interface.type_name("Hit"));
    module.types.replace(result.ty, Type { name, inner });
    for (_, expression) in function.expressions.iter_mut() {
        if let Expression::Compose { ty, components } = expression
            && *ty == result.ty
        {
            *components = order.iter().map(|index| components[*index]).collect();
        }
    }
    module.functions.append(function, Span::UNDEFINED);
    Ok(())
}

/// Adds the meaning of each field, and of the arguments, in comments.
fn commented(text: &str, interface: &Interface) -> String {
    let start = format!("struct {} {{", interface.type_name("Hit"));
    let call = interface.value("hit") + "(";
    let mut lines = Vec::new();
    let mut is_inside = false;
    let mut is_described = false;
    for line in text.lines() {
        let code = line.trim();
        if code.contains("//") {
            lines.push(line.to_string());
            continue;
        }
        if code == start {
            is_inside = true;
            lines.push("// What a ray hits, in the space of the object.".to_string());
        } else if is_inside && code.starts_with('}') {
            is_inside = false;
        } else if is_inside {
            let of_line = |field: &&Described| {
                let words = code.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
                words.into_iter().any(|word| word == field.name)
            };
            if let Some(field) = FIELDS.iter().find(of_line) {
                lines.push(format!("    // {}", field.meaning));
            }
        } else if !is_described && code.contains(&call) && code.ends_with(['{', '(']) {
            is_described = true;
            lines.push("// Returns what a ray hits in the shell over one facet.".to_string());
            for argument in &ARGUMENTS {
                lines.push(format!("// {}: {}", argument.name, argument.meaning));
            }
        }
        lines.push(line.to_string());
    }
    lines.join("\n") + "\n"
}
