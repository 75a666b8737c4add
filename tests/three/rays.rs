//! Rays of any camera and light through a prepared object, one facet after the other.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use relievo::prepare::{PreparedObject, PreparedScene};
use relievo_shared::facet;
use relievo_shared::intersection::{Camera, intersect};
use relievo_shared::model::{Quadric, Ray};

/// The only object of a scene, in its fast tier.
pub struct Rays<'a> {
    object: &'a PreparedObject,
    origin: DVec3,
}

/// A hit on the carved object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub class: u32,
    /// Distance from the ray's origin, world units.
    pub t: f64,
    pub normal: DVec3,
}

impl<'a> Rays<'a> {
    pub fn new(scene: &'a PreparedScene) -> Rays<'a> {
        let [object] = scene.objects.as_slice() else {
            panic!("there is one object");
        };
        assert!(object.placement.is_none());
        Rays {
            object,
            origin: scene.origin,
        }
    }

    /// Returns the nearest hit of each ray, given by its origin and its unit direction.
    pub fn cast(&self, rays: &[(DVec3, DVec3)]) -> Vec<Option<Hit>> {
        let cast = |(origin, direction): &(DVec3, DVec3)| {
            let direction = direction.as_vec3();
            let camera = Camera {
                forward: direction,
                right: Vec3::ZERO,
                down: Vec3::ZERO,
                near: 1e-6,
            };
            let frame = camera.frame((*origin - self.origin).as_vec3());
            let ray = Ray {
                frame: &frame,
                object: &self.object.parameters,
                direction,
            };
            let hits = self.object.triangles.iter().filter_map(|triangle| {
                let found = intersect::<Quadric, _, _>(&ray, triangle, self.object.map.words());
                (found.class != 0).then(|| Hit {
                    class: found.class,
                    t: f64::from(found.t),
                    normal: found.normal.as_dvec3(),
                })
            });
            hits.min_by(|a, b| a.t.total_cmp(&b.t))
        };
        rays.par_iter().map(cast).collect()
    }

    /// Returns whether each ray hits the mesh, whatever is carved there.
    pub fn meet_mesh(&self, rays: &[(DVec3, DVec3)]) -> Vec<bool> {
        let meets = |(origin, direction): &(DVec3, DVec3)| {
            let eye = (*origin - self.origin).as_vec3();
            self.object
                .triangles
                .iter()
                .any(|triangle| facet::intersect(eye, direction.as_vec3(), triangle).hit)
        };
        rays.par_iter().map(meets).collect()
    }
}

/// A box along the axes.
pub struct Cuboid {
    pub centre: DVec3,
    pub size: DVec3,
}

impl Cuboid {
    /// Returns the distance at which a ray from outside enters.
    pub fn cast(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let [low, high] = [-0.5, 0.5].map(|side| self.centre + side * self.size - origin);
        let (a, b) = (low / direction, high / direction);
        let enter = a.min(b).max_element();
        let leave = a.max(b).min_element();
        (enter < leave && enter > 0.0).then_some(enter)
    }
}
