//! Shading languages, stages and outputs of exported shaders.

use naga::ShaderStage;
use std::fmt;

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

    /// Returns the file name of a stage.
    pub(super) fn file(self, stage: Stage) -> String {
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

/// Output of the fragment shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Output {
    /// Linear RGB and an alpha of 1, as floats.
    #[default]
    Color,
    /// The bits of linear RGB and the surface class, as Relievo's renderer reads them.
    Words,
}

impl Output {
    pub(super) fn name(self) -> &'static str {
        match self {
            Output::Color => "color",
            Output::Words => "words",
        }
    }

    /// Returns suitable formats of a target, by their WebGPU names.
    pub(super) fn formats(self) -> &'static [&'static str] {
        match self {
            Output::Color => &["rgba32float", "rgba16float", "rgba8unorm-srgb"],
            Output::Words => &["rgba32uint"],
        }
    }

    pub(super) fn about(self) -> &'static str {
        match self {
            Output::Color => "linear red, green, blue, and 1",
            Output::Words => {
                "the bits of linear red, green and blue as f32, and the class: 1 cap, 2 wall, 3 bevel, 4 floor"
            }
        }
    }
}

/// A stage of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Vertex,
    Fragment,
}

impl Stage {
    pub(super) fn name(self) -> &'static str {
        match self {
            Stage::Vertex => "vertex",
            Stage::Fragment => "fragment",
        }
    }

    /// Returns the name of its entry point, which no language reserves.
    pub(super) fn entry_point(self) -> &'static str {
        match self {
            Stage::Vertex => "vs_main",
            Stage::Fragment => "fs_main",
        }
    }

    pub(super) fn naga(self) -> ShaderStage {
        match self {
            Stage::Vertex => ShaderStage::Vertex,
            Stage::Fragment => ShaderStage::Fragment,
        }
    }
}
