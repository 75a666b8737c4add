//! A device with its queue, and its complaints as errors.

use crate::DeviceError;
use std::sync::mpsc;

/// An opened adapter: wgpu's device and queue, and what to call it.
#[derive(Clone, Debug)]
pub struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
    description: String,
}

impl Device {
    pub(crate) fn new(device: wgpu::Device, queue: wgpu::Queue, description: String) -> Device {
        Device {
            device,
            queue,
            description,
        }
    }

    /// wgpu's device.
    pub fn wgpu(&self) -> &wgpu::Device {
        &self.device
    }

    /// Its queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Name, API and driver of its adapter, in one line.
    pub fn describe(&self) -> &str {
        &self.description
    }

    /// Whether compiled shaders reach the driver untouched.
    pub fn takes_spirv(&self) -> bool {
        self.device
            .features()
            .contains(wgpu::Features::PASSTHROUGH_SHADERS)
    }

    /// Bytes that a storage buffer may have.
    pub fn largest_storage(&self) -> u64 {
        let limits = self.device.limits();
        limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
    }

    /// Collects what the device complains of on this thread from now on.
    pub fn guard(&self) -> Guard<'_> {
        let scope = |filter| self.device.push_error_scope(filter);
        let validation = scope(wgpu::ErrorFilter::Validation);
        let internal = scope(wgpu::ErrorFilter::Internal);
        Guard {
            memory: scope(wgpu::ErrorFilter::OutOfMemory),
            internal,
            validation,
            device: self,
        }
    }

    /// Waits until the device has done all that it was given.
    ///
    /// # Errors
    /// [`DeviceError::Device`] where it never will.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map(|_| ())
            .map_err(|error| self.failed(error))
    }

    /// Waits, and shows the first `bytes` bytes of a buffer that the device has
    /// written, and that has `MAP_READ`, to `look`.
    ///
    /// # Errors
    /// [`DeviceError::Device`] where the buffer cannot be mapped.
    pub fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        look: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, DeviceError> {
        let guard = self.guard();
        let slice = buffer.slice(..bytes);
        let (sender, receiver) = mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver waits below; if it is gone, so is the need.
            let _ = sender.send(result);
        });
        self.wait()?;
        receiver
            .recv()
            .map_err(|error| self.failed(error))?
            .map_err(|error| self.failed(error))?;
        let seen = {
            let bytes = slice
                .get_mapped_range()
                .map_err(|error| self.failed(error))?;
            look(&bytes)
        };
        buffer.unmap();
        guard.finish()?;
        Ok(seen)
    }

    /// An error of this device.
    pub fn failed(&self, reason: impl ToString) -> DeviceError {
        DeviceError::Device {
            adapter: self.description.clone(),
            message: reason.to_string(),
        }
    }
}

/// Collects what a device complains of while it lives; see [`Device::guard`].
#[must_use = "errors are lost unless `finish` is called"]
pub struct Guard<'a> {
    // Dropped in this order, which must be the reverse of that of their making.
    memory: wgpu::ErrorScopeGuard,
    internal: wgpu::ErrorScopeGuard,
    validation: wgpu::ErrorScopeGuard,
    device: &'a Device,
}

impl Guard<'_> {
    /// Ends the collection.
    ///
    /// # Errors
    /// [`DeviceError::Device`] with the first complaint.
    pub fn finish(self) -> Result<(), DeviceError> {
        let memory = pollster::block_on(self.memory.pop());
        let internal = pollster::block_on(self.internal.pop());
        let validation = pollster::block_on(self.validation.pop());
        match memory.or(internal).or(validation) {
            None => Ok(()),
            Some(error) => Err(self.device.failed(error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::adapters;

    #[test]
    fn gpu_complaints_become_errors_and_a_dropped_guard_does_no_harm() {
        let all = adapters();
        assert!(!all.is_empty(), "no adapter on this machine");
        for adapter in all {
            let device = adapter.open().expect("a device");
            drop(device.guard());
            let guard = device.guard();
            // A buffer that is mapped for both directions is against the rules.
            let _ = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE,
                mapped_at_creation: false,
            });
            let message = guard.finish().unwrap_err().to_string();
            assert!(message.contains(&adapter.name()), "{message}");
            device.guard().finish().expect("nothing more");
        }
    }
}
