//! Traces carved surfaces of a known shape in f64, by steps that cannot skip.

use super::shape::{Foot, Shape};
use super::wide::wide_object;
use super::{Oracle, Sample};
use crate::prepare::{Placement, PreparedObject};
use crate::scene::SceneObject;
use crate::shape_map::ShapeMap;
use glam::{DVec2, DVec3};
use relievo_shared::normals::{CLASS_CAP, CLASS_FLOOR, CLASS_WALL};
use relievo_shared_f64::profile::Profile;
use std::f64::consts::SQRT_2;

/// Minimum steps outside and inside the shell, object units; only thinner details
/// can be missed.
const LEAST_OUTSIDE: f64 = 1e-6;
const LEAST_INSIDE: f64 = 1e-5;

/// A carved surface of a known shape.
///
/// The solid lies between the surface's borders where δ ≥ 1 (unless cut out), and
/// where 0 ≤ δ < 1 and g ≤ 0. Only its outside is hit, as in the renderers: a ray
/// below the floor, through a cut-out or past a border, hits nothing until it is
/// outside the surface again.
pub struct AnalyticOracle<'a> {
    /// The surface.
    pub shape: &'a dyn Shape,
    /// Its transform.
    pub placement: Placement,
    /// The shape map.
    pub map: &'a ShapeMap,
    /// Repeats along u and v; whole numbers where they are closed.
    pub repeat: [f64; 2],
    /// S_z, world units; less than the shape's largest depth times the scale.
    pub depth: f64,
    /// Growth of the pattern with the depth.
    pub profile: Profile,
    /// Further layers.
    pub layers: Vec<LayerOracle<'a>>,
    /// Texels that a unit of δ counts for, above and below layers.
    pub slope: f64,
    /// Whether there is no floor.
    pub cut_out: bool,
}

/// A further layer of a carved surface.
pub struct LayerOracle<'a> {
    /// Its map, of the same size.
    pub map: &'a ShapeMap,
    /// δ where it begins and ends.
    pub range: [f64; 2],
    /// Its growth, from δ = 0 to 1 within that range.
    pub profile: Profile,
}

impl Oracle for AnalyticOracle<'_> {
    fn trace(&self, eye: DVec3, direction: DVec3) -> Sample {
        let ray = Ray {
            eye: self.placement.to_object(eye),
            direction: self.placement.direction_to_object(direction),
        };
        match self.first_solid(&ray) {
            Some((before, t)) => self.refine(&ray, before, t),
            None => Sample::MISS,
        }
    }
}

/// A ray in object space, its direction of length 1.
struct Ray {
    eye: DVec3,
    direction: DVec3,
}

impl Ray {
    fn at(&self, t: f64) -> DVec3 {
        self.eye + self.direction * t
    }

    /// Returns the range of t ≥ 0 in the ball of `radius` around the origin.
    fn within(&self, radius: f64) -> Option<(f64, f64)> {
        let middle = -self.eye.dot(self.direction);
        let off = self.at(middle).length_squared();
        let half = (radius * radius - off).max(0.0).sqrt();
        (half > 0.0 && middle + half > 0.0).then(|| ((middle - half).max(0.0), middle + half))
    }
}

impl<'a> AnalyticOracle<'a> {
    /// Makes the oracle of a scene's object, with `shape` in place of its mesh.
    pub fn new(shape: &'a dyn Shape, object: &SceneObject, prepared: &'a PreparedObject) -> Self {
        let parameters = &prepared.parameters;
        let mut layers = prepared.layers.iter().map(|layer| LayerOracle {
            map: &layer.map,
            range: layer.range,
            profile: Profile::new(&wide_object(&layer.parameters)),
        });
        let (map, profile) = match layers.next() {
            Some(own) => (own.map, own.profile),
            None => (&*prepared.map, Profile::new(&wide_object(parameters))),
        };
        Self {
            shape,
            placement: prepared.transform,
            map,
            repeat: object.repeat,
            depth: prepared.unit() * f64::from(parameters.depth),
            profile,
            layers: layers.collect(),
            slope: Profile::new(&wide_object(parameters)).largest_slope(),
            cut_out: object.cut_out,
        }
    }

    /// Computes the unit normal of the carved surface at `sample` of the ray from
    /// `eye` along the unit vector `direction`; world space.
    pub fn normal(&self, eye: DVec3, direction: DVec3, sample: Sample) -> DVec3 {
        let p = self.placement.to_object(eye + direction * sample.t);
        // Wide enough to smooth the staircase outline of the pattern.
        let h = 3.0 / self.texel_rate(p, 0.5 * self.own_depth()).0;
        let slope = |f: &dyn Fn(&Foot) -> f64| -> DVec3 {
            let f = |p| f(&self.shape.foot(p));
            DVec3::AXES
                .map(|axis| f(p + axis * h) - f(p - axis * h))
                .into()
        };
        let gradient = if sample.class == CLASS_WALL {
            slope(&|foot| self.gap(foot))
        } else {
            -slope(&|foot| foot.depth)
        };
        self.placement.rotation
            * gradient.normalize_or(-self.placement.direction_to_object(direction))
    }

    /// S_z, object units.
    fn own_depth(&self) -> f64 {
        self.depth / self.placement.scale
    }

