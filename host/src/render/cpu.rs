//! The renderer on the CPU: a bounding volume hierarchy finds the triangles on
//! a pixel's ray, and the shared code does the rest, rows in parallel.

use super::{ColorWords, GeometryWords, RenderError, Renderer, allocate, background_words};
use crate::prepare::PreparedScene;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::Ray;
use rayon::prelude::*;
use relievo_shared::camera::{pixel_ray, reversed_depth};
use relievo_shared::fragment::{self, Entry, Hit};
use relievo_shared::layout::{Frame, Object, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_RELIEF};
use relievo_shared::normals::CLASS_MISS;
use std::time::Duration;

/// Renders one scene on the CPU.
pub struct CpuRenderer<'a> {
    scene: &'a PreparedScene,
    bvh: Bvh2,
    /// Object and triangle of each leaf of the hierarchy, in its order.
    leaves: Vec<[u32; 2]>,
    /// The largest distance of an eye from the origin for which the boxes are wide enough.
    reach: f32,
}

/// The nearest hit on a ray and what it belongs to.
struct Nearest<'a> {
    object: &'a Object,
    texels: &'a [u32],
    entry: Entry,
    hit: Hit,
    order: [u32; 2],
}

impl<'a> CpuRenderer<'a> {
    /// Builds the hierarchy over all triangles of `scene`.
    pub fn new(scene: &'a PreparedScene) -> CpuRenderer<'a> {
        let reach = 2.0 * Vec3::from(scene.frame.eye).abs().max_element();
        let (bvh, leaves) = build(scene, reach);
        CpuRenderer {
            scene,
            bvh,
            leaves,
            reach,
        }
    }

    /// Makes the boxes wide enough for the eye of `frame`.
    fn reach_for(&mut self, frame: &Frame) {
        let distance = Vec3::from(frame.eye).abs().max_element();
        if distance > self.reach {
            self.reach = 2.0 * distance;
            (self.bvh, self.leaves) = build(self.scene, self.reach);
        }
    }

    /// The nearest hit of the ray along `direction`.
    fn nearest(&self, frame: &Frame, direction: Vec3) -> Option<Nearest<'a>> {
        let mut nearest: Option<Nearest<'a>> = None;
        let ray = Ray::new_inf(Vec3A::from(frame.eye), Vec3A::from(direction));
        self.bvh.ray_traverse_anyhit(ray, |_, leaf| {
            let order = self.leaves[leaf];
            let object = &self.scene.objects[order[0] as usize];
            let triangle = &object.triangles[order[1] as usize];
            let facet = fragment::meet(frame, triangle, direction);
            if !facet.hit {
                return;
            }
            let entry = fragment::enter(&object.parameters, triangle, direction, &facet);
            if !entry.path.enters {
                return;
            }
            // Nothing behind the entry can be nearer than the entry.
            let best = nearest.as_ref().map_or(0.0, |nearest| nearest.hit.depth);
            if reversed_depth(frame, direction, entry.path.entry_t) < best {
                return;
            }
            let texels = object.map.words();
            let trace = match object.parameters.search {
                SEARCH_PAPER => fragment::trace::<SEARCH_PAPER, [u32]>,
                SEARCH_RELIEF => fragment::trace::<SEARCH_RELIEF, [u32]>,
                _ => fragment::trace::<SEARCH_EXTRUSION, [u32]>,
            };
            let hit = trace(frame, &object.parameters, texels, direction, &entry);
            // The order of drawing decides between equal depths, as on a GPU.
            let wins = match &nearest {
                _ if hit.class == CLASS_MISS => false,
                None => hit.depth > 0.0,
                Some(nearest) => {
                    hit.depth > nearest.hit.depth
                        || (hit.depth == nearest.hit.depth && order < nearest.order)
                }
            };
            if wins {
                nearest = Some(Nearest {
                    object: &object.parameters,
                    texels,
                    entry,
                    hit,
                    order,
                });
            }
        });
        nearest
    }

