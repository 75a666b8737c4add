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
