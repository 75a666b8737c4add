//! The renderer on the CPU: a bounding volume hierarchy finds the facets that the rays of a
//! tile of pixels may meet, and the shared code traces them. Rows of tiles are rendered in
//! parallel.
//!
//! ```
//! use relievo::prepare::prepare;
//! use relievo::render::{CpuRenderer, Renderer};
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! image.size = [40, 30]
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let mut renderer = CpuRenderer::new(&prepared);
//! let colors = renderer.color(&prepared.frame)?;
//! assert_eq!(colors.words.len(), 40 * 30);
//! # Ok::<(), relievo::Error>(())
//! ```

use super::error::{RenderError, allocate};
use super::found::Found;
use super::tile::{PIXELS, SIDE, Tile, for_each};
use super::words::{ColorWords, GeometryWords};
use super::{Renderer, background_words};
use crate::hierarchy;
use crate::prepare::{PreparedObject, PreparedScene};
use glam::{UVec4, Vec2, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ray::RayHit;
use rayon::prelude::*;
use relievo_shared::exit::{self, Exit, KnownExit};
use relievo_shared::facet::{FacetHit, intersect, may_surround_eye};
use relievo_shared::layout::{Frame, PrismData};
use relievo_shared::model::{Ray, over_triangle};
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::outline::{Rectangle, bounding_rectangle, prism_outline};
use relievo_shared::prism::{cap_hull, is_near, is_open, normal_hull};
use relievo_shared::trace::{class_and_steps, word};
use std::ops::Add;

/// Renders one scene on the CPU.
pub struct CpuRenderer<'a> {
    scene: &'a PreparedScene,
    bvh: Bvh2,
    /// Object and triangle of each leaf of the hierarchy, in its order.
    leaves: Vec<[u32; 2]>,
    /// Maximum distance of the eye from the origin that the boxes are wide enough
    /// for.
    reach: f32,
    /// Maximum distance by which a ray may meet what a box holds before the box,
    /// object units; infinite if it is not known.
    early: f32,
    /// Object and index of each prism or triangle whose shell may contain the eye.
    around_eye: Vec<[u32; 2]>,
    /// Whether rays ask for their exits.
    asks_for_exits: bool,
}

/// The nearest hit on a ray.
#[derive(Clone, Copy)]
struct Nearest<'a> {
    object: &'a PreparedObject,
    found: Found,
    /// Index of the object, and of its triangle.
    order: [u32; 2],
}

/// What the rays of a tile hit, and space for the search.
struct TileHits<'a> {
    nearest: [Option<Nearest<'a>>; PIXELS],
    /// The exits of the rays: their words, or zeros.
    exits: [UVec4; PIXELS],
    /// Nodes of the hierarchy still to visit, with their least distance from the eye.
    stack: Vec<(f32, u32)>,
}

impl TileHits<'_> {
    fn new() -> Self {
        TileHits {
            nearest: [None; PIXELS],
            exits: [UVec4::ZERO; PIXELS],
            stack: Vec::new(),
        }
    }
}

/// Work of the rays of a frame that hit something.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayStatistics {
    /// Number of rays.
    pub hits: u64,
    /// Steps of their linear searches.
    pub steps: u64,
    /// Prisms that they crossed; 0 unless the tier is accurate.
    pub prisms: u64,
}

impl Add for RayStatistics {
    type Output = RayStatistics;

