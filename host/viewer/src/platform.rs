//! Operations that differ between desktop and browser.

use super::dropped::Arrived;
use super::probe::Probe;
use relievo::export::ExportedFile;
use relievo::scene::Scene;
use std::path::Path;

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
