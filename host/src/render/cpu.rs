//! The renderer on the CPU: a bounding volume hierarchy finds the triangles on
//! a pixel's ray, and the shared code does the rest, rows in parallel.

use super::{ColorWords, GeometryWords, RenderError, Renderer, allocate, background_words};
use crate::hierarchy;
use crate::prepare::{PreparedObject, PreparedScene};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ray::Ray;
use rayon::prelude::*;
use relievo_shared::camera::{pixel_ray, reversed_depth};
use relievo_shared::facet::{FacetHit, may_surround_eye};
use relievo_shared::fragment::{self, Entry, Hit};
use relievo_shared::layout::{Frame, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_RELIEF, Shell};
use relievo_shared::normals::CLASS_MISS;
use relievo_shared::prism::{cap_hull, is_near, is_open, normal_hull};
use relievo_shared::shell::{self, ShellHit};
use std::ops::Add;

/// Renders one scene on the CPU.
pub struct CpuRenderer<'a> {
    scene: &'a PreparedScene,
    bvh: Bvh2,
    /// Object and triangle of each leaf of the hierarchy, in its order.
    leaves: Vec<[u32; 2]>,
    /// The largest distance of an eye from the origin for which the boxes are wide enough.
    reach: f32,
    /// Object and number of each prism, or triangle with its shell, in which the
    /// eye may lie.
    around_eye: Vec<[u32; 2]>,
}

/// The nearest hit on a ray and what it belongs to.
struct Nearest<'a> {
    object: &'a PreparedObject,
    found: Found,
    order: [u32; 2],
}

/// A hit, and what its colour follows from.
#[derive(Clone, Copy)]
enum Found {
    Facet(Entry, Hit),
    Prism(ShellHit),
}

impl Found {
    fn hit(&self) -> &Hit {
        match self {
            Found::Facet(_, hit) => hit,
            Found::Prism(found) => &found.hit,
        }
    }
}

/// What the rays of a frame took that met something.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Rays that met something.
    pub hits: u64,
    /// Steps of their linear searches.
    pub steps: u64,
    /// Prisms that they went through; 0 but in the accurate tier.
    pub prisms: u64,
}

impl Add for Effort {
    type Output = Effort;

    fn add(self, other: Effort) -> Effort {
        Effort {
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
            around_eye: Vec::new(),
        }
    }

