//! Scene files of Relievo as assets, and entities of their objects.

use crate::preparation::Stores;
use crate::prepare::{Placed, prepare_scene};
use crate::{CarvedMaterial, Finish, IsPrepared, LayerMaterial};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, AssetPath, LoadContext, LoadState, ReadAssetBytesError};
use bevy::prelude::*;
use bevy::tasks::futures_lite::future::{block_on, poll_once};
use bevy::tasks::{AsyncComputeTaskPool, Task};
use relievo::Files;
use relievo::files::normal;
use relievo::scene::{Layer, Scene, SceneError, SceneObject};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// A scene file of Relievo, with the meshes and patterns that it names.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct CarvedScene(pub Arc<Scene>);

/// Spawns the objects of a scene file as children of this entity, once they are prepared.
///
/// They have the file's meshes, patterns, parameters and places; of its materials they have base
/// colour, roughness and metallic. Camera and lights are those of the program. Error budgets are
/// left out.
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility)]
pub struct CarvedSceneRoot(pub Handle<CarvedScene>);

/// A file that is no scene.
#[derive(Debug)]
pub enum SceneLoadError {
    /// It cannot be read.
    Read(std::io::Error),
    /// A file that it names cannot be read.
    File(PathBuf, ReadAssetBytesError),
    /// It is malformed.
    Scene(SceneError),
}

impl std::fmt::Display for SceneLoadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            SceneLoadError::Read(error) => error.fmt(f),
            SceneLoadError::File(path, error) => write!(f, "{}: {error}", path.display()),
            SceneLoadError::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SceneLoadError {}

/// Loads a [`CarvedScene`] from a TOML file, and the files that its objects name.
#[derive(Default, TypePath)]
pub struct SceneLoader;

impl AssetLoader for SceneLoader {
    type Asset = CarvedScene;
    type Settings = ();
    type Error = SceneLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<CarvedScene, SceneLoadError> {
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .await
            .map_err(SceneLoadError::Read)?;
        let text = String::from_utf8_lossy(&bytes);
        let path = context.path().path().to_path_buf();
        let mut scene = Scene::parse(&text, &path).map_err(SceneLoadError::Scene)?;
        // What is not drawn here need not be loaded.
        scene.lights.clear();
        scene.environment = None;
        for material in &mut scene.materials {
            material.base_color_image = None;
            material.metallic_roughness_image = None;
            material.normal_image = None;
            material.emission_image = None;
        }
        for object in &mut scene.objects {
            object.budget = None;
        }
        let named = |object: &SceneObject| object.files().map(normal).collect::<Vec<_>>();
        let names: BTreeSet<PathBuf> = scene.objects.iter().flat_map(named).collect();
        let mut files = Vec::new();
        for name in names {
            let file = AssetPath::from_path(&name).into_owned();
            let bytes = context.read_asset_bytes(file).await;
            let bytes = bytes.map_err(|error| SceneLoadError::File(name.clone(), error))?;
            files.push((name, Arc::from(bytes)));
        }
        scene.files = Files::memory(files);
        Ok(CarvedScene(Arc::new(scene)))
    }

    fn extensions(&self) -> &[&str] {
        &["toml"]
    }
}

