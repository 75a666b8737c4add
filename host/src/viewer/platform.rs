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

    /// Is told of every change.
    fn tell(&mut self, probe: &Probe);

    /// What stands in the way of faster or better pictures here, if anything.
    fn notice(&self) -> Option<String> {
        None
    }
}