    /// Fills `pixels` with what `shade` makes of the nearest hits, rows in parallel.
    fn for_each_pixel<T: Send>(
        &self,
        frame: &Frame,
        pixels: &mut [T],
        shade: impl Fn(&mut T, Vec3, &Nearest<'a>) + Sync,
    ) {
        let width = frame.size[0] as usize;
        pixels
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    let direction = pixel_ray(frame, x as u32, y as u32);
                    if let Some(nearest) = self.nearest(frame, direction) {
                        shade(pixel, direction, &nearest);
                    }
                }
            });
    }
}

/// The hierarchy over all triangles of `scene`, and what its leaves are. The
/// boxes are wider than the triangles by more than the rounding errors of the
/// box test and of the triangle test from an eye within `reach`, so that the
/// shared triangle test alone decides what is hit.
fn build(scene: &PreparedScene, reach: f32) -> (Bvh2, Vec<[u32; 2]>) {
    let mut leaves = Vec::with_capacity(scene.triangle_count());
    let mut boxes = Vec::with_capacity(scene.triangle_count());
    for (i, object) in scene.objects.iter().enumerate() {
        for (j, triangle) in object.triangles.iter().enumerate() {
            let [a, b, c] = triangle.corners.map(|corner| Vec3::from(corner.position));
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let largest = low.abs().max(high.abs()).max_element().max(reach);
            let margin = Vec3::splat(4e-6 * largest);
            boxes.push(Aabb::new((low - margin).into(), (high + margin).into()));
            leaves.push([i as u32, j as u32]);
        }
    }
    let bvh = build_bvh2(
        &boxes,
        BvhBuildParams::medium_build(),
        &mut Duration::default(),
    );
    let leaves = bvh
        .primitive_indices
        .iter()
        .map(|&index| leaves[index as usize])
        .collect();
    (bvh, leaves)
}

impl Nearest<'_> {
    fn normal(&self, direction: Vec3) -> Vec3 {
        fragment::normals(self.object, self.texels, direction, &self.entry, &self.hit).carved
    }

    fn color(&self, frame: &Frame, direction: Vec3) -> Vec3 {
        let Nearest {
            object,
            texels,
            entry,
            hit,
            ..
        } = self;
        let color = if object.self_shadow != 0 {
            fragment::color::<true, [u32]>
        } else {
            fragment::color::<false, [u32]>
        };
        color(frame, object, texels, direction, entry, hit)
    }
}

impl Renderer for CpuRenderer<'_> {
    fn name(&self) -> String {
        format!("CPU ({} threads)", rayon::current_num_threads())
    }

    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError> {
        self.reach_for(frame);
        let [width, height] = frame.size.map(|side| side as u32);
        let count = width as usize * height as usize;
        let mut words = allocate("the picture", count, background_words(self.scene))?;
        self.for_each_pixel(frame, &mut words, |pixel, direction, nearest| {
            let rgb = nearest.color(frame, direction);
            *pixel = [
                fragment::word(rgb.x),
                fragment::word(rgb.y),
                fragment::word(rgb.z),
                nearest.hit.class,
            ];
        });
        Ok(ColorWords {
            width,
            height,
            words,
        })
    }

    fn geometry(&mut self, frame: &Frame) -> Result<GeometryWords, RenderError> {
        self.reach_for(frame);
        let [width, height] = frame.size.map(|side| side as u32);
        let count = width as usize * height as usize;
        let mut both = allocate("the picture's geometry", count, ([0; 4], [0; 4]))?;
        self.for_each_pixel(frame, &mut both, |pixel, direction, nearest| {
            let hit = &nearest.hit;
            let normal = nearest.normal(direction);
            *pixel = (
                [hit.t, hit.uv.x, hit.uv.y, hit.depth_fraction].map(fragment::word),
                [
                    fragment::class_and_steps(hit),
                    fragment::word(normal.x),
                    fragment::word(normal.y),
                    fragment::word(normal.z),
                ],
            );
        });
        let mut place = allocate("the picture's geometry", count, [0; 4])?;
        let mut surface = allocate("the picture's geometry", count, [0; 4])?;
        for (i, (hit_place, hit_surface)) in both.into_iter().enumerate() {
            place[i] = hit_place;
            surface[i] = hit_surface;
        }
        Ok(GeometryWords {
            width,
            height,
            place,
            surface,
        })
    }
}
