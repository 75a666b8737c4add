//! What a sweep changes of a scene, one value an axis, and what renders it.

use super::Subject;
use crate::render::gpu::Shaders;
use crate::scene::{MapOptions, Scene, Tier};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What renders, with which shaders.
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

/// Renderings whose times may be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// The CPU.
    Cpu,
    /// A GPU, whatever the shaders.
    Gpu,
}

impl Rendering {
    /// What keys and files call it.
    pub fn name(self) -> &'static str {
        match self {
            Rendering::Cpu => "cpu",
            Rendering::GpuExact => "gpu-exact",
            Rendering::GpuFast => "gpu-fast",
            Rendering::GpuPortable => "gpu-portable",
        }
    }

    /// With what its times may be compared.
    pub fn class(self) -> Class {
        match self {
            Rendering::Cpu => Class::Cpu,
            Rendering::GpuExact | Rendering::GpuFast | Rendering::GpuPortable => Class::Gpu,
        }
    }

    /// The GPU's shaders.
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
    /// What a person calls it.
    pub fn name(self) -> &'static str {
        match self {
            Class::Cpu => "CPU",
            Class::Gpu => "GPU",
        }
    }
}

/// The model of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// The tier.
    pub tier: Tier,
    /// The accurate tier's tolerance, pixels; `None` in the others.
    pub tolerance: Option<f64>,
}

/// Bounds of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps {
    /// Steps of the linear search.
    pub linear: u32,
    /// Bisections after it.
    pub bisections: u32,
}

/// Which objects throw shadows on themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelfShadow {
    /// All.
    On,
    /// None.
    Off,
    /// Those that do in the scene, which are some.
    AsInScene,
}

/// What is drawn, and how: one value for each axis but the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The model of the surface.
    pub model: Model,
    /// The bounds of the search.
    pub steps: Steps,
    /// How far before its place a search may end, pixels.
    pub slack: f64,
    /// How patterns are stored; `None` where every object has a baked map.
    pub map: Option<MapOptions>,
    /// Samples per pixel side.
    pub supersampling: u32,
    /// Shadows.
    pub self_shadow: SelfShadow,
}

/// One point of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// What is drawn.
    pub settings: Settings,
    /// What renders it.
    pub rendering: Rendering,
}

/// What is varied. A key has one part for each, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The tier, with the accurate tier's tolerance.
    Tier,
    /// Linear steps and bisections.
    Steps,
    /// Pixels before its place that a search may end.
    Slack,
    /// Bits of a texel.
    Storage,
    /// Size of the map.
    Reduction,
    /// Samples per pixel side.
    Supersampling,
    /// Shadows.
    SelfShadow,
    /// What renders.
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

    /// Its column in the CSV.
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

    /// What a person calls it.
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

    /// Whether it changes what a ray of a given direction hits.
    fn is_geometric(self) -> bool {
        match self {
            Axis::Tier | Axis::Steps | Axis::Slack | Axis::Storage | Axis::Reduction => true,
            Axis::Supersampling | Axis::SelfShadow | Axis::Renderer => false,
        }
    }
}

impl Variant {
    /// Its value on `axis`, as keys have it.
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

    /// Its name, the same in every run: `accurate-0.1px/256+10/slack-0px/r16/1:2/1x/no-shadow/gpu-fast`.
    pub fn key(&self) -> String {
        self.key_of(|_| true)
    }

    /// The parts of its key that tell variants apart which differ in more than
    /// `axis`.
    pub fn key_without(&self, axis: Axis) -> String {
        self.key_of(|other| other != axis)
    }

    /// The parts of its key that say what is drawn.
    pub fn picture_key(&self) -> String {
        self.key_of(|axis| axis != Axis::Renderer)
    }

    /// The parts of its key that say what each ray hits.
    pub fn geometry_key(&self) -> String {
        self.key_of(Axis::is_geometric)
    }

    fn key_of(&self, is_in: impl Fn(Axis) -> bool) -> String {
        let axes = Axis::ALL.into_iter().filter(|axis| is_in(*axis));
        let parts: Vec<String> = axes.map(|axis| self.value(axis)).collect();
        parts.join("/")
    }
}

impl Settings {
    /// The subject's scene, so drawn.
    pub fn apply(&self, subject: &Subject) -> Scene {
        let mut scene = subject.scene.clone();
        scene.supersampling = self.supersampling;
        for (object, is_baked) in scene.objects.iter_mut().zip(&subject.is_baked) {
            object.budget = None;
            object.tier = self.model.tier;
            if let Some(tolerance) = self.model.tolerance {
                object.tolerance = tolerance;
            }
            object.steps = self.steps.linear;
            object.bisections = self.steps.bisections;
            object.slack = self.slack;
            if let (Some(map), false) = (self.map, is_baked) {
                object.map = map;
            }
            match self.self_shadow {
                SelfShadow::On => object.self_shadow = true,
                SelfShadow::Off => object.self_shadow = false,
                SelfShadow::AsInScene => {}
            }
        }
        scene
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
