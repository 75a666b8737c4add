//! Finding an adapter: which there are, which one to take, and a device of it.

use super::super::RenderError;

/// An adapter, and what a person wants to know of it.
pub struct Found {
    adapter: wgpu::Adapter,
}

impl Found {
    /// Name, API and driver, in one line.
    pub fn describe(&self) -> String {
        let info = self.adapter.get_info();
        let driver = [info.driver.as_str(), info.driver_info.as_str()]
            .into_iter()
            .filter(|text| !text.is_empty())
            .collect::<Vec<_>>()
            .join(" ");
        format!("{} ({}, {driver})", info.name, info.backend)
    }

    /// The adapter's name.
    pub fn name(&self) -> String {
        self.adapter.get_info().name
    }

    /// Whether this is a program on the CPU that stands in for a GPU.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Whether compiled shaders reach the driver untouched.
    pub fn takes_spirv(&self) -> bool {
        self.adapter.get_info().backend == wgpu::Backend::Vulkan
            && self
                .adapter
                .features()
                .contains(wgpu::Features::PASSTHROUGH_SHADERS)
    }

    /// Whether the device's own clock can time a render pass.
    pub fn has_timestamps(&self) -> bool {
        self.adapter
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Opens a device with the adapter's own limits.
    pub(super) fn open(&self) -> Result<(wgpu::Device, wgpu::Queue), RenderError> {
        let mut features = wgpu::Features::empty();
        if self.takes_spirv() {
            features |= wgpu::Features::PASSTHROUGH_SHADERS;
        }
        if self.has_timestamps() {
            features |= wgpu::Features::TIMESTAMP_QUERY;
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("relievo"),
            required_features: features,
            required_limits: self.adapter.limits(),
            // SAFETY: passthrough is used for the committed modules only, which
            // the builder has validated.
            experimental_features: unsafe { wgpu::ExperimentalFeatures::enabled() },
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            trace: wgpu::Trace::Off,
        };
        pollster::block_on(self.adapter.request_device(&descriptor)).map_err(|error| {
            RenderError::Device {
                adapter: self.describe(),
                message: error.to_string(),
            }
        })
    }
}

/// Every adapter of this machine, real GPUs first.
pub fn adapters() -> Vec<Found> {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut found: Vec<Found> =
        pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
            .into_iter()
            .map(|adapter| Found { adapter })
            .collect();
    found.sort_by_key(|found| match found.adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    found
}

/// The first adapter, or the first whose name or driver holds `wanted`
/// (without regard to case).
///
/// # Errors
/// [`RenderError::NoAdapter`] with what there is instead.
pub fn choose(wanted: Option<&str>) -> Result<Found, RenderError> {
    let mut all = adapters();
    let position = match wanted {
        None => (!all.is_empty()).then_some(0),
        Some(wanted) => {
            let wanted = wanted.to_lowercase();
            all.iter()
                .position(|found| found.describe().to_lowercase().contains(&wanted))
        }
    };
    match position {
        Some(position) => Ok(all.swap_remove(position)),
        None => Err(RenderError::NoAdapter {
            wanted: wanted.map_or_else(
                || "was found".to_string(),
                |name| format!("has {name:?} in its name"),
            ),
            found: if all.is_empty() {
                "this machine has none".to_string()
            } else {
                let names: Vec<String> = all.iter().map(Found::describe).collect();
                format!("there are: {}", names.join("; "))
            },
        }),
    }
}