    fn add(self, other: RayStatistics) -> RayStatistics {
        RayStatistics {
            hits: self.hits + other.hits,
            steps: self.steps + other.steps,
            prisms: self.prisms + other.prisms,
        }
    }
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
            early: earliest_entry(scene),
            around_eye: Vec::new(),
            asks_for_exits: scene
                .objects
                .iter()
                .any(|object| object.parameters.number != 0),
        }
    }

    /// As [`CpuRenderer::new`], ready for [`CpuRenderer::object_at`] of `frame`.
    pub(super) fn at(scene: &'a PreparedScene, frame: &Frame) -> CpuRenderer<'a> {
        let mut renderer = CpuRenderer::new(scene);
        renderer.reach_for(frame);
        renderer
    }

    /// Returns the index of the object that pixel (`x`, `y`) of `frame` shows.
    pub(super) fn object_at(&self, frame: &Frame, x: u32, y: u32) -> Option<usize> {
        let mut hits = TileHits::new();
        self.search(frame, &Tile::new(frame, x as usize, y as usize), &mut hits);
        hits.nearest[0].map(|nearest| nearest.order[0] as usize)
    }

    /// Makes the boxes wide enough for the eye of `frame`, and finds the prisms
    /// and triangles around it.
    fn reach_for(&mut self, frame: &Frame) {
        let eye = Vec3::from(frame.eye);
        self.around_eye.clear();
        for (i, object) in self.scene.objects.iter().enumerate() {
            let order = |(j, is_near): (usize, bool)| is_near.then_some([i as u32, j as u32]);
            if object.has_prisms() {
                let prisms = object.prisms.par_iter();
                let near = prisms.map(|prism| is_near(prism, eye - Vec3::from(prism.anchor)));
                let near = near.enumerate().filter_map(order);
                self.around_eye.par_extend(near);
            } else {
                let triangles = object.triangles.par_iter();
                let near =
                    triangles.map(|triangle| may_surround_eye(frame, &object.parameters, triangle));
                let near = near.enumerate().filter_map(order);
                self.around_eye.par_extend(near);
            }
        }
        let distance = eye.abs().max_element();
        if distance > self.reach {
            self.reach = 2.0 * distance;
            (self.bvh, self.leaves) = build(self.scene, self.reach);
        }
    }

    /// Finds the nearest hits on the rays of `tile`.
    fn search(&self, frame: &Frame, tile: &Tile, hits: &mut TileHits<'a>) {
        hits.nearest = [None; PIXELS];
        let mut stack = std::mem::take(&mut hits.stack);
        if self.asks_for_exits {
            hits.exits = self.exits(frame, tile, &mut stack);
        }
        for &order in &self.around_eye {
            self.consider(frame, tile, order, None, hits);
        }
        self.visit_tile(tile, &mut stack, |order, distance| {
            self.consider(frame, tile, order, Some(distance), hits);
        });
        hits.stack = stack;
    }

    /// Traces the rays of `tile` over a facet at least `distance` away from the eye; `None` if
    /// it may surround the eye.
    #[inline]
    fn consider(
        &self,
        frame: &Frame,
        tile: &Tile,
        order: [u32; 2],
        distance: Option<f32>,
        hits: &mut TileHits<'a>,
    ) {
        let object = &self.scene.objects[order[0] as usize];
        let pixels = if object.has_prisms() {
            let prism = &object.prisms[order[1] as usize];
            tile.within(&prism_outline(frame, &object.parameters, prism))
        } else {
            let triangle = &object.triangles[order[1] as usize];
            let rectangle = if distance.is_some() {
                bounding_rectangle(frame, triangle)
            } else {
                EVERYTHING
            };
            tile.which(&rectangle, |direction| {
                intersect(frame.eye.into(), direction, triangle).hit
            })
        };
        let slack = self.early + ROUNDING * self.reach;
        for_each(pixels, |i| {
            let nearest = &mut hits.nearest[i];
            let mut best = 0.0;
            if let Some(nearest) = nearest {
                let hit = nearest.found.hit();
                if distance.is_some_and(|distance| distance > hit.t * (1.0 + ROUNDING) + slack) {
                    return;
                }
                best = hit.depth;
            }
            let ray = object_ray(object, frame, tile.direction(i));
            let exit = KnownExit(hits.exits[i]);
            let Some(found) = Found::new(&ray, object, order[1], best, &exit) else {
                return;
            };
            let hit = found.hit();
            // At equal depth the first in drawing order wins, as on a GPU.
            let wins = hit.class != CLASS_MISS
                && match &*nearest {
                    None => hit.depth > 0.0,
                    Some(nearest) => {
                        hit.depth > best || (hit.depth == best && order < nearest.order)
                    }
                };
            if wins {
                *nearest = Some(Nearest {
                    object,
                    found,
                    order,
                });
            }
        });
    }

    /// Calls `visit` with what the rays of `tile` may meet, and its least distance from the
    /// eye; roughly from near to far.
    #[inline]
    fn visit_tile(
        &self,
        tile: &Tile,
        stack: &mut Vec<(f32, u32)>,
        mut visit: impl FnMut([u32; 2], f32),
    ) {
        let nodes = &self.bvh.nodes;
        let entry = |index: u32| Some((tile.nearest(nodes[index as usize].aabb())?, index));
        stack.clear();
        stack.extend((!nodes.is_empty()).then(|| entry(0)).flatten());
        while let Some((distance, index)) = stack.pop() {
            let node = &nodes[index as usize];
            let first = node.first_index;
            if node.is_leaf() {
                for leaf in first..first + node.prim_count {
                    visit(self.leaves[leaf as usize], distance);
                }
                continue;
            }
            let (left, right) = (entry(first), entry(first + 1));
            // The last one is visited first.
            if left < right {
                stack.extend(right.into_iter().chain(left));
            } else {
                stack.extend(left.into_iter().chain(right));
            }
        }
    }

    /// Calls `visit` with what the ray of `frame` along `direction` may meet, near boxes
    /// first. `visit` returns the distance of the nearest hit so far: boxes that start more
    /// than `early` behind it are left out.
    fn visit(
        &self,
        frame: &Frame,
        direction: Vec3,
        early: f32,
        mut visit: impl FnMut([u32; 2]) -> Option<f32>,
    ) {
        let ray = obvhs::ray::Ray::new_inf(Vec3A::from(frame.eye), Vec3A::from(direction));
        let slack = early + ROUNDING * self.reach;
        self.bvh.ray_traverse(ray, &mut RayHit::none(), |_, leaf| {
            visit(self.leaves[leaf]).map_or(f32::INFINITY, |t| t * (1.0 + ROUNDING) + slack)
        });
    }

    /// Finds the exits of the rays of `tile`: their words, or zeros.
    fn exits(&self, frame: &Frame, tile: &Tile, stack: &mut Vec<(f32, u32)>) -> [UVec4; PIXELS] {
        let mut nearest: [Option<([u32; 2], FacetHit, f32)>; PIXELS] = [None; PIXELS];
        self.visit_tile(tile, stack, |order, _| {
            let object = &self.scene.objects[order[0] as usize];
            if object.parameters.number == 0 {
                return;
            }
            let triangle = &object.triangles[order[1] as usize];
            let behind = exit::reversed(triangle);
            let pixels = tile.which(&bounding_rectangle(frame, &behind), |direction| {
                intersect(frame.eye.into(), direction, &behind).hit
            });
            for_each(pixels, |i| {
                let (facet, depth) = exit::meet(frame, tile.direction(i), triangle);
                // At equal depth the first in drawing order wins, as on a GPU.
                let is_nearer = nearest[i].is_none_or(|(found, _, best)| {
                    depth > best || (depth == best && order < found)
                });
                if facet.hit && is_nearer {
                    nearest[i] = Some((order, facet, depth));
                }
            });
        });
        std::array::from_fn(|i| {
            nearest[i].map_or(UVec4::ZERO, |([object, triangle], facet, _)| {
                let object = &self.scene.objects[object as usize];
                let triangle = &object.triangles[triangle as usize];
                let parameters = &object.parameters;
                Exit::new(parameters, tile.direction(i), triangle, &facet).words(parameters)
            })
        })
    }

    /// Finds the first front-facing triangle on the ray of `frame` along
    /// `direction`: index of its object, its own index, and the hit. Objects must
    /// not have prisms.
    pub(crate) fn first_facet(
        &self,
        frame: &Frame,
        direction: Vec3,
    ) -> Option<([u32; 2], FacetHit)> {
        let mut nearest: Option<([u32; 2], FacetHit)> = None;
        self.visit(frame, direction, 0.0, |order| {
            let object = &self.scene.objects[order[0] as usize];
            let ray = object_ray(object, frame, direction);
            let facet = over_triangle::meet(&ray, &object.triangles[order[1] as usize]);
            let is_nearer = nearest.as_ref().is_none_or(|(_, found)| facet.t < found.t);
            if facet.hit && facet.t > 0.0 && is_nearer {
                nearest = Some((order, facet));
            }
            nearest.as_ref().map(|(_, facet)| facet.t)
        });
        nearest
    }

    /// Counts the work of the rays of `frame`.
    pub fn statistics(&mut self, frame: &Frame) -> RayStatistics {
        self.reach_for(frame);
        let rows = (0..(frame.size[1] as usize).div_ceil(SIDE)).into_par_iter();
        let work = rows.map_init(TileHits::new, |hits, row| {
            let mut work = RayStatistics::default();
            self.search_row(frame, row, hits, |_, _, nearest| {
                work = work
                    + RayStatistics {
                        hits: 1,
                        steps: nearest.found.hit().steps.into(),
                        prisms: nearest.found.prisms().into(),
                    };
            });
            work
        });
        work.reduce(RayStatistics::default, RayStatistics::add)
    }

    /// Calls `shade` for each of `pixels` with a hit, rows of tiles in parallel.
    fn for_each_pixel<T: Send>(
        &self,
        frame: &Frame,
        pixels: &mut [T],
        shade: impl Fn(&mut T, Vec3, &Nearest<'a>) + Sync,
    ) {
        let rows = pixels.par_chunks_mut(frame.size[0] as usize * SIDE);
        let rows = rows.enumerate();
        rows.for_each_init(TileHits::new, |hits, (row, pixels)| {
            self.search_row(frame, row, hits, |i, direction, nearest| {
                shade(&mut pixels[i], direction, nearest);
            });
        });
    }

    /// Calls `visit` for each hit in row `row` of the tiles: with the index of its pixel in
    /// the row of tiles, and its direction.
    fn search_row(
        &self,
        frame: &Frame,
        row: usize,
        hits: &mut TileHits<'a>,
        mut visit: impl FnMut(usize, Vec3, &Nearest<'a>),
    ) {
        let width = frame.size[0] as usize;
        for x in (0..width).step_by(SIDE) {
            let tile = Tile::new(frame, x, row * SIDE);
            self.search(frame, &tile, hits);
            for (i, nearest) in hits.nearest.iter().enumerate() {
                if let Some(nearest) = nearest {
                    visit(i / SIDE * width + x + i % SIDE, tile.direction(i), nearest);
                }
            }
        }
    }
}

/// The ray along `direction` as it is traced through `object`.
fn object_ray<'a>(object: &'a PreparedObject, frame: &'a Frame, direction: Vec3) -> Ray<'a> {
    Ray {
        frame,
        object: &object.parameters,
        direction,
    }
}

/// The whole picture.
const EVERYTHING: Rectangle = Rectangle {
    low: Vec2::NEG_ONE,
    high: Vec2::ONE,
};

/// Bound of the relative rounding errors of a box test and of a hit.
const ROUNDING: f32 = 1e-5;

/// Returns the maximum distance by which a ray may enter a shell before the box of what it
/// enters through, object units. Rays that enter through triangles do so where the quadric
/// of the surface is, which has no bound.
fn earliest_entry(scene: &PreparedScene) -> f32 {
    let objects = scene.objects.iter();
    let entries = objects.map(|object| {
        if !object.has_prisms() {
            return f32::INFINITY;
        }
        // Rays may enter up to 0.01, in weights, beyond the sides: well below a tenth of the
        // radius.
        let radii = object.prisms.iter().map(|prism| 0.1 * prism.radius);
        radii.fold(0.0, f32::max)
    });
    entries.fold(0.0, f32::max)
}

/// Builds the hierarchy over all triangles of `scene`, and returns it with the
/// object and triangle of each leaf. The boxes are wider than the triangles by
/// more than the rounding errors of the box test and of the triangle test for
/// an eye within `reach`, so that the shared triangle test alone decides.
fn build(scene: &PreparedScene, reach: f32) -> (Bvh2, Vec<[u32; 2]>) {
    let mut leaves = Vec::with_capacity(scene.triangle_count());
    let mut boxes = Vec::with_capacity(scene.triangle_count());
    for (i, object) in scene.objects.iter().enumerate() {
        let bounds: &mut dyn Iterator<Item = (Vec3, Vec3)> = if object.has_prisms() {
            let depth = object.parameters.depth;
            &mut object
                .prisms
                .iter()
                .map(move |prism| prism_bounds(prism, depth))
        } else {
            &mut object.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.corners.map(|corner| Vec3::from(corner.position));
                (a.min(b).min(c), a.max(b).max(c))
            })
        };
        for (j, (low, high)) in bounds.enumerate() {
            let largest = low.abs().max(high.abs()).max_element().max(reach);
            let margin = Vec3::splat(4e-6 * largest);
            boxes.push(Aabb::new((low - margin).into(), (high + margin).into()));
            leaves.push([i as u32, j as u32]);
        }
    }
    let bvh = hierarchy::build(&boxes);
    let leaves = bvh
        .primitive_indices
        .iter()
        .map(|&index| leaves[index as usize])
        .collect();
    (bvh, leaves)
}

