//! A device with its queue, whose faults are returned as errors.

use crate::DeviceError;
use crate::attempt::attempt;
use crate::error::TIME_LIMIT;
use std::mem::ManuallyDrop;
use std::sync::{Arc, OnceLock, mpsc};
use std::time::Duration;

/// An opened adapter: wgpu's device and queue, with a description.
///
/// A device that was lost or has timed out stays lost: every later use is an error,
/// and dropping it does not wait for it.
#[derive(Clone, Debug)]
pub struct Device {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    device: ManuallyDrop<wgpu::Device>,
    queue: ManuallyDrop<wgpu::Queue>,
    description: String,
    time_limit: Duration,
    /// The reason, once the device is lost.
    lost: Arc<OnceLock<String>>,
}

impl Device {
    pub(crate) fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        description: String,
        time_limit: Duration,
    ) -> Device {
        // Both callbacks may run at any time on any thread; the first reason is kept.
        let lost = Arc::new(OnceLock::new());
        let callback = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            let message = match reason {
                wgpu::DeviceLostReason::Destroyed => "it was destroyed",
                wgpu::DeviceLostReason::Unknown if message.is_empty() => "no reason is known",
                wgpu::DeviceLostReason::Unknown => message.trim(),
            };
            let _ = callback.set(format!("the device was lost: {message}"));
        });
        let uncaptured = lost.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let _ = uncaptured.set(error.to_string());
        }));
        let shared = Shared {
            device: ManuallyDrop::new(device),
            queue: ManuallyDrop::new(queue),
            description,
            time_limit,
            lost,
        };
        Device {
            shared: Arc::new(shared),
        }
    }

    /// Returns wgpu's device.
    pub fn wgpu(&self) -> &wgpu::Device {
        &self.shared.device
    }

    /// Returns the device's queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.shared.queue
    }

    /// Returns name, API and driver of the adapter in one line.
    pub fn describe(&self) -> &str {
        &self.shared.description
    }

    /// Returns the longest time that [`Device::wait`] waits ([`TIME_LIMIT`]).
    pub fn time_limit(&self) -> Duration {
        self.shared.time_limit
    }

    /// Returns whether the device takes SPIR-V unchanged.
    pub fn takes_spirv(&self) -> bool {
        self.wgpu()
            .features()
            .contains(wgpu::Features::PASSTHROUGH_SHADERS)
    }

    /// Returns the largest size of a storage buffer, bytes.
    pub fn largest_storage(&self) -> u64 {
        let limits = self.wgpu().limits();
        limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
    }

    /// Runs `work`, which uses the device on this thread, and returns its result
    /// unless the device was lost, reported an error or made wgpu panic.
    ///
    /// # Errors
    /// Those of `work`, [`DeviceError::Memory`] if the device is out of memory,
    /// [`DeviceError::Device`] if it fails otherwise.
    pub fn attempt<T, E: From<DeviceError>>(
        &self,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.alive()?;
        let scopes = Scopes::new(self.wgpu());
        let result = attempt("wgpu", work);
        let reported = scopes.finish();
        // wgpu hides most errors of a lost device and reports the loss when polled.
        let polled = attempt("wgpu", || {
            // The status of a poll that does not wait is of no use here.
            let _ = self.wgpu().poll(wgpu::PollType::Poll);
        });
        if let Some(error @ wgpu::Error::OutOfMemory { .. }) = reported {
            return Err(self.failed(error).into());
        }
        self.alive()?;
        if let Err(message) = polled {
            return Err(self.lose(message).into());
        }
        match (reported, result) {
            (Some(error), _) => Err(self.failed(error).into()),
            (None, Err(message)) => Err(self.lose(message).into()),
            (None, Ok(result)) => result,
        }
    }

    /// Waits until the device has finished all submitted work.
    ///
    /// # Errors
    /// [`DeviceError::Device`] if it is lost or takes longer than
    /// [`Device::time_limit`].
    pub fn wait(&self) -> Result<(), DeviceError> {
        let wait = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(self.time_limit()),
        };
        self.polled(wait).map(|_| ())
    }

    /// Polls the device without waiting; returns whether it has finished all
    /// submitted work.
    ///
    /// # Errors
    /// [`DeviceError::Device`] if it is lost.
    pub fn poll(&self) -> Result<bool, DeviceError> {
        self.polled(wgpu::PollType::Poll)
            .map(|status| status.is_queue_empty())
    }

    /// Polls the device; a failure loses it.
    fn polled(&self, poll: wgpu::PollType) -> Result<wgpu::PollStatus, DeviceError> {
        self.alive()?;
        match attempt("wgpu", || self.wgpu().poll(poll)) {
            Ok(Ok(status)) => self.alive().map(|()| status),
            Ok(Err(wgpu::PollError::Timeout)) => Err(self.lose(format!(
                "it has not finished within {} s; give it longer with the environment variable {}",
                self.time_limit().as_secs_f64(),
                TIME_LIMIT
            ))),
            Ok(Err(error)) => Err(self.lose(error.to_string())),
            Err(message) => Err(self.lose(message)),
        }
    }

    /// Checks that the device is not lost.
    ///
    /// # Errors
    /// [`DeviceError::Device`] with the reason of the loss.
    pub fn alive(&self) -> Result<(), DeviceError> {
        match self.shared.lost.get() {
            None => Ok(()),
            Some(reason) => Err(self.failed(reason)),
        }
    }

    /// Marks the device as lost; the first reason is kept.
    fn lose(&self, reason: String) -> DeviceError {
        self.failed(self.shared.lost.get_or_init(|| reason))
    }

    /// Waits for the device, then calls `look` with the first `bytes` bytes of a
    /// buffer that has the usage `MAP_READ`.
    ///
    /// # Errors
    /// [`DeviceError::Device`] if the buffer cannot be mapped.
    pub fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        look: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, DeviceError> {
        self.attempt(|| {
            let slice = buffer.slice(..bytes);
            let (sender, receiver) = mpsc::channel();
            slice.map_async(wgpu::MapMode::Read, move |result| {
                // Fails only if the receiver below has given up.
                let _ = sender.send(result);
            });
            self.wait()?;
            receiver
                // Another thread that polls may be running the callback.
                .recv_timeout(self.time_limit())
                .map_err(|error| self.failed(error))?
                .map_err(|error| self.failed(error))?;
            let seen = {
                let bytes = slice
                    .get_mapped_range()
                    .map_err(|error| self.failed(error))?;
                look(&bytes)
            };
            buffer.unmap();
            Ok(seen)
        })
    }

    /// Makes an error of this device.
    pub fn failed(&self, reason: impl ToString) -> DeviceError {
        DeviceError::of(self.describe(), reason)
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // Dropping waits for the queue, for ever if the device hangs, and may
        // panic: a lost device is leaked.
        if self.lost.get().is_none() {
            let _ = attempt("wgpu", || {
                // SAFETY: neither is used again, since their owner is dropped.
                unsafe {
                    ManuallyDrop::drop(&mut self.queue);
                    ManuallyDrop::drop(&mut self.device);
                }
            });
        }
    }
}

