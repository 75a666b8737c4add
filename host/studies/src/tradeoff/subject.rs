//! A scene to vary.

use super::variant::{SelfShadow, Settings};
use relievo::Error;
use relievo::scene::{Scene, SceneObject, Search, Shape};
use relievo::shape_map::ShapeMap;
use sha2::{Digest, Sha256};
use std::path::Path;

/// A scene whose variants are measured.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Scene, with the size to measure.
    pub scene: Scene,
    /// Whether each object's shape is a baked map, which is used as it is.
    pub is_baked: Vec<bool>,
    /// SHA-256 of the scene's text and of every file it names, hexadecimal.
    pub digest: String,
}

impl Subject {
    /// Examines `scene`.
    ///
    /// # Errors
    /// [`Error`] if a mesh or a shape cannot be read.
    pub fn new(scene: Scene) -> Result<Subject, Error> {
        let is_baked = scene
            .objects
            .iter()
            .map(|object| {
                Ok(match &object.shape {
                    Shape::File(path) => ShapeMap::is_shape_map_of(&scene.files, path)?,
                    _ => false,
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

    /// Returns whether every object has a baked map.
    pub fn is_all_baked(&self) -> bool {
        self.is_baked.iter().all(|is_baked| *is_baked)
    }

    /// Returns the scene's own setting of shadows.
    pub fn self_shadow(&self) -> SelfShadow {
        let objects = &self.scene.objects;
        let count = objects.iter().filter(|object| object.self_shadow).count();
        match count {
            0 => SelfShadow::Off,
            count if count == objects.len() => SelfShadow::On,
            _ => SelfShadow::AsInScene,
        }
    }

    /// Returns the scene with these settings.
    pub fn with(&self, settings: &Settings) -> Scene {
        let mut scene = self.scene.clone();
        scene.supersampling = settings.supersampling;
        for (object, is_baked) in scene.objects.iter_mut().zip(&self.is_baked) {
            object.budget = None;
            object.tier = settings.model.tier;
            if let Some(tolerance) = settings.model.tolerance {
                object.tolerance = tolerance;
            }
            object.steps = settings.steps.linear;
            object.bisections = settings.steps.bisections;
            object.slack = settings.slack;
            if let (Some(map), false) = (settings.map, is_baked) {
                object.map = map;
            }
            match settings.self_shadow {
                SelfShadow::On => object.self_shadow = true,
                SelfShadow::Off => object.self_shadow = false,
                SelfShadow::AsInScene => {}
            }
        }
        scene
    }

    /// Returns what the sweep leaves out and why, a sentence each.
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

/// Hashes the text of `scene` and each file it names, once.
fn digest(scene: &Scene) -> Result<String, Error> {
    let mut state = Sha256::new();
    // Lengths delimit the parts.
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
