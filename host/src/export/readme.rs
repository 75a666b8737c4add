//! Writes the README of an export: its files, bindings and how to draw it.

use super::files::{DRAW_FILE, ShaderFile, map_file};
use super::hit;
use super::hull::{INDICES_FILE, VERTICES_FILE};
use super::interface::Interface;
use super::layout::Binding;
use super::target::Stage;
use super::{MapForm, Options, Output};
use crate::prepare::{PreparedObject, PreparedScene};
use crate::shaders::EntryPoints;
use relievo_shared::layout::{TIER_ACCURATE, TIER_FAST, TIER_PLANAR};
use relievo_translate::{METAL_SIZES, Target};

/// Name of the file.
pub(super) const FILE: &str = "README.md";

/// Replaces characters of a name that have a meaning in Markdown.
fn plain(name: &str) -> String {
    name.chars()
        .map(|letter| match letter {
            '`' | '|' | '<' | '>' | '\\' => '\'',
            letter if letter.is_control() => ' ',
            letter => letter,
        })
        .collect()
}

/// Writes the README that lists the folders of several objects.
pub(super) fn list(folders: &[(String, &PreparedObject)]) -> String {
    let mut text = String::from(
        "# Exported objects\n\nEach folder is complete. Draw all objects in one pass, with one depth buffer.\n`frame.bin` is the same in all folders.\n\n| folder | object |\n|---|---|\n",
    );
    for (folder, object) in folders {
        text += &format!(
            "| [{folder}]({folder}/{FILE}) | {} |\n",
            plain(&object.name)
        );
    }
    text
}

/// Writes the README of one object.
pub(super) fn object(
    scene: &PreparedScene,
    object: &PreparedObject,
    entry_points: EntryPoints,
    options: &Options,
    shaders: &[ShaderFile],
) -> String {
    let Options {
        output, interface, ..
    } = options;
    let [width, height] = scene.size;
    let tier = match object.parameters.tier {
        TIER_PLANAR => "planar",
        TIER_FAST => "fast",
        TIER_ACCURATE => "accurate",
        _ => "paper",
    };
    let mut text = format!(
        "# {}\n\nWritten by `relievo export`: an object whose pattern is carved in its fragment shader,\nand all data that the shader reads. Tier: `{tier}`. The shaders are Relievo's `{}`\nand `{}`, compiled for the features of this object. Their licence is\nMIT OR Apache-2.0, at your choice.\n\n## Files\n\n| file | |\n|---|---|\n",
        plain(&object.name),
        entry_points.vertex,
        output.source(entry_points),
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
    if *output == Output::Hit {
        let targets = Target::ALL.iter().filter(|target| {
            **target != Target::Spirv && shaders.iter().any(|shader| shader.target == **target)
        });
        for target in targets {
            text += &format!(
                "| `{}` | the function `{}` in {}, to include in your own shaders |\n",
                hit::file_name(*target),
                interface.value("hit"),
                language(*target)
            );
        }
    }
    let all = interface.bindings(entry_points.facets);
    for binding in &all {
        text += &format!(
            "| `{}` | contents of binding {} |\n",
            binding.file, binding.number
        );
    }
    if *output == Output::Hit {
        text += &format!(
            "| `{VERTICES_FILE}`, `{INDICES_FILE}` | vertices and indices of hulls around the facets, for engines with vertex buffers |\n"
        );
    }
    let map = &object.map;
    text += &format!(
        "| `{DRAW_FILE}` | four u32: vertices, instances, first vertex, first instance, as an indirect draw reads them |\n\
         | `layout.json` | the bindings, every field of every struct with offset, type and unit, and the pipeline state |\n\
         | `bindings.rs` | the same for Rust with wgpu |\n\
         | `mesh.glb` | the triangles for other tools; not read by the shaders |\n\
         | `{}` | the shape map, {} × {} texels as {}, for other tools; `relievo render` takes it as `object.shape` |\n\n",
        map_file(map.storage()),
        map.width(),
        map.height(),
        map.storage(),
    );

    text += &format!(
        "## Bind\n\nGroup (set, space) {} has {}, little-endian, without padding:\n\n",
        interface.group,
        match interface.map {
            MapForm::Buffer => "four read-only storage buffers".to_string(),
            MapForm::Texture => format!(
                "three read-only storage buffers and a 2D texture (`r32uint`, {} × {} texels, without levels of detail)",
                MapForm::WIDTH,
                MapForm::height(map.words().len())
            ),
        }
    );
    text +=
        "| binding | name | contents | stages | bytes in this export |\n|---|---|---|---|---|\n";
    let sizes = [
        size_of_val(&scene.frame),
        size_of_val(&object.parameters),
        object.triangles.len() * entry_points.facets.bytes(),
        interface.map.bytes(map.words()).len(),
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
        Output::Color | Output::Hit => {
            let [red, green, blue] = scene.background;
            format!("the scene's background, linear: {red}, {green}, {blue}")
        }
        Output::Words => "a value that is not a class, such as 0".to_string(),
    };
    text += &format!(
        "\n## Draw\n\n\
         * {} vertices as a triangle list, not indexed, one instance, no vertex buffers. Each\n  \
           facet has three, for an outline around its pixels. No culling, one sample per pixel.\n\
         * Target 0: {}, without blending. It gets\n  \
           {}. Clear it to {clear}.\n\
         * Depth: a 32-bit float buffer, cleared to 0, compare `greater`, write enabled. The\n  \
           fragment shader writes `near / z`, with z the distance along `forward`: 1 at the near\n  \
           plane, 0 at infinity. Anything else drawn into it must do the same (a reversed\n  \
           projection with an infinite far plane). The shader discards fragments.\n\
         * The target must have the frame's `size`, here {width} × {height}.\n\n",
        3 * object.triangles.len(),
        quoted(output.formats()),
        output.about(),
    );

    if *output == Output::Hit {
        text += &hit_section(interface);
    }
    let [x, y, z] = scene.origin.to_array();
    text += &format!(
        "## Another camera\n\n\
         Rewrite `frame`. Nothing else depends on the camera, except `object.slack` if it is\n\
         not 0, which is proportional to the width of a pixel. Positions are relative to the\n\
         centre of the scene, ({x}, {y}, {z}) in world units. In Relievo, `unlit_frame` in\n\
         `host/src/prepare/camera.rs` does this. For an eye, a unit view direction `f`, an `up`, a\n\
         vertical field of view `a`, and a picture of `w` × `h` pixels:\n\n\
         ```text\n\
         r = normalize(cross(f, up))        u = cross(r, f)\n\
         ty = tan(a / 2)                    tx = ty * w / h\n\n\
         eye        = eye - origin          forward   = f\n\
         right      = r / tx                up        = u / ty\n\
         ray_right  = r * (2 * tx / w)      ray_down  = u * (-2 * ty / h)\n\
         ray_first  = f - r * tx + u * ty + (ray_right + ray_down) / 2\n\
         near       > 0, less than the distance of anything visible\n\
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
            text += &format!(
                "* **{}**: {}\n",
                language(target),
                notes(target, fragment, interface)
            );
        }
    }
    text
}

