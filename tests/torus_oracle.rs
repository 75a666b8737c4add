//! What a carved torus really looks like: its closed-form depth and texture
//! coordinates, traced in f64 by steps that cannot skip (section 7). Shares no
//! marching code with the product, only the definition of the pattern's edge:
//! the zero set of the bilinear interpolation of the shape map.

use glam::DVec3;
use rayon::prelude::*;
use relievo::prepare::PreparedScene;
use relievo::render::GeometryWords;
use relievo::shape_map::ShapeMap;
use std::f64::consts::TAU;

/// The torus of `assets/meshes/torus.obj`.
const MAJOR: f64 = 1.0;
const MINOR: f64 = 0.4;

/// A carved torus around the y axis.
pub struct TorusOracle<'a> {
    /// The pattern.
    pub map: &'a ShapeMap,
    /// Repeats around the major and the minor circle.
    pub repeat: [f64; 2],
    /// S_z, object units.
    pub depth: f64,
    /// r(δ), texels.
    pub radius: &'a (dyn Fn(f64) -> f64 + Sync),
    /// The largest r, texels.
    pub largest_radius: f64,
}

/// How well a rendering agrees with the oracle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Pixels hit in both, over pixels hit in either.
    pub silhouette_iou: f64,
    /// Pixels that the oracle hits and the rendering misses.
    pub holes: usize,
    /// Those more than one pixel inside the oracle's outline.
    pub interior_holes: usize,
    /// Pixels that the rendering hits and the oracle misses.
    pub extra: usize,
    /// 99th percentile of the error of t, object units, where both hit.
    pub distance_p99: f64,
    /// Share of the pixels hit in both whose class differs.
    pub class_errors: f64,
}

impl TorusOracle<'_> {
    /// Depth below the surface, object units.
    fn depth_of(&self, p: DVec3) -> f64 {
        let ring = p.x.hypot(p.z) - MAJOR;
        MINOR - ring.hypot(p.y)
    }

    /// Distance to the pattern, texels.
    fn distance_to_pattern(&self, p: DVec3) -> f64 {
        let ring = p.x.hypot(p.z) - MAJOR;
        let u = p.x.atan2(p.z) / TAU * self.repeat[0];
        let v = -p.y.atan2(ring) / TAU * self.repeat[1];
        let (width, height) = (f64::from(self.map.width()), f64::from(self.map.height()));
        let x = u.rem_euclid(1.0) * width - 0.5;
        let y = v.rem_euclid(1.0) * height - 0.5;
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let texel = |dx: i64, dy: i64| {
            let tx = (x.floor() as i64 + dx).rem_euclid(i64::from(self.map.width()));
            let ty = (y.floor() as i64 + dy).rem_euclid(i64::from(self.map.height()));
            f64::from(self.map.decode(tx as u32, ty as u32))
        };
        let upper = texel(0, 0) * (1.0 - fx) + texel(1, 0) * fx;
        let lower = texel(0, 1) * (1.0 - fx) + texel(1, 1) * fx;
        upper * (1.0 - fy) + lower * fy
    }

    /// Class (0 miss, 1 cap, 2 side, 4 floor) and distance of the first hit.
    pub fn trace(&self, eye: DVec3, direction: DVec3) -> (u32, f64) {
        // The shortest way through the shell that crosses one texel.
        let per_texel = (TAU * (MAJOR - MINOR) / (self.repeat[0] * f64::from(self.map.width())))
            .min(TAU * (MINOR - self.depth) / (self.repeat[1] * f64::from(self.map.height())));
        let least = 1e-6;
        let mut t = 0.0;
        let mut before = 0.0;
        let far = eye.length() + 2.0 * (MAJOR + MINOR);
        while t < far {
            let p = eye + direction * t;
            let depth = self.depth_of(p);
            if depth < 0.0 {
                before = t;
                t += (-depth).max(least);
                continue;
            }
            let fraction = depth / self.depth;
            let distance = self.distance_to_pattern(p);
            let gap = distance - (self.radius)(fraction);
            if fraction >= 1.0 || gap <= 0.0 {
                return self.refine(eye, direction, before, t);
            }
            // The field is √2-Lipschitz a texel, and the largest radius bounds the growth.
            let sideways =
                (distance - self.largest_radius) * std::f64::consts::FRAC_1_SQRT_2 * per_texel;
            let down = self.depth - depth;
            before = t;
            t += sideways.min(down).max(least * 10.0);
        }
        (0, 0.0)
    }

    fn solid(&self, p: DVec3) -> bool {
        let depth = self.depth_of(p);
        depth >= self.depth
            || (depth >= 0.0 && self.distance_to_pattern(p) <= (self.radius)(depth / self.depth))
    }

    fn refine(
        &self,
        eye: DVec3,
        direction: DVec3,
        mut outside: f64,
        mut inside: f64,
    ) -> (u32, f64) {
        for _ in 0..60 {
            let middle = 0.5 * (outside + inside);
            if self.solid(eye + direction * middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        let fraction = self.depth_of(eye + direction * inside) / self.depth;
        let class = if fraction < 1e-4 {
            1
        } else if fraction > 1.0 - 1e-6 {
            4
        } else {
            2
        };
        (class, inside)
    }

    /// Compares what a renderer found in the frame of `scene` with the truth.
    pub fn judge(&self, scene: &PreparedScene, words: &GeometryWords) -> Accuracy {
        let (width, height) = (words.width as usize, words.height as usize);
        let camera = &scene.camera;
        let eye = DVec3::from(camera.eye);
        let frame = &scene.frame;
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let truth: Vec<(u32, f64)> = (0..width * height)
            .into_par_iter()
            .map(|i| {
                let raw = wide(frame.ray_first)
                    + wide(frame.ray_right) * (i % width) as f64
                    + wide(frame.ray_down) * (i / width) as f64;
                self.trace(eye, raw.normalize())
            })
            .collect();
        let ours: Vec<(u32, f64)> = words
            .place
            .iter()
            .enumerate()
            .map(|(i, place)| (words.class(i), f64::from(f32::from_bits(place[0]))))
            .collect();
        let inside = |i: usize| {
            let (x, y) = (i % width, i / width);
            x > 0
                && y > 0
                && x + 1 < width
                && y + 1 < height
                && (0..9).all(|k| truth[(y + k / 3 - 1) * width + x + k % 3 - 1].0 != 0)
        };
        let (mut both, mut either, mut holes, mut interior, mut extra, mut wrong) =
            (0, 0, 0, 0, 0, 0);
        let mut errors = Vec::new();
        for (i, (real, found)) in truth.iter().zip(&ours).enumerate() {
            let (hit, seen) = (real.0 != 0, found.0 != 0);
            either += usize::from(hit || seen);
            extra += usize::from(seen && !hit);
            holes += usize::from(hit && !seen);
            interior += usize::from(hit && !seen && inside(i));
            if hit && seen {
                both += 1;
                errors.push((real.1 - found.1).abs());
                let side = |class: u32| if class == 3 { 2 } else { class };
                wrong += usize::from(side(real.0) != side(found.0));
            }
        }
        errors.sort_by(f64::total_cmp);
        Accuracy {
            silhouette_iou: both as f64 / either.max(1) as f64,
            holes,
            interior_holes: interior,
            extra,
            distance_p99: errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0),
            class_errors: wrong as f64 / both.max(1) as f64,
        }
    }
}
