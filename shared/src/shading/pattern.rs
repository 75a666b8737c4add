//! How a pattern lies on a surface: how many repeats are a unit, how wide its gaps are, and how far it
//! grows with the depth.

use super::Tables;
use super::layout::Finish;
use crate::arithmetic::{div, kept, max, sqrt};
use crate::gbuffer::Sample;
use crate::layout::vec2;
use crate::{Real, Vec2, Vec3};

/// Returns repeats of the pattern per world unit along u and v at `hit`.
#[inline]
pub(super) fn density<T: Tables + ?Sized>(tables: &T, finish: &Finish, hit: &Sample) -> Vec2 {
    let facet = tables.facet(finish.first_facet + hit.facet);
    vec2(facet.density) * div(1.0, max(hit.unit, 1e-12))
}

/// Returns texels of the chart of `finish` per world unit along u and v, where `rate` repeats of the
/// pattern are.
#[inline]
pub(super) fn texels(finish: &Finish, rate: Vec2) -> Vec2 {
    let chart = &finish.chart.image;
    rate * Vec2::new(chart.width as i32 as Real, chart.height as i32 as Real)
}

/// Returns the mean width of the pattern's gaps, world units, where `rate` repeats of it are a world unit
/// along u and v.
#[inline]
pub(super) fn gap(finish: &Finish, rate: Vec2) -> Real {
    let texels = texels(finish, rate);
    div(finish.chart.gap, max(sqrt(texels.x * texels.y), 1e-12))
}

/// Returns how far the pattern grows from cap to floor, in the unit of which `density` repeats are one,
/// across an outline whose normal has the part `along_u` along u.
#[inline]
pub(super) fn growth_across(finish: &Finish, density: Vec2, along_u: Real) -> Real {
    let growth = vec2(finish.growth);
    let u = div(growth.x, max(density.x, 1e-12)) * along_u;
    let v = div(growth.y, max(density.y, 1e-12));
    sqrt(kept(u * u + v * v * max(1.0 - along_u * along_u, 0.0)))
}

/// Returns how far the pattern grows from cap to floor along the unit vector `across` its outline,
/// object units, at a `hit` on a cap or a floor of `finish`.
#[inline]
pub(super) fn growth<T: Tables + ?Sized>(
    tables: &T,
    finish: &Finish,
    hit: &Sample,
    across: Vec3,
) -> Real {
    let facet = tables.facet(finish.first_facet + hit.facet);
    growth_across(finish, vec2(facet.density), kept(across.dot(hit.tangent)))
}
