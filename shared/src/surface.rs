//! The smooth surface at a point of a facet, interpolated from the corners.

use crate::arithmetic::{div, kept3, normalize_or};
use crate::contract::SMALLEST_PRODUCT;
use crate::facet::FacetHit;
use crate::layout::{Triangle, depth_reductions, vec2, vec3};
use crate::{Real, Vec2, Vec3};

/// The surface above a point of a facet.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Unit normal N, pointing out.
    pub normal: Vec3,
    /// Unit tangent T, orthogonal to N.
    pub tangent: Vec3,
    /// Unit bitangent B, orthogonal to both.
    pub bitangent: Vec3,
    /// Quadric coefficients (xx, xy, yy) in (T, B), 1 / object units.
    pub quadric: Vec3,
    /// Texture coordinates, repeats.
    pub uv: Vec2,
    /// ∇u in the plane orthogonal to N, repeats per object unit.
    pub gradient_u: Vec3,
    /// ∇v in the plane orthogonal to N, repeats per object unit.
    pub gradient_v: Vec3,
    /// Half the second derivative of the texture coordinates on the surface along
    /// the ray, see [`uv_bend`]; 0 in models that do not use it.
    pub uv_bend: Vec2,
    /// δ0: how far the facet lies below the smooth surface here, object units.
    pub facet_depth: Real,
}

impl Surface {
    /// Returns the cap of an object whose rays ask for their exits: this surface, or the facet
    /// where the quadric is 0. There the surface is straight (docs/object.md), although its
    /// normals may differ. `facet_normal` has the direction of the facet's normal.
    #[inline]
    pub fn cap(self, facet_normal: Vec3) -> Surface {
        let is_straight = self.quadric.x == 0.0 && self.quadric.y == 0.0 && self.quadric.z == 0.0;
        Surface {
            normal: if is_straight {
                normalize_or(facet_normal, self.normal)
            } else {
                self.normal
            },
            facet_depth: if is_straight { 0.0 } else { self.facet_depth },
            ..self
        }
    }
}

/// Returns the surface of `triangle` at `hit`.
#[inline]
pub fn interpolate(triangle: &Triangle, hit: &FacetHit) -> Surface {
    let [a, b, c] = &triangle.corners;
    let (wa, wb, wc) = (hit.weights.x, hit.weights.y, hit.weights.z);
    let (na, nb, nc) = (vec3(a.normal), vec3(b.normal), vec3(c.normal));
    let sum_of_normals = na * wa + nb * wb + nc * wc;
    // Normals that cancel have no direction: the facet's is used.
    let has_direction = sum_of_normals.dot(sum_of_normals) > 1e-30;
    let raw_normal = if has_direction {
        sum_of_normals
    } else {
        hit.normal
    };
    let normal = normalize_or(raw_normal, Vec3::Z);

    let raw_tangent = vec3(a.tangent) * wa + vec3(b.tangent) * wb + vec3(c.tangent) * wc;
    let tangent = normalize_or(
        raw_tangent - normal * normal.dot(raw_tangent),
        any_perpendicular(normal),
    );
    let bitangent = normal.cross(tangent) * triangle.handedness;

    // ½ [interp(p·n) − p·interp(n)] with p relative to corner a (section 4).
    let pb = vec3(b.position) - vec3(a.position);
    let pc = vec3(c.position) - vec3(a.position);
    let p = pb * wb + pc * wc;
    let facet_depth = 0.5 * (wb * pb.dot(nb) + wc * pc.dot(nc) - p.dot(sum_of_normals));

    let gradient_u = vec3(a.gradient_u) * wa + vec3(b.gradient_u) * wb + vec3(c.gradient_u) * wc;
    let gradient_v = vec3(a.gradient_v) * wa + vec3(b.gradient_v) * wb + vec3(c.gradient_v) * wc;
    Surface {
        uv_bend: Vec2::ZERO,
        normal,
        tangent,
        bitangent,
        quadric: kept3(vec3(a.quadric) * wa + vec3(b.quadric) * wb + vec3(c.quadric) * wc),
        uv: vec2(a.uv) * wa + vec2(b.uv) * wb + vec2(c.uv) * wc,
        gradient_u: gradient_u - normal * gradient_u.dot(normal),
        gradient_v: gradient_v - normal * gradient_v.dot(normal),
        facet_depth,
    }
}

/// Returns the local depth h of the shell over `triangle` at `hit` in an object whose
/// depth S_z is `depth`, object units: S_z exactly where nothing reduces it.
#[inline]
pub fn local_depth(triangle: &Triangle, hit: &FacetHit, depth: Real) -> Real {
    let [a, b, c] = depth_reductions(triangle.depth_reductions);
    let reduction = a * hit.weights.x + b * hit.weights.y + c * hit.weights.z;
    depth * (1.0 - reduction)
}

