//! Code shared by the models that are drawn over triangles.

use super::{Found, Model, Normals, Place, Ray, Traced};
use crate::Real;
use crate::contract::{check, check2, check3};
use crate::exit::{self, Exit, Exits};
use crate::facet::{self, FacetHit, may_surround_eye};
use crate::layout::{Triangle, vec3};
use crate::march::{Limits, March, march};
use crate::normals::SmoothSurface;
use crate::path::{Path, QuadraticPath};
use crate::profile::Profile;
use crate::shadow::{self, ShadowPoint};
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::{Surface, interpolate, local_depth, uv_bend};

/// Where a ray enters the shell over a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TriangleEntry {
    /// The smooth surface there.
    pub surface: Surface,
    /// The ray inside the shell; its `enters` says whether it enters.
    pub path: QuadraticPath,
    /// The local depth h, object units.
    pub depth: Real,
}

/// A model over triangles: a path, and a search along it.
pub trait OverTriangle {
    /// Whether the surface is a quadric; else it is flat.
    fn is_curved(ray: &Ray<'_>) -> bool;

    /// Whether the mesh says where a ray leaves it, if a quadric cannot.
    fn asks_for_exits() -> bool {
        false
    }

    /// Searches along the path of `entry` for the first hit; its place is the
    /// path's parameter s, object units.
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        triangle: &Triangle,
        texels: &T,
        entry: &TriangleEntry,
    ) -> Found<Real>;
}

/// A hit of a search along a path of `entry`.
#[inline]
pub(super) fn found_on(entry: &TriangleEntry, march: March) -> Found<Real> {
    Found {
        march,
        t: entry.path.entry_t + march.s,
        place: march.s,
    }
}

/// [`march`] along the path of `entry`.
#[inline]
pub(super) fn march_over<T: Texels + ?Sized>(
    ray: &Ray<'_>,
    texels: &T,
    entry: &TriangleEntry,
) -> Found<Real> {
    let object = ray.object;
    let found = march(
        &entry.path,
        &Profile::new(object),
        &ShapeMap::new(object),
        texels,
        &Limits {
            linear_steps: object.linear_steps,
            binary_steps: object.binary_steps,
            slack: object.slack * entry.path.entry_t,
        },
    );
    found_on(entry, found)
}

/// Intersects the ray with the flat `triangle`: behind the near plane, or anywhere
/// if the eye may lie in the triangle's shell.
#[inline]
pub fn meet(ray: &Ray<'_>, triangle: &Triangle) -> FacetHit {
    let (frame, direction) = (ray.frame, ray.direction);
    let found = facet::intersect(vec3(frame.eye), direction, triangle);
    let is_behind_near_plane = found.t * direction.dot(vec3(frame.forward)) >= frame.near;
    // Without branches: both are cheap.
    FacetHit {
        hit: found.hit & (is_behind_near_plane | may_surround_eye(frame, ray.object, triangle)),
        ..found
    }
}

/// The parameter s of the path.
impl Place for Real {
    #[inline]
    fn facet(&self, drawn: u32) -> u32 {
        drawn
    }

    #[inline]
    fn prisms(&self) -> u32 {
        0
    }
}

impl<M: OverTriangle> Model<Triangle> for M {
    type Meeting = FacetHit;
    type Entry = TriangleEntry;
    type Place = Real;
    type Surface = SmoothSurface;

    #[inline]
    fn meet(ray: &Ray<'_>, triangle: &Triangle) -> (bool, FacetHit) {
        let found = meet(ray, triangle);
        (found.hit, found)
    }

    #[inline]
    fn enter<X: Exits>(
        ray: &Ray<'_>,
        triangle: &Triangle,
        facet: &FacetHit,
        exits: &X,
    ) -> (bool, TriangleEntry) {
        let direction = ray.direction;
        let depth = local_depth(triangle, facet, ray.object.depth);
        let mut surface = interpolate(triangle, facet);
        let is_curved = M::is_curved(ray);
        if is_curved {
            surface.uv_bend = uv_bend(triangle, surface.normal, direction);
        }
        let asks = M::asks_for_exits() && ray.object.number != 0;
        let path = if is_curved {
            let cap = if asks {
                surface.cap(facet.normal)
            } else {
                surface
            };
            let path = QuadraticPath::bent(&cap, direction, facet.t, depth);
            if asks && path.enters {
                let number = exit::number(ray.frame, ray.object);
                path.until(&Exit::from_words(exits.words(), number), facet.t)
            } else {
                path
            }
        } else {
            QuadraticPath::straight(&surface, direction, facet.t, depth)
        };
        if path.enters {
            check3(surface.normal);
            check3(surface.quadric);
            check2(path.entry_uv);
            check(path.entry_t);
            check(path.slope);
            check(path.bend);
            check(path.end());
        }
        let entry = TriangleEntry {
            surface,
            path,
            depth,
        };
        (path.enters, entry)
    }

    #[inline]
    fn entry_t(entry: &TriangleEntry) -> Real {
        entry.path.entry_t
    }

    #[inline]
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        triangle: &Triangle,
        texels: &T,
        entry: &TriangleEntry,
    ) -> Found<Real> {
        M::search(ray, triangle, texels, entry)
    }

    #[inline]
    fn surface(ray: &Ray<'_>, _: &Triangle, entry: &TriangleEntry, s: &Real) -> SmoothSurface {
        SmoothSurface {
            surface: entry.surface,
            normal: entry.path.surface_normal(&entry.surface, ray.direction, *s),
            depth: entry.depth,
        }
    }

    #[inline]
    fn lit<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        _: &Triangle,
        texels: &T,
        traced: &Traced<Real>,
        surface: &SmoothSurface,
        normals: &Normals,
    ) -> bool {
        shadow::lit(
            ray.object,
            &ShapeMap::new(ray.object),
            texels,
            &surface.surface,
            M::is_curved(ray),
            &ShadowPoint {
                class: traced.hit.class,
                uv: traced.hit.uv,
                depth_fraction: traced.hit.depth_fraction,
                depth: surface.depth,
                normal: normals.carved,
                surface_normal: normals.smooth,
            },
            vec3(ray.frame.light_direction),
        )
    }
}
