//! One pixel of one triangle, from the ray to the colour.

use crate::arithmetic::floor;
use crate::camera::reversed_depth;
use crate::contract::{check, check2, check3};
use crate::facet::{self, FacetHit, may_surround_eye};
use crate::layout::{Frame, Object, SEARCH_PAPER, SEARCH_RELIEF, TIER_FAST, Triangle, vec3};
use crate::light;
use crate::march::{Effort, march};
use crate::normals::{CLASS_MISS, class_of, normal_at};
use crate::paper;
use crate::path::{Path, QuadraticPath};
use crate::profile::Profile;
use crate::relief;
use crate::shadow::{self, ShadowPoint};
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::{Surface, interpolate, uv_bend};
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

/// Meets the flat `triangle` of `object` with the ray along the unit vector
/// `direction`: behind the near plane, or anywhere if the eye may lie in the
/// triangle's shell.
#[inline]
pub fn meet(frame: &Frame, object: &Object, triangle: &Triangle, direction: Vec3) -> FacetHit {
    let found = facet::intersect(vec3(frame.eye), direction, triangle);
    let is_behind_near_plane = found.t * direction.dot(vec3(frame.forward)) >= frame.near;
    // Without branches: both are cheap.
    FacetHit {
        hit: found.hit & (is_behind_near_plane | may_surround_eye(frame, object, triangle)),
        ..found
    }
}

/// Enters the shell over `triangle` where the ray has met it.
#[inline]
pub fn enter(object: &Object, triangle: &Triangle, direction: Vec3, facet: &FacetHit) -> Entry {
    let mut surface = interpolate(triangle, facet);
    if object.tier == TIER_FAST {
        surface.uv_bend = uv_bend(triangle, surface.normal, direction);
    }
    let path = QuadraticPath::new(&surface, direction, facet.t, object.depth, object.tier);
    if path.enters {
        check3(surface.normal);
        check3(surface.quadric);
        check2(path.entry_uv);
        check(path.entry_t);
        check(path.slope);
        check(path.bend);
        check(path.end());
    }
    Entry { surface, path }
}

/// Searches the shell behind `entry` for the first hit, in the way of the
/// `SEARCH_` constant `SEARCH`: a parameter of the type, so that a shader holds
/// only what it runs. A hit in front of the near plane is a miss.
#[inline]
pub fn trace<const SEARCH: u32, T: Texels + ?Sized>(
    frame: &Frame,
    object: &Object,
    texels: &T,
    direction: Vec3,
    entry: &Entry,
) -> Hit {
    let map = ShapeMap::new(object);
    let found = if SEARCH == SEARCH_PAPER {
        paper::search(object, &map, texels, &entry.surface, direction)
    } else if SEARCH == SEARCH_RELIEF {
        relief::search(
            &entry.path,
            &Profile::new(object),
            &map,
            texels,
            object.linear_steps,
            object.binary_steps,
        )
    } else {
        march(
            &entry.path,
            &Profile::new(object),
            &map,
            texels,
            &Effort {
                linear_steps: object.linear_steps,
                binary_steps: object.binary_steps,
                slack: object.slack * entry.path.entry_t,
            },
        )
    };
    let class = class_of(&found, object);
    let t = entry.path.entry_t + found.s;
    let depth = reversed_depth(frame, direction, t);
    if class != CLASS_MISS {
        check(t);
        check2(found.uv);
        check(found.depth_fraction);
    }
    Hit {
        class: if depth > 1.0 { CLASS_MISS } else { class },
        depth,
        t,
        s: found.s,
        uv: Vec2::new(
            found.uv.x - floor(found.uv.x),
            found.uv.y - floor(found.uv.y),
        ),
        depth_fraction: found.depth_fraction,
        steps: found.steps,
    }
}

/// The two normals at a hit.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    /// Unit normal of the carved surface, which is lit.
    pub carved: Vec3,
    /// Unit normal of the smooth surface below it.
    pub smooth: Vec3,
}

/// The normals at `hit`.
#[inline]
pub fn normals<T: Texels + ?Sized>(
    object: &Object,
    texels: &T,
    direction: Vec3,
    entry: &Entry,
    hit: &Hit,
) -> Normals {
    let smooth = entry
        .path
        .surface_normal(&entry.surface, direction, hit.s, object.tier);
    let carved = normal_at(
        hit.class,
        object,
        &ShapeMap::new(object),
        texels,
        &entry.surface,
        smooth,
        hit.uv,
    );
    check3(carved);
    Normals { carved, smooth }
}

/// Linear RGB of `hit`, with self-shadows if `SHADOW`.
#[inline]
pub fn color<const SHADOW: bool, T: Texels + ?Sized>(
    frame: &Frame,
    object: &Object,
    texels: &T,
    direction: Vec3,
    entry: &Entry,
    hit: &Hit,
) -> Vec3 {
    let normals = normals(object, texels, direction, entry, hit);
    let lit = !SHADOW
        || shadow::lit(
            object,
            &ShapeMap::new(object),
            texels,
            &entry.surface,
            &ShadowPoint {
                class: hit.class,
                uv: hit.uv,
                depth_fraction: hit.depth_fraction,
                normal: normals.carved,
                surface_normal: normals.smooth,
            },
            vec3(frame.light_direction),
        );
    let color = light::shade(frame, object, hit.class, normals.carved, direction, lit);
    check3(color);
    color
}

/// A number as pictures carry it: its bits, and one word for both zeros, whose
/// sign is nothing that devices keep alike.
#[inline]
pub fn word(x: f32) -> u32 {
    if x == 0.0 { 0 } else { x.to_bits() }
}

/// Class and number of steps in one word, as pictures of geometry carry them.
#[inline]
pub fn class_and_steps(hit: &Hit) -> u32 {
    hit.class | (hit.steps << 8)
}
