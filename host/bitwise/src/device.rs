//! A device with its queue, and its faults as errors.

use crate::DeviceError;
use crate::attempt::attempt;
use std::mem::ManuallyDrop;
use std::sync::{Arc, OnceLock, mpsc};
use std::time::Duration;

/// An opened adapter: wgpu's device and queue, and what to call it.
///
/// A device that has once been lost, or has not answered in time, stays lost:
/// each later use is an error, and it is not waited for when it is dropped.
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
    /// Why the device is lost, once it is.
    lost: Arc<OnceLock<String>>,
}

impl Device {
    pub(crate) fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        description: String,
        time_limit: Duration,
    ) -> Device {
        // Both may come at any time and on any thread; the first reason is kept.
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

    /// wgpu's device.
    pub fn wgpu(&self) -> &wgpu::Device {
        &self.shared.device
    }

    /// Its queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.shared.queue
    }

    /// Name, API and driver of its adapter, in one line.
    pub fn describe(&self) -> &str {
        &self.shared.description
    }

    /// How long [`Device::wait`] waits at most; see [`crate::TIME_LIMIT`].
    pub fn time_limit(&self) -> Duration {
        self.shared.time_limit
    }

    /// Whether compiled shaders reach the driver untouched.
    pub fn takes_spirv(&self) -> bool {
        self.wgpu()
            .features()
            .contains(wgpu::Features::PASSTHROUGH_SHADERS)
    }

    /// Bytes that a storage buffer may have.
    pub fn largest_storage(&self) -> u64 {
        let limits = self.wgpu().limits();
        limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
    }

    /// Runs `work`, which uses the device on this thread, and gives its result
    /// unless the device was lost, complained or made wgpu panic meanwhile.
    ///
    /// # Errors
    /// Those of `work`; [`DeviceError::Memory`] where the device has too
    /// little, [`DeviceError::Device`] where it fails otherwise.
    pub fn attempt<T, E: From<DeviceError>>(
        &self,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.alive()?;
        let scopes = Scopes::new(self.wgpu());
        let result = attempt("wgpu", work);
        let complaint = scopes.finish();
        // wgpu keeps most errors of a lost device to itself, and tells its loss
        // when it is polled.
        let polled = attempt("wgpu", || {
            // A poll that does not wait has nothing else to tell.
            let _ = self.wgpu().poll(wgpu::PollType::Poll);
        });
        if let Some(error @ wgpu::Error::OutOfMemory { .. }) = complaint {
            return Err(self.failed(error).into());
        }
        self.alive()?;
        if let Err(message) = polled {
            return Err(self.lose(message).into());
        }
        match (complaint, result) {
            (Some(error), _) => Err(self.failed(error).into()),
            (None, Err(message)) => Err(self.lose(message).into()),
            (None, Ok(result)) => result,
        }
    }

    /// Waits until the device has done all that it was given.
    ///
    /// # Errors
    /// [`DeviceError::Device`] where it is lost, or not done within
    /// [`Device::time_limit`].
    pub fn wait(&self) -> Result<(), DeviceError> {
        let wait = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(self.time_limit()),
        };
        self.polled(wait).map(|_| ())
    }

    /// Has the device tell what it has done, without waiting; whether that is all
    /// that it was given.
    ///
    /// # Errors
    /// [`DeviceError::Device`] where it is lost.
    pub fn poll(&self) -> Result<bool, DeviceError> {
        self.polled(wgpu::PollType::Poll)
            .map(|status| status.is_queue_empty())
    }

    /// Polls; a device that fails at it is lost.
    fn polled(&self, poll: wgpu::PollType) -> Result<wgpu::PollStatus, DeviceError> {
        self.alive()?;
        match attempt("wgpu", || self.wgpu().poll(poll)) {
            Ok(Ok(status)) => self.alive().map(|()| status),
            Ok(Err(wgpu::PollError::Timeout)) => Err(self.lose(format!(
                "it has not finished within {} s; give it longer with the environment variable {}",
                self.time_limit().as_secs_f64(),
                crate::TIME_LIMIT
            ))),
            Ok(Err(error)) => Err(self.lose(error.to_string())),
            Err(message) => Err(self.lose(message)),
        }
    }

    /// An error where the device is lost.
    ///
    /// # Errors
    /// [`DeviceError::Device`] with the reason.
    pub fn alive(&self) -> Result<(), DeviceError> {
        match self.shared.lost.get() {
            None => Ok(()),
            Some(reason) => Err(self.failed(reason)),
        }
    }

    /// Never uses the device again, for this reason unless there was one before.
    fn lose(&self, reason: String) -> DeviceError {
        self.failed(self.shared.lost.get_or_init(|| reason))
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
        self.attempt(|| {
            let slice = buffer.slice(..bytes);
            let (sender, receiver) = mpsc::channel();
            slice.map_async(wgpu::MapMode::Read, move |result| {
                // The receiver waits below; if it is gone, so is the need.
                let _ = sender.send(result);
            });
            self.wait()?;
            receiver
                // Whoever polls beside us may have taken it to be told.
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

    /// An error of this device.
    pub fn failed(&self, reason: impl ToString) -> DeviceError {
        DeviceError::of(self.describe(), reason)
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // wgpu waits for the queue when it is dropped, without end where the
        // device hangs, and panics where that fails: what is lost is left.
        if self.lost.get().is_none() {
            let _ = attempt("wgpu", || {
                // SAFETY: neither is used again: this is their owner's end.
                unsafe {
                    ManuallyDrop::drop(&mut self.queue);
                    ManuallyDrop::drop(&mut self.device);
                }
            });
        }
    }
}

/// Collects what a device complains of on this thread while it lives.
#[cfg_attr(
    target_arch = "wasm32",
    expect(dead_code, reason = "they end when they are dropped")
)]
struct Scopes {
    // Dropped in this order, which must be the reverse of that of their making.
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

    /// The gravest of the first complaints of each kind.
    #[cfg(not(target_arch = "wasm32"))]
    fn finish(self) -> Option<wgpu::Error> {
        let memory = pollster::block_on(self.memory.pop());
        let internal = pollster::block_on(self.internal.pop());
        let validation = pollster::block_on(self.validation.pop());
        memory.or(internal).or(validation)
    }

    /// A browser answers later, and nobody can wait for it: complaints that
    /// are not collected make the device a lost one.
    #[cfg(target_arch = "wasm32")]
    fn finish(self) -> Option<wgpu::Error> {
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::{DeviceError, adapters};

    #[test]
    fn gpu_complaints_and_panics_become_errors() {
        let all = adapters();
        assert!(!all.is_empty(), "no adapter on this machine");
        for adapter in all {
            let device = adapter.open().expect("a device");
            // A buffer that is mapped for both directions is against the rules.
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
            // Nobody knows what it left half done.
            let again = device.attempt(|| Ok::<_, DeviceError>(())).unwrap_err();
            assert_eq!(again.to_string(), message);
        }
    }

    #[test]
    fn gpu_a_complaint_that_nobody_collects_is_no_panic() {
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
