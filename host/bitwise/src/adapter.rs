//! Lists adapters, chooses one and opens a device.
//!
//! ```
//! use relievo_bitwise::adapters;
//!
//! for adapter in adapters() {
//!     println!("{}, SPIR-V passthrough: {}", adapter.describe(), adapter.takes_spirv());
//! }
//! ```

use crate::attempt::attempt;
use crate::error::TIME_LIMIT;
use crate::{Device, DeviceError};
use std::sync::OnceLock;
use std::time::Duration;

/// Returns the longest time to wait for a device (see [`TIME_LIMIT`]).
fn time_limit(is_software: bool) -> Result<Duration, DeviceError> {
    let Some(value) = std::env::var_os(TIME_LIMIT) else {
        return Ok(Duration::from_secs(if is_software { 3600 } else { 60 }));
    };
    let value = value.to_string_lossy();
    let seconds = value.trim().parse().ok().filter(|&seconds| seconds > 0.0);
    seconds
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| DeviceError::TimeLimit {
            value: value.to_string(),
        })
}

/// An adapter of this machine.
pub struct Adapter {
    adapter: wgpu::Adapter,
}

impl Adapter {
    /// Returns name, API and driver in one line.
    pub fn describe(&self) -> String {
        let info = self.adapter.get_info();
        let driver = [info.driver.as_str(), info.driver_info.as_str()]
            .into_iter()
            .filter(|text| !text.is_empty())
            .collect::<Vec<_>>()
            .join(" ");
        format!("{} ({}, {driver})", info.name, info.backend)
    }

    /// Returns the adapter's name.
    pub fn name(&self) -> String {
        self.adapter.get_info().name
    }

    /// Returns wgpu's description: name, backend, driver and its version, type of
    /// device, vendor and device ids.
    pub fn info(&self) -> wgpu::AdapterInfo {
        self.adapter.get_info()
    }

    /// Returns whether this is a software driver, which runs on the CPU.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Returns whether the driver takes SPIR-V unchanged (Vulkan with shader
    /// passthrough).
    pub fn takes_spirv(&self) -> bool {
        !(self.adapter.features() & untouched(&self.adapter)).is_empty()
    }

    /// Opens a device with the adapter's own limits.
    ///
    /// # Errors
    /// [`DeviceError::Device`] with the driver's reason,
    /// [`DeviceError::TimeLimit`] if [`TIME_LIMIT`] is malformed.
    pub fn open(&self) -> Result<Device, DeviceError> {
        let descriptor = descriptor(&self.adapter);
        let time_limit = time_limit(self.is_software())?;
        let refused = |message| DeviceError::of(&self.describe(), message);
        let (device, queue) = attempt("wgpu", || {
            pollster::block_on(self.adapter.request_device(&descriptor))
        })
        .map_err(refused)?
        .map_err(|error| refused(error.to_string()))?;
        Ok(Device::new(device, queue, self.describe(), time_limit))
    }
}

/// Returns the descriptor with which [`Adapter::open`] requests a device, and with
/// which a device for [`Device::shared`] must be requested: the adapter's limits,
/// and shader passthrough and timestamp queries where available.
pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let wanted = wgpu::Features::TIMESTAMP_QUERY | untouched(adapter);
    wgpu::DeviceDescriptor {
        label: Some("bitwise"),
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        // SAFETY: passthrough is the only experimental feature requested, and
        // `Module::untouched` states what its modules must satisfy.
        experimental_features: unsafe { wgpu::ExperimentalFeatures::enabled() },
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        trace: wgpu::Trace::Off,
    }
}

/// Returns the feature for SPIR-V passthrough, on backends that have it.
fn untouched(adapter: &wgpu::Adapter) -> wgpu::Features {
    if adapter.get_info().backend == wgpu::Backend::Vulkan {
        wgpu::Features::PASSTHROUGH_SHADERS
    } else {
        wgpu::Features::empty()
    }
}

impl Device {
    /// Wraps a device that the caller has requested by [`descriptor`] and may use
    /// as well.
    ///
    /// # Errors
    /// [`DeviceError::TimeLimit`] if [`TIME_LIMIT`] is malformed.
    pub fn shared(
        adapter: &wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
    ) -> Result<Device, DeviceError> {
        let adapter = Adapter {
            adapter: adapter.clone(),
        };
        let time_limit = time_limit(adapter.is_software())?;
        Ok(Device::new(device, queue, adapter.describe(), time_limit))
    }
}

/// Returns every adapter of this machine, hardware GPUs first. The list is empty
/// if a driver fails during enumeration.
pub fn adapters() -> Vec<Adapter> {
    enumerate().unwrap_or_default()
}

/// Enumerates the adapters, or returns the reason why a driver failed.
fn enumerate() -> Result<Vec<Adapter>, String> {
    let mut found: Vec<Adapter> = attempt("wgpu", || {
        // One for the process: drivers and layers are loaded once, and never unloaded
        // while another thread calls them.
        static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
        let instance = INSTANCE.get_or_init(|| {
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
        });
        pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
    })?
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
    Ok(found)
}

/// Returns the first adapter, or the first whose description
/// ([`Adapter::describe`]) contains `wanted`, ignoring case.
///
/// # Errors
/// [`DeviceError::NoAdapter`] with the adapters of this machine.
pub fn choose(wanted: Option<&str>) -> Result<Adapter, DeviceError> {
    let (mut all, fault) = match enumerate() {
        Ok(all) => (all, None),
        Err(fault) => (Vec::new(), Some(fault)),
    };
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
            found: if let Some(fault) = fault {
                format!("a driver failed during enumeration: {fault}")
            } else if all.is_empty() {
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
    fn an_unknown_name_is_answered_with_the_known_ones() {
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
