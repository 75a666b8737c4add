//! Errors of renderers.

/// Failure of the machine or of its limits while rendering.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// There is no GPU adapter, or none of that name.
    #[error("no GPU adapter {wanted}; {found}; use --backend cpu, or install a Vulkan driver")]
    NoAdapter {
        /// The name looked for.
        wanted: String,
        /// The adapters found.
        found: String,
    },
    /// The adapter provided no device, or the device failed or was lost.
    #[error("{adapter}: {message}; use --backend cpu or another --adapter")]
    Device {
        /// The adapter.
        adapter: String,
        /// Why.
        message: String,
    },
    /// The device has too little memory for the scene or its picture.
    #[error(
        "{adapter}: {message}; use --backend cpu, a smaller picture (--size), or less in the scene"
    )]
    DeviceMemory {
        /// The adapter.
        adapter: String,
        /// What the memory was needed for.
        message: String,
    },
    /// The time limit for waiting for a device is malformed.
    #[error(
        "the environment variable {variable} is {value:?}; make it a number of seconds, such as 60, or leave it out"
    )]
    TimeLimit {
        /// The environment variable.
        variable: &'static str,
        /// What it was set to.
        value: String,
    },
    /// No window can be opened.
    #[error("no window can be opened: {message}; use `relievo render` for pictures without one")]
    Window {
        /// Why.
        message: String,
    },
    /// The memory does not suffice for the picture.
    #[error(
        "not enough memory for {what} ({bytes} bytes); make the picture smaller (--size, or supersample = false)"
    )]
    Memory {
        /// What does not fit.
        what: String,
        /// Its size, bytes.
        bytes: usize,
    },
    /// The scene exceeds a limit of the adapter.
    #[error(
        "{adapter}: {what} needs {needed}, and its limit is {limit}; use --backend cpu, or less of it"
    )]
    Limit {
        /// The adapter.
        adapter: String,
        /// What is too large.
        what: String,
        /// Required amount.
        needed: u64,
        /// Allowed amount.
        limit: u64,
    },
}

/// Allocates `count` copies of `value` for `what`.
///
/// # Errors
/// [`RenderError::Memory`] if the memory does not suffice.
pub(crate) fn allocate<T: Clone>(
    what: &str,
    count: usize,
    value: T,
) -> Result<Vec<T>, RenderError> {
    let mut buffer = Vec::new();
    buffer
        .try_reserve_exact(count)
        .map_err(|_| RenderError::Memory {
            what: what.to_string(),
            bytes: count.saturating_mul(size_of::<T>()),
        })?;
    buffer.resize(count, value);
    Ok(buffer)
}
