//! The compiled shaders: which modules there are, which entry point draws what,
//! and how a module reaches the driver.

use relievo_shared::layout::{Object, SEARCH_PAPER, SEARCH_RELIEF};
use std::borrow::Cow;

/// The modules (see `assets/shaders/manifest.toml`).
static EXACT: &[u8] = include_bytes!("../../../../assets/shaders/relievo_exact.spv");
static FAST: &[u8] = include_bytes!("../../../../assets/shaders/relievo_fast.spv");

/// The entry point of every vertex stage.
pub(super) const VERTEX: &str = "vertex";

/// Every entry point of each module.
const ENTRY_POINTS: [&str; 10] = [
    VERTEX,
    "color_extrusion",
    "color_extrusion_shadow",
    "color_relief",
    "color_relief_shadow",
    "color_paper",
    "color_paper_shadow",
    "geometry_extrusion",
    "geometry_relief",
    "geometry_paper",
];

/// Which module is used, and how it reaches the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shaders {
    /// The exact module, untouched: the CPU's words. Vulkan only.
    Exact,
    /// The freely optimised module, untouched. Vulkan only.
    Fast,
    /// The freely optimised module through naga, which every backend of wgpu takes.
    Portable,
}

impl Shaders {
    /// What a person calls it.
    pub fn describe(self) -> &'static str {
        match self {
            Shaders::Exact => "exact shaders",
            Shaders::Fast => "fast shaders",
            Shaders::Portable => "portable shaders",
        }
    }

    /// Whether the driver must take SPIR-V untouched.
    pub fn is_untouched(self) -> bool {
        self != Shaders::Portable
    }

    /// Loads the module on `device`.
    pub(super) fn load(self, device: &wgpu::Device) -> wgpu::ShaderModule {
        let words = wgpu::util::make_spirv_raw(match self {
            Shaders::Exact => EXACT,
            Shaders::Fast | Shaders::Portable => FAST,
        });
        if self.is_untouched() {
            let entry_points = ENTRY_POINTS
                .into_iter()
                .map(|name| wgpu::PassthroughShaderEntryPoint {
                    name: Cow::Borrowed(name),
                    workgroup_size: (1, 1, 1),
                })
                .collect();
            // SAFETY: the module was validated when it was built, its bindings
            // are those of the renderer's layout, and `shared` keeps its indices
            // within the buffers.
            unsafe {
                device.create_shader_module_passthrough(wgpu::ShaderModuleDescriptorPassthrough {
                    label: Some("relievo"),
                    entry_points,
                    spirv: Some(words),
                    ..Default::default()
                })
            }
        } else {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("relievo"),
                source: wgpu::ShaderSource::SpirV(words),
            })
        }
    }
}

/// The shader that draws the colours of an object with these parameters.
pub(super) fn color_entry_point(object: &Object) -> &'static str {
    match (object.search, object.self_shadow != 0) {
        (SEARCH_PAPER, false) => "color_paper",
        (SEARCH_PAPER, true) => "color_paper_shadow",
        (SEARCH_RELIEF, false) => "color_relief",
        (SEARCH_RELIEF, true) => "color_relief_shadow",
        (_, false) => "color_extrusion",
        (_, true) => "color_extrusion_shadow",
    }
}

/// The shader that draws the geometry of an object with these parameters.
pub(super) fn geometry_entry_point(object: &Object) -> &'static str {
    match object.search {
        SEARCH_PAPER => "geometry_paper",
        SEARCH_RELIEF => "geometry_relief",
        _ => "geometry_extrusion",
    }
}
