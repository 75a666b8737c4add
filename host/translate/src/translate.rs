//! Translates a shader to a shading language with naga (feature `export`).
//!
//! ```
//! use relievo_translate::{METAL_SIZES, Target, finish};
//!
//! let mut module = naga::front::wgsl::parse_str(
//!     "@compute @workgroup_size(1) fn nothing() {}",
//! )?;
//! let written = finish(&mut module, Target::Hlsl, METAL_SIZES)?;
//! assert!(String::from_utf8(written.bytes)?.contains("void nothing"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::portable;
use naga::back::{glsl, hlsl, msl, spv, wgsl};
use naga::compact::{KeepUnused, compact};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ResourceBinding, ShaderStage};
use std::fmt;

/// Shader model of the HLSL, which both of its compilers take.
const SHADER_MODEL: hlsl::ShaderModel = hlsl::ShaderModel::V5_1;
/// Version of the Metal shading language.
const METAL: (u8, u8) = (2, 0);
/// Version of GLSL.
const GLSL: u16 = 450;
/// Version of SPIR-V, that of Vulkan 1.1.
const SPIRV: (u8, u8) = (1, 3);
/// Slots of a group in GLSL and Metal, which have no groups.
pub const GROUP: u32 = 16;
/// Metal's last slot of buffers, for the sizes of the others.
pub const METAL_SIZES: u8 = 30;

/// A shading language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// SPIR-V 1.3, for Vulkan.
    Spirv,
    /// WGSL, for WebGPU.
    Wgsl,
    /// GLSL 4.50, for OpenGL.
    Glsl,
    /// HLSL (shader model 5.1), for Direct3D.
    Hlsl,
    /// Metal 2.0.
    Msl,
}

impl Target {
    /// All languages.
    pub const ALL: [Target; 5] = [
        Target::Spirv,
        Target::Wgsl,
        Target::Glsl,
        Target::Hlsl,
        Target::Msl,
    ];

