//! Prepares carved entities in the background, whenever they change.

use crate::material::{Carving, CarvingMaterial, CarvingUniform, opaque};
use crate::prepare::{Prepared, mesh_data, prepare};
use crate::{Carved, CarvedMaterial, Pattern};
use bevy::asset::{AssetEventSystems, LoadState};
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashSet;
use bevy::prelude::*;
use bevy::render::storage::ShaderBuffer;
use bevy::shader::Shader;
use bevy::tasks::futures_lite::future::{block_on, poll_once};
use bevy::tasks::{AsyncComputeTaskPool, Task};

/// Marks carved entities whose picture is that of their [`Carved`]: it is removed when they
/// change, and comes back when they have been prepared.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct IsPrepared;

/// Marks entities that have to be prepared.
#[derive(Component)]
struct Waits;

/// The preparation of an entity.
#[derive(Component)]
struct Preparing(Task<Result<Prepared, String>>);

/// Marks the entities whose component, mesh or pattern changed.
fn notice(
    mut commands: Commands,
    changed: Query<Entity, Changed<Carved>>,
    all: Query<(Entity, &Carved)>,
    mut meshes: MessageReader<AssetEvent<Mesh>>,
    mut patterns: MessageReader<AssetEvent<Pattern>>,
) {
    let mut wait = |entity| {
        commands
            .entity(entity)
            .insert(Waits)
            .remove::<(IsPrepared, Preparing)>();
    };
    changed.iter().for_each(&mut wait);
    let meshes: HashSet<_> = meshes.read().filter_map(modified).collect();
    let patterns: HashSet<_> = patterns.read().filter_map(modified).collect();
    if !meshes.is_empty() || !patterns.is_empty() {
        let uses = |(_, carved): &(_, &Carved)| {
            meshes.contains(&carved.mesh.id()) || patterns.contains(&carved.pattern.id())
        };
        all.iter().filter(uses).for_each(|(entity, _)| wait(entity));
    }
}

/// Returns the asset of an event that says that it changed.
fn modified<A: Asset>(event: &AssetEvent<A>) -> Option<AssetId<A>> {
    match event {
        AssetEvent::Modified { id } => Some(*id),
        _ => None,
    }
}

/// Begins to prepare the entities whose mesh and pattern are there.
fn begin(
    mut commands: Commands,
    waiting: Query<(Entity, &Carved, Option<&Name>), With<Waits>>,
    meshes: Res<Assets<Mesh>>,
    patterns: Res<Assets<Pattern>>,
    assets: Res<AssetServer>,
) {
    for (entity, carved, name) in &waiting {
        let lacking = [
            (
                "mesh",
                carved.mesh.id().untyped(),
                meshes.contains(&carved.mesh),
            ),
            (
                "pattern",
                carved.pattern.id().untyped(),
                patterns.contains(&carved.pattern),
            ),
        ];
        if let Some((what, id, _)) = lacking.into_iter().find(|(_, _, is_there)| !is_there) {
            let is_unset = id == Handle::<Mesh>::default().id().untyped()
                || id == Handle::<Pattern>::default().id().untyped();
            let reason = match assets.get_load_state(id) {
                _ if is_unset => "is not set; give its Carved one".to_string(),
                Some(LoadState::Failed(error)) => format!("cannot be loaded: {error}"),
                // It may still come.
                _ => continue,
            };
            error!("{}: its {what} {reason}", describe(entity, name));
            commands.entity(entity).remove::<Waits>();
            continue;
        }
        let (Some(mesh), Some(pattern)) = (meshes.get(&carved.mesh), patterns.get(&carved.pattern))
        else {
            continue;
        };
        commands.entity(entity).remove::<Waits>();
        let mesh = match mesh_data(mesh) {
            Ok(mesh) => mesh,
            Err(problem) => {
                error!("{}: {problem}", describe(entity, name));
                continue;
            }
        };
        let (carved, pattern) = (carved.clone(), pattern.0.clone());
        let task =
            AsyncComputeTaskPool::get().spawn(async move { prepare(&carved, mesh, pattern) });
        commands.entity(entity).insert(Preparing(task));
    }
}

