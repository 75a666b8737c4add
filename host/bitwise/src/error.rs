//! What can go wrong.

use crate::generate::DomainError;

/// The machine, the module or the list of kernels does not allow the comparison.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// There is no adapter, or none of the wanted name.
    #[error("no GPU adapter {wanted}; {found}; install a Vulkan driver, or choose another adapter")]
    NoAdapter {
        /// What was looked for.
        wanted: String,
        /// What is there.
        found: String,
    },
    /// The adapter gave no device, or the device failed.
    #[error("{adapter}: {message}; choose another adapter, or renew its driver")]
    Device {
        /// The adapter.
        adapter: String,
        /// Why.
        message: String,
    },
    /// The device has not the memory for what it was given.
    #[error("{adapter}: {message}; choose another adapter, or give it less at once")]
    Memory {
        /// The adapter.
        adapter: String,
        /// For what.
        message: String,
    },
    /// The longest time to wait for a device is no time.
    #[error(
        "the environment variable {} is {value:?}; make it a number of seconds, such as 60, or leave it out",
        crate::TIME_LIMIT
    )]
    TimeLimit {
        /// What it was set to.
        value: String,
    },
    /// Something is larger than the adapter's limits.
    #[error(
        "{adapter}: {what} needs {needed}, and its limit is {limit}; choose another adapter, or less of it"
    )]
    Limit {
        /// The adapter.
        adapter: String,
        /// What is too large.
        what: String,
        /// How much it needs.
        needed: u64,
        /// How much there may be.
        limit: u64,
    },
    /// The adapter's driver cannot be given SPIR-V as it is.
    #[error(
        "{adapter} does not take SPIR-V untouched; choose a Vulkan adapter with shader passthrough, or a portable module"
    )]
    Untouched {
        /// The adapter.
        adapter: String,
    },
    /// The bytes are not a SPIR-V module.
    #[error("no SPIR-V module: {message}; compile it again")]
    Module {
        /// What is wrong with it.
        message: String,
    },
    /// A kernel does not fit its module, or its arguments.
    #[error("kernel {kernel:?}: {message}")]
    Kernel {
        /// The kernel.
        kernel: &'static str,
        /// What does not fit, and the way out.
        message: String,
    },
    /// The domain of an argument is not one.
    #[error(transparent)]
    Domain(#[from] DomainError),
}

impl DeviceError {
    /// The fault of an adapter for which wgpu or its driver gives this reason.
    pub(crate) fn of(adapter: &str, reason: impl ToString) -> DeviceError {
        let message = reason.to_string();
        let adapter = adapter.to_string();
        // Where a device is lost for want of memory, or wgpu panics for it,
        // only the text tells.
        let plain = message.to_lowercase().replace(['_', ' '], "");
        if plain.contains("outofmemory")
            || plain.contains("outofdevicememory")
            || plain.contains("outofhostmemory")
            || plain.contains("notenoughmemory")
        {
            DeviceError::Memory { adapter, message }
        } else {
            DeviceError::Device { adapter, message }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn want_of_memory_is_told_from_other_faults() {
        let memory =
            |reason: &str| matches!(DeviceError::of("a", reason), DeviceError::Memory { .. });
        for reason in [
            wgpu::hal::DeviceError::OutOfMemory.to_string(),
            "the device was lost: Out of memory".to_string(),
            "Not enough memory left.".to_string(),
            "`Result::unwrap()` on an `Err` value: ERROR_OUT_OF_DEVICE_MEMORY".to_string(),
        ] {
            assert!(memory(&reason), "{reason}");
        }
        assert!(!memory(&wgpu::hal::DeviceError::Lost.to_string()));
    }
}
