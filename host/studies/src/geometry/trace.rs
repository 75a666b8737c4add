//! Draws a [`Carving`] on the CPU: a wide hierarchy finds the triangle of each ray.

use super::carve::Carving;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use relievo::render::{ColorWords, GeometryWords};
use relievo_shared::camera::pixel_ray;
use relievo_shared::layout::{Frame, Object};
use relievo_shared::light::shade;
use std::time::Duration;

/// Draws triangles on the CPU.
pub struct Tracer<'a> {
    carving: &'a Carving,
    object: &'a Object,
    triangles: Vec<Triangle>,
    hierarchy: CwBvh,
}

/// What a ray hits.
struct Hit {
    t: f32,
    class: u32,
    normal: Vec3,
}

impl<'a> Tracer<'a> {
    /// Builds the hierarchy of `carving`, whose colours are those of `object`.
    pub fn new(carving: &'a Carving, object: &'a Object) -> Tracer<'a> {
        let triangles: Vec<Triangle> = carving
            .indices
            .par_chunks_exact(3)
            .map(|corners| {
                let at = |i: usize| Vec3A::from(carving.vertices[corners[i] as usize].position);
                let [v0, v1, v2] = [at(0), at(1), at(2)];
                Triangle { v0, v1, v2 }
            })
            .collect();
        let parameters = BvhBuildParams::medium_build();
        Tracer {
            hierarchy: build_cwbvh_from_tris(&triangles, parameters, &mut Duration::default()),
            carving,
            object,
            triangles,
        }
    }

    fn hit(&self, eye: Vec3A, direction: Vec3) -> Option<Hit> {
        let ray = Ray::new_inf(eye, direction.into());
        let mut hit = RayHit::none();
        let found = self.hierarchy.ray_traverse(ray, &mut hit, |ray, number| {
            self.triangles[self.hierarchy.primitive_indices[number] as usize].intersect(ray)
        });
        if !found {
            return None;
        }
        let number = self.hierarchy.primitive_indices[hit.primitive_id as usize] as usize;
        let corners = &self.carving.indices[3 * number..3 * number + 3];
        let vertices = [0, 1, 2].map(|i| &self.carving.vertices[corners[i] as usize]);
        let Triangle { v0, v1, v2 } = self.triangles[number];
        // Barycentrics by areas.
        let point = eye + hit.t * Vec3A::from(direction);
        let (first, second) = (v1 - v0, v2 - v0);
        let normal = first.cross(second);
        let scale = 1.0 / normal.length_squared();
        let w1 = (point - v0).cross(second).dot(normal) * scale;
        let w2 = first.cross(point - v0).dot(normal) * scale;
        let [n0, n1, n2] = vertices.map(|vertex| Vec3::from(vertex.normal.map(f32::from)));
        Some(Hit {
            t: hit.t,
            class: u32::from(vertices[0].class),
            normal: (n0 * (1.0 - w1 - w2) + n1 * w1 + n2 * w2).normalize_or_zero(),
        })
    }

    /// Calls `word` for the hit of each pixel, with its direction.
    fn pixels<T: Send>(
        &self,
        frame: &Frame,
        word: impl Fn(Vec3, Option<Hit>) -> T + Sync,
    ) -> Vec<T> {
        let [width, height] = frame.size.map(|side| side as u32);
        let eye = Vec3A::from(frame.eye);
        (0..width * height)
            .into_par_iter()
            .with_min_len(width as usize)
            .map(|i| {
                let direction = pixel_ray(frame, i % width, i / width);
                word(direction, self.hit(eye, direction))
            })
            .collect()
    }

    /// Draws the colours of `frame`.
    pub fn color(&self, frame: &Frame) -> ColorWords {
        let words = self.pixels(frame, |direction, hit| match hit {
            Some(Hit { class, normal, .. }) => {
                let color = shade(frame, self.object, class, normal, direction, true);
                let [r, g, b] = color.to_array().map(f32::to_bits);
                [r, g, b, class]
            }
            None => [0; 4],
        });
        let [width, height] = frame.size.map(|side| side as u32);
        ColorWords {
            width,
            height,
            words,
        }
    }

    /// Draws distances and classes of `frame`; the other words are 0.
    pub fn geometry(&self, frame: &Frame) -> GeometryWords {
        let hits = self.pixels(frame, |_, hit| match hit {
            Some(Hit { t, class, .. }) => ([t.to_bits(), 0, 0, 0], [class, 0, 0, 0]),
            None => ([0; 4], [0; 4]),
        });
        let (place, surface) = hits.into_iter().unzip();
        let [width, height] = frame.size.map(|side| side as u32);
        GeometryWords {
            width,
            height,
            place,
            surface,
        }
    }
}
