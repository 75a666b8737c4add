//! The carved torus: closed-form depth and texture coordinates, traced in f64
//! by steps that cannot skip.

use super::{Sample, Truth};
use crate::scene::Extrusion;
use crate::shape_map::ShapeMap;
use glam::DVec3;
use rayon::prelude::*;
use relievo_shared::layout::Frame;
use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// The torus of `assets/meshes/torus.obj`.
const MAJOR: f64 = 1.0;
const MINOR: f64 = 0.4;

/// A carved torus around the y axis, as `assets/meshes/torus.obj` approximates it.
pub struct TorusOracle<'a> {
    /// The pattern.
    pub map: &'a ShapeMap,
    /// Repeats around the major and the minor circle.
    pub repeat: [f64; 2],
    /// S_z, object units; less than the minor radius, 0.4.
    pub depth: f64,
    /// How the pattern grows with the depth.
    pub extrusion: Extrusion,
}

impl TorusOracle<'_> {
    /// What each ray of `frame` really meets, seen from `eye` (world units).
    pub fn truth(&self, eye: DVec3, frame: &Frame) -> Truth {
        let [width, height] = frame.size.map(|side| side as usize);
        let samples = (0..width * height)
            .into_par_iter()
            .map(|i| self.trace(eye, ray(frame, i % width, i / width)))
            .collect();
        Truth {
            width,
            height,
            samples,
        }
    }

    /// The first hit on the ray from `eye` along the unit vector `direction`.
    pub fn trace(&self, eye: DVec3, direction: DVec3) -> Sample {
        // The distance is √2-Lipschitz a texel, and the pattern grows on the way down.
        let growth = self.extrusion.bevel * f64::from(self.map.width()) / self.depth;
        let per_gap = 1.0 / (1.0 / (FRAC_1_SQRT_2 * self.shortest_texel()) + growth);
        let (least_outside, least_inside) = (1e-6, 1e-5);
        let mut t = 0.0;
        let mut before = 0.0;
        let far = eye.length() + 2.0 * (MAJOR + MINOR);
        while t < far {
            let p = eye + direction * t;
            let depth = self.depth_of(p);
            if depth < 0.0 {
                before = t;
                t += (-depth).max(least_outside);
                continue;
            }
            let gap = self.gap(p);
            if depth >= self.depth || gap <= 0.0 {
                return self.refine(eye, direction, before, t);
            }
            before = t;
            t += (gap * per_gap).min(self.depth - depth).max(least_inside);
        }
        Sample::MISS
    }

    /// Unit normal of the carved surface at `sample` of the ray from `eye`
    /// along the unit vector `direction`.
    pub fn normal(&self, eye: DVec3, direction: DVec3, sample: Sample) -> DVec3 {
        let p = eye + direction * sample.t;
        let slope = |f: &dyn Fn(DVec3) -> f64| {
            // Wide enough to smooth the staircase of the pattern's pixels.
            let h = 3.0 * self.shortest_texel();
            DVec3::AXES
                .map(|axis| f(p + axis * h) - f(p - axis * h))
                .into()
        };
        let gradient: DVec3 = if sample.class == CLASS_WALL {
            slope(&|p| self.gap(p))
        } else {
            -slope(&|p| self.depth_of(p))
        };
        gradient.normalize_or(-direction)
    }

    /// The shortest way through the shell that crosses one texel, object units.
    fn shortest_texel(&self) -> f64 {
        let width = self.repeat[0] * f64::from(self.map.width());
        let height = self.repeat[1] * f64::from(self.map.height());
        (TAU * (MAJOR - MINOR) / width).min(TAU * (MINOR - self.depth) / height)
    }

    /// Depth below the surface, object units.
    fn depth_of(&self, p: DVec3) -> f64 {
        let ring = p.x.hypot(p.z) - MAJOR;
        MINOR - ring.hypot(p.y)
    }

    /// g of section 2, texels: the distance to the grown pattern.
    fn gap(&self, p: DVec3) -> f64 {
        let Extrusion {
            extension,
            bevel,
            chamfer,
        } = self.extrusion;
        let fraction = (self.depth_of(p) / self.depth).max(0.0);
        let radius = extension + bevel * fraction.min(chamfer);
        self.distance_to_pattern(p) - radius * f64::from(self.map.width())
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

    fn is_solid(&self, p: DVec3) -> bool {
        let depth = self.depth_of(p);
        depth >= self.depth || (depth >= 0.0 && self.gap(p) <= 0.0)
    }

    fn refine(&self, eye: DVec3, direction: DVec3, mut outside: f64, mut inside: f64) -> Sample {
        for _ in 0..60 {
            let middle = 0.5 * (outside + inside);
            if self.is_solid(eye + direction * middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        let fraction = self.depth_of(eye + direction * inside) / self.depth;
        let class = if fraction < 1e-4 {
            CLASS_CAP
        } else if fraction > 1.0 - 1e-6 {
            CLASS_FLOOR
        } else {
            CLASS_WALL
        };
        Sample { class, t: inside }
    }
}

/// Unit direction through the centre of pixel (`x`, `y`) of `frame`.
fn ray(frame: &Frame, x: usize, y: usize) -> DVec3 {
    let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let raw =
        wide(frame.ray_first) + wide(frame.ray_right) * x as f64 + wide(frame.ray_down) * y as f64;
    raw.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape_map::{Pattern, Storage, bake};
    use proptest::prelude::*;

    /// One column a repeat, a quarter of it wide.
    fn map() -> ShapeMap {
        let pattern = Pattern::from_fn(8, 8, |x, _| (3..5).contains(&x)).unwrap();
        bake(&pattern, Storage::R16, &|_| ())
    }

    fn oracle(map: &ShapeMap, extrusion: Extrusion) -> TorusOracle<'_> {
        TorusOracle {
            map,
            repeat: [12.0, 5.0],
            depth: 0.1,
            extrusion,
        }
    }

    const BEVELED: Extrusion = Extrusion {
        extension: 0.05,
        bevel: 0.2,
        chamfer: 0.6,
    };

    proptest! {
        /// Small equal steps find no hit before the oracle's.
        #[test]
        fn nothing_is_skipped(aim in proptest::array::uniform3(-1.0f64..1.0), from in 0.2f64..3.0) {
            let map = map();
            let oracle = oracle(&map, BEVELED);
            let eye = DVec3::new(0.0, from, 3.0);
            let direction = (DVec3::from(aim) * DVec3::new(1.4, 0.4, 1.4) - eye).normalize();
            let sample = oracle.trace(eye, direction);
            let end = if sample.is_hit() { sample.t - 1e-4 } else { 6.0 };
            let mut t = 0.5;
            while t < end {
                prop_assert!(!oracle.is_solid(eye + direction * t), "{t} before {sample:?}");
                t += 2e-4;
            }
            if sample.is_hit() {
                prop_assert!(oracle.is_solid(eye + direction * (sample.t + 1e-9)));
                let normal = oracle.normal(eye, direction, sample);
                prop_assert!((normal.length() - 1.0).abs() < 1e-9);
            }
        }
    }

    /// From above onto a ring at the torus's top: cap, then floor beside it.
    #[test]
    fn straight_down_the_cap_and_the_floor_are_met() {
        let map = map();
        let oracle = oracle(
            &map,
            Extrusion {
                extension: 0.0,
                bevel: 0.0,
                chamfer: 1.0,
            },
        );
        let above = |u: f64| {
            let angle = TAU * u / 12.0;
            let eye = DVec3::new(angle.sin(), 3.0, angle.cos());
            oracle.trace(eye, DVec3::NEG_Y)
        };
        let (cap, floor) = (above(0.5), above(0.9));
        assert_eq!((cap.class, floor.class), (CLASS_CAP, CLASS_FLOOR));
        assert!((cap.t - 2.6).abs() < 1e-6 && (floor.t - 2.7).abs() < 1e-6);
    }
}
