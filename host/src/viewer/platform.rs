//! What the desktop and the browser do differently.

use super::probe::Probe;
use std::path::Path;

/// Where the viewer runs.
pub trait Platform {
    /// Keeps files under their names, all or none, and says where they are.
    ///
    /// # Errors
    /// What stands against it, for a person.
    fn save(&mut self, files: &[(String, Vec<u8>)]) -> Result<String, String>;

    /// The folder that saved scenes lie in; their paths are relative to it.
    fn folder(&self) -> &Path;

    /// Whether the files that a scene names are saved with it: there is no disk
    /// from which they could be read again.
    fn keeps_files(&self) -> bool;

    /// Whether somebody wants to be told of changes.
    fn listens(&self) -> bool;

    /// Is told of every change, if it listens.
    fn tell(&mut self, probe: &Probe);
}
