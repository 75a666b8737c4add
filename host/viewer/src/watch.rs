//! Reports finished device work, so that the window does not have to poll: each
//! poll would redraw it, on the same device.

use std::sync::Arc;

#[cfg(not(target_arch = "wasm32"))]
pub use native::Watch;
#[cfg(target_arch = "wasm32")]
pub use web::Watch;

/// Requests a repaint; may be called from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use relievo::render::gpu::Device;
    use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
    use std::thread::JoinHandle;
    use std::time::Duration;

    /// Time between two polls, a small part of a frame.
    const PAUSE: Duration = Duration::from_millis(1);

    /// Polls a device on its own thread, which ends when this is dropped.
    pub struct Watch {
        begun: Option<Sender<()>>,
        thread: Option<JoinHandle<()>>,
    }

    impl Watch {
        /// Starts watching `device`.
        pub fn new(device: &Device) -> Watch {
            let (begun, work) = channel();
            let device = device.clone();
            let thread = std::thread::spawn(move || while ask(&device, &work) {});
            Watch {
                begun: Some(begun),
                thread: Some(thread),
            }
        }

        /// Announces work submitted to the device.
        pub fn begin(&self) {
            if let Some(begun) = &self.begun {
                // The thread has ended if the device is lost, which is reported
                // elsewhere.
                let _ = begun.send(());
            }
        }
    }

    impl Drop for Watch {
        fn drop(&mut self) {
            self.begun = None;
            if let Some(thread) = self.thread.take() {
                // The thread must not keep the device alive after the window.
                let _ = thread.join();
            }
        }
    }

    /// Waits for work and polls until it is done. Returns whether to continue.
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
    use relievo::render::gpu::Device;

    /// Does nothing: a browser reports completion by itself.
    pub struct Watch;

    impl Watch {
        /// Ignores the device.
        pub fn new(_: &Device) -> Watch {
            Watch
        }

        /// Announces work submitted to the device.
        pub fn begin(&self) {}
    }
}