/// Returns the bounding box of the faces through which a ray may enter a prism
/// from outside.
fn prism_bounds(data: &PrismData, depth: f32) -> (Vec3, Vec3) {
    let cap = cap_hull(data);
    let mut low = cap.into_iter().fold(cap[0], Vec3::min);
    let mut high = cap.into_iter().fold(cap[0], Vec3::max);
    if is_open(data) {
        for (point, normal) in cap.into_iter().zip(normal_hull(data)) {
            let floor = point - normal * depth;
            low = low.min(floor);
            high = high.max(floor);
        }
    }
    // Rays may enter slightly beyond the sides.
    let margin = Vec3::splat(1e-3 * (high - low).max_element());
    let anchor = Vec3::from(data.anchor);
    (anchor + low - margin, anchor + high + margin)
}

impl Nearest<'_> {
    fn normal(&self, frame: &Frame, direction: Vec3) -> Vec3 {
        let ray = object_ray(self.object, frame, direction);
        self.found.normal(&ray, self.object, self.order[1])
    }

    fn color(&self, frame: &Frame, direction: Vec3) -> Vec3 {
        let ray = object_ray(self.object, frame, direction);
        self.found.color(&ray, self.object, self.order[1])
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
                word(rgb.x),
                word(rgb.y),
                word(rgb.z),
                nearest.found.hit().class,
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
            let hit = nearest.found.hit();
            let normal = nearest.normal(frame, direction);
            *pixel = (
                [hit.t, hit.uv.x, hit.uv.y, hit.depth_fraction].map(word),
                [
                    class_and_steps(hit),
                    word(normal.x),
                    word(normal.y),
                    word(normal.z),
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
