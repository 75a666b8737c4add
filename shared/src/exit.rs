//! Where a ray leaves the mesh: the nearest back face on it.
//!
//! The quadric of a facet knows the surface near the facet. Where it lets a ray out
//! through the cap although the mesh goes on, the mesh itself is asked: see
//! [`QuadraticPath::until`](crate::path::QuadraticPath::until). On a GPU a render pass
//! writes the nearest back face of each pixel before the objects are drawn.

use crate::arithmetic::{clamp, floor};
use crate::camera::reversed_depth;
use crate::facet::{FacetHit, intersect};
use crate::layout::{Frame, Object, Triangle, vec3};
use crate::surface::{interpolate, local_depth};
use crate::{Real, Vec2, Vec3};
use glam::UVec4;

/// The nearest back face on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    /// Distance from the eye to the facet, object units; 0 where none is known.
    pub t: Real,
    /// Cosine of the angle between the ray and the normal of the cap there, 0 to 1.
    pub slope: Real,
    /// How far the facet lies below the cap there, object units.
    pub facet_depth: Real,
    /// Texture coordinates there, repeats; known up to whole numbers.
    pub uv: Vec2,
    /// The local depth h there, object units.
    pub depth: Real,
}

/// Returns the number that marks the exits of `object`, or of its copy, drawn with `frame`.
#[inline]
pub fn number(frame: &Frame, object: &Object) -> u32 {
    object.number.wrapping_add(frame.number)
}

/// The nearest back face on the ray of one pixel, as [`Exit::words`] stores it.
pub trait Exits {
    /// Returns its words; zeros where there is none.
    fn words(&self) -> UVec4;
}

/// The words of an exit that is known already; zeros for none.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownExit(pub UVec4);

impl Exits for KnownExit {
    #[inline]
    fn words(&self) -> UVec4 {
        self.0
    }
}

/// No exits: where nobody has looked for them.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoExits;

impl Exits for NoExits {
    #[inline]
    fn words(&self) -> UVec4 {
        UVec4::ZERO
    }
}

/// The bits of the facet's depth that hold the object's number instead.
const NUMBER: u32 = 0xff;
/// The bits of h that are kept.
const UPPER: u32 = 0xffff_0000;

/// Returns `triangle` as seen from behind, to intersect it. The depth reductions keep the
/// order of the corners of `triangle`.
#[inline]
pub fn reversed(triangle: &Triangle) -> Triangle {
    let [a, b, c] = triangle.corners;
    Triangle {
        corners: [a, c, b],
        ..*triangle
    }
}

/// Intersects the ray from the eye of `frame` along `direction` with the back side of
/// `triangle`, behind the near plane. Returns the hit on the triangle's front side, and
/// its reversed depth; the largest one on a ray is its exit.
#[inline]
pub fn meet(frame: &Frame, direction: Vec3, triangle: &Triangle) -> (FacetHit, Real) {
    let behind = intersect(vec3(frame.eye), direction, &reversed(triangle));
    let depth = reversed_depth(frame, direction, behind.t);
    let weights = behind.weights;
    let found = FacetHit {
        hit: behind.hit & (depth <= 1.0),
        t: behind.t,
        weights: Vec3::new(weights.x, weights.z, weights.y),
        normal: -behind.normal,
    };
    (found, depth)
}

impl Exit {
    /// Returns the exit at `hit` of the back side of `triangle` of `object`.
    #[inline]
    pub fn new(object: &Object, direction: Vec3, triangle: &Triangle, hit: &FacetHit) -> Exit {
        let surface = interpolate(triangle, hit);
        let cap = surface.cap(hit.normal);
        Exit {
            t: hit.t,
            slope: clamp(direction.dot(cap.normal), 0.0, 1.0),
            facet_depth: cap.facet_depth,
            uv: surface.uv,
            depth: local_depth(triangle, hit, object.depth),
        }
    }

