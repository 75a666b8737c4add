//! Loads the files of a scene, from which its objects can be prepared in
//! several ways.

use super::camera::{default_camera, frame, sees};
use super::meshes::{LoadedMesh, MeshCache, cached, load_meshes};
use super::object::{Common, prepare_object};
use super::prepared::{PreparedObject, PreparedScene};
use super::shapes::Shapes;
use super::shells::Shells;
use super::step::Step;
use crate::Error;
use crate::limits::Account;
use crate::mesh::{Bounds, Mesh};
use crate::scene::{Camera, Scene, SceneObject};
use glam::DVec3;
use relievo_shared::layout::Frame;
use std::sync::Arc;
use std::time::Duration;
use web_time::Instant;

/// The meshes and patterns of a scene, kept for [`super::prepare_with`].
#[derive(Default)]
pub struct Assets {
    meshes: MeshCache,
    shapes: Shapes,
    shells: Shells,
}

/// A scene whose files are loaded.
pub(crate) struct LoadedScene<'a> {
    scene: &'a Scene,
    /// One for each object.
    meshes: Vec<LoadedMesh>,
    /// Patterns of the objects that are seen.
    shapes: Shapes,
    /// Local depths of the meshes.
    shells: Shells,
    bounds: Bounds,
    camera: Camera,
    frame: Frame,
    start: Instant,
}

impl<'a> LoadedScene<'a> {
    /// Loads all objects of `scene`, reusing `assets`, which are empty afterwards.
    pub(crate) fn load(
        scene: &'a Scene,
        assets: &mut Assets,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<LoadedScene<'a>, Error> {
        LoadedScene::load_seen(scene, &|_| true, std::mem::take(assets), progress)
    }

    /// Loads the objects that may be in the picture from the scene's own camera.
    /// The camera of a scene that has none sees everything.
    pub(crate) fn load_view(
        scene: &'a Scene,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<LoadedScene<'a>, Error> {
        let is_seen = |bounds: &Bounds| {
            let camera = scene.camera.as_ref();
            camera.is_none_or(|camera| sees(scene, camera, bounds))
        };
        LoadedScene::load_seen(scene, &is_seen, Assets::default(), progress)
    }

    fn load_seen(
        scene: &'a Scene,
        is_seen: &dyn Fn(&Bounds) -> bool,
        before: Assets,
        progress: &(dyn Fn(Step) + Sync),
    ) -> Result<LoadedScene<'a>, Error> {
        let start = Instant::now();
        scene.check()?;
        let mut account = Account::new(&scene.path, &scene.limits);
        take_picture(scene, &mut account)?;
        let meshes = load_meshes(scene, is_seen, before.meshes, &mut account, progress)?;
        let objects = scene.objects.iter().zip(&meshes);
        let seen = objects.filter(|(_, loaded)| loaded.mesh.is_some());
        let shapes = Shapes::load(
            seen.map(|(object, _)| object),
            scene,
            before.shapes,
            &mut account,
            progress,
        )?;
        let bounds = meshes
            .iter()
            .map(|loaded| loaded.bounds)
            .reduce(|a, b| Bounds {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            })
            .expect("a scene has at least one object");
        let camera = scene
            .camera
            .unwrap_or_else(|| default_camera(&bounds, scene));
        Ok(LoadedScene {
            frame: frame(scene, &camera, bounds.centre(), &bounds, scene.size),
            scene,
            meshes,
            shapes,
            shells: before.shells.for_next(),
            bounds,
            camera,
            start,
        })
    }

    /// Prepares every object that is seen, as the scene describes it.
    pub(crate) fn prepare(&mut self) -> Result<PreparedScene, Error> {
        let scene = self.scene;
        let mut objects = Vec::with_capacity(self.meshes.len());
        let mut outside = Vec::new();
        for (number, object) in scene.objects.iter().enumerate() {
            match self.meshes[number].mesh.clone() {
                Some(mesh) => {
                    let prepared = self.object(number, object, mesh)?;
                    tell_local_depth(&prepared);
                    objects.push(prepared);
                }
                None => outside.push(object.name.clone()),
            }
        }
        Ok(PreparedScene {
            frame: self.frame,
            size: scene.size,
            supersampling: scene.supersampling,
            background: scene.background.linear(),
            objects,
            outside,
            origin: self.bounds.centre(),
            bounds: self.bounds,
            camera: self.camera,
            preparation: self.elapsed(),
        })
    }

    /// Prepares object `number` of the scene as `object` describes it, which has
    /// the same pattern; `mesh` is its mesh.
    pub(crate) fn object(
        &mut self,
        number: usize,
        object: &SceneObject,
        mesh: Arc<Mesh>,
    ) -> Result<PreparedObject, Error> {
        let map = self.shapes.map(object).map_err(|problem| Error::Object {
            scene: self.scene.path.clone(),
            name: object.name.clone(),
            problem,
        })?;
        let common = Common {
            scene: self.scene,
            origin: self.bounds.centre(),
            pixel: DVec3::from(self.frame.ray_right.map(f64::from)).length(),
            shells: &mut self.shells,
        };
        prepare_object(common, number, object, mesh, map)
    }

    /// Width and height of the plain pattern of `object`, pixels; `None` if its
    /// map is baked.
    pub(crate) fn pattern_size(&self, object: &SceneObject) -> Option<[u32; 2]> {
        self.shapes.plain_size(object)
    }

    /// Time since loading began.
    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Keeps what was loaded for the next scene.
    pub(crate) fn into_assets(self) -> Assets {
        Assets {
            meshes: cached(self.scene, &self.meshes),
            shapes: self.shapes,
            shells: self.shells,
        }
    }
}

/// Tells where an object is less deep than asked for.
fn tell_local_depth(object: &PreparedObject) {
    let Some(local_depth) = object.local_depth else {
        return;
    };
    tracing::warn!(
        "object {:?}: the depth {:.6} is {local_depth}, since the mesh is too thin or too curved there",
        object.name,
        object.depth,
    );
}

/// Takes the memory of the picture: its samples as words, and its bytes.
fn take_picture(scene: &Scene, account: &mut Account<'_>) -> Result<(), Error> {
    let [width, height] = scene.size.map(u64::from);
    let samples = u64::from(scene.supersampling).pow(2);
    let what = format!("the picture of {width} × {height} pixels, {samples} sample(s) each,");
    Ok(account.take(what, width * height, 16 * samples + 3)?)
}
