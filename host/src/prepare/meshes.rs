//! The meshes of a scene: each is loaded once.

use super::places::Source;
use super::step::Step;
use crate::Error;
use crate::limits::Account;
use crate::mesh::{Bounds, Mesh, MeshOptions, MeshPrism, MeshSource, MeshTriangle};
use crate::scene::{Scene, SceneObject, Tier};
use relievo_shared::layout::{PrismData, Triangle};
use std::sync::Arc;

/// Meshes by the source and the options that they were made with.
pub(super) type MeshCache = Vec<(MeshSource, MeshOptions, Arc<Mesh>)>;

/// The mesh of a source.
#[derive(Clone)]
pub(super) struct LoadedMesh {
    /// `None` where it is not seen.
    pub mesh: Option<Arc<Mesh>>,
    /// The box around the mesh, in its space.
    pub bounds: Bounds,
}

/// Returns the meshes of `sources` that are seen.
pub(super) fn cached(scene: &Scene, sources: &[Source<'_>], meshes: &[LoadedMesh]) -> MeshCache {
    let smooth_tangents = reads_tangents(scene);
    let sources = sources.iter().zip(meshes);
    sources
        .filter_map(|(source, loaded)| {
            let mesh = loaded.mesh.clone()?;
            let options = mesh_options(source, smooth_tangents);
            Some((source.object.mesh.clone(), options, mesh))
        })
        .collect()
}

/// Loads the mesh of each of `sources`; those with equal options load it once. `is_seen`
/// tells whether a box in the space of a source is seen.
pub(super) fn load_meshes(
    scene: &Scene,
    sources: &[Source<'_>],
    is_seen: &dyn Fn(usize, &Bounds) -> bool,
    before: MeshCache,
    account: &mut Account<'_>,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<Vec<LoadedMesh>, Error> {
    let smooth_tangents = reads_tangents(scene);
    let mut triangles_left = scene.limits.triangles;
    let mut loaded: Vec<(&MeshSource, MeshOptions, LoadedMesh)> = Vec::new();
    let mut meshes = Vec::with_capacity(sources.len());
    for (index, source) in sources.iter().enumerate() {
        let object = &source.object;
        let is_seen = |bounds: &Bounds| is_seen(index, bounds);
        let options = mesh_options(source, smooth_tangents);
        let known = loaded
            .iter()
            .find(|(path, known, _)| **path == object.mesh && *known == options);
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
                        Mesh::load_if(&scene.files, &object.mesh, &within, &is_seen)?.map(Arc::new)
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
                loaded.push((&object.mesh, options, mesh.clone()));
                mesh
            }
        };
        if let Some(mesh) = &mesh.mesh {
            let count = mesh.triangles.len();
            let drawn = count.saturating_mul(source.places);
            triangles_left = triangles_left.checked_sub(drawn).ok_or_else(|| {
                let times = match source.places {
                    1 => String::new(),
                    places => format!(", drawn {places} times,"),
                };
                Error::Object {
                    scene: scene.path.clone(),
                    name: object.name.clone(),
                    problem: format!(
                        "its {count} triangles{times} are beyond the limit of {} for all objects together; simplify the mesh, or raise the limit (--max-triangles)",
                        scene.limits.triangles
                    ),
                }
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

/// Options to load the mesh of `source` with. `smooth_tangents` is the same for all objects
/// of a scene, so that they share meshes.
fn mesh_options(source: &Source<'_>, smooth_tangents: bool) -> MeshOptions {
    let Source {
        object, transform, ..
    } = source;
    MeshOptions {
        smooth_tangents,
        parts: object.parts.clone(),
        projection: object.projection,
        scale: transform.scale,
        rotation: transform.rotation,
        translation: transform.translation,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::Placement;
    use std::borrow::Cow;
    use std::path::Path;

    #[test]
    fn tangents_are_smooth_where_a_tier_reads_them() {
        let scene = |objects: &str| Scene::parse(objects, Path::new("a.toml")).unwrap();
        let object = |rest: &str| format!("[[object]]\nmesh = 'a.obj'\nshape = 'a.png'\n{rest}\n");
        let [planar, accurate] =
            ["planar", "accurate"].map(|tier| object(&format!("tier = '{tier}'")));
        let options = |objects: &str| {
            let scene = scene(objects);
            let source = Source {
                object: Cow::Borrowed(&scene.objects[0]),
                transform: Placement::default(),
                places: 1,
            };
            mesh_options(&source, reads_tangents(&scene))
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
