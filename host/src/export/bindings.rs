//! Writes the bindings of an exported object as JSON and as Rust.

use super::files::{DRAW_FILE, ShaderFile};
use super::hull::{self, Hull};
use super::layout::{Binding, Element, Struct, structs};
use super::{MapForm, Options, Output};
use crate::prepare::{PreparedObject, PreparedScene};
use crate::shaders::EntryPoints;
use relievo_translate::METAL_SIZES;
use serde::Serialize;
use std::mem::offset_of;

/// Version of `layout.json`.
const FORMAT: u32 = 1;

/// `layout.json`.
#[derive(Serialize)]
struct Layout<'a> {
    format: u32,
    generator: &'static str,
    object: &'a str,
    /// Entry points of Relievo's shaders that these are compiled from.
    vertex_shader: &'a str,
    fragment_shader: &'a str,
    output: &'static str,
    shaders: Vec<Shader<'a>>,
    bind_groups: [Group; 1],
    structs: Vec<StructJson>,
    draw: Draw,
    #[serde(skip_serializing_if = "Option::is_none")]
    hull: Option<HullJson>,
    placement: PlacementJson,
    pipeline: Pipeline,
    picture: Picture,
    metal: Metal,
}

#[derive(Serialize)]
struct Shader<'a> {
    file: &'a str,
    language: &'a str,
    stage: &'a str,
    entry_point: &'a str,
}

#[derive(Serialize)]
struct Group {
    group: u32,
    entries: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    binding: u32,
    name: &'static str,
    visibility: Vec<&'static str>,
    #[serde(rename = "type")]
    kind: &'static str,
    /// Type of the buffer's contents, or of the array's elements.
    element: &'static str,
    is_array: bool,
    element_bytes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    texture: Option<TextureJson>,
    file: &'static str,
    about: &'static str,
}

/// The texture of the shape map.
#[derive(Serialize)]
struct TextureJson {
    format: &'static str,
    sample_type: &'static str,
    view_dimension: &'static str,
    width: u32,
    height: usize,
}

impl TextureJson {
    fn of(object: &PreparedObject) -> TextureJson {
        TextureJson {
            format: "r32uint",
            sample_type: "uint",
            view_dimension: "2d",
            width: MapForm::WIDTH,
            height: MapForm::height(object.map.words().len()),
        }
    }
}

#[derive(Serialize)]
struct StructJson {
    name: &'static str,
    about: &'static str,
    bytes: usize,
    fields: Vec<FieldJson>,
}

#[derive(Serialize)]
struct FieldJson {
    name: &'static str,
    offset: usize,
    #[serde(rename = "type")]
    kind: &'static str,
    /// Sides of the array, the outermost first; empty for a single element.
    shape: Vec<usize>,
    unit: &'static str,
    about: &'static str,
}

#[derive(Serialize)]
struct Draw {
    topology: &'static str,
    vertex_buffers: [(); 0],
    indexed: bool,
    vertices: u32,
    instances: u32,
    vertices_per_facet: u32,
    indirect: &'static str,
}

/// Vertex and index buffers for engines that draw the facets' hulls.
#[derive(Serialize)]
struct HullJson {
    topology: &'static str,
    /// Faces turned towards the camera are left out.
    cull: &'static str,
    front_face: &'static str,
    vertices: HullBuffer,
    stride: usize,
    attributes: [HullAttribute; 3],
    indices: HullBuffer,
    index_format: &'static str,
}

#[derive(Serialize)]
struct HullBuffer {
    file: &'static str,
    count: usize,
}

#[derive(Serialize)]
struct HullAttribute {
    name: &'static str,
    format: &'static str,
    offset: usize,
    about: &'static str,
}

impl HullJson {
    fn of(hull: &Hull) -> HullJson {
        HullJson {
            topology: "triangle-list",
            cull: "front",
            front_face: "ccw",
            vertices: HullBuffer {
                file: hull::VERTICES_FILE,
                count: hull.vertices.len(),
            },
            stride: size_of::<hull::Vertex>(),
            attributes: [
                HullAttribute {
                    name: "position",
                    format: "float32x3",
                    offset: offset_of!(hull::Vertex, position),
                    about: "object units",
                },
                HullAttribute {
                    name: "outward",
                    format: "float32x3",
                    offset: offset_of!(hull::Vertex, outward),
                    about: "position + s outward moves the faces out by s object units",
                },
                HullAttribute {
                    name: "facet",
                    format: "uint32",
                    offset: offset_of!(hull::Vertex, facet),
                    about: "index of the facet",
                },
            ],
            indices: HullBuffer {
                file: hull::INDICES_FILE,
                count: hull.indices.len(),
            },
            index_format: "uint32",
        }
    }
}

