//! The paper's algorithms as printed, to reproduce its figures and to measure its
//! errors against the other tiers. Every fault listed in section 8 is kept and marked
//! `Fault:`.
//!
//! Two things differ from the paper. Where a quotient has no value (a flat surface
//! gives 0/0), `quotient` returns 0 or [`FAR`] instead of NaN. And z points inward
//! throughout, the only reading under which (11), Algorithm 2 and Algorithm 9 agree.

use super::over_triangle::{OverTriangle, TriangleEntry, found_on};
use super::{Found, Ray};
use crate::arithmetic::{abs, clamp, div, max, min, normalize_or, sqrt};
use crate::layout::{Object, Triangle};
use crate::march::{END_CAP, END_FLOOR, END_MISS, END_SIDE, March};
use crate::shape_map::{ShapeMap, Texels};
use crate::surface::Surface;
use crate::{FAR, Real, Vec2, Vec3};

/// The paper's tier: its own path and search.
#[derive(Clone, Copy, Debug)]
pub struct Paper;

impl OverTriangle for Paper {
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
        let map = ShapeMap::new(ray.object);
        let found = search(ray.object, &map, texels, &entry.surface, ray.direction);
        found_on(entry, found)
    }
}

/// Returns `a / b`; [`FAR`] with the sign of `a` if `b` is nearly 0; 0 if both are.
#[inline]
fn quotient(a: Real, b: Real) -> Real {
    if abs(b) > 1e-15 {
        clamp(div(a, b), -FAR, FAR)
    } else if a > 1e-15 {
        FAR
    } else if a < -1e-15 {
        -FAR
    } else {
        0.0
    }
}

/// Largest texture coordinates at which a map can be read, repeats.
const FAR_UV: Real = 1e6;

/// Parameters of the paper's procedures: map, technique and steps.
struct Procedures<'a, T: Texels + ?Sized> {
    map: &'a ShapeMap,
    texels: &'a T,
    extension: Real,
    bevel: Real,
    chamfer: Real,
    linear_steps: u32,
    binary_steps: u32,
}

impl<T: Texels + ?Sized> Procedures<'_, T> {
    /// D(P) = τ EDT(P) − e, width units, 0 on the pattern; (4), and e as in the
    /// text below (7). Fault: e appears in no algorithm.
    #[inline]
    fn distance(&self, p: Vec3) -> Real {
        // Rays that leave the surface run away. Beyond the limit, uv has no
        // fractional digits.
        let uv = Vec2::new(clamp(p.x, -FAR_UV, FAR_UV), clamp(p.y, -FAR_UV, FAR_UV));
        let texels = self.map.distance(self.texels, uv) + 0.5;
        max(div(max(texels, 0.0), self.map.size.x) - self.extension, 0.0)
    }

    /// D_b(P) = D(P) − b z, (6).
    #[inline]
    fn beveled(&self, p: Vec3) -> Real {
        self.distance(p) - self.bevel * p.z
    }

    /// Algorithms 3 (basic) and 4 (beveled): the ray is inside the quadric.
    /// Fault: no exit test inside the loop, no snap to the floor; 4 idles once
    /// D_b ≤ 0. Fault: |(v_R + w)_xy| ≠ 1, so that a step is not conservative.
    /// Algorithms 5 and 6 differ by the term in q: `w` or `q` is 0.
    #[inline]
    fn march(&self, p0: Vec3, v: Vec3, w: Vec3, q: Real) -> (Real, u32) {
        let mut t = 0.0;
        let mut p = p0;
        let mut steps = 0;
        while steps < self.linear_steps && p.z < 1.0 {
            if self.bevel <= 0.0 || self.beveled(p) > 0.0 {
                t += self.distance(p);
                p = p0 + (v + w) * t;
                p.z -= t * t * q;
            }
            steps += 1;
        }
        (t, steps)
    }

    /// Algorithm 7. Fault: it starts from D(P), which is about 0 at the hit, in
    /// place of the last step. Fault: it walks along v, not the curved ray.
    #[inline]
    fn binary_search(&self, mut p: Vec3, v: Vec3) -> Vec3 {
        let mut distance = self.distance(p);
        let mut step = 0;
        while step < self.binary_steps {
            distance *= 0.5;
            if self.beveled(p) > 0.0 {
                p += v * distance;
            } else {
                p -= v * distance;
            }
            step += 1;
        }
        p
    }

    /// Algorithm 8, with D_c of (7). Fault: it walks along v, in width units.
    #[inline]
    fn chamfered(&self, mut p: Vec3, v: Vec3) -> Vec3 {
        if p.z > self.chamfer {
            let mut step = 0;
            while step < self.binary_steps {
                p += v * max(self.distance(p) - self.bevel * self.chamfer, 0.0);
                step += 1;
            }
        }
        p
    }
}

/// Algorithm 1. Fault, line 2: a V_x² + a V_y². Fault: depth "1" must be S_z.
/// Fault, line 7: the far root. Fault: t_max is not set where D ≤ 0 (here:
/// never), and |·| hides a wrong sign.
#[inline]
fn t_max_inside(a: Real, b: Real, v: Vec3, u: Vec3) -> Real {
    let qa = a * v.x * v.x + a * v.y * v.y;
    let qb = 2.0 * a * v.x * u.x + 2.0 * b * v.y * u.y - v.z;
    let qc = a * u.x * u.x + b * u.y * u.y - u.z;
    let d = qb * qb - 4.0 * qa * qc;
    let mut t_max = FAR;
    if d > 0.0 {
        t_max = quotient(qb - sqrt(d), -2.0 * qa);
    }
    let d = quotient(v.z, qa);
    if d > 0.0 {
        t_max = min(t_max, d);
    }
    abs(t_max)
}

