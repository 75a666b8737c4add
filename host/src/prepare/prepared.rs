//! A prepared scene: plain data that renderers read.

use super::camera::{View, camera_of, finer, frame};
use super::exits::number_of_exits;
use super::layers::PreparedLayer;
use super::lit::PreparedLighting;
use super::placement::Placement;
use crate::mesh::{Bounds, LocalDepth, Mesh, MeshPrism};
use crate::prism::narrow_prism;
use crate::scene::{Camera, Development, MapOptions, Scene};
use crate::shape_map::ShapeMap;
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::{Frame, Object, PrismData, SEARCH_PRISMS, Triangle};
use std::borrow::Cow;
use std::sync::Arc;
use std::time::Duration;

/// A scene, ready for a renderer.
pub struct PreparedScene {
    /// Camera, light and picture size, one sample per pixel.
    pub frame: Frame,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Samples per pixel side.
    pub supersampling: u32,
    /// Linear RGB of pixels without a hit.
    pub background: [f32; 3],
    /// How pictures are developed.
    pub development: Development,
    /// Materials and lights of a scene that is lit physically.
    pub lighting: Option<Arc<PreparedLighting>>,
    /// The objects, in drawing order.
    pub objects: Vec<PreparedObject>,
    /// Names of the objects that lie outside the picture and are not prepared.
    pub outside: Vec<String>,
    /// Centre of all objects, world units; positions are relative to it.
    pub origin: DVec3,
    /// Bounding box of all meshes, world units.
    pub bounds: Bounds,
    /// The camera, world units; the default one where the scene has none.
    pub camera: Camera,
    /// Time spent on loading, baking and planning.
    pub preparation: Duration,
}

/// An object, or one of its instances, ready for a renderer. Objects that differ by their
/// placement only share triangles, prisms, map and mesh.
#[derive(Clone)]
pub struct PreparedObject {
    /// The object's name.
    pub name: String,
    /// Its number in the scene, from 0.
    pub number: usize,
    /// Number of the instance of the object, from 0.
    pub instance: usize,
    /// From object space to world space, relative to the scene's origin; `None` where object
    /// space is world space, relative to the scene's origin.
    pub placement: Option<Placement>,
    /// From the space of the mesh file to world space.
    pub transform: Placement,
    /// Its parameters.
    pub parameters: Object,
    /// Its triangles.
    pub triangles: Arc<Vec<Triangle>>,
    /// The depth asked for, object units; that of `parameters` is less where there is
    /// nowhere room for it.
    pub depth: f64,
    /// Where the local depth is less than asked for; `None` if it is so nowhere.
    pub local_depth: Option<LocalDepth>,
    /// Its prisms, one for each triangle; empty unless the tier is accurate.
    pub prisms: Arc<Vec<PrismData>>,
    /// Its shape map; objects with the same pattern share it.
    pub map: Arc<ShapeMap>,
    /// Its layers; empty if it has no other pattern than its own.
    pub layers: Arc<Vec<PreparedLayer>>,
    /// Options that the map was made with, of a plain pattern.
    pub map_options: MapOptions,
    /// The mesh it came from; objects with the same mesh and transform share it.
    pub mesh: Arc<Mesh>,
}