/// Returns the finishes of an object: of the materials that it names, or else its colours.
fn finishes(scene: &Scene, object: &SceneObject) -> CarvedMaterial {
    let linear = |color: relievo::scene::Color| {
        let [red, green, blue] = color.linear();
        Some(Color::linear_rgb(red, green, blue))
    };
    let finish = |name: &Option<String>, color: relievo::scene::Color| {
        let is_named = |name: &String| {
            let mut all = scene.materials.iter();
            all.find(|material| material.name == *name)
        };
        match name.as_ref().and_then(is_named) {
            Some(material) => Finish {
                base_color: linear(material.base_color),
                roughness: Some(material.roughness as f32),
                metallic: Some(material.metallic as f32),
            },
            None => Finish {
                base_color: linear(color),
                ..Finish::default()
            },
        }
    };
    let (names, colors) = (&object.finish, object.material);
    let layer = |layer: &Layer| LayerMaterial {
        cap: finish(&layer.finish.cap, layer.material.cap),
        wall: finish(&layer.finish.wall, layer.material.wall),
        bevel: finish(&layer.finish.bevel, layer.material.bevel),
    };
    CarvedMaterial {
        base: Handle::default(),
        cap: finish(&names.cap, colors.cap),
        wall: finish(&names.wall, colors.wall),
        bevel: finish(&names.bevel, colors.bevel),
        floor: finish(&names.floor, colors.floor),
        layers: object.layers.iter().map(layer).collect(),
    }
}

/// The preparation of a scene.
#[derive(Component)]
struct PreparingScene(Task<Result<Vec<Placed>, String>>);

/// The entities of a scene's objects.
#[derive(Component, Default)]
struct Objects(Vec<Entity>);

/// Marks the scenes that are being prepared, have been, or cannot be.
#[derive(Component)]
struct Seen;

/// Prepares the scenes that are new or changed.
fn begin(
    mut commands: Commands,
    roots: Query<(Entity, Ref<CarvedSceneRoot>, Has<Seen>)>,
    mut events: MessageReader<AssetEvent<CarvedScene>>,
    scenes: Res<Assets<CarvedScene>>,
    assets: Res<AssetServer>,
) {
    let modified = |event: &AssetEvent<CarvedScene>| match event {
        AssetEvent::Modified { id } => Some(*id),
        _ => None,
    };
    let modified: Vec<_> = events.read().filter_map(modified).collect();
    for (entity, root, is_seen) in &roots {
        if is_seen && !root.is_changed() && !modified.contains(&root.0.id()) {
            continue;
        }
        let mut commands = commands.entity(entity);
        commands.remove::<(IsPrepared, PreparingScene, Seen)>();
        if let Some(scene) = scenes.get(&root.0) {
            let scene = scene.0.clone();
            let task = AsyncComputeTaskPool::get().spawn(async move { prepare_scene(&scene) });
            commands.insert((PreparingScene(task), Seen));
        } else if let Some(LoadState::Failed(error)) = assets.get_load_state(&root.0) {
            error!("the carved scene {entity}: its file cannot be loaded: {error}");
            commands.insert(Seen);
        }
    }
}

/// Spawns the objects of the scenes that have been prepared.
fn finish(
    mut commands: Commands,
    mut preparing: Query<(
        Entity,
        &CarvedSceneRoot,
        &mut PreparingScene,
        Option<&Objects>,
    )>,
    scenes: Res<Assets<CarvedScene>>,
    mut stores: Stores,
) {
    for (root, handle, mut task, before) in &mut preparing {
        let Some(result) = block_on(poll_once(&mut task.0)) else {
            continue;
        };
        commands.entity(root).remove::<PreparingScene>();
        let placed = match result {
            Ok(placed) => placed,
            Err(problem) => {
                error!("the carved scene {root}: {problem}");
                continue;
            }
        };
        let Some(scene) = scenes.get(&handle.0) else {
            continue;
        };
        for object in before.map_or(&[][..], |objects| &objects.0) {
            commands.entity(*object).despawn();
        }
        let spawn = |placed: Placed| {
            let material = finishes(&scene.0, &scene.0.objects[placed.number]);
            let shown = stores.show(placed.object, placed.repeat, &material);
            let name = Name::new(placed.name);
            let object = (name, placed.transform, material, shown, ChildOf(root));
            commands.spawn(object).id()
        };
        let objects = placed.into_iter().map(spawn).collect();
        commands.entity(root).insert((Objects(objects), IsPrepared));
    }
}

pub(crate) struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<CarvedScene>()
            .init_asset_loader::<SceneLoader>()
            .add_systems(PostUpdate, (begin, finish).chain());
    }
}