/// Algorithm 2. Fault, line 2: V_z² − 4 q must be V_z² − 4 q S_z. The rest as
/// in Algorithm 1.
#[inline]
fn t_max_outside(v: Vec3, q: Real) -> Real {
    let d = v.z * v.z - 4.0 * q;
    let mut t_max = FAR;
    if d > 0.0 {
        t_max = quotient(sqrt(d) - v.z, -2.0 * q);
    }
    let d = quotient(v.z, q);
    if d > 0.0 {
        t_max = min(t_max, d);
    }
    abs(t_max)
}

/// Runs Algorithm 9 for the ray along the unit vector `direction` over `surface`. The
/// result's `s` is the distance from the facet, object units.
#[inline]
pub fn search<T: Texels + ?Sized>(
    object: &Object,
    map: &ShapeMap,
    texels: &T,
    surface: &Surface,
    direction: Vec3,
) -> March {
    let search = Procedures {
        map,
        texels,
        extension: object.extension,
        bevel: object.bevel,
        chamfer: object.chamfer,
        linear_steps: object.linear_steps,
        binary_steps: object.binary_steps,
    };
    // Fault: z = a x² + b y² of (8) has no cross term.
    let (a, b) = (surface.quadric.x, surface.quadric.z);
    let to_texture = |x: Vec3| {
        Vec3::new(
            x.dot(surface.gradient_u),
            x.dot(surface.gradient_v),
            -div(x.dot(surface.normal), object.depth),
        )
    };
    let v_tangent = Vec3::new(
        direction.dot(surface.tangent),
        direction.dot(surface.bitangent),
        -direction.dot(surface.normal),
    );
    let u_tangent = normalize_or(v_tangent * v_tangent.z - Vec3::Z, Vec3::X);
    let u_object = surface.tangent * u_tangent.x + surface.bitangent * u_tangent.y
        - surface.normal * u_tangent.z;

    // Lines 2–7. Fault: R is Width/Height and must be Height/Width. Fault: the
    // parameter is normalised by depth, which grazing rays have none of.
    let p0 = Vec3::new(surface.uv.x, surface.uv.y, 0.0);
    let ratio = div(map.size.x, map.size.y);
    let raw = to_texture(direction);
    let length = sqrt(raw.dot(raw));
    let v = normalize_or(raw, Vec3::Z);
    let z = max(v.z, 1e-12);
    let v = v * div(1.0, z);
    let flat = max(sqrt(v.x * v.x + ratio * ratio * v.y * v.y), 1e-12);
    let v_r = v * div(1.0, flat);
    // t of v_R, as a distance along the ray.
    let object_units = div(1.0, max(length * z * flat, 1e-18));

    // Lines 8–11. Fault: with U perpendicular to V, d is not a depth. Fault:
    // D > 0 asks whether a line meets the quadric, not whether it is convex.
    let qa = a * u_tangent.x * u_tangent.x + b * u_tangent.y * u_tangent.y;
    let qb =
        2.0 * a * v_tangent.x * u_tangent.x + 2.0 * b * v_tangent.y * u_tangent.y - u_tangent.z;
    let qc = a * v_tangent.x * v_tangent.x + b * v_tangent.y * v_tangent.y - v_tangent.z;
    let discriminant = qb * qb - 4.0 * qa * qc;
    let (t_max, (t, steps)) = if discriminant > 0.0 {
        let t_max = t_max_inside(a, b, v_tangent, u_tangent);
        // Fault, line 14: u must not be normalised.
        let u = normalize_or(to_texture(u_object), Vec3::ZERO);
        // Fault: R = P + U d lies on the quadric; where it is flat, this is 0/0.
        let d = clamp(
            quotient(quotient(qb - sqrt(discriminant), -2.0 * qa), z),
            -1e9,
            1e9,
        );
        (t_max, search.march(p0, v_r, u * d, 0.0))
    } else {
        let q = a * v_tangent.x * v_tangent.x + b * v_tangent.y * v_tangent.y;
        let t_max = t_max_outside(v_tangent, q);
        // Fault, line 25: q / S_z / z² belongs to another parameter than v_R's.
        let q = clamp(quotient(div(q, object.depth), z * z), -1e9, 1e9);
        (t_max, search.march(p0, v_r, Vec3::ZERO, q))
    };
    // Line 32. Fault: t is in width units, t_max in object units; floor hits
    // have t ≥ t_max and are discarded.
    if t > t_max {
        return March {
            end: END_MISS,
            s: 0.0,
            uv: surface.uv,
            depth_fraction: 0.0,
            steps,
        };
    }
    // Line 35. Fault: w and −q t² are dropped.
    let mut p = p0 + v_r * t;
    if object.bevel > 0.0 {
        p = search.binary_search(p, v_r);
        if object.chamfer < 1.0 {
            p = search.chamfered(p, v_r);
        }
    }
    let travelled = quotient(p.z - p0.z, v_r.z);
    let end = if p.z >= 1.0 {
        END_FLOOR
    } else if t <= 0.0 {
        END_CAP
    } else {
        END_SIDE
    };
    March {
        end,
        s: clamp(travelled * object_units, -1e9, 1e9),
        uv: Vec2::new(p.x, p.y),
        depth_fraction: clamp(p.z, 0.0, 1.0),
        steps,
    }
}