/// Returns half the second derivative of the texture coordinates along the part of
/// `direction` in the surface of `triangle` with unit normal `normal`, repeats per square
/// object unit. It is not 0 since ∇u and ∇v differ between the corners.
#[inline]
pub fn uv_bend(triangle: &Triangle, normal: Vec3, direction: Vec3) -> Vec2 {
    let [a, b, c] = &triangle.corners;
    let second = vec3(b.position) - vec3(a.position);
    let third = vec3(c.position) - vec3(a.position);
    let along = direction - normal * normal.dot(direction);
    let facet_normal = second.cross(third);
    let squared = facet_normal.dot(facet_normal);
    // A triangle too small for its square to be a normal number counts as one with
    // constant gradients.
    let scale = if squared > SMALLEST_PRODUCT {
        div(0.5, squared)
    } else {
        0.0
    };
    // Change of the weights of the second and of the third corner.
    let by_second = scale * facet_normal.dot(along.cross(third));
    let by_third = scale * facet_normal.dot(second.cross(along));
    let change = |a: [Real; 3], b: [Real; 3], c: [Real; 3]| {
        let at_a = vec3(a).dot(along);
        by_second * (vec3(b).dot(along) - at_a) + by_third * (vec3(c).dot(along) - at_a)
    };
    Vec2::new(
        change(a.gradient_u, b.gradient_u, c.gradient_u),
        change(a.gradient_v, b.gradient_v, c.gradient_v),
    )
}