/// Writes the section on the function that finds hits.
fn hit_section(interface: &Interface) -> String {
    let (function, first) = (interface.value("hit"), interface.first_binding);
    let mut text = format!(
        "## The hit\n\n`{0}` finds what a ray hits in the shell over one facet; call it for each pixel of the\nfacet's outline, as `fragment`, `depth` and `geometry` do. It reads bindings {1} to {2}. Positions and\ndirections are in object space. It neither discards nor asks for derivatives, so it may be called\nin any stage and in any branch. In Metal what it reads is given by further arguments. SPIR-V has no\nincludes, and only the shaders that call it.\n\n| argument of `{0}` | |\n|---|---|\n",
        function,
        first + 1,
        first + 3
    );
    let row =
        |described: &hit::Described| format!("| `{}` | {} |\n", described.name, described.meaning);
    text.extend(hit::ARGUMENTS.iter().map(row));
    text += &format!(
        "\n| field of `{}` | |\n|---|---|\n",
        interface.type_name("Hit")
    );
    text.extend(hit::FIELDS.iter().map(row));
    text + "\n### Vertex buffers\n\n\
        `vertex` needs the camera in `frame`. An engine that has its own vertex stage draws the hulls of the\n\
        facets instead, with any camera: perspective, orthographic, or that of a shadow map. Of their faces\n\
        draw those that are turned away (cull mode `front`, counterclockwise faces are front). Add `outward` times\n\
        the width of a pixel at the vertex (object units) to `position`: then pixels and samples at the\n\
        edges are covered, whatever the device's rules. `layout.json` describes the vertices. The hit is at `origin + t\n\
        direction`: write its depth, by the engine's matrices.\n\n\
        ### Orthographic cameras\n\n\
        `depth_orthographic` draws the hulls into the shadow map of a distant light. It takes a `frame` with the\n\
        centre of the near plane as `eye`, the distance from there to the far plane as `near`, the change of position from\n\
        pixel to pixel as `ray_right` and `ray_down`, and the vector from the eye to the centre of the first pixel\n\
        as `ray_first`. The depth is 1 on the near plane and 0 on the far plane.\n\n"
}

/// Formats names as a list in code style.
fn quoted(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

/// Returns the name of a language with its version.
fn language(target: Target) -> &'static str {
    match target {
        Target::Spirv => "SPIR-V",
        Target::Wgsl => "WGSL",
        Target::Glsl => "GLSL 4.50",
        Target::Hlsl => "HLSL (shader model 5.1)",
        Target::Msl => "Metal 2.0",
    }
}

/// Returns notes on how to use the shaders of a language.
fn notes(target: Target, fragment: &ShaderFile, interface: &Interface) -> String {
    let Interface {
        group,
        first_binding,
        ..
    } = *interface;
    let last = first_binding + 3;
    match target {
        Target::Spirv => format!("for Vulkan 1.1 or newer. y points up in vertex positions: use a viewport with a negative height (`y = height`, `height = -height`). Descriptor set {group}, storage buffers."),
        Target::Wgsl => "for native programs and browsers; uses no optional features. The device must allow 4 storage buffers per stage.".to_string(),
        Target::Glsl => format!("link both files to one program. `glBindBufferBase(GL_SHADER_STORAGE_BUFFER, slot, …)`, the first at slot {}, `glDepthFunc(GL_GREATER)`, an empty vertex array object, `glDrawArrays(GL_TRIANGLES, 0, …)`. The picture is upright as usual in OpenGL, its first row at the bottom. The depth written is the window depth, with OpenGL's default range of 0 to 1.", interface.first_slot()),
        Target::Hlsl => format!("`ByteAddressBuffer`s at `t{first_binding}` to `t{last}`, space {group}. `fxc /T ps_5_1 /E {0}` or `dxc -T ps_6_0 -E {0}`, and likewise the vertex shader.", fragment.entry_point),
        Target::Msl => format!("buffers {} to {} of both stages. Buffer {METAL_SIZES} (array sizes) is declared but never read: bind any 16 bytes.", interface.first_slot(), interface.first_slot() + 3),
    }
}
