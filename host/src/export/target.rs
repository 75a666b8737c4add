//! Stages and outputs of exported shaders, and their file names.

use crate::shaders::EntryPoints;
use naga::ShaderStage;
use relievo_translate::Target;

/// Returns the name of the file with the shader `name` of a stage.
pub(super) fn file_name(target: Target, stage: Stage, name: &str) -> String {
    format!("{name}.{}", target.extension(stage.naga()))
}

/// Output of the fragment shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Output {
    /// Linear RGB and an alpha of 1, as floats.
    #[default]
    Color,
    /// The bits of linear RGB and the surface class, as Relievo's renderer reads them.
    Words,
    /// What a ray hits, as a function to call from shaders of one's own; and shaders that call
    /// it: the colours lit by one light, the depth alone, and a geometry buffer.
    Hit,
}

impl Output {
    pub(super) fn name(self) -> &'static str {
        match self {
            Output::Color => "color",
            Output::Words => "words",
            Output::Hit => "hit",
        }
    }

    /// Returns the compiled shader that fragment shaders with this output are made from.
    pub(super) fn source(self, entry_points: EntryPoints) -> &'static str {
        match self {
            Output::Color | Output::Words => entry_points.color,
            Output::Hit => entry_points.hit,
        }
    }

    /// Returns suitable formats of a target, by their WebGPU names.
    pub(super) fn formats(self) -> &'static [&'static str] {
        match self {
            Output::Color | Output::Hit => &["rgba32float", "rgba16float", "rgba8unorm-srgb"],
            Output::Words => &["rgba32uint"],
        }
    }

    pub(super) fn about(self) -> &'static str {
        match self {
            Output::Color | Output::Hit => "linear red, green, blue, and 1",
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
