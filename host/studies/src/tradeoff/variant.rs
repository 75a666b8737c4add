//! Variants of a scene: one value per axis, and a renderer.

use relievo::render::gpu::Shaders;
use relievo::scene::{MapOptions, Tier};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Renderer and shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rendering {
    /// The CPU.
    Cpu,
    /// A GPU with the exact shaders.
    GpuExact,
    /// A GPU with the fast shaders.
    GpuFast,
    /// A GPU with the fast shaders, through naga.
    GpuPortable,
}

/// Renderings with comparable times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// The CPU.
    Cpu,
    /// A GPU with any shaders.
    Gpu,
}

impl Rendering {
    /// Returns the name in keys and files.
    pub fn name(self) -> &'static str {
        match self {
            Rendering::Cpu => "cpu",
            Rendering::GpuExact => "gpu-exact",
            Rendering::GpuFast => "gpu-fast",
            Rendering::GpuPortable => "gpu-portable",
        }
    }

    /// Returns the class of comparable times.
    pub fn class(self) -> Class {
        match self {
            Rendering::Cpu => Class::Cpu,
            Rendering::GpuExact | Rendering::GpuFast | Rendering::GpuPortable => Class::Gpu,
        }
    }

    /// Returns the GPU's shaders.
    pub fn shaders(self) -> Option<Shaders> {
        match self {
            Rendering::Cpu => None,
            Rendering::GpuExact => Some(Shaders::Exact),
            Rendering::GpuFast => Some(Shaders::Fast),
            Rendering::GpuPortable => Some(Shaders::Portable),
        }
    }
}

impl Class {
    /// Returns the name shown to users.
    pub fn name(self) -> &'static str {
        match self {
            Class::Cpu => "CPU",
            Class::Gpu => "GPU",
        }
    }
}

/// Surface model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Tier.
    pub tier: Tier,
    /// Tolerance of the accurate tier, pixels; `None` in the others.
    pub tolerance: Option<f64>,
}

/// Search bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps {
    /// Linear steps.
    pub linear: u32,
    /// Bisections.
    pub bisections: u32,
}

/// Which objects shadow themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfShadow {
    /// All.
    On,
    /// None.
    Off,
    /// As in the scene, where some do.
    AsInScene,
}

/// One value for each axis except the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Surface model.
    pub model: Model,
    /// Search bounds.
    pub steps: Steps,
    /// Slack, pixels: distance before the hit at which a search may end.
    pub slack: f64,
    /// Storage of patterns; `None` if every object has a baked map.
    pub map: Option<MapOptions>,
    /// Samples per pixel side.
    pub supersampling: u32,
    /// Self-shadowing.
    pub self_shadow: SelfShadow,
}

/// One point of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Settings.
    pub settings: Settings,
    /// Renderer.
    pub rendering: Rendering,
}

/// Dimension of a sweep. A key has one part for each, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Tier, with the accurate tier's tolerance.
    Tier,
    /// Linear steps and bisections.
    Steps,
    /// Slack.
    Slack,
    /// Bits per texel.
    Storage,
    /// Map size.
    Reduction,
    /// Samples per pixel side.
    Supersampling,
    /// Self-shadowing.
    SelfShadow,
    /// Renderer.
    Renderer,
}

impl Axis {
    /// Every axis, in the order of a key's parts.
    pub const ALL: [Axis; 8] = [
        Axis::Tier,
        Axis::Steps,
        Axis::Slack,
        Axis::Storage,
        Axis::Reduction,
        Axis::Supersampling,
        Axis::SelfShadow,
        Axis::Renderer,
    ];

    /// Returns the CSV column.
    pub fn column(self) -> &'static str {
        match self {
            Axis::Tier => "tier",
            Axis::Steps => "steps",
            Axis::Slack => "slack",
            Axis::Storage => "map_storage",
            Axis::Reduction => "map_size",
            Axis::Supersampling => "supersampling",
            Axis::SelfShadow => "self_shadow",
            Axis::Renderer => "renderer",
        }
    }

    /// Returns the name shown to users.
    pub fn title(self) -> &'static str {
        match self {
            Axis::Tier => "Tier",
            Axis::Steps => "Linear steps + bisections",
            Axis::Slack => "Slack",
            Axis::Storage => "Map storage",
            Axis::Reduction => "Map size",
            Axis::Supersampling => "Samples per pixel side",
            Axis::SelfShadow => "Self-shadow",
            Axis::Renderer => "Shaders",
        }
    }

    /// Returns whether it changes the hit of a given ray.
    fn is_geometric(self) -> bool {
        match self {
            Axis::Tier | Axis::Steps | Axis::Slack | Axis::Storage | Axis::Reduction => true,
            Axis::Supersampling | Axis::SelfShadow | Axis::Renderer => false,
        }
    }
}

impl Variant {
    /// Returns its value on `axis`, as in keys.
    pub fn value(&self, axis: Axis) -> String {
        let Settings {
            model,
            steps,
            slack,
            map,
            supersampling,
            self_shadow,
        } = self.settings;
        match axis {
            Axis::Tier => model.to_string(),
            Axis::Steps => format!("{}+{}", steps.linear, steps.bisections),
            Axis::Slack => format!("slack-{slack}px"),
            Axis::Storage => map.map_or("baked", |map| map.storage.name()).to_string(),
            Axis::Reduction => format!("1:{}", map.map_or(1, |map| map.reduction)),
            Axis::Supersampling => format!("{supersampling}x"),
            Axis::SelfShadow => match self_shadow {
                SelfShadow::On => "shadow",
                SelfShadow::Off => "no-shadow",
                SelfShadow::AsInScene => "own-shadow",
            }
            .to_string(),
            Axis::Renderer => self.rendering.name().to_string(),
        }
    }

    /// Returns its name, the same in every run:
    /// `accurate-0.1px/256+10/slack-0px/r16/1:2/1x/no-shadow/gpu-fast`.
    pub fn key(&self) -> String {
        self.key_of(|_| true)
    }

    /// Returns the key without the part of `axis`.
    pub fn key_without(&self, axis: Axis) -> String {
        self.key_of(|other| other != axis)
    }

    /// Returns the parts of the key that determine the picture.
    pub fn picture_key(&self) -> String {
        self.key_of(|axis| axis != Axis::Renderer)
    }

    /// Returns the parts of the key that determine what each ray hits.
    pub fn geometry_key(&self) -> String {
        self.key_of(Axis::is_geometric)
    }

    fn key_of(&self, is_in: impl Fn(Axis) -> bool) -> String {
        let axes = Axis::ALL.into_iter().filter(|axis| is_in(*axis));
        let parts: Vec<String> = axes.map(|axis| self.value(axis)).collect();
        parts.join("/")
    }
}

impl fmt::Display for Model {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.tolerance {
            Some(tolerance) => write!(formatter, "{}-{tolerance}px", self.tier.name()),
            None => formatter.write_str(self.tier.name()),
        }
    }
}
