//! The planar tier: the surface is the flat facet, extrusion mapping without
//! silhouettes.

use super::over_triangle::{OverTriangle, TriangleEntry, march_over};
use super::{Found, Ray};
use crate::arithmetic::{abs, div, max};
use crate::layout::Triangle;
use crate::path::{FLAT, QuadraticPath};
use crate::shape_map::Texels;
use crate::surface::Surface;
use crate::{Real, Vec2, Vec3};

/// The planar tier.
#[derive(Clone, Copy, Debug)]
pub struct Flat;

impl OverTriangle for Flat {
    #[inline]
    fn is_curved(_: &Ray<'_>) -> bool {
        false
    }

    #[inline]
    fn search<T: Texels + ?Sized>(
        ray: &Ray<'_>,
        _: &Triangle,
        texels: &T,
        entry: &TriangleEntry,
    ) -> Found<Real> {
        march_over(ray, texels, entry)
    }
}

impl QuadraticPath {
    /// The straight ray over a flat surface; arguments as for
    /// [`QuadraticPath::new`].
    #[inline]
    pub fn straight(
        surface: &Surface,
        direction: Vec3,
        facet_t: Real,
        depth: Real,
    ) -> QuadraticPath {
        let v_z = -direction.dot(surface.normal);
        let slope = abs(v_z);
        let goes_down = slope > FLAT;
        QuadraticPath {
            // Along the cap it enters here; away from it never.
            enters: v_z >= 0.0,
            entry_t: facet_t,
            entry_from_facet: 0.0,
            entry_uv: surface.uv,
            velocity: Vec2::new(
                direction.dot(surface.gradient_u),
                direction.dot(surface.gradient_v),
            ),
            uv_bend: Vec2::ZERO,
            slope,
            bend: 0.0,
            twist: 0.0,
            steepest: slope,
            inverse_depth: div(1.0, depth),
            warp: 0.0,
            foot_bend: Vec2::ZERO,
            start: max(-facet_t, 0.0),
            // A ray that follows the cap for ever can hit nothing but the cap.
            end: if goes_down { div(depth, slope) } else { 0.0 },
            ends_on_floor: goes_down,
            is_bent: false,
        }
    }
}
