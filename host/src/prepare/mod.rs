//! From a scene to plain data that a renderer reads.
//!
//! Positions are moved so that the middle of all objects is the origin, in
//! f64, before they become f32: a scene far from the origin keeps its digits.

mod object;
mod shapes;
#[cfg(test)]
pub(crate) mod tests;
mod view;

pub use view::unlit_frame;

use crate::Error;
use crate::budget::{self, Plan};
use crate::limits::Account;
use crate::mesh::{Bounds, Mesh, MeshOptions, MeshShell, MeshTriangle};
use crate::scene::{Camera, MapOptions, Scene, SceneObject, Shape, Tier};
use crate::shape_map::ShapeMap;
use crate::shell::narrow_shell;
use glam::{DQuat, DVec3, EulerRot};
use object::prepare_object;
use rayon::prelude::*;
use relievo_shared::layout::{Frame, Object, SEARCH_PRISMS, Shell, Triangle};
use shapes::Shapes;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use view::{default_camera, frame};
use web_time::Instant;

/// A scene, ready for a renderer.
pub struct PreparedScene {
    /// Camera, light and picture size, one sample per pixel.
    pub frame: Frame,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Samples per pixel side.
    pub supersampling: u32,
    /// Linear RGB where nothing is.
    pub background: [f32; 3],
    /// What is drawn, in order.
    pub objects: Vec<PreparedObject>,
    /// Names of the objects that lie outside the picture and are not prepared.
    pub outside: Vec<String>,
    /// The middle of all objects, world units: positions are relative to it.
    pub origin: DVec3,
    /// The box around all meshes, world units.
    pub bounds: Bounds,
    /// The camera in world units, also where the scene file has none.
    pub camera: Camera,
    /// Time spent on loading and baking.
    pub preparation: Duration,
}

/// An object, ready for a renderer.
pub struct PreparedObject {
    /// The object's name.
    pub name: String,
    /// Its number in the scene, from 0.
    pub number: usize,
    /// Its parameters.
    pub parameters: Object,
    /// Its triangles, relative to the scene's origin.
    pub triangles: Vec<Triangle>,
    /// The prisms over them; empty unless the tier is the accurate one.
    pub shells: Vec<Shell>,
    /// Its shape map; objects with the same pattern share it.
    pub map: Arc<ShapeMap>,
    /// How that was made of a plain pattern.
    pub map_options: MapOptions,
    /// The mesh it came from; objects with the same mesh and transform share it.
    pub mesh: Arc<Mesh>,
    /// How it came to be drawn so, where the scene gives it a budget.
    pub plan: Option<Plan>,
}

/// What was loaded and made for a scene.
#[derive(Default)]
pub struct Assets {
    meshes: Vec<(PathBuf, MeshOptions, Arc<Mesh>)>,
    shapes: Shapes,
}

/// A step of the work, for a progress bar.
#[derive(Clone, Debug)]
pub enum Step {
    /// A mesh is loaded and its curvature fitted.
    Mesh(PathBuf),
    /// A pattern is loaded and its distance field computed; the fraction done.
    ShapeMap(Shape, f64),
    /// The cheapest way to draw the object of this name is looked for.
    Plan(String),
}

/// Loads and prepares everything that `scene` names; `progress` may be called
/// from any thread.
///
/// # Errors
/// [`Error`] for the first object whose assets cannot be used.
pub fn prepare(scene: &Scene, progress: &(dyn Fn(Step) + Sync)) -> Result<PreparedScene, Error> {
    prepare_with(scene, &mut Assets::default(), progress)
}