    /// Returns the words of a picture's pixel: t as the bits of f32; the slope as a fraction of
    /// 16 bits, and the upper 16 bits of h; the bits of the facet depth with the `number` of
    /// the object in the lowest 8; u and v as fractions of 16 bits.
    #[inline]
    #[allow(clippy::unnecessary_cast)] // Real may be f64.
    pub fn words(&self, number: u32) -> UVec4 {
        let fraction = |x: Real| ((x - floor(x)) * 65_536.0) as u32 & 0xffff;
        UVec4::new(
            (self.t as f32).to_bits(),
            (self.slope * 65_535.0) as u32 | ((self.depth as f32).to_bits() & UPPER),
            ((self.facet_depth as f32).to_bits() & !NUMBER) | (number & NUMBER),
            fraction(self.uv.x) | fraction(self.uv.y) << 16,
        )
    }

    /// Returns the exit of `words`; its t is 0 unless it is one of the object of this `number`.
    #[inline]
    pub fn from_words(words: UVec4, number: u32) -> Exit {
        const SLOPE_STEP: Real = 1.0 / 65_535.0;
        const UV_STEP: Real = 1.0 / 65_536.0;
        let (t, slope_and_depth, facet_depth, uv) = (words.x, words.y, words.z, words.w);
        let is_own = facet_depth & NUMBER == number & NUMBER;
        Exit {
            t: if is_own {
                f32::from_bits(t) as Real
            } else {
                0.0
            },
            slope: (slope_and_depth & !UPPER) as i32 as Real * SLOPE_STEP,
            facet_depth: f32::from_bits(facet_depth & !NUMBER) as Real,
            uv: Vec2::new(
                (uv & 0xffff) as i32 as Real * UV_STEP,
                (uv >> 16) as i32 as Real * UV_STEP,
            ),
            depth: f32::from_bits(slope_and_depth & UPPER) as Real,
        }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::layout::Corner;

    #[test]
    fn words_keep_the_exit_of_their_own_object() {
        let exit = Exit {
            t: 3.25,
            slope: 0.7,
            facet_depth: 0.001,
            uv: Vec2::new(-1.25, 7.5),
            depth: 0.03,
        };
        let words = exit.words(3);
        let found = Exit::from_words(words, 3);
        assert_eq!(found.t, exit.t);
        assert!((found.slope - exit.slope).abs() < 2e-5);
        assert!((found.depth - exit.depth).abs() < 0.01 * exit.depth);
        assert!((found.facet_depth - exit.facet_depth).abs() < 1e-4 * exit.facet_depth);
        assert_eq!(found.uv, Vec2::new(0.75, 0.5));
        assert_eq!(Exit::from_words(words, 4).t, 0.0);
        assert_eq!(Exit::from_words(UVec4::ZERO, 3).t, 0.0);
    }

    #[test]
    fn the_back_side_is_met_where_the_front_side_is_not() {
        let frame = crate::camera::tests::looking_down_z();
        let corner = |x: Real, y: Real, u: Real| Corner {
            position: [x, y, -2.0],
            normal: [0.0, 0.0, -1.0],
            uv: [u, 0.0],
            ..Corner::default()
        };
        // Counter-clockwise seen from behind: the eye sees the back.
        let triangle = Triangle {
            corners: [
                corner(-1.0, -1.0, 0.0),
                corner(0.0, 1.0, 0.5),
                corner(1.0, -1.0, 1.0),
            ],
            handedness: 1.0,
            depth_reductions: 0,
        };
        let (hit, depth) = meet(&frame, Vec3::NEG_Z, &triangle);
        assert!(hit.hit && !meet(&frame, Vec3::NEG_Z, &reversed(&triangle)).0.hit);
        assert!((depth - 0.005).abs() < 1e-6);
        let exit = Exit::new(&Object::default(), Vec3::NEG_Z, &triangle, &hit);
        assert!((exit.t - 2.0).abs() < 1e-6 && (exit.slope - 1.0).abs() < 1e-6);
        assert!((exit.uv.x - 0.5).abs() < 1e-6, "{}", exit.uv);
        // In front of the near plane there is no exit.
        let near = Triangle {
            corners: triangle.corners.map(|corner| Corner {
                position: [corner.position[0], corner.position[1], -0.005],
                ..corner
            }),
            ..triangle
        };
        assert!(!meet(&frame, Vec3::NEG_Z, &near).0.hit);
    }
}