/// From the object's space to the scene's world.
#[derive(Serialize)]
struct PlacementJson {
    translation: [f64; 3],
    /// x, y, z, w.
    rotation: [f64; 4],
    scale: f64,
}

#[derive(Serialize)]
struct Pipeline {
    targets: [TargetJson; 1],
    depth: Depth,
    cull: &'static str,
    samples: u32,
}

#[derive(Serialize)]
struct TargetJson {
    location: u32,
    formats: Vec<&'static str>,
    blend: &'static str,
    about: &'static str,
    clear: [f32; 4],
}

#[derive(Serialize)]
struct Depth {
    format: &'static str,
    compare: &'static str,
    write: bool,
    clear: f32,
    written_by: &'static str,
    about: &'static str,
}

#[derive(Serialize)]
struct Picture {
    width: u32,
    height: u32,
    /// Centre of all objects, world units. Positions are relative to it.
    origin: [f64; 3],
}

#[derive(Serialize)]
struct Metal {
    /// Slot of binding 0; the other bindings follow.
    first_buffer: u32,
    /// Slot of the buffer sizes, which are declared but never read.
    sizes_buffer: u8,
}

/// Returns the size of a buffer's elements, bytes.
fn element_bytes(element: Element, structs: &[Struct]) -> usize {
    match element {
        Element::F32 | Element::U32 => 4,
        Element::Struct(name) => structs
            .iter()
            .find(|described| described.name == name)
            .map_or(0, |described| described.size),
    }
}

/// Writes `layout.json` for an object of `scene`.
pub(super) fn json(
    scene: &PreparedScene,
    object: &PreparedObject,
    entry_points: EntryPoints,
    options: &Options,
    shaders: &[ShaderFile],
    hull: Option<&Hull>,
) -> String {
    let Options {
        output, interface, ..
    } = options;
    let facets = entry_points.facets;
    let placement = object.placement.unwrap_or_default();
    let structs = structs(facets);
    let entry = |binding: Binding| Entry {
        binding: binding.number,
        name: binding.name,
        visibility: if binding.in_vertex {
            vec!["vertex", "fragment"]
        } else {
            vec!["fragment"]
        },
        kind: binding.map.name(),
        element: binding.element.name(),
        is_array: binding.is_array,
        element_bytes: element_bytes(binding.element, &structs),
        texture: (binding.map == MapForm::Texture).then(|| TextureJson::of(object)),
        file: binding.file,
        about: binding.about,
    };
    let [red, green, blue] = scene.background;
    let layout = Layout {
        format: FORMAT,
        generator: concat!("relievo ", env!("CARGO_PKG_VERSION")),
        object: &object.name,
        vertex_shader: entry_points.vertex,
        fragment_shader: output.source(entry_points),
        output: output.name(),
        shaders: shaders
            .iter()
            .map(|shader| Shader {
                file: &shader.file,
                language: shader.target.name(),
                stage: shader.stage.name(),
                entry_point: &shader.entry_point,
            })
            .collect(),
        bind_groups: [Group {
            group: interface.group,
            entries: interface.bindings(facets).map(entry).into(),
        }],
        draw: Draw {
            topology: "triangle-list",
            vertex_buffers: [],
            indexed: false,
            vertices: 3 * object.triangles.len() as u32,
            instances: 1,
            vertices_per_facet: 3,
            indirect: DRAW_FILE,
        },
        hull: hull.map(HullJson::of),
        placement: PlacementJson {
            translation: (scene.origin + placement.translation).to_array(),
            rotation: placement.rotation.to_array(),
            scale: placement.scale,
        },
        pipeline: Pipeline {
            targets: [TargetJson {
                location: 0,
                formats: output.formats().into(),
                blend: "none",
                about: output.about(),
                clear: match output {
                    Output::Color | Output::Hit => [red, green, blue, 1.0],
                    Output::Words => [0.0; 4],
                },
            }],
            depth: Depth {
                format: "depth32float",
                compare: "greater",
                write: true,
                clear: 0.0,
                written_by: "the fragment shader",
                about: "frame.near / distance along frame.forward: 1 at the near plane, 0 at infinity",
            },
            cull: "none",
            samples: 1,
        },
        picture: Picture {
            width: scene.size[0],
            height: scene.size[1],
            origin: scene.origin.to_array(),
        },
        metal: Metal {
            first_buffer: interface.first_slot(),
            sizes_buffer: METAL_SIZES,
        },
        structs: structs.iter().map(describe).collect(),
    };
    let mut text = serde_json::to_string_pretty(&layout)
        .expect("strings and finite numbers can be written as JSON");
    text.push('\n');
    text
}

