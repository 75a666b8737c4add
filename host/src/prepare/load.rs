//! Loads the files of a scene, from which its objects can be prepared in
//! several ways.

use super::camera::{camera_of, frame, sees};
use super::layers::encode;
use super::lighting::{Bakes, prepare_lighting};
use super::meshes::{LoadedMesh, MeshCache, cached, load_meshes};
use super::object::{Common, prepare_object};
use super::placement::Placement;
use super::places::{Place, Sharing, Source, places};
use super::prepared::{PreparedObject, PreparedScene};
use super::shapes::Shapes;
use super::shells::Shells;
use super::sources::has_shadows;
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

/// The meshes, patterns, pictures and the environment of a scene, kept for [`super::prepare_with`].
#[derive(Default)]
pub struct Assets {
    meshes: MeshCache,
    shapes: Shapes,
    shells: Shells,
    bakes: Bakes,
}

/// A scene whose files are loaded.
pub(crate) struct LoadedScene<'a> {
    scene: &'a Scene,
    sources: Vec<Source<'a>>,
    /// One for each source.
    meshes: Vec<LoadedMesh>,
    /// Where the sources stand, in drawing order.
    places: Vec<Place>,
    /// Whether each place is seen.
    is_seen: Vec<bool>,
    /// Patterns of the objects that are seen.
    shapes: Shapes,
    /// Local depths of the meshes.
    shells: Shells,
    /// What is baked for shading.
    bakes: Bakes,
    bounds: Bounds,
    camera: Camera,
    frame: Frame,
    /// The memory that was taken.
    account: Account<'a>,
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
            // What is outside may cast a shadow.
            let camera = scene.own_camera().filter(|_| !has_shadows(scene));
            camera.is_none_or(|camera| sees(scene, &camera, bounds))
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
        // A plan depends on where an object is.
        let has_budgets = scene.objects.iter().any(|object| object.budget.is_some());
        let sharing = if has_budgets {
            Sharing::Apart
        } else {
            Sharing::Shared
        };
        let (sources, places) = places(scene, sharing, &mut account)?;
        let of_place = |place: &Place, bounds: &Bounds| match &place.placement {
            Some(placement) => placement.bounds(bounds),
            None => *bounds,
        };
        let mut of_source: Vec<Vec<&Place>> = vec![Vec::new(); sources.len()];
        for place in &places {
            of_source[place.source].push(place);
        }
        let meshes = load_meshes(
            scene,
            &sources,
            &|source, bounds| {
                let mut places = of_source[source].iter();
                places.any(|place| is_seen(&of_place(place, bounds)))
            },
            before.meshes,
            &mut account,
            progress,
        )?;
        let around: Vec<Bounds> = places
            .iter()
            .map(|place| of_place(place, &meshes[place.source].bounds))
            .collect();
        let seen_places = places.iter().zip(&around);
        let is_seen: Vec<bool> = seen_places
            .map(|(place, bounds)| meshes[place.source].mesh.is_some() && is_seen(bounds))
            .collect();
        let seen = sources.iter().zip(&meshes);
        let seen = seen.filter(|(_, loaded)| loaded.mesh.is_some());
        let shapes = Shapes::load(
            seen.map(|(source, _)| &*source.object),
            scene,
            before.shapes,
            &mut account,
            progress,
        )?;
        let bounds = around
            .into_iter()
            .reduce(|a, b| Bounds {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            })
            .expect("a scene has at least one object");
        let camera = camera_of(scene, &bounds);
        Ok(LoadedScene {
            frame: frame(scene, &camera, bounds.centre(), &bounds, scene.size),
            scene,
            sources,
            meshes,
            places,
            is_seen,
            shapes,
            shells: before.shells.for_next(),
            bakes: before.bakes.for_next(),
            bounds,
            camera,
            account,
            start,
        })
    }

    /// Prepares every object that is seen, as the scene describes it.
    pub(crate) fn prepare(&mut self) -> Result<PreparedScene, Error> {
        let mut objects: Vec<PreparedObject> = Vec::with_capacity(self.places.len());
        let mut outside: Vec<String> = Vec::new();
        // The prepared object of each source that is shared.
        let mut shared: Vec<Option<usize>> = vec![None; self.sources.len()];
        for index in 0..self.places.len() {
            let Place {
                number,
                instance,
                source,
                placement,
            } = self.places[index];
            let name = &self.scene.objects[number].name;
            let mesh = self.meshes[source].mesh.clone();
            let Some(mesh) = mesh.filter(|_| self.is_seen[index]) else {
                if outside.last() != Some(name) {
                    outside.push(name.clone());
                }
                continue;
            };
            let of_source = self.sources[source].transform;
            let transform = placement.map_or(of_source, |placement| of_source.then(&placement));
            // Positions of a shared mesh are relative to its own centre.
            let placement = placement.map(|placement| Placement {
                translation: placement.point(mesh.bounds.centre()) - self.bounds.centre(),
                ..placement
            });
            let prepared = match shared[source] {
                Some(first) => objects[first].clone().in_order(index),
                None => {
                    let object = self.sources[source].object.clone();
                    let origin = match placement {
                        Some(_) => mesh.bounds.centre(),
                        None => self.bounds.centre(),
                    };
                    let prepared = self.object_at(index, &object, mesh, origin)?;
                    tell_local_depth(&prepared);
                    if placement.is_some() {
                        shared[source] = Some(objects.len());
                    }
                    prepared
                }
            };
            let prepared = PreparedObject {
                name: name.clone(),
                number,
                instance,
                placement,
                transform,
                ..prepared
            };
            objects.push(prepared);
        }
        let lighting = match self.scene.is_physical() {
            true => {
                // What the rest of the scene takes stays counted.
                let mut account = self.account.clone();
                let bounds = &self.bounds;
                let bakes = &mut self.bakes;
                let made = prepare_lighting(self.scene, &mut objects, bounds, bakes, &mut account);
                Some(Arc::new(made?))
            }
            false => None,
        };
        Ok(PreparedScene {
            frame: self.frame,
            size: self.scene.size,
            supersampling: self.scene.supersampling,
            background: self.scene.background.linear(),
            development: self.scene.development,
            lighting,
            objects,
            outside,
            origin: self.bounds.centre(),
            bounds: self.bounds,
            camera: self.camera,
            preparation: self.elapsed(),
        })
    }

    /// Prepares the object that `prepared` is as `object` describes it, which has the same
    /// mesh and pattern.
    pub(crate) fn again(
        &mut self,
        prepared: &PreparedObject,
        object: &SceneObject,
    ) -> Result<PreparedObject, Error> {
        let is_it =
            |place: &Place| (place.number, place.instance) == (prepared.number, prepared.instance);
        let mut places = self.places.iter();
        let index = places.position(is_it).expect("it stands in a place");
        let object = SceneObject {
            // That of the instance.
            depth: self.sources[self.places[index].source].object.depth,
            ..object.clone()
        };
        let mesh = prepared.mesh.clone();
        let made = self.object_at(index, &object, mesh, self.bounds.centre())?;
        let mut made = PreparedObject {
            number: prepared.number,
            instance: prepared.instance,
            transform: prepared.transform,
            ..made
        };
        made.parameters.finish = prepared.parameters.finish;
        Ok(made)
    }

    /// Prepares `object`, number `number` of those drawn, with positions relative to `origin`.
    fn object_at(
        &mut self,
        number: usize,
        object: &SceneObject,
        mesh: Arc<Mesh>,
        origin: DVec3,
    ) -> Result<PreparedObject, Error> {
        let maps = match object.layers.is_empty() {
            true => self.shapes.map(object).map(|map| vec![map]),
            false => {
                let fields = self.shapes.fields(object);
                fields.and_then(|fields| encode(object, &fields))
            }
        };
        let maps = maps.map_err(|problem| Error::Object {
            scene: self.scene.path.clone(),
            name: object.name.clone(),
            problem,
        })?;
        let common = Common {
            scene: self.scene,
            origin,
            pixel: DVec3::from(self.frame.ray_right.map(f64::from)).length(),
            shells: &mut self.shells,
        };
        prepare_object(common, number, object, mesh, maps)
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
            meshes: cached(self.scene, &self.sources, &self.meshes),
            shapes: self.shapes,
            shells: self.shells,
            bakes: self.bakes,
        }
    }
}

/// Tells where an object is less deep than asked for.
fn tell_local_depth(object: &PreparedObject) {
    let Some(local_depth) = object.local_depth else {
        return;
    };
    log::warn!(
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
    // A scene that is lit physically is drawn to a G-buffer first. With smooth edges the means of small
    // patterns are a picture of their own.
    let words = match (scene.is_physical(), scene.smooth_edges) {
        (true, true) => 64,
        (true, false) => 48,
        (false, _) => 16,
    };
    let channels = 3 + u64::from(scene.development.is_transparent);
    Ok(account.take(what, width * height, words * samples + channels)?)
}
