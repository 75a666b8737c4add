//! What the desktop and the browser do differently.

use super::probe::Probe;
use crate::export::ExportedFile;
use std::path::Path;

/// Where the viewer runs.
pub trait Platform {
    /// Keeps a file, and says where it is.
    ///
    /// # Errors
    /// What stands against it, for a person.
    fn save_file(&mut self, name: &str, bytes: &[u8]) -> Result<String, String>;

    /// Keeps files in a folder of this name, all or none, and says where it is.
    ///
    /// # Errors
    /// What stands against it, for a person.
    fn save_folder(&mut self, name: &str, files: &[ExportedFile]) -> Result<String, String>;

    /// The folder that saved scenes lie in; their paths are relative to it.
    fn folder(&self) -> &Path;

    /// Whether somebody wants to be told of changes.
    fn listens(&self) -> bool;

    /// Is told of every change, if it listens.
    fn tell(&mut self, probe: &Probe);
}