fn describe(described: &Struct) -> StructJson {
    StructJson {
        name: described.name,
        about: described.about,
        bytes: described.size,
        fields: described
            .fields
            .iter()
            .map(|field| FieldJson {
                name: field.name,
                offset: field.offset,
                kind: field.kind.element.name(),
                shape: field.kind.shape.clone(),
                unit: field.unit,
                about: field.meaning,
            })
            .collect(),
    }
}

/// Writes `bindings.rs`: the structs, and constants for a wgpu pipeline. It depends
/// on the kind of facets only, so that one program draws all objects of that kind.
pub(super) fn rust(entry_points: EntryPoints, options: &Options) -> String {
    let Options {
        output, interface, ..
    } = options;
    let bindings = interface.bindings(entry_points.facets);
    let facets = entry_points.facets;
    let mut text = String::from(
        "//! The structs that the exported shaders read, and constants for a pipeline.\n\
         //! Written by `relievo export`; needs the crates `bytemuck` (with `derive`) and `wgpu`.\n\
         #![allow(dead_code)]\n\n",
    );
    let mut put = |line: &str| {
        text.push_str(line);
        text.push('\n');
    };
    put("/// Entry point of the vertex shader (in GLSL: main).");
    put("pub const VERTEX: &str = \"vs_main\";");
    put("/// Entry point of the fragment shader (in GLSL: main).");
    put("pub const FRAGMENT: &str = \"fs_main\";");
    put("/// Number of vertices to draw per facet, without vertex or index buffers.");
    put("pub const VERTICES_PER_FACET: u32 = 3;");
    put(
        "/// Format of the depth buffer: compare `Greater`, clear to 0, written by the fragment shader.",
    );
    put("pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;");
    put("/// Format of a target that keeps the fragment shader's output exactly.");
    let format = match output {
        Output::Color | Output::Hit => "Rgba32Float",
        Output::Words => "Rgba32Uint",
    };
    put(&format!(
        "pub const TARGET_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::{format};"
    ));
    put(&format!(
        "/// Files with the contents of group {}, in the order of the bindings.",
        interface.group
    ));
    let files = bindings.map(|binding| format!("{:?}", binding.file));
    put(&format!(
        "pub const BUFFERS: [&str; 4] = [{}];",
        files.join(", ")
    ));
    for described in structs(facets) {
        put("");
        put(&format!("/// {}", described.about));
        put("#[repr(C)]");
        put("#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]");
        put(&format!("pub struct {} {{", described.name));
        for field in &described.fields {
            let unit = match field.unit {
                "" => String::new(),
                unit => format!(" In {unit}."),
            };
            put(&format!("    /// {}{unit}", field.meaning));
            put(&format!("    pub {}: {},", field.name, field.kind.rust()));
        }
        put("}");
    }
    put("");
    let is_texture = interface.map == MapForm::Texture;
    if is_texture {
        put(
            "/// Width of the texture with the shape map, of the format R32Uint; its file has whole rows.",
        );
        put(&format!("pub const MAP_WIDTH: u32 = {};", MapForm::WIDTH));
        put("");
    }
    put(&format!(
        "/// Makes the layout of group {}: {}.",
        interface.group,
        match interface.map {
            MapForm::Buffer => "four read-only storage buffers",
            MapForm::Texture => "three read-only storage buffers and the texture of the shape map",
        }
    ));
    put("pub fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {");
    put("    let both = wgpu::ShaderStages::VERTEX_FRAGMENT;");
    put("    let stages = [both, both, both, wgpu::ShaderStages::FRAGMENT];");
    put("    let buffer = wgpu::BindingType::Buffer {");
    put("        ty: wgpu::BufferBindingType::Storage { read_only: true },");
    put("        has_dynamic_offset: false,");
    put("        min_binding_size: None,");
    put("    };");
    if is_texture {
        put("    let texture = wgpu::BindingType::Texture {");
        put("        sample_type: wgpu::TextureSampleType::Uint,");
        put("        view_dimension: wgpu::TextureViewDimension::D2,");
        put("        multisampled: false,");
        put("    };");
        put("    let types = [buffer, buffer, buffer, texture];");
    }
    put("    let entries = [0, 1, 2, 3].map(|index| wgpu::BindGroupLayoutEntry {");
    put(&match interface.first_binding {
        0 => "        binding: index,".to_string(),
        first => format!("        binding: {first} + index,"),
    });
    put("        visibility: stages[index as usize],");
    put(if is_texture {
        "        ty: types[index as usize],"
    } else {
        "        ty: buffer,"
    });
    put("        count: None,");
    put("    });");
    put("    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {");
    put("        label: Some(\"relievo\"),");
    put("        entries: &entries,");
    put("    })");
    put("}");
    text
}
