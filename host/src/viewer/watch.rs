//! Lets a device tell what it has done, so that the window need not ask: each
//! time that it asks it draws itself, on the same device.

use std::sync::Arc;

#[cfg(not(target_arch = "wasm32"))]
pub use native::Watch;
#[cfg(target_arch = "wasm32")]
pub use web::Watch;

/// Has the window look again; may be called from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use crate::render::gpu::Device;
    use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
    use std::thread::JoinHandle;
    use std::time::Duration;

    /// Between two looks at the device: a small part of a frame.
    const PAUSE: Duration = Duration::from_millis(1);

    /// Asks a device for what it has done, on a thread of its own, which ends
    /// with this.
    pub struct Watch {
        begun: Option<Sender<()>>,
        thread: Option<JoinHandle<()>>,
    }

    impl Watch {
        /// Over `device`.
        pub fn new(device: &Device) -> Watch {
            let (begun, work) = channel();
            let device = device.clone();
            let thread = std::thread::spawn(move || while ask(&device, &work) {});
            Watch {
                begun: Some(begun),
                thread: Some(thread),
            }
        }

        /// The device was given work that somebody waits for.
        pub fn begin(&self) {
            if let Some(begun) = &self.begun {
                // Nobody asks a device that is lost, which tells of that itself.
                let _ = begun.send(());
            }
        }
    }

    impl Drop for Watch {
        fn drop(&mut self) {
            self.begun = None;
            if let Some(thread) = self.thread.take() {
                // The device must not outlive the window there.
                let _ = thread.join();
            }
        }
    }

    /// Waits for work and asks until it is done; whether there may be more.
    fn ask(device: &Device, work: &Receiver<()>) -> bool {
        if work.recv().is_err() {
            return false;
        }
        loop {
            let Ok(is_done) = device.poll() else {
                return false;
            };
            match work.try_recv() {
                Err(TryRecvError::Disconnected) => return false,
                Err(TryRecvError::Empty) if is_done => return true,
                _ => std::thread::sleep(PAUSE),
            }
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod web {
    use crate::render::gpu::Device;

    /// Nothing: a browser tells without being asked.
    pub struct Watch;

    impl Watch {
        /// Over no matter which device.
        pub fn new(_: &Device) -> Watch {
            Watch
        }

        /// The device was given work that somebody waits for.
        pub fn begin(&self) {}
    }
}