/// Returns the entity for a message.
fn describe(entity: Entity, name: Option<&Name>) -> String {
    match name {
        Some(name) => format!("the carved entity {:?} ({entity})", name.as_str()),
        None => format!("the carved entity {entity}"),
    }
}

/// Where what is drawn is kept.
#[derive(SystemParam)]
pub(crate) struct Stores<'w> {
    shaders: ResMut<'w, Assets<Shader>>,
    buffers: ResMut<'w, Assets<ShaderBuffer>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<CarvingMaterial>>,
    bases: Res<'w, Assets<StandardMaterial>>,
}

impl Stores<'_> {
    /// Returns the components that show an object.
    pub(crate) fn show(
        &mut self,
        prepared: Prepared,
        repeat: Vec2,
        material: &CarvedMaterial,
    ) -> impl Bundle + use<> {
        let Prepared {
            key,
            shader,
            buffers,
            hull,
            origin,
        } = prepared;
        // The shader of a key is always the same.
        if !self.shaders.contains(&key.handle()) {
            let inserted = self.shaders.insert(&key.handle(), shader);
            debug_assert!(inserted.is_ok(), "the handle has no generation");
        }
        let mut uniform = CarvingUniform {
            ball: origin.extend(hull.radius),
            repeat,
            ..CarvingUniform::default()
        };
        uniform.set(material);
        let [object, facets, map] = buffers.map(|contents| self.buffers.add(contents));
        let material = CarvingMaterial {
            base: opaque(&material.base, &self.bases),
            extension: Carving {
                key,
                uniform,
                object,
                facets,
                map,
            },
        };
        (
            Mesh3d(self.meshes.add(hull.mesh)),
            MeshMaterial3d(self.materials.add(material)),
            hull.bounds,
            NoAutoAabb,
            IsPrepared,
        )
    }
}

/// Shows the entities that have been prepared.
fn finish(
    mut commands: Commands,
    mut preparing: Query<(
        Entity,
        &mut Preparing,
        &Carved,
        &CarvedMaterial,
        Option<&Name>,
    )>,
    mut stores: Stores,
) {
    for (entity, mut task, carved, material, name) in &mut preparing {
        let Some(result) = block_on(poll_once(&mut task.0)) else {
            continue;
        };
        let mut commands = commands.entity(entity);
        commands.remove::<Preparing>();
        match result {
            Ok(prepared) => {
                commands.insert(stores.show(prepared, carved.repeat, material));
            }
            Err(problem) => error!("{}: {problem}", describe(entity, name)),
        }
    }
}

/// Gives the entities whose materials changed the new ones.
fn repaint(
    mut events: MessageReader<AssetEvent<StandardMaterial>>,
    carved: Query<(Ref<CarvedMaterial>, &MeshMaterial3d<CarvingMaterial>)>,
    bases: Res<Assets<StandardMaterial>>,
    mut materials: ResMut<Assets<CarvingMaterial>>,
) {
    let changed = |event: &AssetEvent<StandardMaterial>| match event {
        AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
        _ => None,
    };
    let changed: HashSet<_> = events.read().filter_map(changed).collect();
    for (material, handle) in &carved {
        if !material.is_changed() && !changed.contains(&material.base.id()) {
            continue;
        }
        if let Some(mut drawn) = materials.get_mut(handle) {
            drawn.base = opaque(&material.base, &bases);
            drawn.extension.uniform.set(&material);
        }
    }
}

pub(crate) struct PreparationPlugin;

impl Plugin for PreparationPlugin {
    fn build(&self, app: &mut App) {
        let systems = (notice, begin, finish, repaint).chain();
        app.add_systems(PostUpdate, systems.before(AssetEventSystems));
    }
}
