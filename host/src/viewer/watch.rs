//! Lets a device tell what it has done, so that the window need not ask: each
//! time that it asks it draws itself, on the same device.

use crate::render::gpu::Device;
use std::sync::Arc;

/// Has the window look again; may be called from any thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Asks a device for what it has done, on a thread of its own. A browser does
/// without being asked.
pub struct Watch {
    #[cfg(not(target_arch = "wasm32"))]
    begun: std::sync::mpsc::Sender<()>,
}

impl Watch {
    /// Over `device`, until this is dropped.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(device: &Device) -> Watch {
        /// A small part of a frame.
        const PAUSE: std::time::Duration = std::time::Duration::from_millis(1);
        let (begun, work) = std::sync::mpsc::channel();
        let device = device.clone();
        std::thread::spawn(move || {
            while work.recv().is_ok() {
                // Polling calls back; a device that is lost has nothing left to do.
                while let Ok(status) = device.wgpu().poll(wgpu::PollType::Poll) {
                    let has_more = work.try_iter().count() > 0;
                    if status.is_queue_empty() && !has_more {
                        break;
                    }
                    std::thread::sleep(PAUSE);
                }
            }
        });
        Watch { begun }
    }

    /// Over `device`, until this is dropped.
    #[cfg(target_arch = "wasm32")]
    pub fn new(_: &Device) -> Watch {
        Watch {}
    }

    /// The device was given work that somebody waits for.
    pub fn begin(&self) {
        // The other end lives as long as this.
        #[cfg(not(target_arch = "wasm32"))]
        let _ = self.begun.send(());
    }
}
