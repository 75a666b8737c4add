//! Measures an object in the picture: the quantities that its errors depend on.

use crate::mesh::smaller_stretch;
use crate::prepare::PreparedScene;
use crate::render::CpuRenderer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use relievo_shared::camera::pixel_ray;
use relievo_shared::facet::FacetHit;
use relievo_shared::layout::{Frame, Object, Triangle};
use relievo_shared::surface::interpolate;

/// Maximum number of rays along each side of the grid.
const GRID: f32 = 64.0;

/// Smaller cosines between ray and normal are clamped to this.
const LEAST_COSINE: f64 = 0.02;

/// Measurements of one object in the picture. All are 0 if no ray meets it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScreenMetrics {
    /// Rays of the grid that meet the object.
    pub rays: usize,
    /// Estimated number of the picture's pixels that show the object.
    pub pixels: f64,
    /// Median distance of the facets below the smooth surface, pixels; it depends
    /// on curvature, triangle size and distance.
    pub facet_px: f64,
    /// 0.9 quantile of the length of a ray's path along the surface within the
    /// shell, pixels; it depends on depth, curvature and distance.
    pub way_px: f64,
    /// Median of 1 / cosine between ray and normal.
    pub slant: f64,
    /// 0.98 quantile of the width of a texel of the shape map, pixels.
    pub texel_px: f64,
}

/// Measurements on one ray.
struct RayMetrics {
    object: u32,
    facet_px: f64,
    way_px: f64,
    slant: f64,
    texel_px: f64,
}

/// Measures each object of `scene` on a coarse grid of rays that meet its facets.
pub fn measure(scene: &PreparedScene) -> Vec<ScreenMetrics> {
    let renderer = CpuRenderer::new(scene);
    let frame = coarse(&scene.frame);
    let pixel = DVec3::from(scene.frame.ray_right.map(f64::from)).length();
    let [width, height] = frame.size.map(|side| side as u32);
    let pixels = |frame: &Frame| f64::from(frame.size[0]) * f64::from(frame.size[1]);
    let pixels_per_ray = pixels(&scene.frame) / pixels(&frame);
    let rays: Vec<RayMetrics> = (0..width * height)
        .into_par_iter()
        .filter_map(|i| {
            let direction = pixel_ray(&frame, i % width, i / width);
            let ([object, triangle], facet) = renderer.first_facet(&frame, direction)?;
            let prepared = &scene.objects[object as usize];
            let triangle = &prepared.triangles[triangle as usize];
            Some(RayMetrics::new(
                object,
                &prepared.parameters,
                triangle,
                &facet,
                direction,
                pixel,
            ))
        })
        .collect();
    (0..scene.objects.len() as u32)
        .map(|object| {
            ScreenMetrics::of(
                rays.iter().filter(|ray| ray.object == object),
                pixels_per_ray,
            )
        })
        .collect()
}

/// Returns `frame` with at most [`GRID`] rays along each side.
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

/// Returns a frame of `size` rays of `frame`: the first at `first` (pixels from
/// its first ray), the others `strides` pixels apart.
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

impl RayMetrics {
    fn new(
        object: u32,
        parameters: &Object,
        triangle: &Triangle,
        facet: &FacetHit,
        direction: Vec3,
        pixel: f64,
    ) -> RayMetrics {
        let surface = interpolate(triangle, facet);
        let depth = f64::from(parameters.depth);
        // Pixels per object unit at the hit.
        let scale = 1.0 / (pixel * f64::from(facet.t));
        let cosine = f64::from(-direction.dot(surface.normal)).clamp(LEAST_COSINE, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        let [x, y] =
            [surface.tangent, surface.bitangent].map(|axis| f64::from(direction.dot(axis)));
        let [xx, xy, yy] = surface.quadric.to_array().map(f64::from);
        // Curvature of the surface along the ray.
        let curvature = 2.0 * (xx * x * x + xy * x * y + yy * y * y) / (x * x + y * y).max(1e-12);
        let size = parameters.map_size.map(f64::from);
        let [u, v] = [surface.gradient_u, surface.gradient_v].map(Vec3::as_dvec3);
        let texels = smaller_stretch(u * size[0], v * size[1]);
        RayMetrics {
            object,
            facet_px: scale * f64::from(surface.facet_depth).max(0.0),
            way_px: scale * sine * way(depth, curvature, cosine / sine.max(1e-9)),
            slant: 1.0 / cosine,
            texel_px: if texels > 0.0 { scale / texels } else { 0.0 },
        }
    }
}

/// Computes the length of a ray's path along the surface until the ray is
/// `depth` below it, or has left it again. The ray descends by `slope` per unit
/// of length, and `curvature` is positive where the surface bends away from it.
fn way(depth: f64, curvature: f64, slope: f64) -> f64 {
    if curvature > 0.0 {
        // To the floor, or out again if it does not reach that deep.
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

impl ScreenMetrics {
    fn of<'a>(
        rays: impl Iterator<Item = &'a RayMetrics> + Clone,
        pixels_per_ray: f64,
    ) -> ScreenMetrics {
        let quantile = |value: fn(&RayMetrics) -> f64, share: f64| {
            let mut values: Vec<f64> = rays.clone().map(value).collect();
            values.sort_by(f64::total_cmp);
            let last = values.len().saturating_sub(1);
            let found = values.get((share * last as f64) as usize);
            found.copied().unwrap_or_default()
        };
        ScreenMetrics {
            rays: rays.clone().count(),
            pixels: pixels_per_ray * rays.clone().count() as f64,
            facet_px: quantile(|ray| ray.facet_px, 0.5),
            way_px: quantile(|ray| ray.way_px, 0.9),
            slant: quantile(|ray| ray.slant, 0.5),
            texel_px: quantile(|ray| ray.texel_px, 0.98),
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
}