    /// Makes the boxes wide enough for the eye of `frame`, and finds the prisms
    /// and triangles around it.
    fn reach_for(&mut self, frame: &Frame) {
        let eye = Vec3::from(frame.eye);
        self.around_eye.clear();
        for (i, object) in self.scene.objects.iter().enumerate() {
            let order = |(j, is_near): (usize, bool)| is_near.then_some([i as u32, j as u32]);
            if object.has_prisms() {
                let shells = object.shells.par_iter();
                let near = shells.map(|shell| is_near(shell, eye - Vec3::from(shell.anchor)));
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

    /// The nearest hit of the ray along `direction`.
    fn nearest(&self, frame: &Frame, direction: Vec3) -> Option<Nearest<'a>> {
        let mut nearest: Option<Nearest<'a>> = None;
        let mut visit = |order: [u32; 2]| {
            let object = &self.scene.objects[order[0] as usize];
            let best = nearest
                .as_ref()
                .map_or(0.0, |nearest| nearest.found.hit().depth);
            let found = if object.has_prisms() {
                Some(find_in_prisms(object, frame, direction, order[1]))
            } else {
                find_behind_facet(object, frame, direction, order[1], best)
            };
            let Some(found) = found else { return };
            let hit = found.hit();
            // The order of drawing decides between equal depths, as on a GPU.
            let wins = hit.class != CLASS_MISS
                && match &nearest {
                    None => hit.depth > 0.0,
                    Some(nearest) => {
                        hit.depth > best || (hit.depth == best && order < nearest.order)
                    }
                };
            if wins {
                nearest = Some(Nearest {
                    object,
                    found,
                    order,
                });
            }
        };
        for &order in &self.around_eye {
            visit(order);
        }
        let ray = Ray::new_inf(Vec3A::from(frame.eye), Vec3A::from(direction));
        self.bvh
            .ray_traverse_anyhit(ray, |_, leaf| visit(self.leaves[leaf]));
        nearest
    }

    /// The first triangle's front that the ray of `frame` along `direction`
    /// meets: number of its object and of itself, and where. Prisms are not
    /// looked at, so no object may have them.
    pub(crate) fn first_facet(
        &self,
        frame: &Frame,
        direction: Vec3,
    ) -> Option<([u32; 2], FacetHit)> {
        let mut nearest: Option<([u32; 2], FacetHit)> = None;
        let ray = Ray::new_inf(Vec3A::from(frame.eye), Vec3A::from(direction));
        self.bvh.ray_traverse_anyhit(ray, |_, leaf| {
            let order = self.leaves[leaf];
            let object = &self.scene.objects[order[0] as usize];
            let facet = fragment::meet(
                frame,
                &object.parameters,
                &object.triangles[order[1] as usize],
                direction,
            );
            let is_nearer = nearest.as_ref().is_none_or(|(_, found)| facet.t < found.t);
            if facet.hit && facet.t > 0.0 && is_nearer {
                nearest = Some((order, facet));
            }
        });
        nearest
    }

    /// What the rays of `frame` take.
    pub fn effort(&mut self, frame: &Frame) -> Effort {
        self.reach_for(frame);
        let [width, height] = frame.size.map(|side| side as u32);
        let renderer = &*self;
        let pixels = (0..height).into_par_iter().flat_map_iter(|y| {
            (0..width).filter_map(move |x| renderer.nearest(frame, pixel_ray(frame, x, y)))
        });
        pixels
            .map(|nearest| Effort {
                hits: 1,
                steps: nearest.found.hit().steps.into(),
                prisms: match nearest.found {
                    Found::Prism(found) => found.prisms.into(),
                    Found::Facet(..) => 0,
                },
            })
            .reduce(Effort::default, Effort::add)
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

/// What the ray along `direction` meets where it comes in through prism `index`.
fn find_in_prisms(object: &PreparedObject, frame: &Frame, direction: Vec3, index: u32) -> Found {
    let (parameters, texels) = (&object.parameters, object.map.words());
    let shells = object.shells.as_slice();
    Found::Prism(shell::trace(
        frame, parameters, shells, texels, direction, index,
    ))
}

/// What the ray along `direction` meets behind triangle `index`, if that may be
/// as near as the depth `best`.
fn find_behind_facet(
    object: &PreparedObject,
    frame: &Frame,
    direction: Vec3,
    index: u32,
    best: f32,
) -> Option<Found> {
    let parameters = &object.parameters;
    let triangle = &object.triangles[index as usize];
    let facet = fragment::meet(frame, parameters, triangle, direction);
    if !facet.hit {
        return None;
    }
    let entry = fragment::enter(parameters, triangle, direction, &facet);
    // Nothing behind the entry can be nearer than the entry.
    if !entry.path.enters || reversed_depth(frame, direction, entry.path.entry_t) < best {
        return None;
    }
    let trace = match parameters.search {
        SEARCH_PAPER => fragment::trace::<SEARCH_PAPER, [u32]>,
        SEARCH_RELIEF => fragment::trace::<SEARCH_RELIEF, [u32]>,
        _ => fragment::trace::<SEARCH_EXTRUSION, [u32]>,
    };
    let hit = trace(frame, parameters, object.map.words(), direction, &entry);
    Some(Found::Facet(entry, hit))
}

/// The hierarchy over all triangles of `scene`, and what its leaves are. The
/// boxes are wider than the triangles by more than the rounding errors of the
/// box test and of the triangle test from an eye within `reach`, so that the
/// shared triangle test alone decides what is hit.
fn build(scene: &PreparedScene, reach: f32) -> (Bvh2, Vec<[u32; 2]>) {
    let mut leaves = Vec::with_capacity(scene.triangle_count());
    let mut boxes = Vec::with_capacity(scene.triangle_count());
    for (i, object) in scene.objects.iter().enumerate() {
        let bounds: &mut dyn Iterator<Item = (Vec3, Vec3)> = if object.has_prisms() {
            let depth = object.parameters.depth;
            &mut object
                .shells
                .iter()
                .map(move |shell| prism_bounds(shell, depth))
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

/// A box around everything through which a ray may come into a prism from outside.
fn prism_bounds(shell: &Shell, depth: f32) -> (Vec3, Vec3) {
    let cap = cap_hull(shell);
    let mut low = cap.into_iter().fold(cap[0], Vec3::min);
    let mut high = cap.into_iter().fold(cap[0], Vec3::max);
    if is_open(shell) {
        for (point, normal) in cap.into_iter().zip(normal_hull(shell)) {
            let floor = point - normal * depth;
            low = low.min(floor);
            high = high.max(floor);
        }
    }
    // Rays come in up to a little beyond the sides.
    let margin = Vec3::splat(1e-3 * (high - low).max_element());
    let anchor = Vec3::from(shell.anchor);
    (anchor + low - margin, anchor + high + margin)
}

impl Nearest<'_> {
    fn normal(&self, direction: Vec3) -> Vec3 {
        let (parameters, texels) = (&self.object.parameters, self.object.map.words());
        match &self.found {
            Found::Facet(entry, hit) => {
                fragment::normals(parameters, texels, direction, entry, hit).carved
            }
            Found::Prism(hit) => {
                shell::normals(parameters, self.object.shells.as_slice(), texels, hit).carved
            }
        }
    }

    fn color(&self, frame: &Frame, direction: Vec3) -> Vec3 {
        let (parameters, texels) = (&self.object.parameters, self.object.map.words());
        let shadow = parameters.self_shadow != 0;
        match &self.found {
            Found::Facet(entry, hit) => {
                let color = if shadow {
                    fragment::color::<true, [u32]>
                } else {
                    fragment::color::<false, [u32]>
                };
                color(frame, parameters, texels, direction, entry, hit)
            }
            Found::Prism(hit) => {
                let color = if shadow {
                    shell::color::<true, [Shell], [u32]>
                } else {
                    shell::color::<false, [Shell], [u32]>
                };
                let shells = self.object.shells.as_slice();
                color(frame, parameters, shells, texels, direction, hit)
            }
        }
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