/// Returns a unit vector orthogonal to the unit vector `n`.
#[inline]
fn any_perpendicular(n: Vec3) -> Vec3 {
    let axis = if n.x * n.x < 0.5 { Vec3::X } else { Vec3::Y };
    normalize_or(kept3(axis - n * n.dot(axis)), Vec3::Z)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::layout::Corner;
    use crate::layout::{REDUCTION_STEPS, pack_depth_reductions};
    use proptest::prelude::*;

    fn sphere_triangle(directions: [Vec3; 3], radius: Real) -> Triangle {
        Triangle {
            corners: directions.map(|n| Corner {
                position: (n * radius).to_array(),
                normal: n.to_array(),
                tangent: any_perpendicular(n).to_array(),
                quadric: [0.5 / radius, 0.0, 0.5 / radius],
                gradient_u: [1.0, 0.0, 0.0],
                gradient_v: [0.0, 1.0, 0.0],
                ..Corner::default()
            }),
            handedness: 1.0,
            depth_reductions: 0,
        }
    }

    proptest! {
        #[test]
        fn facet_depth_of_a_sphere(
            radius in 0.01f32..100.0,
            weights in (0.05f32..1.0, 0.05f32..1.0, 0.05f32..1.0),
        ) {
            let unit = |x: Real, y: Real| normalize_or(Vec3::new(x, y, 1.0), Vec3::Z);
            let triangle = sphere_triangle([unit(0.0, 0.0), unit(0.2, 0.0), unit(0.0, 0.2)], radius);
            let weights = Vec3::new(weights.0, weights.1, weights.2);
            let weights = weights / (weights.x + weights.y + weights.z);
            let p: Vec3 = (0..3)
                .map(|i| vec3(triangle.corners[i].position) * weights[i])
                .fold(Vec3::ZERO, |sum, p| sum + p);
            let hit = FacetHit { hit: true, t: 1.0, weights, normal: Vec3::Z };
            let surface = interpolate(&triangle, &hit);
            let exact = radius - p.length();
            prop_assert!((surface.facet_depth - exact).abs() < 0.03 * exact + 1e-5 * radius);
            prop_assert!(surface.tangent.dot(surface.normal).abs() < 1e-6);
            prop_assert!((surface.bitangent.length() - 1.0).abs() < 1e-5);
            prop_assert!(surface.gradient_u.dot(surface.normal).abs() < 1e-5);
        }
    }

    fn at(weights: [Real; 3]) -> FacetHit {
        FacetHit {
            hit: true,
            t: 1.0,
            weights: vec3(weights),
            normal: Vec3::new(0.0, 0.0, 5.0),
        }
    }

    #[test]
    fn texture_coordinates_bend_as_their_gradients_change() {
        // u = x² + 3 x y, v = −2 y² over the plane.
        let corner = |x: f32, y: f32| Corner {
            position: [x, y, 0.0],
            gradient_u: [2.0 * x + 3.0 * y, 3.0 * x, 0.0],
            gradient_v: [0.0, -4.0 * y, 0.0],
            ..Corner::default()
        };
        let mut triangle = Triangle {
            corners: [corner(0.2, 0.1), corner(1.3, 0.4), corner(0.5, 0.9)],
            handedness: 1.0,
            depth_reductions: 0,
        };
        for (x, y, z) in [(1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (0.48, -0.64, -0.6)] {
            let bend = uv_bend(&triangle, Vec3::Z, Vec3::new(x, y, z));
            let expected = Vec2::new(x * x + 3.0 * x * y, -2.0 * y * y);
            assert!((bend - expected).length() < 1e-5, "{bend} {expected}");
        }
        // No area, no change.
        triangle.corners[2] = triangle.corners[1];
        assert_eq!(uv_bend(&triangle, Vec3::Z, Vec3::X), Vec2::ZERO);
    }

    #[test]
    fn a_corner_is_reproduced() {
        let mut triangle = sphere_triangle([Vec3::X, Vec3::Y, Vec3::Z], 2.0);
        for (i, corner) in triangle.corners.iter_mut().enumerate() {
            corner.uv = [i as f32, 1.0 - i as f32];
            corner.quadric = [i as f32, -1.0, 0.5];
        }
        let surface = interpolate(&triangle, &at([0.0, 1.0, 0.0]));
        assert_eq!(surface.normal, Vec3::Y);
        assert_eq!(surface.uv, Vec2::new(1.0, 0.0));
        assert_eq!(surface.quadric, Vec3::new(1.0, -1.0, 0.5));
        // Exactly at a corner the facet lies on the surface.
        assert!(surface.facet_depth.abs() < 1e-6);
        // ∇v = (0, 1, 0) stands upright here, and is pressed into the surface.
        assert_eq!(surface.gradient_u, Vec3::X);
        assert_eq!(surface.gradient_v, Vec3::ZERO);
    }

    #[test]
    fn the_local_depth_is_linear_between_the_corners() {
        let mut triangle = sphere_triangle([Vec3::X, Vec3::Y, Vec3::Z], 2.0);
        let middle = at([0.1, 0.2, 0.7]);
        assert_eq!(local_depth(&triangle, &middle, 0.3), 0.3);
        triangle.depth_reductions = pack_depth_reductions([341, 682, 0]);
        let near = |weights: [f32; 3], depth: f32| {
            (local_depth(&triangle, &at(weights), 3.0) - depth).abs() < 1e-6
        };
        assert!(near([1.0, 0.0, 0.0], 2.0) && near([0.0, 1.0, 0.0], 1.0));
        assert!(near([0.0, 0.0, 1.0], 3.0) && near([0.1, 0.2, 0.7], 2.5));
        assert_eq!(
            depth_reductions(pack_depth_reductions([REDUCTION_STEPS, 0, 0])),
            [1.0, 0.0, 0.0]
        );
    }

    #[test]
    fn handedness_turns_the_bitangent() {
        let mut triangle = sphere_triangle([Vec3::Z; 3], 1.0);
        let right = interpolate(&triangle, &at([0.2, 0.3, 0.5])).bitangent;
        triangle.handedness = -1.0;
        let left = interpolate(&triangle, &at([0.2, 0.3, 0.5])).bitangent;
        assert_eq!(right, -left);
        assert!((right - Vec3::Z.cross(any_perpendicular(Vec3::Z))).length() < 1e-6);
    }

    #[test]
    fn normals_and_tangents_that_cancel_have_a_replacement() {
        let mut triangle = sphere_triangle([Vec3::X, Vec3::NEG_X, Vec3::Y], 1.0);
        triangle.corners[1].tangent = (-vec3(triangle.corners[0].tangent)).to_array();
        let surface = interpolate(&triangle, &at([0.5, 0.5, 0.0]));
        // The facet's own normal.
        assert_eq!(surface.normal, Vec3::Z);
        assert!((surface.tangent.length() - 1.0).abs() < 1e-6);
        assert!(surface.tangent.dot(surface.normal).abs() < 1e-6);
        for n in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, vec3([0.6, 0.0, 0.8])] {
            let perpendicular = any_perpendicular(n);
            assert!((perpendicular.length() - 1.0).abs() < 1e-6);
            assert!(perpendicular.dot(n).abs() < 1e-6);
        }
    }

    #[test]
    fn the_depth_of_a_hollow_facet_is_negative_and_of_a_flat_one_zero() {
        let unit = |x: Real, y: Real| normalize_or(Vec3::new(x, y, 1.0), Vec3::Z);
        let mut triangle = sphere_triangle([unit(0.0, 0.0), unit(0.2, 0.0), unit(0.0, 0.2)], 1.0);
        let middle = at([0.4, 0.3, 0.3]);
        let convex = interpolate(&triangle, &middle).facet_depth;
        assert!(convex > 0.001);
        // The same facet with normals that point to the centre.
        for corner in &mut triangle.corners {
            corner.normal = corner.normal.map(|n| -n);
        }
        assert!((interpolate(&triangle, &middle).facet_depth + convex).abs() < 1e-6);
        for corner in &mut triangle.corners {
            corner.normal = [0.0, 0.0, 1.0];
        }
        assert!(interpolate(&triangle, &middle).facet_depth.abs() < 1e-6);
    }
}
