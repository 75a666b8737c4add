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
use super::placed::Placed;
use super::shading::shade;
use super::space::{ROUNDING, Space};
use super::tile::{PIXELS, SIDE, Tile, for_each, visit_tile};
use super::words::{ColorWords, GeometryWords};
use super::{Renderer, background_words};
use crate::prepare::{PreparedLighting, PreparedObject, PreparedScene};
use glam::{UVec4, Vec2, Vec3, Vec3A};
use obvhs::ray::RayHit;
use rayon::prelude::*;
use relievo_shared::camera::pixel_ray;
use relievo_shared::exit::{self, Exit, KnownExit};
use relievo_shared::facet::{FacetHit, intersect, may_surround_eye};
use relievo_shared::layout::Frame;
use relievo_shared::model::{Ray, over_triangle};
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::outline::{Rectangle, bounding_rectangle, prism_outline};
use relievo_shared::prism::is_near;
use relievo_shared::trace;
use std::ops::Add;

/// Renders one scene on the CPU.
pub struct CpuRenderer<'a> {
    scene: &'a PreparedScene,
    /// The objects without a placement.
    world: Space<'a>,
    /// The objects with one.
    placed: Placed<'a>,
    /// Object and index of each prism or triangle whose shell may contain the eye.
    around_eye: Vec<[u32; 2]>,
    /// Whether rays ask for their exits.
    asks_for_exits: bool,
    /// The words of the shadow maps; empty until colours are asked for.
    shadows: Vec<u32>,
    /// Whether rays that show only the mean of a pattern are not marched.
    shows_means: bool,
}

/// The nearest hit on a ray.
#[derive(Clone, Copy)]
struct Nearest<'a> {
    object: &'a PreparedObject,
    found: Found,
    /// Distance, world units.
    t: f32,
    /// Index of the object, and of its triangle.
    order: [u32; 2],
}

/// What the rays of a tile hit, and space for the search.
struct TileHits<'a> {
    nearest: [Option<Nearest<'a>>; PIXELS],
    /// The exits of the rays: their words, or zeros.
    exits: [UVec4; PIXELS],
    stacks: Stacks,
}

/// Nodes still to visit, with their least distance from the eye: of the hierarchy of a
/// space, and of that over the placed objects.
#[derive(Default)]
struct Stacks {
    space: Vec<(f32, u32)>,
    placed: Vec<(f32, u32)>,
}

