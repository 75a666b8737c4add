//! Finding an adapter: which there are, which one to take, and a device of it.

use crate::{Device, DeviceError};

/// An adapter, and what a person wants to know of it.
pub struct Adapter {
    adapter: wgpu::Adapter,
}

impl Adapter {
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

    /// What a report names one by one: `name`, `backend`, `driver`,
    /// `driver_info` (its version), `device_type`, and the numbers of `vendor`
    /// and `device`.
    pub fn info(&self) -> wgpu::AdapterInfo {
        self.adapter.get_info()
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

    /// Whether the device's own clock can time a pass.
    pub fn has_timestamps(&self) -> bool {
        self.adapter
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Opens a device with the adapter's own limits.
    ///
    /// # Errors
    /// [`DeviceError::Device`] with the driver's reason.
    pub fn open(&self) -> Result<Device, DeviceError> {
        let mut features = wgpu::Features::empty();
        if self.takes_spirv() {
            features |= wgpu::Features::PASSTHROUGH_SHADERS;
        }
        if self.has_timestamps() {
            features |= wgpu::Features::TIMESTAMP_QUERY;
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("bitwise"),
            required_features: features,
            required_limits: self.adapter.limits(),
            // SAFETY: of the experimental features only passthrough is asked
            // for, and what goes through it is `Module::untouched`'s contract.
            experimental_features: unsafe { wgpu::ExperimentalFeatures::enabled() },
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            trace: wgpu::Trace::Off,
        };
        let (device, queue) = pollster::block_on(self.adapter.request_device(&descriptor))
            .map_err(|error| DeviceError::Device {
                adapter: self.describe(),
                message: error.to_string(),
            })?;
        Ok(Device::new(device, queue, self.describe()))
    }
}

/// Every adapter of this machine, real GPUs first.
pub fn adapters() -> Vec<Adapter> {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let instance = wgpu::Instance::new(descriptor);
    let mut found: Vec<Adapter> =
        pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
            .into_iter()
            .map(|adapter| Adapter { adapter })
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
/// [`DeviceError::NoAdapter`] with what there is instead.
pub fn choose(wanted: Option<&str>) -> Result<Adapter, DeviceError> {
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
        None => Err(DeviceError::NoAdapter {
            wanted: wanted.map_or_else(
                || "was found".to_string(),
                |name| format!("has {name:?} in its name"),
            ),
            found: if all.is_empty() {
                "this machine has none".to_string()
            } else {
                let names: Vec<String> = all.iter().map(Adapter::describe).collect();
                format!("there are: {}", names.join("; "))
            },
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_is_answered_with_what_there_is() {
        let Err(error) = choose(Some("no such adapter")) else {
            panic!("an adapter has that name");
        };
        let message = error.to_string();
        assert!(
            message.contains("has \"no such adapter\" in its name"),
            "{message}"
        );
        assert!(matches!(error, DeviceError::NoAdapter { .. }));
    }

    #[test]
    fn gpu_every_adapter_is_found_by_its_own_description() {
        let all = adapters();
        assert!(!all.is_empty(), "no adapter on this machine");
        for adapter in all {
            let wanted = adapter.describe().to_uppercase();
            let found = choose(Some(&wanted)).expect("it is there");
            assert_eq!(found.describe(), adapter.describe());
            assert_eq!(found.info().name, adapter.name());
        }
    }
}
