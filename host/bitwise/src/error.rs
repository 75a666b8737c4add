//! Errors of adapters, devices, modules and lists of kernels.

use crate::generate::DomainError;

/// Environment variable with the longest time to wait for a device, in seconds > 0.
///
/// The default is 60 for a GPU, longer than operating systems let one GPU job run,
/// and 3600 for a software driver, which may need long for a large picture.
pub const TIME_LIMIT: &str = "RELIEVO_GPU_TIMEOUT";

/// A fault of an adapter, a device, a module or a list of kernels.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// There is no adapter, or none with the wanted name.
    #[error("no GPU adapter {wanted}; {found}; install a Vulkan driver, or choose another adapter")]
    NoAdapter {
        /// End of the sentence "no GPU adapter …".
        wanted: String,
        /// The adapters of this machine.
        found: String,
    },
    /// The adapter did not open, or the device failed.
    #[error("{adapter}: {message}; choose another adapter, or update its driver")]
    Device {
        /// The adapter.
        adapter: String,
        /// The reason.
        message: String,
    },
    /// The device is out of memory.
    #[error("{adapter}: {message}; choose another adapter, or give it less at once")]
    Memory {
        /// The adapter.
        adapter: String,
        /// The reason.
        message: String,
    },
    /// [`TIME_LIMIT`] is set to something else than a number of seconds.
    #[error(
        "the environment variable {TIME_LIMIT} is {value:?}; make it a number of seconds, such as 60, or leave it out"
    )]
    TimeLimit {
        /// The value of the variable.
        value: String,
    },
    /// A resource exceeds the adapter's limits.
    #[error(
        "{adapter}: {what} needs {needed}, and its limit is {limit}; choose another adapter, or less of it"
    )]
    Limit {
        /// The adapter.
        adapter: String,
        /// The resource, with its unit.
        what: String,
        /// The required amount.
        needed: u64,
        /// The adapter's limit.
        limit: u64,
    },
    /// The adapter's driver does not take SPIR-V unchanged.
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
        /// The reason.
        message: String,
    },
    /// A picture does not match its shaders.
    #[error("the picture of {fragment:?}: {message}")]
    Picture {
        /// Its fragment shader.
        fragment: String,
        /// The mismatch and how to correct it.
        message: String,
    },
    /// A kernel does not match its module or its arguments.
    #[error("kernel {kernel:?}: {message}")]
    Kernel {
        /// The kernel.
        kernel: &'static str,
        /// The mismatch and how to correct it.
        message: String,
    },
    /// The domain of an argument is invalid.
    #[error(transparent)]
    Domain(#[from] DomainError),
}

impl DeviceError {
    /// Returns the error for a reason given by wgpu or its driver.
    pub(crate) fn of(adapter: &str, reason: impl ToString) -> DeviceError {
        let message = reason.to_string();
        let adapter = adapter.to_string();
        // If lack of memory loses the device or makes wgpu panic, only the text
        // says so.
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
    fn lack_of_memory_is_distinguished_from_other_faults() {
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
