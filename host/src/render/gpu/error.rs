//! Errors of devices as errors of renderers.

use crate::render::RenderError;
use relievo_bitwise::{DeviceError, TIME_LIMIT};

impl From<DeviceError> for RenderError {
    fn from(error: DeviceError) -> RenderError {
        match error {
            DeviceError::NoAdapter { wanted, found } => RenderError::NoAdapter { wanted, found },
            DeviceError::Device { adapter, message } => RenderError::Device { adapter, message },
            DeviceError::Memory { adapter, message } => {
                RenderError::DeviceMemory { adapter, message }
            }
            DeviceError::TimeLimit { value } => RenderError::TimeLimit {
                variable: TIME_LIMIT,
                value,
            },
            DeviceError::Limit {
                adapter,
                what,
                needed,
                limit,
            } => RenderError::Limit {
                adapter,
                what,
                needed,
                limit,
            },
            DeviceError::Untouched { adapter } => RenderError::Device {
                adapter,
                message: "takes no SPIR-V untouched".to_string(),
            },
            error @ (DeviceError::Module { .. }
            | DeviceError::Kernel { .. }
            | DeviceError::Picture { .. }
            | DeviceError::Domain(_)) => RenderError::Device {
                adapter: "the shaders built in".to_string(),
                message: error.to_string(),
            },
        }
    }
}