impl TileHits<'_> {
    fn new() -> Self {
        TileHits {
            nearest: [None; PIXELS],
            exits: [UVec4::ZERO; PIXELS],
            stacks: Stacks::default(),
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
    /// Builds the hierarchies over all triangles of `scene`.
    pub fn new(scene: &'a PreparedScene) -> CpuRenderer<'a> {
        let reach = 2.0 * Vec3::from(scene.frame.eye).abs().max_element();
        let objects = (0..).zip(&scene.objects);
        let world = objects.filter(|(_, object)| object.placement.is_none());
        CpuRenderer {
            scene,
            world: Space::new(world.collect(), reach),
            placed: Placed::new(scene),
            around_eye: Vec::new(),
            asks_for_exits: scene
                .objects
                .iter()
                .any(|object| object.parameters.number != 0),
            shadows: Vec::new(),
            shows_means: false,
        }
    }

    /// Returns the index of the object that each pixel of `frame` shows, rows from the top;
    /// [`NO_OBJECT`] for a miss.
    pub(super) fn objects(&mut self, frame: &Frame) -> Vec<u32> {
        self.reach_for(frame);
        let count = frame.size[0] as usize * frame.size[1] as usize;
        let mut objects = vec![NO_OBJECT; count];
        self.for_each_pixel(frame, &mut objects, |object, _, nearest| {
            *object = nearest.order[0];
        });
        objects
    }

    /// Renders the colours of a scene that is lit physically.
    fn lit(
        &mut self,
        frame: &Frame,
        lighting: &PreparedLighting,
    ) -> Result<ColorWords, RenderError> {
        self.shows_means = true;
        let hits = self.lit_hits(frame, lighting);
        self.shows_means = false;
        shade(frame, lighting, &self.shadows, &hits?)
    }

    /// Renders the shadow maps, if that has not been done, and the G-buffer.
    fn lit_hits(
        &mut self,
        frame: &Frame,
        lighting: &PreparedLighting,
    ) -> Result<Vec<[UVec4; 2]>, RenderError> {
        if self.shadows.len() != lighting.shadow_words() {
            self.shadows = self.depths(lighting)?;
        }
        self.surface(frame)
    }

    /// Renders the shadow maps: reversed depths, one map after the other.
    fn depths(&mut self, lighting: &PreparedLighting) -> Result<Vec<u32>, RenderError> {
        let count = lighting.shadow_words();
        let mut depths = allocate("the shadow maps", count, 0)?;
        let mut rest = &mut depths[..];
        for frame in &lighting.shadow_frames {
            self.reach_for(frame);
            let count = frame.size[0] as usize * frame.size[1] as usize;
            let (map, others) = rest.split_at_mut(count);
            self.for_each_pixel(frame, map, |depth, _, nearest| {
                *depth = nearest.found.hit().depth.to_bits();
            });
            rest = others;
        }
        Ok(depths)
    }

    /// Renders the G-buffer: place and surface of each pixel.
    fn surface(&mut self, frame: &Frame) -> Result<Vec<[UVec4; 2]>, RenderError> {
        self.reach_for(frame);
        let count = frame.size[0] as usize * frame.size[1] as usize;
        let mut words = allocate("the picture's hits", count, [UVec4::ZERO; 2])?;
        self.for_each_pixel(frame, &mut words, |pixel, ray, nearest| {
            let found = &nearest.found;
            *pixel = found.surface(ray, nearest.object, nearest.order[1]).into();
        });
        Ok(words)
    }

    /// Makes the boxes wide enough for the eye of `frame`, and finds the prisms
    /// and triangles around it.
    fn reach_for(&mut self, frame: &Frame) {
        self.world
            .reach_for(Vec3::from(frame.eye).abs().max_element());
        self.placed.reach_for(self.scene, frame);
        self.around_eye.clear();
        let depths = self.scene.objects.iter();
        let depths = depths.map(|object| object.parameters.depth);
        let depth = depths.fold(0.0, f32::max);
        let mut near = std::mem::take(&mut self.around_eye);
        self.world.around_eye(frame, depth, |order| {
            near.extend(self.may_surround_eye(frame, order));
        });
        for &object in &self.placed.objects {
            let frame = self.placed.frame(frame, object);
            let depth = self.scene.objects[object as usize].parameters.depth;
            let space = self.placed.space(object);
            space.around_eye(frame, depth, |[_, facet]| {
                near.extend(self.may_surround_eye(frame, [object, facet]));
            });
        }
        near.sort_unstable();
        self.around_eye = near;
    }

    /// Returns `order`, object and facet, if its shell may contain the eye of `frame`.
    fn may_surround_eye(&self, frame: &Frame, order: [u32; 2]) -> Option<[u32; 2]> {
        let [object, facet] = order;
        let object = &self.scene.objects[object as usize];
        let may = if object.has_prisms() {
            let prism = &object.prisms[facet as usize];
            is_near(prism, Vec3::from(frame.eye) - Vec3::from(prism.anchor))
        } else {
            may_surround_eye(frame, &object.parameters, &object.triangles[facet as usize])
        };
        may.then_some(order)
    }

    /// Finds the nearest hits on the rays of `tile`.
    fn search(&self, frame: &Frame, tile: &Tile, hits: &mut TileHits<'a>) {
        hits.nearest = [None; PIXELS];
        let mut stacks = std::mem::take(&mut hits.stacks);
        if self.asks_for_exits {
            hits.exits = self.exits(frame, tile, &mut stacks);
        }
        let mut own: Option<(u32, Tile)> = None;
        for &order in &self.around_eye {
            if self.scene.objects[order[0] as usize].placement.is_none() {
                self.consider(frame, tile, order, None, hits);
                continue;
            }
            let frame = self.placed.frame(frame, order[0]);
            if own.as_ref().is_none_or(|(object, _)| *object != order[0]) {
                own = Some((order[0], tile.seen_from(frame)));
            }
            if let Some((_, tile)) = &own {
                self.consider(frame, tile, order, None, hits);
            }
        }
        self.for_each_facet(frame, tile, &mut stacks, |frame, tile, order, distance| {
            self.consider(frame, tile, order, Some(distance), hits);
        });
        hits.stacks = stacks;
    }

    /// Calls `visit` with all facets that the rays of `tile` may meet: with frame and tile in
    /// the space of their object, their order, and their least distance from the eye.
    #[inline]
    fn for_each_facet(
        &self,
        frame: &Frame,
        tile: &Tile,
        stacks: &mut Stacks,
        mut visit: impl FnMut(&Frame, &Tile, [u32; 2], f32),
    ) {
        let Stacks { space, placed } = stacks;
        visit_tile(&self.world.bvh, tile, space, |leaf, distance| {
            visit(frame, tile, self.world.leaves[leaf as usize], distance);
        });
        visit_tile(&self.placed.bvh, tile, placed, |leaf, _| {
            let object = self.placed.objects[leaf as usize];
            let frame = self.placed.frame(frame, object);
            let tile = tile.seen_from(frame);
            let own = self.placed.space(object);
            visit_tile(&own.bvh, &tile, space, |leaf, distance| {
                let [_, facet] = own.leaves[leaf as usize];
                visit(frame, &tile, [object, facet], distance);
            });
        });
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
        let space = match object.placement {
            None => &self.world,
            Some(_) => self.placed.space(order[0]),
        };
        let slack = space.slack() * frame.unit;
        for_each(pixels, |i| {
            let nearest = &mut hits.nearest[i];
            let mut best = 0.0;
            if let Some(nearest) = nearest {
                let behind = nearest.t * (1.0 + ROUNDING) + slack;
                if distance.is_some_and(|distance| distance * frame.unit > behind) {
                    return;
                }
                best = nearest.found.hit().depth;
            }
            let ray = object_ray(object, frame, tile.direction(i));
            let exit = KnownExit(hits.exits[i]);
            let Some(found) = Found::new(&ray, object, order[1], best, &exit, self.shows_means)
            else {
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
                    t: hit.t * frame.unit,
                    found,
                    order,
                });
            }
        });
    }

    /// Finds the exits of the rays of `tile`: their words, or zeros.
    fn exits(&self, frame: &Frame, tile: &Tile, stacks: &mut Stacks) -> [UVec4; PIXELS] {
        let mut nearest: [Option<([u32; 2], FacetHit, f32)>; PIXELS] = [None; PIXELS];
        self.for_each_facet(frame, tile, stacks, |frame, tile, order, _| {
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
            nearest[i].map_or(UVec4::ZERO, |(order, facet, _)| {
                let object = &self.scene.objects[order[0] as usize];
                let triangle = &object.triangles[order[1] as usize];
                let parameters = &object.parameters;
                let direction = self.direction(frame, tile, i, order[0]);
                Exit::new(parameters, direction, triangle, &facet).words(parameters.number)
            })
        })
    }

    /// Returns the direction of ray `index` of `tile`, which is one of `frame`, in the space of
    /// `object`.
    fn direction(&self, frame: &Frame, tile: &Tile, index: usize, object: u32) -> Vec3 {
        if self.scene.objects[object as usize].placement.is_none() {
            return tile.direction(index);
        }
        let [x, y] = tile.pixel(index);
        pixel_ray(self.placed.frame(frame, object), x, y)
    }

    /// Finds the first front-facing triangle on the ray of `frame` along
    /// `direction`: index of its object, its own index, and the hit. Objects must
    /// have neither prisms nor placements.
    pub(crate) fn first_facet(
        &self,
        frame: &Frame,
        direction: Vec3,
    ) -> Option<([u32; 2], FacetHit)> {
        let mut nearest: Option<([u32; 2], FacetHit)> = None;
        let ray = obvhs::ray::Ray::new_inf(Vec3A::from(frame.eye), Vec3A::from(direction));
        let Space { bvh, leaves, .. } = &self.world;
        // Near boxes first; those behind the nearest hit are left out.
        bvh.ray_traverse(ray, &mut RayHit::none(), |_, leaf| {
            let order = leaves[leaf];
            let object = &self.scene.objects[order[0] as usize];
            let ray = object_ray(object, frame, direction);
            let facet = over_triangle::meet(&ray, &object.triangles[order[1] as usize]);
            let is_nearer = nearest.as_ref().is_none_or(|(_, found)| facet.t < found.t);
            if facet.hit && facet.t > 0.0 && is_nearer {
                nearest = Some((order, facet));
            }
            nearest.as_ref().map_or(f32::INFINITY, |(_, facet)| {
                facet.t * (1.0 + ROUNDING) + self.world.rounding()
            })
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
        shade: impl Fn(&mut T, &Ray<'_>, &Nearest<'a>) + Sync,
    ) {
        let rows = pixels.par_chunks_mut(frame.size[0] as usize * SIDE);
        let rows = rows.enumerate();
        rows.for_each_init(TileHits::new, |hits, (row, pixels)| {
            self.search_row(frame, row, hits, |i, ray, nearest| {
                shade(&mut pixels[i], ray, nearest);
            });
        });
    }

    /// Calls `visit` for each hit in row `row` of the tiles: with the index of its pixel in
    /// the row of tiles, and its ray in the space of its object.
    fn search_row(
        &self,
        frame: &Frame,
        row: usize,
        hits: &mut TileHits<'a>,
        mut visit: impl FnMut(usize, &Ray<'_>, &Nearest<'a>),
    ) {
        let width = frame.size[0] as usize;
        for x in (0..width).step_by(SIDE) {
            let tile = Tile::new(frame, x, row * SIDE);
            self.search(frame, &tile, hits);
            for (i, nearest) in hits.nearest.iter().enumerate() {
                if let Some(nearest) = nearest {
                    let object = nearest.order[0];
                    let direction = self.direction(frame, &tile, i, object);
                    let frame = self.placed.frame(frame, object);
                    let ray = object_ray(nearest.object, frame, direction);
                    visit(i / SIDE * width + x + i % SIDE, &ray, nearest);
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

/// No object: the pixel is a miss.
pub(super) const NO_OBJECT: u32 = u32::MAX;

impl Renderer for CpuRenderer<'_> {
    fn name(&self) -> String {
        format!("CPU ({} threads)", rayon::current_num_threads())
    }

    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError> {
        if let Some(lighting) = &self.scene.lighting {
            return self.lit(frame, lighting);
        }
        self.reach_for(frame);
        let [width, height] = frame.size.map(|side| side as u32);
        let count = width as usize * height as usize;
        let mut words = allocate("the picture", count, background_words(self.scene))?;
        self.for_each_pixel(frame, &mut words, |pixel, ray, nearest| {
            let found = &nearest.found;
            let rgb = found.color(ray, nearest.object, nearest.order[1]);
            *pixel = trace::color_words(rgb, found.hit()).to_array();
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
        self.for_each_pixel(frame, &mut both, |pixel, ray, nearest| {
            let found = &nearest.found;
            let normal = found.normal(ray, nearest.object, nearest.order[1]);
            let (place, surface) = trace::geometry_words(ray.frame, found.hit(), normal);
            *pixel = (place.to_array(), surface.to_array());
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
