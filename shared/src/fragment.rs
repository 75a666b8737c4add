//! One pixel of one triangle, from the ray to the colour.

use crate::arithmetic::floor;
use crate::camera::reversed_depth;
use crate::facet::{self, FacetHit};
use crate::layout::{Frame, Object, Triangle, vec3};
use crate::light;
use crate::march::march;
use crate::normals::{CLASS_MISS, class_of, normal_at};
use crate::path::{Path, QuadraticPath};
use crate::profile::Profile;
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::{Surface, interpolate};
use crate::{Real, Vec2, Vec3};

/// A ray's way into the shell over a triangle, before any search.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The smooth surface there.
    pub surface: Surface,
    /// The ray inside the shell; look at its `enters` first.
    pub path: QuadraticPath,
}

/// What was found on the ray.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Surface class, one of the `CLASS_` constants; the rest is meaningless for a miss.
    pub class: u32,
    /// Depth to compare, see [`reversed_depth`]: larger is nearer.
    pub depth: Real,
    /// Distance from the eye, object units.
    pub t: Real,
    /// The path's parameter.
    pub s: Real,
    /// Texture coordinates, 0…1 within one repeat.
    pub uv: Vec2,
    /// δ, 0…1.
    pub depth_fraction: Real,
    /// Steps of the linear search.
    pub steps: u32,
}

/// Meets the flat `triangle` with the ray along the unit vector `direction`.
#[inline]
pub fn meet(frame: &Frame, triangle: &Triangle, direction: Vec3) -> FacetHit {
    facet::intersect(vec3(frame.eye), direction, triangle)
}

/// Enters the shell over `triangle` where the ray has met it.
#[inline]
pub fn enter(object: &Object, triangle: &Triangle, direction: Vec3, facet: &FacetHit) -> Entry {
    let surface = interpolate(triangle, facet);
    let path = QuadraticPath::new(&surface, direction, facet.t, object.depth, object.tier);
    Entry { surface, path }
}

/// Searches the shell behind `entry` for the first hit. A hit in front of the
/// near plane is a miss.
#[inline]
pub fn trace<T: Texels + ?Sized>(
    frame: &Frame,
    object: &Object,
    texels: &T,
    direction: Vec3,
    entry: &Entry,
) -> Hit {
    let map = ShapeMap::new(object);
    let profile = Profile::new(object);
    let found = march(
        &entry.path,
        &profile,
        &map,
        texels,
        object.linear_steps,
        object.binary_steps,
    );
    let class = class_of(&found, object);
    let t = entry.path.entry_t + found.s;
    let depth = reversed_depth(frame, direction, t);
    let uv = entry.path.uv(found.s);
    Hit {
        class: if depth > 1.0 { CLASS_MISS } else { class },
        depth,
        t,
        s: found.s,
        uv: Vec2::new(uv.x - floor(uv.x), uv.y - floor(uv.y)),
        depth_fraction: found.depth_fraction,
        steps: found.steps,
    }
}

/// The unit normal at `hit`.
#[inline]
pub fn normal<T: Texels + ?Sized>(
    object: &Object,
    texels: &T,
    direction: Vec3,
    entry: &Entry,
    hit: &Hit,
) -> Vec3 {
    let surface_normal = entry
        .path
        .surface_normal(&entry.surface, direction, hit.s, object.tier);
    normal_at(
        hit.class,
        object,
        &ShapeMap::new(object),
        texels,
        &entry.surface,
        surface_normal,
        hit.uv,
    )
}

/// Linear RGB of `hit`.
#[inline]
pub fn color(frame: &Frame, object: &Object, direction: Vec3, hit: &Hit, normal: Vec3) -> Vec3 {
    light::shade(frame, object, hit.class, normal, direction)
}
