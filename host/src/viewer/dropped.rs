//! Files that a person drops.

use super::Viewer;
use crate::Files;
use crate::scene::{Scene, Shape};
use eframe::egui;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Makes a file the mesh (`.obj`, `.gltf`, `.glb`) or else the pattern of an
/// object of `scene`. `bytes` are those of a file that is on no disk; it is
/// known as `dropped-number/name` then.
///
/// Says whether it is a mesh: of another size, and to be seen from elsewhere.
pub fn adopt(scene: &mut Scene, object: usize, path: &Path, bytes: Vec<u8>, number: u64) -> bool {
    let Some(object) = scene.objects.get_mut(object) else {
        return false;
    };
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let is_mesh = ["obj", "gltf", "glb"].contains(&ending.to_lowercase().as_str());
    let mut name = path.to_path_buf();
    match &mut scene.files {
        Files::Memory(files) => {
            // A name of its own: what has been read is known by its name.
            let folder = PathBuf::from(format!("dropped-{number}"));
            name = folder.join(path.file_name().unwrap_or_default());
            Arc::make_mut(files).insert(name.clone(), bytes.into());
        }
        // Who drops a file allows it to be read.
        files => *files = Files::Disk,
    }
    if is_mesh {
        object.mesh = name;
        object.depth = None;
        scene.camera = None;
    } else {
        (object.shape, object.raster) = (Shape::File(name), None);
    }
    is_mesh
}

/// Files that were dropped on the window and have been read.
#[derive(Clone, Default)]
pub(super) struct Arrived(Arc<Mutex<Vec<File>>>);

/// A name, and bytes where the file is on no disk.
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
    /// Reads what was dropped on the window; it arrives in [`Viewer::use_dropped`].
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

    /// Makes dropped files the mesh or the pattern of the selected object.
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