    /// Returns the name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Target::Spirv => "spirv",
            Target::Wgsl => "wgsl",
            Target::Glsl => "glsl",
            Target::Hlsl => "hlsl",
            Target::Msl => "msl",
        }
    }

    /// Returns the extension of a file with a shader of `stage`.
    pub fn extension(self, stage: ShaderStage) -> &'static str {
        match (self, stage) {
            (Target::Spirv, _) => "spv",
            (Target::Wgsl, _) => "wgsl",
            (Target::Glsl, ShaderStage::Vertex) => "vert",
            (Target::Glsl, ShaderStage::Fragment) => "frag",
            (Target::Glsl, ShaderStage::Compute) => "comp",
            (Target::Glsl, _) => "glsl",
            (Target::Hlsl, _) => "hlsl",
            (Target::Msl, _) => "metal",
        }
    }

    /// Returns whether naga translates only loops that [`portable::lower`] has rewritten.
    fn needs_lowered_loops(self) -> bool {
        matches!(self, Target::Glsl | Target::Hlsl | Target::Msl)
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A shader translated to a language.
#[derive(Clone, Debug)]
pub struct Written {
    /// Contents of its file.
    pub bytes: Vec<u8>,
    /// Name of its entry point in this language.
    pub entry_point: String,
    /// Its stage.
    pub stage: ShaderStage,
}

/// Translates the shader in `words`, SPIR-V with one entry point, to `target`.
///
/// In the name of the entry point, `_` replaces `::`. Bindings of group 0 keep their numbers;
/// GLSL and Metal, which have no groups, have binding b of group g at 16·g + b.
///
/// # Errors
/// naga's reason why the shader cannot be read, validated or written.
pub fn translate(words: &[u32], target: Target) -> Result<Written, String> {
    let mut module = portable::read(words)?;
    for entry_point in &mut module.entry_points {
        entry_point.name = entry_point.name.replace("::", "_");
    }
    finish(&mut module, target, METAL_SIZES)
}

/// Translates `module`, which has one entry point, to `target`: rewrites its loops if need
/// be, removes what is unused, validates it for WebGPU without optional features, and
/// writes it. `metal_sizes` is Metal's slot of the sizes of buffers.
///
/// # Errors
/// naga's reason why the module cannot be validated or written.
pub fn finish(module: &mut Module, target: Target, metal_sizes: u8) -> Result<Written, String> {
    if target.needs_lowered_loops() {
        portable::lower(module)?;
    }
    compact(module, KeepUnused::No);
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(module)
        .map_err(|error| describe(error.as_inner()))?;
    write(module, &info, target, metal_sizes)
}

/// Formats an error with its causes.
fn describe(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}

/// Returns the bindings of a module, with their slots in a language without groups.
fn slots(module: &Module) -> Result<Vec<(ResourceBinding, u8)>, String> {
    let bindings = module.global_variables.iter();
    bindings
        .filter_map(|(_, variable)| variable.binding)
        .map(|binding| {
            let is_alone = binding.group == 0 || binding.binding < GROUP;
            let slot = binding.group.checked_mul(GROUP).filter(|_| is_alone);
            let slot = slot.and_then(|first| first.checked_add(binding.binding));
            let slot = slot.and_then(|slot| u8::try_from(slot).ok());
            let ResourceBinding { group, binding: number } = binding;
            let slot = slot.ok_or_else(|| {
                format!("it has no slot for binding {number} of group {group}: this language has no groups, and 16 slots for each")
            })?;
            Ok((binding, slot))
        })
        .collect()
}

/// Writes a validated module with one entry point.
fn write(
    module: &Module,
    info: &ModuleInfo,
    target: Target,
    metal_sizes: u8,
) -> Result<Written, String> {
    let [entry_point] = module.entry_points.as_slice() else {
        return Err("it does not have exactly one entry point".to_string());
    };
    let (name, stage) = (entry_point.name.clone(), entry_point.stage);
    // Indices are within the buffers by construction.
    let unchecked = BoundsCheckPolicies::default();
    let (bytes, entry_point) = match target {
        Target::Wgsl => {
            let text = wgsl::write_string(module, info, wgsl::WriterFlags::empty())
                .map_err(|error| describe(&error))?;
            // naga changes names that WGSL reserves, and writes the entry point last.
            let last = text.rsplit_once("\nfn ").map(|(_, last)| last);
            let name = last.and_then(|last| last.split_once('('));
            let (name, _) = name.ok_or("its entry point was not written")?;
            let name = name.to_string();
            (text.into_bytes(), name)
        }
        Target::Spirv => {
            let options = spv::Options {
                lang_version: SPIRV,
                flags: spv::WriterFlags::DEBUG | spv::WriterFlags::LABEL_VARYINGS,
                fake_missing_bindings: true,
                bounds_check_policies: unchecked,
                force_loop_bounding: false,
                ..Default::default()
            };
            let words =
                spv::write_vec(module, info, &options, None).map_err(|error| describe(&error))?;
            (spirv_bytes(&words), name)
        }
        Target::Glsl => {
            let options = glsl::Options {
                version: glsl::Version::Desktop(GLSL),
                // Neither y nor z is changed: the picture is upright as usual in
                // OpenGL, and the fragment shader writes the depth.
                writer_flags: glsl::WriterFlags::empty(),
                binding_map: slots(module)?.into_iter().collect(),
                ..Default::default()
            };
            let pipeline = glsl::PipelineOptions {
                shader_stage: stage,
                entry_point: name,
                multiview: None,
            };
            let mut text = String::new();
            glsl::Writer::new(&mut text, module, info, &options, &pipeline, unchecked)
                .and_then(|mut writer| writer.write())
                .map_err(|error| describe(&error))?;
            (text.into_bytes(), "main".to_string())
        }
        Target::Hlsl => {
            let options = hlsl::Options {
                shader_model: SHADER_MODEL,
                restrict_indexing: false,
                force_loop_bounding: false,
                ..Default::default()
            };
            let pipeline = hlsl::PipelineOptions::default();
            let mut text = String::new();
            let reflection = hlsl::Writer::new(&mut text, &options, &pipeline)
                .write(module, info, None)
                .map_err(|error| describe(&error))?;
            let [Ok(name)] = reflection.entry_point_names.as_slice() else {
                return Err("its entry point was not written".to_string());
            };
            (text.into_bytes(), name.clone())
        }
        Target::Msl => {
            // Buffers, textures and samplers are counted apart.
            let of = |slot: u8| msl::BindTarget {
                buffer: Some(slot),
                texture: Some(slot),
                sampler: Some(msl::BindSamplerTarget::Resource(slot)),
                mutable: true,
                ..Default::default()
            };
            let resources = slots(module)?;
            let resources = msl::EntryPointResources {
                resources: resources
                    .into_iter()
                    .map(|(b, slot)| (b, of(slot)))
                    .collect(),
                sizes_buffer: Some(metal_sizes),
                ..Default::default()
            };
            let options = msl::Options {
                lang_version: METAL,
                per_entry_point_map: [(name, resources)].into_iter().collect(),
                fake_missing_bindings: false,
                bounds_check_policies: unchecked,
                force_loop_bounding: false,
                ..Default::default()
            };
            let pipeline = msl::PipelineOptions::default();
            let (text, translated) = msl::write_string(module, info, &options, &pipeline)
                .map_err(|error| describe(&error))?;
            let [Ok(name)] = translated.entry_point_names.as_slice() else {
                return Err("its entry point was not written".to_string());
            };
            (text.into_bytes(), name.clone())
        }
    };
    Ok(Written {
        bytes,
        entry_point,
        stage,
    })
}

/// Converts words to the bytes of a `.spv` file.
pub fn spirv_bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(source: &str, target: Target) -> Result<(String, String), String> {
        let mut module = naga::front::wgsl::parse_str(source).expect("WGSL");
        let written = finish(&mut module, target, METAL_SIZES)?;
        let text = String::from_utf8_lossy(&written.bytes).into_owned();
        Ok((text, written.entry_point))
    }

    /// Two groups, a read-write buffer, and a name that Metal reserves.
    const GROUPS: &str = "
        @group(0) @binding(17) var<storage> a: array<u32>;
        @group(1) @binding(2) var<storage, read_write> b: array<u32>;
        @compute @workgroup_size(64)
        fn kernel(@builtin(global_invocation_id) id: vec3<u32>) { b[id.x] = a[id.x]; }
    ";

    #[test]
    fn groups_have_slots_of_their_own_where_there_are_none() {
        let (glsl, name) = written(GROUPS, Target::Glsl).unwrap();
        assert!(
            glsl.contains("binding = 17") && glsl.contains("binding = 18"),
            "{glsl}"
        );
        assert!(glsl.contains("local_size_x = 64"), "{glsl}");
        assert_eq!(name, "main");
        let (metal, name) = written(GROUPS, Target::Msl).unwrap();
        for slot in [17, 18, METAL_SIZES.into()] {
            assert!(metal.contains(&format!("buffer({slot})")), "{metal}");
        }
        assert!(
            metal.contains(&format!("kernel void {name}(")) && name != "kernel",
            "{metal}"
        );
        let (hlsl, _) = written(GROUPS, Target::Hlsl).unwrap();
        assert!(hlsl.contains("register(u2, space1)"), "{hlsl}");

        let far = GROUPS.replace("binding(2)", "binding(16)");
        let error = written(&far, Target::Glsl).unwrap_err();
        assert!(error.contains("binding 16 of group 1"), "{error}");
        written(&far, Target::Wgsl).unwrap();
    }

    #[test]
    fn the_name_is_that_of_the_entry_point_as_written() {
        let source = "fn first() {} @compute @workgroup_size(1) fn last() { first(); }";
        for target in Target::ALL {
            let (text, name) = written(source, target).unwrap();
            assert!(text.contains(&name), "{target}: {name}");
            assert_eq!(name.starts_with("last"), target != Target::Glsl, "{target}");
        }
        let mut module = naga::front::wgsl::parse_str(source).expect("WGSL");
        // Reserved in WGSL.
        module.entry_points[0].name = "override".to_string();
        let written = finish(&mut module, Target::Wgsl, METAL_SIZES).unwrap();
        let text = String::from_utf8(written.bytes).unwrap();
        assert_ne!(written.entry_point, "override");
        assert!(
            text.contains(&format!("fn {}(", written.entry_point)),
            "{text}"
        );
        naga::front::wgsl::parse_str(&text).unwrap();
    }

    #[test]
    fn what_naga_refuses_has_its_reason() {
        // An optional feature of WebGPU.
        let source = "enable f16; @compute @workgroup_size(1) fn half() { var x = 1.0h; x += x; }";
        let error = written(source, Target::Wgsl).unwrap_err();
        assert!(error.contains("FLOAT16"), "{error}");
        let two = "@compute @workgroup_size(1) fn a() {} @compute @workgroup_size(1) fn b() {}";
        let error = written(two, Target::Wgsl).unwrap_err();
        assert!(error.contains("exactly one"), "{error}");
    }
}
