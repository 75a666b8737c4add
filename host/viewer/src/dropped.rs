//! Files dropped on the window, or opened.

use super::patterns::has_ending;
use super::watch::Wake;
use super::{Viewer, saving};
use eframe::egui;
use relievo::Files;
use relievo::scene::{Scene, Shape};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Endings of meshes.
pub const MESHES: [&str; 3] = ["obj", "gltf", "glb"];
/// Endings of scenes.
pub const SCENES: [&str; 1] = ["toml"];

/// Sets a file as the mesh (`.obj`, `.gltf`, `.glb`) or the pattern (any other
/// ending) of an object of `scene`. `bytes` are the contents of a file that is
/// not on disk; its path becomes `dropped-DIGEST/name`.
///
/// Returns whether it is a mesh, in which case the camera should be reset.
pub fn adopt(scene: &mut Scene, object: usize, path: &Path, bytes: Vec<u8>) -> bool {
    let Some(object) = scene.objects.get_mut(object) else {
        return false;
    };
    let is_mesh = has_ending(path, &MESHES);
    let mut name = path.to_path_buf();
    match &mut scene.files {
        Files::Memory(files) => {
            // A name for these bytes alone, because loaded files are cached by name.
            let mut hasher = DefaultHasher::new();
            bytes.hash(&mut hasher);
            let folder = PathBuf::from(format!("dropped-{:016x}", hasher.finish()));
            name = folder.join(path.file_name().unwrap_or_default());
            Arc::make_mut(files).insert(name.clone(), bytes.into());
        }
        // Dropping a file grants permission to read it.
        files => *files = Files::Disk,
    }
    if is_mesh {
        object.mesh = name.into();
        object.depth = None;
        object.raised = false;
        scene.camera = None;
    } else {
        (object.shape, object.raster) = (Shape::File(name), None);
    }
    is_mesh
}

/// Files that have been read.
#[derive(Clone)]
pub struct Arrived {
    files: Arc<Mutex<Vec<File>>>,
    wake: Wake,
}

/// Path, and bytes if the file is not on disk.
type File = (PathBuf, Result<Vec<u8>, String>);

impl Arrived {
    pub(super) fn new(wake: Wake) -> Arrived {
        Arrived {
            files: Arc::default(),
            wake,
        }
    }

    /// Adds a file: its path, and its bytes, which are empty if it is on disk, or why
    /// it cannot be read.
    pub fn add(&self, path: PathBuf, bytes: Result<Vec<u8>, String>) {
        self.list().push((path, bytes));
        (self.wake)();
    }

    fn list(&self) -> std::sync::MutexGuard<'_, Vec<File>> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Viewer {
    /// Starts reading dropped files; [`Viewer::use_dropped`] receives them.
    pub(super) fn read_dropped(&self, context: &egui::Context) {
        let files = context.input_mut(|input| std::mem::take(&mut input.raw.dropped_files));
        for file in files {
            let arrived = self.dropped.clone();
            #[cfg(not(target_arch = "wasm32"))]
            arrived.add(file.path().to_path_buf(), Ok(Vec::new()));
            #[cfg(target_arch = "wasm32")]
            wasm_bindgen_futures::spawn_local(async move {
                let bytes = file.bytes_async().await;
                arrived.add(file.path().to_path_buf(), bytes);
            });
        }
    }

    /// Opens scenes that have arrived, and sets other files as mesh or pattern of the
    /// selected object.
    pub(super) fn use_dropped(&mut self) {
        let files = std::mem::take(&mut *self.dropped.list());
        for (path, bytes) in files {
            match bytes {
                Ok(bytes) if has_ending(&path, &SCENES) => match self.read_scene(&path, bytes) {
                    Ok(scene) => {
                        self.name = saving::name(&scene.path);
                        self.camera = scene.own_camera();
                        self.selected = 0;
                        self.replace(scene);
                    }
                    Err(problem) => self.complain(problem),
                },
                Ok(bytes) => {
                    if adopt(&mut self.scene, self.selected, &path, bytes) {
                        self.camera = None;
                    }
                    self.order(false);
                }
                Err(problem) => self.complain(format!("cannot read {}: {problem}", path.display())),
            }
        }
    }

    /// Reads a scene within the limits of the present one.
    fn read_scene(&self, path: &Path, bytes: Vec<u8>) -> Result<Scene, String> {
        let limits = &self.scene.limits;
        let read = match &self.scene.files {
            Files::Memory(_) => {
                let text = String::from_utf8(bytes);
                let text = text.map_err(|_| format!("{}: it is not UTF-8 text", path.display()))?;
                Scene::parse_with(&text, path, limits, self.scene.files.clone())
            }
            Files::Disk | Files::Below(_) => Scene::load_within(path, limits),
        };
        read.map_err(|error| error.to_string())
    }
}