    /// Returns t (object units) of a point outside the solid and of one inside it,
    /// which bracket the first hit.
    fn first_solid(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (start, end) = ray.within(self.shape.radius())?;
        let floor = self.own_depth();
        let (mut t, mut before) = (start, start);
        let mut outside = self.shape.foot(ray.at(start)).depth < floor;
        while t <= end {
            let p = ray.at(t);
            let foot = self.shape.foot(p);
            if foot.beyond > 0.0 || foot.depth < 0.0 {
                outside = foot.depth < floor;
                before = t;
                t += foot
                    .beyond
                    .max(-foot.depth)
                    .max(foot.depth - floor)
                    .max(LEAST_OUTSIDE);
                continue;
            }
            if outside && self.is_solid(&foot) {
                return Some((before, t));
            }
            before = t;
            outside &= foot.depth < floor;
            t += if outside {
                self.safe_step(p, &foot)
            } else {
                // To the surface or a border, but at least to the floor.
                let way_out = foot.depth.min(-foot.beyond);
                way_out.max(foot.depth - floor).max(LEAST_OUTSIDE)
            };
        }
        None
    }

    /// Returns a step through the shell that reaches neither the floor nor the
    /// grown pattern, but at least [`LEAST_INSIDE`].
    fn safe_step(&self, p: DVec3, foot: &Foot) -> f64 {
        let floor = self.own_depth();
        let (texels, reach) = self.texel_rate(p, floor - foot.depth);
        // The distance is √2-Lipschitz per texel, and the pattern grows downwards.
        let slope = |layer: &LayerOracle<'_>| {
            layer.profile.largest_slope() / (layer.range[1] - layer.range[0])
        };
        let slopes = self.layers.iter().map(slope);
        let own = match self.layers.is_empty() {
            true => self.profile.largest_slope(),
            false => self.profile.largest_slope().max(self.slope),
        };
        let growth = slopes.fold(own, f64::max) / floor;
        let gap = self.gap(foot);
        (gap / (SQRT_2 * texels + growth))
            .min(reach)
            .max(LEAST_INSIDE)
    }

    /// Returns the maximum texels per object unit within some reach of `p`, and
    /// that reach, which is at most `limit`.
    fn texel_rate(&self, p: DVec3, limit: f64) -> (f64, f64) {
        let metric = self.shape.metric(p, limit);
        let rate = self.texels() / metric.lengths;
        (rate.length(), metric.reach)
    }

    /// Returns the texels per unit of u and of v.
    fn texels(&self) -> DVec2 {
        let size = DVec2::new(f64::from(self.map.width()), f64::from(self.map.height()));
        DVec2::from(self.repeat) * size
    }

    /// Computes g of section 2, texels: the distance to the grown pattern, or to the nearest layer.
    fn gap(&self, foot: &Foot) -> f64 {
        self.gap_and_face(foot).0
    }

    /// Computes that distance, and whether a layer's cap or underside is nearest.
    fn gap_and_face(&self, foot: &Foot) -> (f64, bool) {
        let fraction = (foot.depth / self.own_depth()).clamp(0.0, 1.0);
        let distance = self.distance_to(self.map, foot.uv);
        let mut nearest = (self.profile.gap(distance, fraction), false);
        for layer in &self.layers {
            let [top, bottom] = layer.range;
            let own = ((fraction - top) / (bottom - top)).clamp(0.0, 1.0);
            let beside = layer.profile.gap(self.distance_to(layer.map, foot.uv), own);
            let above = if top > 0.0 { top - fraction } else { -1.0 };
            let below = if bottom < 1.0 {
                fraction - bottom
            } else {
                -1.0
            };
            let face = self.slope * above.max(below);
            if beside.max(face) < nearest.0 {
                nearest = (beside.max(face), face > beside);
            }
        }
        nearest
    }

    /// Computes the distance to the pattern of `map`, texels: the bilinear interpolation of
    /// the map, whose rows run down while v runs up.
    fn distance_to(&self, map: &ShapeMap, uv: DVec2) -> f64 {
        let (width, height) = (map.width(), map.height());
        let column = |x: f64| (x as i64).rem_euclid(i64::from(width)) as u32;
        let row = |y: f64| (y as i64).rem_euclid(i64::from(height)) as u32;
        let place = self.texels() * DVec2::new(uv.x, -uv.y) - 0.5;
        let (whole, part) = (place.floor(), place - place.floor());
        let texel =
            |dx: f64, dy: f64| f64::from(map.decode(column(whole.x + dx), row(whole.y + dy)));
        let upper = texel(0.0, 0.0) * (1.0 - part.x) + texel(1.0, 0.0) * part.x;
        let lower = texel(0.0, 1.0) * (1.0 - part.x) + texel(1.0, 1.0) * part.x;
        upper * (1.0 - part.y) + lower * part.y
    }

    fn is_solid(&self, foot: &Foot) -> bool {
        foot.beyond <= 0.0
            && foot.depth >= 0.0
            && if foot.depth >= self.own_depth() {
                !self.cut_out
            } else {
                self.gap(foot) <= 0.0
            }
    }

    fn refine(&self, ray: &Ray, mut outside: f64, mut inside: f64) -> Sample {
        for _ in 0..60 {
            let middle = 0.5 * (outside + inside);
            if self.is_solid(&self.shape.foot(ray.at(middle))) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        let foot = self.shape.foot(ray.at(inside));
        let fraction = foot.depth / self.own_depth();
        let class = if fraction > 1.0 - 1e-6 && !self.cut_out {
            CLASS_FLOOR
        } else if fraction < 1e-4 || self.gap_and_face(&foot).1 {
            CLASS_CAP
        } else {
            CLASS_WALL
        };
        Sample {
            class,
            t: inside * self.placement.scale,
        }
    }
}

#[cfg(test)]
mod tests;