/// Collects the errors that a device reports on this thread.
#[cfg_attr(
    target_arch = "wasm32",
    expect(dead_code, reason = "they end when they are dropped")
)]
struct Scopes {
    // Fields are dropped in this order, which must be the reverse of creation.
    memory: wgpu::ErrorScopeGuard,
    internal: wgpu::ErrorScopeGuard,
    validation: wgpu::ErrorScopeGuard,
}

impl Scopes {
    fn new(device: &wgpu::Device) -> Scopes {
        let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
        Scopes {
            memory: device.push_error_scope(wgpu::ErrorFilter::OutOfMemory),
            internal,
            validation,
        }
    }

    /// Returns the first error of the gravest kind.
    #[cfg(not(target_arch = "wasm32"))]
    fn finish(self) -> Option<wgpu::Error> {
        let memory = pollster::block_on(self.memory.pop());
        let internal = pollster::block_on(self.internal.pop());
        let validation = pollster::block_on(self.validation.pop());
        memory.or(internal).or(validation)
    }

    /// Collects nothing: a browser answers later and cannot be waited for. Errors
    /// that are not collected lose the device.
    #[cfg(target_arch = "wasm32")]
    fn finish(self) -> Option<wgpu::Error> {
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::{DeviceError, adapters};

    #[test]
    fn gpu_device_errors_and_panics_are_returned() {
        let all = adapters();
        assert!(!all.is_empty(), "no adapter on this machine");
        for adapter in all {
            let device = adapter.open().expect("a device");
            // Mapping a buffer in both directions is not allowed.
            let wrong = || {
                let _ = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: 4,
                    usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE,
                    mapped_at_creation: false,
                });
                Ok::<_, DeviceError>(())
            };
            let message = device.attempt(wrong).unwrap_err().to_string();
            assert!(message.contains(&adapter.name()), "{message}");
            let nested = device.attempt(|| {
                assert!(device.attempt(wrong).is_err());
                Ok::<_, DeviceError>(7)
            });
            assert_eq!(nested.expect("the inner one has taken it"), 7);

            let panics = || -> Result<(), DeviceError> { panic!("as wgpu does") };
            let message = device.attempt(panics).unwrap_err().to_string();
            assert!(message.contains("as wgpu does"), "{message}");
            // The device stays lost.
            let again = device.attempt(|| Ok::<_, DeviceError>(())).unwrap_err();
            assert_eq!(again.to_string(), message);
        }
    }

    #[test]
    fn gpu_an_uncollected_error_does_not_panic() {
        for adapter in adapters() {
            let device = adapter.open().expect("a device");
            let _ = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE,
                mapped_at_creation: false,
            });
            assert!(matches!(device.wait(), Err(DeviceError::Device { .. })));
        }
    }
}