/// As [`prepare`], with what of `assets` has not changed: for scenes of which
/// one follows from another. Afterwards they are those of `scene`; after an
/// error, there may be none.
///
/// Files are known by their names: what has changed within one is not seen.
///
/// # Errors
/// As [`prepare`].
pub fn prepare_with(
    scene: &Scene,
    assets: &mut Assets,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PreparedScene, Error> {
    assemble(scene, &|_| true, assets, progress)
}

/// As [`prepare`], but for the picture of the scene's own camera only: meshes
/// that lie outside of it are read for their extent and not prepared. The
/// picture is the same.
///
/// # Errors
/// As [`prepare`], but not for what is found in preparing what is not seen.
pub fn prepare_view(
    scene: &Scene,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PreparedScene, Error> {
    match scene.camera {
        Some(camera) => assemble(
            scene,
            &|bounds| view::sees(scene, &camera, bounds),
            &mut Assets::default(),
            progress,
        ),
        // That of a scene without one sees everything.
        None => prepare(scene, progress),
    }
}

fn assemble(
    scene: &Scene,
    is_seen: &dyn Fn(&Bounds) -> bool,
    assets: &mut Assets,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<PreparedScene, Error> {
    let start = Instant::now();
    let mut account = Account::new(&scene.path, &scene.limits);
    take_picture(scene, &mut account)?;
    let before = std::mem::take(assets);
    let meshes = load_meshes(scene, is_seen, before.meshes, &mut account, progress)?;
    let seen = || (0..).zip(&meshes).filter(|(_, mesh)| mesh.mesh.is_some());
    let seen: Vec<usize> = seen().map(|(number, _)| number).collect();
    let mut shapes = Shapes::load(
        seen.iter().map(|&number| &scene.objects[number]),
        scene,
        before.shapes,
        &mut account,
        progress,
    )?;
    let kept = scene.objects.iter().zip(&meshes);
    assets.meshes = kept
        .filter_map(|(object, loaded)| {
            let mesh = loaded.mesh.clone()?;
            Some((object.mesh.clone(), mesh_options(object), mesh))
        })
        .collect();

    let bounds = meshes
        .iter()
        .map(|mesh| mesh.bounds)
        .reduce(|a, b| Bounds {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        })
        .expect("a scene has at least one object");
    let origin = bounds.centre();
    let camera = scene
        .camera
        .unwrap_or_else(|| default_camera(&bounds, scene));

    let frame = frame(scene, &camera, origin, &bounds, scene.size);
    let view = View {
        origin,
        pixel: DVec3::from(frame.ray_right.map(f64::from)).length(),
    };
    let mut objects = Vec::with_capacity(seen.len());
    let mut outside = Vec::new();
    for ((number, object), mesh) in scene.objects.iter().enumerate().zip(meshes) {
        match mesh.mesh {
            Some(mesh) => {
                let made = make(scene, object, mesh, &mut shapes, view)?;
                objects.push(PreparedObject { number, ..made });
            }
            None => outside.push(object.name.clone()),
        }
    }

    let mut prepared = PreparedScene {
        frame,
        size: scene.size,
        supersampling: scene.supersampling,
        background: scene.background.linear(),
        objects,
        outside,
        origin,
        bounds,
        camera,
        preparation: Duration::ZERO,
    };
    keep_budgets(scene, &mut prepared, &mut shapes, view, progress)?;
    assets.shapes = shapes;
    prepared.preparation = start.elapsed();
    Ok(prepared)
}

/// What objects are prepared for.
#[derive(Clone, Copy)]
struct View {
    /// The scene's origin, world units.
    origin: DVec3,
    /// A pixel's width at distance 1, world units.
    pixel: f64,
}

/// One object, drawn as it says.
fn make(
    scene: &Scene,
    object: &SceneObject,
    mesh: Arc<Mesh>,
    shapes: &mut Shapes,
    view: View,
) -> Result<PreparedObject, Error> {
    let map = shapes.map(object).map_err(|problem| Error::Object {
        scene: scene.path.clone(),
        name: object.name.clone(),
        problem,
    })?;
    prepare_object(scene, object, mesh, map, view)
}

/// Plans how the objects with a budget are drawn.
fn keep_budgets(
    scene: &Scene,
    prepared: &mut PreparedScene,
    shapes: &mut Shapes,
    view: View,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<(), Error> {
    if scene.objects.iter().all(|object| object.budget.is_none()) {
        return Ok(());
    }
    let views = budget::look(prepared);
    for (index, shown) in views.into_iter().enumerate() {
        let PreparedObject { number, mesh, .. } = &prepared.objects[index];
        let (number, mesh) = (*number, mesh.clone());
        let object = &scene.objects[number];
        let Some(budget) = object.budget else {
            continue;
        };
        progress(Step::Plan(object.name.clone()));
        let (plan, drawn) = budget::plan(
            object,
            budget,
            shown,
            shapes.plain_size(object),
            prepared,
            &mut |object| make(scene, object, mesh.clone(), shapes, view),
        )?;
        tracing::info!("{:?}: {plan}", object.name);
        prepared.objects[index] = PreparedObject {
            number,
            plan: Some(plan),
            ..drawn
        };
    }
    Ok(())
}

impl PreparedScene {
    /// The frame of a picture of `size` pixels from another camera; `scene` is
    /// the one that was prepared, and has the light and the field of view.
    pub fn frame_from(&self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Frame {
        frame(scene, camera, self.origin, &self.bounds, size)
    }

    /// The frame of a picture with `factor` samples per pixel side.
    pub fn frame_with_samples(&self, factor: u32) -> Frame {
        finer(&self.frame, factor)
    }

    /// The same view of `object` alone.
    pub(crate) fn alone(&self, object: PreparedObject) -> PreparedScene {
        PreparedScene {
            objects: vec![object],
            outside: Vec::new(),
            ..*self
        }
    }

    /// Makes the prisms of every object, also of those that do not need them.
    pub fn make_all_shells(&mut self) {
        for object in &mut self.objects {
            let shells = object.all_shells(self.origin).into_owned();
            object.shells = shells;
        }
    }

    /// Number of triangles of all objects.
    pub fn triangle_count(&self) -> usize {
        self.objects
            .iter()
            .map(|object| object.triangles.len())
            .sum()
    }
}

/// `frame` with `factor` samples per pixel side: the same view on a finer grid.
pub fn finer(frame: &Frame, factor: u32) -> Frame {
    let inverse = 1.0 / f64::from(factor);
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let (right, down) = (wide(frame.ray_right), wide(frame.ray_down));
    // The first sample's centre is nearer to the pixel's corner.
    let first = wide(frame.ray_first) + (right + down) * (0.5 * inverse - 0.5);
    Frame {
        ray_first: narrow(first),
        ray_right: narrow(right * inverse),
        ray_down: narrow(down * inverse),
        size: frame.size.map(|side| side * factor as f32),
        ..*frame
    }
}

impl PreparedObject {
    /// Rounds `shells` to what renderers read, for the object's depth.
    fn narrow_shells(&self, shells: &[MeshShell], origin: DVec3) -> Vec<Shell> {
        let depth = f64::from(self.parameters.depth);
        shells
            .par_iter()
            .zip(&self.triangles)
            .map(|(shell, triangle)| {
                let uv = triangle.corners.map(|corner| corner.uv);
                narrow_shell(shell, uv, depth, origin)
            })
            .collect()
    }

    /// The prisms over all triangles, made for this call where the tier needs
    /// none; `origin` is the scene's.
    pub fn all_shells(&self, origin: DVec3) -> Cow<'_, [Shell]> {
        if self.shells.is_empty() {
            Cow::Owned(self.narrow_shells(&self.mesh.shells(), origin))
        } else {
            Cow::Borrowed(&self.shells)
        }
    }

    /// Bytes of its map where nobody asks for another: 16 bits a texel, as many
    /// texels as its pattern has pixels.
    pub fn plain_map_bytes(&self) -> u64 {
        let side = |texels: u32| u64::from(texels) * u64::from(self.map_options.reduction);
        side(self.map.width()) * side(self.map.height()) * 2
    }

    /// Whether rays are followed through prisms.
    pub fn has_prisms(&self) -> bool {
        self.parameters.search == SEARCH_PRISMS
    }
}

/// The mesh of an object, unless it is not seen.
#[derive(Clone)]
struct Loaded {
    mesh: Option<Arc<Mesh>>,
    bounds: Bounds,
}

/// The mesh of each object, loaded once for objects that share it.
fn load_meshes(
    scene: &Scene,
    is_seen: &dyn Fn(&Bounds) -> bool,
    before: Vec<(PathBuf, MeshOptions, Arc<Mesh>)>,
    account: &mut Account<'_>,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<Vec<Loaded>, Error> {
    let mut triangles_left = scene.limits.triangles;
    let mut loaded: Vec<(PathBuf, MeshOptions, Loaded)> = Vec::new();
    let mut meshes = Vec::with_capacity(scene.objects.len());
    for object in &scene.objects {
        let options = mesh_options(object);
        let known = loaded
            .iter()
            .find(|(path, known, _)| *path == object.mesh && *known == options);
        let mesh = match known {
            Some((_, _, mesh)) => mesh.clone(),
            None => {
                let kept = before
                    .iter()
                    .find(|(path, known, _)| *path == object.mesh && *known == options)
                    .filter(|(_, _, mesh)| is_seen(&mesh.bounds));
                let made = match kept {
                    Some((_, _, mesh)) => Ok(mesh.clone()),
                    None => {
                        progress(Step::Mesh(object.mesh.clone()));
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
                        account.take(object.mesh.display(), count, bytes)?;
                        Loaded {
                            bounds: mesh.bounds,
                            mesh: Some(mesh),
                        }
                    }
                    Err(bounds) => Loaded { mesh: None, bounds },
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

/// How the mesh of `object` is made.
fn mesh_options(object: &SceneObject) -> MeshOptions {
    MeshOptions {
        projection: object.projection,
        scale: object.scale,
        rotation: rotation(object.rotate),
        translation: DVec3::from(object.translate),
        ..MeshOptions::default()
    }
}

/// Bytes that a byte of a mesh file is estimated to take while it is read: as
/// text, as the statements that are kept, and as numbers.
const TEXT_BYTE: u64 = 4;

/// Bytes that a triangle is estimated to take while it is prepared.
const TRIANGLE_MADE: u64 = 2 * size_of::<MeshTriangle>() as u64;

/// Bytes that a triangle of `object` takes for a renderer.
fn drawn_bytes(object: &SceneObject) -> u64 {
    let plain = size_of::<Triangle>();
    // A plan may choose the accurate tier.
    let has_prisms = object.tier == Tier::Accurate || object.budget.is_some();
    let prisms = size_of::<Shell>() + size_of::<MeshShell>();
    (plain + if has_prisms { prisms } else { 0 }) as u64
}

/// Takes the memory of the picture: its samples as words, and its bytes.
fn take_picture(scene: &Scene, account: &mut Account<'_>) -> Result<(), Error> {
    let [width, height] = scene.size.map(u64::from);
    let samples = u64::from(scene.supersampling).pow(2);
    let what = format!("the picture of {width} × {height} pixels, {samples} sample(s) each,");
    account.take(what, width * height, 16 * samples + 3)
}

/// What a scene's `rotate` does: degrees about x, y and z in turn.
pub(crate) fn rotation(degrees: [f64; 3]) -> DQuat {
    let [x, y, z] = degrees.map(f64::to_radians);
    DQuat::from_euler(EulerRot::ZYX, z, y, x)
}

fn narrow(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}
