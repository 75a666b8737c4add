//! Rays of pixels, and depth of distances.
//!
//! ```
//! use relievo_shared::Vec3;
//! use relievo_shared::camera::{pixel_ray, reversed_depth};
//! use relievo_shared::layout::Frame;
//!
//! let frame = Frame {
//!     near: 0.1,
//!     forward: [0.0, 0.0, -1.0],
//!     ray_first: [0.0, 0.0, -1.0],
//!     ..Frame::default()
//! };
//! let direction = pixel_ray(&frame, 0, 0);
//! assert_eq!(direction, Vec3::NEG_Z);
//! assert_eq!(reversed_depth(&frame, direction, 0.2), 0.5);
//! ```

use crate::arithmetic::{div, kept, min, normalize_or};
use crate::layout::{Frame, vec3};
use crate::{Real, Vec3};

/// Returns the unit direction from the eye through the centre of pixel (`x`, `y`),
/// counted from the top left.
#[inline]
pub fn pixel_ray(frame: &Frame, x: u32, y: u32) -> Vec3 {
    let direction = through(frame, x as i32 as Real, y as i32 as Real);
    normalize_or(direction, vec3(frame.forward))
}

/// Returns the direction from the eye through a point of the picture, whose part along the view
/// axis is 1; `x` and `y` count pixels from the centre of the top left one.
#[inline]
pub fn through(frame: &Frame, x: Real, y: Real) -> Vec3 {
    vec3(frame.ray_first) + vec3(frame.ray_right) * x + vec3(frame.ray_down) * y
}

/// Returns the reversed depth at distance `t` along `direction`: near plane over
/// distance along the view axis. It is 1 at the near plane, 0 at infinity, and above
/// 1 in front of the near plane. Reversed, so that f32 keeps its digits far away.
#[inline]
pub fn reversed_depth(frame: &Frame, direction: Vec3, t: Real) -> Real {
    let z = t * direction.dot(vec3(frame.forward));
    // Behind or at the eye: in front of every near plane.
    if z > 1e-18 { div(frame.near, z) } else { 2.0 }
}

/// Returns the sides of what the pixel of the ray along `direction` covers, to the right and down, on
/// the plane with the unit `normal` through the ray's point at distance `t`. Smaller cosines between
/// the normal and the direction to the eye count as `least_cosine`.
#[inline]
pub fn on_plane(
    frame: &Frame,
    direction: Vec3,
    t: Real,
    normal: Vec3,
    least_cosine: Real,
) -> [Vec3; 2] {
    let depth = t * direction.dot(vec3(frame.forward));
    let inverse = div(1.0, min(kept(normal.dot(direction)), -least_cosine));
    let along = |step: Vec3| (step - direction * (kept(normal.dot(step)) * inverse)) * depth;
    [along(vec3(frame.ray_right)), along(vec3(frame.ray_down))]
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
pub(crate) mod tests {
    use super::*;
    use crate::layout::UPRIGHT_AXES;

    /// A picture of `width` × `height` pixels along `forward` from `eye`, and
    /// half the vertical field of view by its tangent.
    pub(crate) fn frame(eye: Vec3, forward: Vec3, width: u32, height: u32, tan_y: f32) -> Frame {
        let axis = if forward.y.abs() < 0.9 {
            Vec3::Y
        } else {
            Vec3::X
        };
        let right = forward.cross(axis).normalize();
        let up = right.cross(forward);
        let (w, h) = (width as f32, height as f32);
        let tan_x = tan_y * w / h;
        let ray_right = right * (2.0 * tan_x / w);
        let ray_down = up * (-2.0 * tan_y / h);
        let corner = forward - right * tan_x + up * tan_y;
        Frame {
            eye: eye.to_array(),
            near: 0.01,
            right: (right / tan_x).to_array(),
            up: (up / tan_y).to_array(),
            forward: forward.to_array(),
            ray_first: (corner + (ray_right + ray_down) * 0.5).to_array(),
            ray_right: ray_right.to_array(),
            ray_down: ray_down.to_array(),
            size: [w, h],
            unit: 1.0,
            axes: UPRIGHT_AXES,
            ..Frame::default()
        }
    }

    pub(crate) fn looking_down_z() -> Frame {
        frame(Vec3::ZERO, Vec3::NEG_Z, 8, 4, 0.5)
    }

    #[test]
    fn rays_fill_the_picture() {
        let forward = Vec3::new(0.36, 0.48, -0.8);
        // The middle pixel of a picture with odd sides.
        let odd = frame(Vec3::ONE, forward, 7, 5, 0.3);
        assert!((pixel_ray(&odd, 3, 2) - forward).length() < 1e-6);
        // Pixel centres lie half a pixel inside the edges: x = ±⅞ and y = ±¾.
        let even = looking_down_z();
        let first = Vec3::new(-0.875, 0.375, -1.0).normalize();
        let last = Vec3::new(0.875, -0.375, -1.0).normalize();
        assert!((pixel_ray(&even, 0, 0) - first).length() < 1e-6);
        assert!((pixel_ray(&even, 7, 3) - last).length() < 1e-6);
    }

    #[test]
    fn depth_is_one_at_the_near_plane_and_falls_with_distance() {
        let frame = looking_down_z();
        let aside = Vec3::new(0.6, 0.0, -0.8);
        assert!((reversed_depth(&frame, aside, 0.01 / 0.8) - 1.0).abs() < 1e-6);
        assert!((reversed_depth(&frame, Vec3::NEG_Z, 10.0) - 0.001).abs() < 1e-9);
        assert!(reversed_depth(&frame, Vec3::NEG_Z, 0.005) > 1.0);
        for t in [0.0, -0.0, -1.0, -1e30, 1e-30] {
            assert!(reversed_depth(&frame, Vec3::NEG_Z, t) > 1.0);
        }
        assert!(reversed_depth(&frame, Vec3::NEG_Z, 1e30) > 0.0);
    }
}
