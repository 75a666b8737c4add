//! What a picture shows of an object: the numbers that its errors follow from.

use crate::prepare::PreparedScene;
use crate::render::CpuRenderer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use relievo_shared::camera::pixel_ray;
use relievo_shared::facet::FacetHit;
use relievo_shared::layout::{Frame, Object, Triangle};
use relievo_shared::surface::interpolate;

/// Rays along each side of the grid that looks at a scene, at most.
const GRID: f32 = 64.0;

/// The least cosine between a ray and the surface's normal that is told apart.
const LEAST_COSINE: f64 = 0.02;

/// What a picture shows of one object. All is 0 where nothing is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// Rays of the grid that meet it.
    pub rays: usize,
    /// Median of how far its facets lie below the smooth surface, pixels: from
    /// curvature, triangle size and distance.
    pub facet_px: f64,
    /// What nine in ten rays go along the surface at most while they are in the
    /// shell, pixels: from depth, curvature and distance.
    pub way_px: f64,
    /// Median of 1 / cosine between ray and normal.
    pub slant: f64,
    /// Width of a texel of the shape map, pixels, that one in fifty exceeds.
    pub texel_px: f64,
}

/// One ray's share of a [`View`].
struct Look {
    object: u32,
    facet_px: f64,
    way_px: f64,
    slant: f64,
    texel_px: f64,
}

/// What the picture of `scene` shows of each of its objects, none of which has
/// prisms.
pub fn look(scene: &PreparedScene) -> Vec<View> {
    let renderer = CpuRenderer::new(scene);
    let frame = coarse(&scene.frame);
    let pixel = DVec3::from(scene.frame.ray_right.map(f64::from)).length();
    let [width, height] = frame.size.map(|side| side as u32);
    let looks: Vec<Look> = (0..width * height)
        .into_par_iter()
        .filter_map(|i| {
            let direction = pixel_ray(&frame, i % width, i / width);
            let ([object, triangle], facet) = renderer.first_facet(&frame, direction)?;
            let prepared = &scene.objects[object as usize];
            let triangle = &prepared.triangles[triangle as usize];
            let look = Look::new(
                object,
                &prepared.parameters,
                triangle,
                &facet,
                direction,
                pixel,
            );
            Some(look)
        })
        .collect();
    (0..scene.objects.len() as u32)
        .map(|object| View::of(looks.iter().filter(|look| look.object == object)))
        .collect()
}

/// `frame` with at most [`GRID`] rays along each side.
fn coarse(frame: &Frame) -> Frame {
    let strides = frame.size.map(|side| (side / GRID).max(1.0));
    let size = [0, 1].map(|axis| (frame.size[axis] / strides[axis]).floor());
    thinned(
        frame,
        strides.map(|stride| 0.5 * stride - 0.5),
        strides,
        size,
    )
}

/// The rays of `frame` from `first` on (pixels from its first ray), `strides`
/// pixels apart, `size` of them along each side.
pub(super) fn thinned(frame: &Frame, first: [f32; 2], strides: [f32; 2], size: [f32; 2]) -> Frame {
    let [start, right, down] = [frame.ray_first, frame.ray_right, frame.ray_down].map(Vec3::from);
    Frame {
        ray_first: (start + right * first[0] + down * first[1]).to_array(),
        ray_right: (right * strides[0]).to_array(),
        ray_down: (down * strides[1]).to_array(),
        size,
        ..*frame
    }
}

impl Look {
    fn new(
        object: u32,
        parameters: &Object,
        triangle: &Triangle,
        facet: &FacetHit,
        direction: Vec3,
        pixel: f64,
    ) -> Look {
        let surface = interpolate(triangle, facet);
        let depth = f64::from(parameters.depth);
        // Pixels in an object unit there.
        let scale = 1.0 / (pixel * f64::from(facet.t));
        let cosine = f64::from(-direction.dot(surface.normal)).clamp(LEAST_COSINE, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        let [x, y] =
            [surface.tangent, surface.bitangent].map(|axis| f64::from(direction.dot(axis)));
        let [xx, xy, yy] = surface.quadric.to_array().map(f64::from);
        // The surface's curvature along the ray.
        let curvature = 2.0 * (xx * x * x + xy * x * y + yy * y * y) / (x * x + y * y).max(1e-12);
        let size = parameters.map_size.map(f64::from);
        let [u, v] = [surface.gradient_u, surface.gradient_v].map(Vec3::as_dvec3);
        let texels = smaller_stretch(u * size[0], v * size[1]);
        Look {
            object,
            facet_px: scale * f64::from(surface.facet_depth).max(0.0),
            way_px: scale * sine * way(depth, curvature, cosine / sine.max(1e-9)),
            slant: 1.0 / cosine,
            texel_px: if texels > 0.0 { scale / texels } else { 0.0 },
        }
    }
}

/// How far a ray goes along a surface until it is `depth` below it, or out
/// again, where it sinks by `slope` per unit of way and the surface bends away
/// from under it by `curvature`.
fn way(depth: f64, curvature: f64, slope: f64) -> f64 {
    if curvature > 0.0 {
        // To the floor, or past the summit and as far again.
        let radicand = slope * slope - 2.0 * curvature * depth;
        if radicand >= 0.0 {
            2.0 * depth / (slope + radicand.sqrt())
        } else {
            2.0 * slope / curvature
        }
    } else {
        2.0 * depth / (slope + (slope * slope - 2.0 * curvature * depth).sqrt()).max(1e-12)
    }
}

/// The smaller singular value of the map with the rows `u` and `v`.
pub(crate) fn smaller_stretch(u: DVec3, v: DVec3) -> f64 {
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let (mean, half) = (0.5 * (uu + vv), 0.5 * (uu - vv));
    (mean - half.hypot(uv)).max(0.0).sqrt()
}

impl View {
    fn of<'a>(looks: impl Iterator<Item = &'a Look> + Clone) -> View {
        let quantile = |value: fn(&Look) -> f64, share: f64| {
            let mut values: Vec<f64> = looks.clone().map(value).collect();
            values.sort_by(f64::total_cmp);
            let last = values.len().saturating_sub(1);
            let found = values.get((share * last as f64) as usize);
            found.copied().unwrap_or_default()
        };
        View {
            rays: looks.clone().count(),
            facet_px: quantile(|look| look.facet_px, 0.5),
            way_px: quantile(|look| look.way_px, 0.9),
            slant: quantile(|look| look.slant, 0.5),
            texel_px: quantile(|look| look.texel_px, 0.98),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_roots() {
        for curvature in [-3.0, -0.1, 0.0, 0.1, 3.0] {
            for slope in [0.05, 0.5, 5.0] {
                let way = way(0.1, curvature, slope);
                let depth = slope * way - 0.5 * curvature * way * way;
                let wanted = if slope * slope >= 0.2 * curvature {
                    0.1
                } else {
                    0.0
                };
                assert!(
                    (depth - wanted).abs() < 1e-12,
                    "{curvature} {slope}: {depth}"
                );
                assert!(way > 0.0);
            }
        }
    }

    #[test]
    fn stretches_are_singular_values() {
        assert_eq!(smaller_stretch(DVec3::X * 3.0, DVec3::Y * 2.0), 2.0);
        assert!(smaller_stretch(DVec3::X, DVec3::X * 5.0) < 1e-9);
        assert_eq!(smaller_stretch(DVec3::ZERO, DVec3::ZERO), 0.0);
    }
}