impl PreparedScene {
    /// Returns the frame of a picture of `size` pixels from another camera, with
    /// the light and field of view of `scene`, which is the scene that was
    /// prepared.
    pub fn frame_from(&self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> Frame {
        frame(scene, camera, self.origin, &self.bounds, size)
    }

    /// Returns its own view.
    pub fn view(&self) -> View {
        View {
            camera: self.camera,
            frame: self.frame,
        }
    }

    /// Returns the view with camera and light of `scene`: the scene that was prepared, at
    /// another time ([`Scene::is_still`]).
    pub fn view_of(&self, scene: &Scene) -> View {
        let camera = camera_of(scene, &self.bounds);
        View {
            camera,
            frame: self.frame_from(scene, &camera, self.size),
        }
    }

    /// Returns the frame with `factor` samples per pixel side.
    pub fn frame_with_samples(&self, factor: u32) -> Frame {
        finer(&self.frame, factor)
    }

    /// Returns the same view of `object` alone.
    pub(crate) fn alone(&self, object: PreparedObject) -> PreparedScene {
        PreparedScene {
            objects: vec![object],
            outside: Vec::new(),
            lighting: self.lighting.clone(),
            ..*self
        }
    }

    /// Makes the prisms of every object, whatever its tier.
    pub fn make_all_prisms(&mut self) {
        for index in 0..self.objects.len() {
            let object = &self.objects[index];
            let first = self.objects[..index].iter();
            let prisms = match first.rev().find(|first| first.shares_facets(object)) {
                Some(first) => first.prisms.clone(),
                None => Arc::new(object.all_prisms(self.origin).into_owned()),
            };
            self.objects[index].prisms = prisms;
        }
    }

    /// Returns the number of triangles of all objects.
    pub fn triangle_count(&self) -> usize {
        self.objects
            .iter()
            .map(|object| object.triangles.len())
            .sum()
    }
}

impl PreparedObject {
    /// Returns the object as number `order` of those drawn.
    pub(super) fn in_order(mut self, order: usize) -> PreparedObject {
        if self.parameters.number != 0 {
            self.parameters.number = number_of_exits(order);
        }
        self
    }

    /// Returns the world units per object unit.
    pub fn unit(&self) -> f64 {
        self.placement.map_or(1.0, |placement| placement.scale)
    }

    /// Returns `frame`, which is in world space, in the space of the object.
    pub fn frame<'a>(&self, frame: &'a Frame) -> Cow<'a, Frame> {
        match &self.placement {
            Some(placement) => Cow::Owned(placement.frame(frame)),
            None => Cow::Borrowed(frame),
        }
    }

    /// Returns whether `other` has the same facets in memory.
    pub fn shares_facets(&self, other: &PreparedObject) -> bool {
        Arc::ptr_eq(&self.triangles, &other.triangles)
    }

    /// Rounds `prisms` to f32, for the object's depth.
    pub(super) fn narrow_prisms(&self, prisms: &[MeshPrism], origin: DVec3) -> Vec<PrismData> {
        let depth = f64::from(self.parameters.depth);
        prisms
            .par_iter()
            .zip(self.triangles.par_iter())
            .map(|(prism, triangle)| {
                let uv = triangle.corners.map(|corner| corner.uv);
                narrow_prism(prism, uv, depth, origin)
            })
            .collect()
    }

    /// Returns the prisms of all triangles, made by this call unless the tier is
    /// accurate; `origin` is the scene's.
    pub fn all_prisms(&self, origin: DVec3) -> Cow<'_, [PrismData]> {
        if self.prisms.is_empty() {
            let origin = match self.placement {
                Some(_) => self.mesh.bounds.centre(),
                None => origin,
            };
            let shell = self.mesh.shell(self.depth);
            Cow::Owned(self.narrow_prisms(&shell.prisms, origin))
        } else {
            Cow::Borrowed(&self.prisms)
        }
    }

    /// Returns the bytes of its map with default options: 16 bits a texel, one
    /// texel per pixel of the pattern.
    pub fn plain_map_bytes(&self) -> u64 {
        let side = |texels: u32| u64::from(texels) * u64::from(self.map_options.reduction);
        side(self.map.width()) * side(self.map.height()) * 2
    }

    /// Returns whether the depth is anywhere less than asked for.
    pub fn reduces_depth(&self) -> bool {
        self.depth > f64::from(self.parameters.depth)
            || self
                .triangles
                .iter()
                .any(|triangle| triangle.depth_reductions != 0)
    }

    /// Returns whether rays are followed through prisms.
    pub fn has_prisms(&self) -> bool {
        self.parameters.search == SEARCH_PRISMS
    }
}
