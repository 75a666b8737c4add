//! The README of an export: what is in the folder, and what to bind where.

use super::layout::{Binding, bindings};
use super::shader::{METAL_SIZES, Stage};
use super::{DRAW_FILE, Output, ShaderFile, Target, map_file};
use crate::prepare::{PreparedObject, PreparedScene};
use crate::render::gpu::EntryPoints;
use relievo_shared::layout::{TIER_ACCURATE, TIER_FAST, TIER_PLANAR};

/// Its name.
pub(super) const FILE: &str = "README.md";

/// A name as it may stand in Markdown.
fn plain(name: &str) -> String {
    name.chars()
        .map(|letter| match letter {
            '`' | '|' | '<' | '>' | '\\' => '\'',
            letter if letter.is_control() => ' ',
            letter => letter,
        })
        .collect()
}

/// The list of the folders of several objects.
pub(super) fn list(folders: &[(String, &PreparedObject)]) -> String {
    let mut text = String::from(
        "# Exported objects\n\nOne folder for each, complete by itself; draw all of them in one pass, with one depth buffer.\n`frame.bin` is the same in all.\n\n| folder | object |\n|---|---|\n",
    );
    for (folder, object) in folders {
        text += &format!(
            "| [{folder}]({folder}/{FILE}) | {} |\n",
            plain(&object.name)
        );
    }
    text
}

/// The README of one object.
pub(super) fn object(
    scene: &PreparedScene,
    object: &PreparedObject,
    entry_points: EntryPoints,
    output: Output,
    shaders: &[ShaderFile],
) -> String {
    let [width, height] = scene.size;
    let tier = match object.parameters.tier {
        TIER_PLANAR => "planar",
        TIER_FAST => "fast",
        TIER_ACCURATE => "accurate",
        _ => "paper",
    };
    let mut text = format!(
        "# {}\n\nMade by `relievo export`: an object whose pattern is carved in its pixel shader,\nand all that the shader reads. Tier `{tier}`; the shaders are Relievo's `{}` and\n`{}`, which hold what this object needs and no more. Their licence is\nMIT OR Apache-2.0, at your choice.\n\n## Files\n\n| file | |\n|---|---|\n",
        plain(&object.name),
        entry_points.vertex,
        entry_points.color,
    );
    for shader in shaders {
        text += &format!(
            "| `{}` | {} shader in {}, entry point `{}` |\n",
            shader.file,
            shader.stage.name(),
            language(shader.target),
            shader.entry_point
        );
    }
    let all = bindings(entry_points.facets);
    for binding in &all {
        text += &format!(
            "| `{}` | bytes of binding {} |\n",
            binding.file, binding.number
        );
    }
    let map = &object.map;
    text += &format!(
        "| `{DRAW_FILE}` | four u32: vertices, instances, first vertex, first instance, as an indirect draw reads them |\n\
         | `layout.json` | bindings, every field of every struct with offset, type and unit, and the pipeline's state |\n\
         | `bindings.rs` | the same for Rust with wgpu |\n\
         | `mesh.glb` | the triangles for other tools; the shaders do not read it |\n\
         | `{}` | the shape map, {} × {} texels as {}, for other tools; `relievo render` takes it as `object.shape` |\n\n",
        map_file(map.storage()),
        map.width(),
        map.height(),
        map.storage(),
    );

    text += "## Bind\n\nGroup (set, space) 0, four read-only storage buffers, little-endian, without padding:\n\n| binding | name | holds | stages | bytes now |\n|---|---|---|---|---|\n";
    let sizes = [
        size_of_val(&scene.frame),
        size_of_val(&object.parameters),
        object.triangles.len() * entry_points.facets.bytes(),
        size_of_val(map.words()),
    ];
    for (
        Binding {
            number,
            name,
            element,
            is_array,
            in_vertex,
            about,
            ..
        },
        bytes,
    ) in all.iter().zip(sizes)
    {
        let many = if *is_array { "array of " } else { "" };
        let stages = if *in_vertex {
            "vertex, fragment"
        } else {
            "fragment"
        };
        text += &format!(
            "| {number} | `{name}` | {many}`{}`: {about} | {stages} | {bytes} |\n",
            element.name()
        );
    }
    let clear = match output {
        Output::Color => {
            let [red, green, blue] = scene.background;
            format!("the scene's background, linear: {red}, {green}, {blue}")
        }
        Output::Words => "anything that is no class, such as 0".to_string(),
    };
    text += &format!(
        "\n## Draw\n\n\
         * {} vertices, not indexed, one instance, no vertex buffers, a list of triangles: six\n  \
           vertices a facet, an outline around its pixels. No culling, one sample a pixel.\n\
         * Target 0 is {}, without blending: {}.\n  \
           Clear it to {clear}.\n\
         * Depth: a 32-bit float buffer, cleared to 0, compare `greater`, written. The fragment\n  \
           shader writes `near / z`, z the distance along `forward`: 1 at the near plane, 0 at\n  \
           infinity. What else is drawn into it must do the same (a reversed projection with an\n  \
           infinite far plane). Fragments are discarded.\n\
         * The target has the frame's `size`: {width} × {height} now.\n\n",
        6 * object.triangles.len(),
        output.formats().in_words(),
        output.about(),
    );

    let [x, y, z] = scene.origin.to_array();
    text += &format!(
        "## Another camera\n\n\
         Write `frame` anew; nothing else depends on it, but `object.slack` (if it is not 0),\n\
         which grows with the width of a pixel. Positions are relative to the middle of the\n\
         scene, ({x}, {y}, {z}) in world units. In Relievo `unlit_frame` in\n\
         `host/src/prepare/view.rs` does this. For an eye, a view along unit `f`, an `up`, a\n\
         vertical field of view `a`, and a picture of `w` × `h` pixels:\n\n\
         ```text\n\
         r = normalize(cross(f, up))        u = cross(r, f)\n\
         ty = tan(a / 2)                    tx = ty * w / h\n\n\
         eye        = eye - origin          forward   = f\n\
         right      = r / tx                up        = u / ty\n\
         ray_right  = r * (2 * tx / w)      ray_down  = u * (-2 * ty / h)\n\
         ray_first  = f - r * tx + u * ty + (ray_right + ray_down) / 2\n\
         near       > 0, nearer than anything that is seen\n\
         size       = (w, h)\n\
         ```\n\n\
         `light_direction` is a unit vector towards the light; `light_color` and `ambient` are\n\
         linear RGB.\n\n",
    );
    text += "## Languages\n\n";
    for target in Target::ALL {
        let of_target = |stage| {
            shaders
                .iter()
                .find(|shader| shader.target == target && shader.stage == stage)
        };
        if let (Some(_), Some(fragment)) = (of_target(Stage::Vertex), of_target(Stage::Fragment)) {
            text += &format!("* **{}**: {}\n", language(target), notes(target, fragment));
        }
    }
    text
}

