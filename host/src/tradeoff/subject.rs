//! A scene, and what of it can be varied.

use super::variant::SelfShadow;
use crate::Error;
use crate::scene::{Scene, SceneObject, Search, Shape};
use crate::shape_map::ShapeMap;
use sha2::{Digest, Sha256};
use std::path::Path;

/// A scene whose variants are measured.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The scene, of the size that is measured.
    pub scene: Scene,
    /// Whether each object's shape is a baked map, which is taken as it is.
    pub is_baked: Vec<bool>,
    /// SHA-256 of the scene's text and of every file that it names, hexadecimal.
    pub digest: String,
}

impl Subject {
    /// Of `scene`.
    ///
    /// # Errors
    /// [`Error`] where a mesh or a shape cannot be read.
    pub fn new(scene: Scene) -> Result<Subject, Error> {
        let is_baked = scene
            .objects
            .iter()
            .map(|object| {
                Ok(match &object.shape {
                    Shape::File(path) => ShapeMap::is_shape_map_of(&scene.files, path)?,
                    Shape::Text(_) => false,
                })
            })
            .collect::<Result<Vec<bool>, Error>>()?;
        let digest = digest(&scene)?;
        Ok(Subject {
            scene,
            is_baked,
            digest,
        })
    }

    /// Whether no object has a pattern that could be stored otherwise.
    pub fn is_all_baked(&self) -> bool {
        self.is_baked.iter().all(|is_baked| *is_baked)
    }

    /// The scene's own shadows.
    pub fn self_shadow(&self) -> SelfShadow {
        let objects = &self.scene.objects;
        let count = objects.iter().filter(|object| object.self_shadow).count();
        match count {
            0 => SelfShadow::Off,
            count if count == objects.len() => SelfShadow::On,
            _ => SelfShadow::AsInScene,
        }
    }

    /// What is left out for this scene, and why; a sentence each.
    pub fn left_out(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let objects = &self.scene.objects;
        let named = |is_named: &dyn Fn(usize) -> bool| {
            let names = objects.iter().enumerate();
            let names: Vec<String> = names
                .filter(|(index, _)| is_named(*index))
                .map(|(_, object)| format!("{:?}", object.name))
                .collect();
            (!names.is_empty()).then(|| names.join(", "))
        };
        if let Some(names) = named(&|index| objects[index].search == Search::Relief) {
            notes.push(format!(
                "The tiers paper and accurate, which have searches of their own: technique = \"relief\" of {names} is one as well."
            ));
        }
        if let Some(names) = named(&|index| self.is_baked[index]) {
            notes.push(format!(
                "Storage and size of the maps of {names}, which are baked and taken as they are."
            ));
        }
        if let Some(names) = named(&|index| objects[index].budget.is_some()) {
            notes.push(format!(
                "The plan for the error budget of {names}: the sweep sets what a plan would choose."
            ));
        }
        notes
    }
}

/// Of the text of `scene` and of each file that it names, once.
fn digest(scene: &Scene) -> Result<String, Error> {
    let mut state = Sha256::new();
    // Lengths keep neighbours apart.
    let mut add = |bytes: &[u8]| {
        state.update((bytes.len() as u64).to_le_bytes());
        state.update(bytes);
    };
    add(scene.text.as_bytes());
    let mut known: Vec<&Path> = Vec::new();
    let files = scene.objects.iter();
    for path in files.flat_map(SceneObject::files) {
        if known.contains(&path) {
            continue;
        }
        known.push(path);
        let bytes = scene
            .files
            .read(path, scene.limits.memory)
            .map_err(|source| Error::Measurements {
                path: path.to_path_buf(),
                problem: format!("cannot be read: {source}; check the path and its permissions"),
            })?;
        add(&bytes);
    }
    let bytes = state.finalize();
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
