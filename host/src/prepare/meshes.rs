//! The meshes of a scene: each is loaded once.

use super::step::Step;
use crate::Error;
use crate::limits::Account;
use crate::mesh::{Bounds, Mesh, MeshOptions, MeshPrism, MeshSource, MeshTriangle};
use crate::scene::{Scene, SceneObject, Tier};
use glam::{DQuat, DVec3, EulerRot};
use relievo_shared::layout::{PrismData, Triangle};
use std::sync::Arc;

/// Meshes by the source and the options that they were made with.
pub(super) type MeshCache = Vec<(MeshSource, MeshOptions, Arc<Mesh>)>;

/// The mesh of an object.
#[derive(Clone)]
pub(super) struct LoadedMesh {
    /// `None` where the object is not seen.
    pub mesh: Option<Arc<Mesh>>,
    /// The box around the mesh, world units.
    pub bounds: Bounds,
}

/// Returns the meshes of the objects of `scene` that are seen.
pub(super) fn cached(scene: &Scene, meshes: &[LoadedMesh]) -> MeshCache {
    let smooth_tangents = reads_tangents(scene);
    let objects = scene.objects.iter().zip(meshes);
    objects
        .filter_map(|(object, loaded)| {
            let mesh = loaded.mesh.clone()?;
            Some((
                object.mesh.clone(),
                mesh_options(object, smooth_tangents),
                mesh,
            ))
        })
        .collect()
}

/// Loads the mesh of each object; objects that share a mesh load it once.
pub(super) fn load_meshes(
    scene: &Scene,
    is_seen: &dyn Fn(&Bounds) -> bool,
    before: MeshCache,
    account: &mut Account<'_>,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<Vec<LoadedMesh>, Error> {
    let smooth_tangents = reads_tangents(scene);
    let mut triangles_left = scene.limits.triangles;
    let mut loaded: Vec<(MeshSource, MeshOptions, LoadedMesh)> = Vec::new();
    let mut meshes = Vec::with_capacity(scene.objects.len());
    for object in &scene.objects {
        let options = mesh_options(object, smooth_tangents);
        let known = loaded
            .iter()
            .find(|(path, known, _)| *path == object.mesh && *known == options);
        let mesh = match known {
            Some((_, _, mesh)) => mesh.clone(),
            None => {
                let kept = before
                    .iter()
                    .find(|(path, known, _)| *path == object.mesh && serves(known, &options))
                    .filter(|(_, _, mesh)| is_seen(&mesh.bounds));
                let made = match kept {
                    Some((_, _, mesh)) => Ok(mesh.clone()),
                    None => {
                        progress(Step::Mesh(object.mesh.to_string().into()));
                        let within = MeshOptions {
                            triangle_limit: triangles_left
                                .min(account.left(TRIANGLE_MADE) as usize),
                            byte_limit: account.left(TEXT_BYTE),
                            ..options.clone()
                        };
                        Mesh::load_if(&scene.files, &object.mesh, &within, is_seen)?.map(Arc::new)
                    }
                };
                let mesh = match made {
                    Ok(mesh) => {
                        let count = mesh.triangles.len() as u64;
                        let bytes = size_of::<MeshTriangle>() as u64;
                        account.take(&object.mesh, count, bytes)?;
                        LoadedMesh {
                            bounds: mesh.bounds,
                            mesh: Some(mesh),
                        }
                    }
                    Err(bounds) => LoadedMesh { mesh: None, bounds },
                };
                loaded.push((object.mesh.clone(), options, mesh.clone()));
                mesh
            }
        };
        if let Some(mesh) = &mesh.mesh {
            let count = mesh.triangles.len();
            triangles_left = triangles_left.checked_sub(count).ok_or_else(|| Error::Object {
                scene: scene.path.clone(),
                name: object.name.clone(),
                problem: format!(
                    "its {count} triangles are beyond the limit of {} for all objects together; simplify the mesh, or raise the limit (--max-triangles)",
                    scene.limits.triangles
                ),
            })?;
            account.take(
                format_args!("object {:?}", object.name),
                count as u64,
                drawn_bytes(object),
            )?;
        }
        meshes.push(mesh);
    }
    Ok(meshes)
}

/// Returns whether a mesh that was loaded with `options` is as good as one with `wanted`.
fn serves(options: &MeshOptions, wanted: &MeshOptions) -> bool {
    let smooth_tangents = options.smooth_tangents || wanted.smooth_tangents;
    *options
        == MeshOptions {
            smooth_tangents,
            ..wanted.clone()
        }
}

/// Returns whether a tier that an object of `scene` has, or may get by a plan, reads
/// tangents.
fn reads_tangents(scene: &Scene) -> bool {
    let mut objects = scene.objects.iter();
    objects.any(|object| {
        object.budget.is_some() || !matches!(object.tier, Tier::Planar | Tier::Accurate)
    })
}

/// Options to load the mesh of `object` with. `smooth_tangents` is the same for all objects
/// of a scene, so that they share meshes.
fn mesh_options(object: &SceneObject, smooth_tangents: bool) -> MeshOptions {
    MeshOptions {
        smooth_tangents,
        projection: object.projection,
        scale: object.scale,
        rotation: rotation(object.rotate),
        translation: DVec3::from(object.translate),
        crease_angle: object.crease_angle,
        raise: object.depth.filter(|_| object.raised).unwrap_or(0.0),
        ..MeshOptions::default()
    }
}

/// Estimated bytes of memory per byte of a mesh file while it is read: its text,
/// the statements kept, and their numbers.
const TEXT_BYTE: u64 = 4;

/// Estimated bytes of memory per triangle while it is prepared.
const TRIANGLE_MADE: u64 = 2 * size_of::<MeshTriangle>() as u64;

/// Bytes of a triangle of `object` in a renderer.
fn drawn_bytes(object: &SceneObject) -> u64 {
    let plain = size_of::<Triangle>();
    // A plan may choose the accurate tier.
    let has_prisms = object.tier == Tier::Accurate || object.budget.is_some();
    let prisms = size_of::<PrismData>() + size_of::<MeshPrism>();
    (plain + if has_prisms { prisms } else { 0 }) as u64
}

/// Rotation of a scene's `rotate`: degrees about x, y and z in turn.
pub(crate) fn rotation(degrees: [f64; 3]) -> DQuat {
    let [x, y, z] = degrees.map(f64::to_radians);
    DQuat::from_euler(EulerRot::ZYX, z, y, x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn tangents_are_smooth_where_a_tier_reads_them() {
        let scene = |objects: &str| Scene::parse(objects, Path::new("a.toml")).unwrap();
        let object = |rest: &str| format!("[[object]]\nmesh = 'a.obj'\nshape = 'a.png'\n{rest}\n");
        let [planar, accurate] =
            ["planar", "accurate"].map(|tier| object(&format!("tier = '{tier}'")));
        let options = |objects: &str| {
            let scene = scene(objects);
            mesh_options(&scene.objects[0], reads_tangents(&scene))
        };
        let rough = options(&[&*planar, &accurate].concat());
        assert!(!rough.smooth_tangents);
        let smooth = options(&[&*planar, &object("tier = 'fast'")].concat());
        assert!(smooth.smooth_tangents && options(&object("error_px = 1")).smooth_tangents);
        // A mesh that is there already is used again.
        assert!(serves(&smooth, &rough) && serves(&rough, &rough) && !serves(&rough, &smooth));
        let larger = MeshOptions {
            scale: 2.0,
            ..smooth
        };
        assert!(!serves(&larger, &rough));
    }
}