/// A list of formats in words.
trait InWords {
    fn in_words(&self) -> String;
}

impl InWords for [&str] {
    fn in_words(&self) -> String {
        let quoted: Vec<String> = self.iter().map(|name| format!("`{name}`")).collect();
        quoted.join(", ")
    }
}

/// What a language is called.
fn language(target: Target) -> &'static str {
    match target {
        Target::Spirv => "SPIR-V",
        Target::Wgsl => "WGSL",
        Target::Glsl => "GLSL 4.50",
        Target::Hlsl => "HLSL (shader model 5.1)",
        Target::Msl => "Metal 2.0",
    }
}

/// What to know about a language.
fn notes(target: Target, fragment: &ShaderFile) -> String {
    match target {
        Target::Spirv => "for Vulkan 1.1 or newer. y goes up in the vertices' positions: give the viewport a negative height (`y = height`, `height = -height`). Descriptor set 0, storage buffers.".to_string(),
        Target::Wgsl => "as it is, also in browsers; nothing optional is used. The device must allow 4 storage buffers a stage.".to_string(),
        Target::Glsl => "one program of both files. `glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, …)`, `glDepthFunc(GL_GREATER)`, an empty vertex array object, `glDrawArrays(GL_TRIANGLES, 0, …)`. The picture stands upright as in OpenGL, its first row at the bottom; the depth that is written is the window's, with the range 0 to 1 that OpenGL starts with.".to_string(),
        Target::Hlsl => format!("`ByteAddressBuffer`s at `t0` to `t3`, space 0. `fxc /T ps_5_1 /E {0}` or `dxc -T ps_6_0 -E {0}`, and likewise the vertex shader.", fragment.entry_point),
        Target::Msl => format!("buffers 0 to 3 of both stages; buffer {METAL_SIZES} (sizes of arrays) is declared and never read: bind 16 bytes of anything."),
    }
}
