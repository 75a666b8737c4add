//! Finding an adapter: which there are, which one to take, and a device of it.

use crate::attempt::attempt;
use crate::{Device, DeviceError};
use std::time::Duration;

/// The environment variable with the seconds that a device is waited for.
///
/// Without it a GPU has 60: longer than any operating system lets a GPU work on
/// one thing, so that only one that hangs is given up. A software driver, which
/// may really need long for a large picture, has an hour.
pub const TIME_LIMIT: &str = "RELIEVO_GPU_TIMEOUT";

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
        !(self.adapter.features() & untouched(&self.adapter)).is_empty()
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
    /// [`DeviceError::Device`] with the driver's reason,
    /// [`DeviceError::TimeLimit`] where [`TIME_LIMIT`] is no time.
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

/// What a device is asked for by one who opens it for [`Device::shared`], and
/// by [`Adapter::open`]: the adapter's own limits, untouched shaders and a clock
/// where it has them.
pub fn descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let wanted = wgpu::Features::TIMESTAMP_QUERY | untouched(adapter);
    wgpu::DeviceDescriptor {
        label: Some("bitwise"),
        required_features: adapter.features() & wanted,
        required_limits: adapter.limits(),
        // SAFETY: of the experimental features only passthrough is asked
        // for, and what goes through it is `Module::untouched`'s contract.
        experimental_features: unsafe { wgpu::ExperimentalFeatures::enabled() },
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        trace: wgpu::Trace::Off,
    }
}

/// The feature by which compiled shaders reach the driver untouched, where that
/// means anything.
fn untouched(adapter: &wgpu::Adapter) -> wgpu::Features {
    if adapter.get_info().backend == wgpu::Backend::Vulkan {
        wgpu::Features::PASSTHROUGH_SHADERS
    } else {
        wgpu::Features::empty()
    }
}

impl Device {
    /// A device that somebody else has opened, by [`descriptor`], and uses too.
    ///
    /// # Errors
    /// [`DeviceError::TimeLimit`] where [`TIME_LIMIT`] is no time.
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

/// Every adapter of this machine, real GPUs first; none where a driver fails
/// at being asked.
pub fn adapters() -> Vec<Adapter> {
    look().unwrap_or_default()
}

/// As [`adapters`], or the driver's fault.
fn look() -> Result<Vec<Adapter>, String> {
    let mut found: Vec<Adapter> = attempt("wgpu", || {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        let instance = wgpu::Instance::new(descriptor);
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

/// The first adapter, or the first whose name or driver holds `wanted`
/// (without regard to case).
///
/// # Errors
/// [`DeviceError::NoAdapter`] with what there is instead.
pub fn choose(wanted: Option<&str>) -> Result<Adapter, DeviceError> {
    let (mut all, fault) = match look() {
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
                format!("a driver failed at being asked: {fault}")
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
