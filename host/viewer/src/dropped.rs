//! Files dropped on the window.

use super::Viewer;
use eframe::egui;
use relievo::Files;
use relievo::scene::{Scene, Shape};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Sets a file as the mesh (`.obj`, `.gltf`, `.glb`) or the pattern (any other
/// ending) of an object of `scene`. `bytes` are the contents of a file that is
/// not on disk; its path becomes `dropped-number/name`.
///
/// Returns whether it is a mesh, in which case the camera should be reset.
pub fn adopt(scene: &mut Scene, object: usize, path: &Path, bytes: Vec<u8>, number: u64) -> bool {
    let Some(object) = scene.objects.get_mut(object) else {
        return false;
    };
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let is_mesh = ["obj", "gltf", "glb"].contains(&ending.to_lowercase().as_str());
    let mut name = path.to_path_buf();
    match &mut scene.files {
        Files::Memory(files) => {
            // A unique name, because loaded files are cached by name.
            let folder = PathBuf::from(format!("dropped-{number}"));
            name = folder.join(path.file_name().unwrap_or_default());
            Arc::make_mut(files).insert(name.clone(), bytes.into());
        }
        // Dropping a file grants permission to read it.
        files => *files = Files::Disk,
    }
    if is_mesh {
        object.mesh = name.into();
        object.depth = None;
        scene.camera = None;
    } else {
        (object.shape, object.raster) = (Shape::File(name), None);
    }
    is_mesh
}

/// Dropped files that have been read.
#[derive(Clone, Default)]
pub(super) struct Arrived(Arc<Mutex<Vec<File>>>);

/// Path, and bytes if the file is not on disk.
type File = (PathBuf, Result<Vec<u8>, String>);

impl Arrived {
    fn add(&self, file: File) {
        self.list().push(file);
    }

    fn list(&self) -> std::sync::MutexGuard<'_, Vec<File>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Viewer {
    /// Starts reading dropped files; [`Viewer::use_dropped`] receives them.
    pub(super) fn read_dropped(&self, context: &egui::Context) {
        let files = context.input_mut(|input| std::mem::take(&mut input.raw.dropped_files));
        for file in files {
            let arrived = self.dropped.clone();
            #[cfg(not(target_arch = "wasm32"))]
            arrived.add((file.path().to_path_buf(), Ok(Vec::new())));
            #[cfg(target_arch = "wasm32")]
            {
                let context = context.clone();
                wasm_bindgen_futures::spawn_local(async move {
                    let bytes = file.bytes_async().await;
                    arrived.add((file.path().to_path_buf(), bytes));
                    context.request_repaint();
                });
            }
        }
    }

    /// Sets dropped files as mesh or pattern of the selected object.
    pub(super) fn use_dropped(&mut self) {
        let files = std::mem::take(&mut *self.dropped.list());
        for (path, bytes) in files {
            match bytes {
                Ok(bytes) => {
                    let number = self.ordered + 1;
                    if adopt(&mut self.scene, self.selected, &path, bytes, number) {
                        self.camera = None;
                    }
                    self.order(false);
                }
                Err(problem) => self.complain(format!("cannot read {}: {problem}", path.display())),
            }
        }
    }
}
