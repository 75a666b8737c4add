//! Operations that differ between desktop and browser.

use super::dropped::Arrived;
use super::probe::Probe;
use super::watch::Wake;
use relievo::export::ExportedFile;
use relievo::scene::Scene;
use std::path::Path;

/// A worker without shared memory, which runs [`Station`](super::away::Station). It ends when this is
/// dropped.
pub trait Worker {
    /// Sends an order.
    fn send(&mut self, order: Vec<u8>);

    /// Returns what has come from the worker since, one by one.
    fn news(&mut self) -> Option<News>;
}

/// What comes from a [`Worker`].
pub enum News {
    /// It has started.
    Ready,
    /// It has executed an order.
    Reply(Vec<u8>),
    /// It has ended, and why.
    Stopped(String),
}

/// Starts a worker that calls [`Wake`] when there are news.
///
/// # Errors
/// Why there is none.
pub type StartWorker = Box<dyn Fn(Wake) -> Result<Box<dyn Worker>, String>>;

/// Host of the viewer.
pub trait Platform {
    /// Saves a file and returns where it is.
    ///
    /// # Errors
    /// A message for the user.
    fn save_file(&mut self, name: &str, bytes: &[u8]) -> Result<String, String>;

    /// Saves files in a folder of this name, all or none, and returns where it
    /// is.
    ///
    /// # Errors
    /// A message for the user.
    fn save_folder(&mut self, name: &str, files: &[ExportedFile]) -> Result<String, String>;

    /// Lets the user choose a file, which `arrived` receives later. Returns `false` if
    /// the viewer should list the files of the disk.
    fn choose(&mut self, arrived: &Arrived) -> bool;

    /// Returns how workers are started, where scenes are not prepared on a thread.
    fn workers(&self) -> Option<StartWorker> {
        None
    }

    /// Returns whether there are addresses that show a scene.
    fn has_links(&self) -> bool {
        false
    }

    /// Returns the address that shows `scene`.
    ///
    /// # Errors
    /// A message for the user.
    fn link(&mut self, scene: &Scene) -> Result<String, String> {
        let _ = scene;
        Err("this window has no address".to_string())
    }

    /// Returns the folder of saved scenes; their paths are relative to it.
    fn folder(&self) -> &Path;

    /// Returns whether [`Platform::tell`] should be called.
    fn listens(&self) -> bool;

    /// Receives the state of the window after every change.
    fn tell(&mut self, probe: &Probe);
}
