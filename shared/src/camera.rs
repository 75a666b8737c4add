//! From pixels to rays and from triangles to rectangles of pixels.

use crate::arithmetic::{div, max, min, normalize_or};
use crate::layout::{Frame, Triangle, vec3};
use crate::{Real, Vec2, Vec3};

/// Unit direction from the eye through the centre of pixel (`x`, `y`), counted
/// from the top left.
#[inline]
pub fn pixel_ray(frame: &Frame, x: u32, y: u32) -> Vec3 {
    let raw = vec3(frame.ray_first)
        + vec3(frame.ray_right) * (x as i32 as Real)
        + vec3(frame.ray_down) * (y as i32 as Real);
    normalize_or(raw, vec3(frame.forward))
}

/// Depth to compare and to write: near plane over distance along the view
/// axis, 1 at the near plane and 0 at infinity (reversed, so that f32 keeps
/// its digits far away). Above 1 in front of the near plane.
#[inline]
pub fn reversed_depth(frame: &Frame, direction: Vec3, t: Real) -> Real {
    let z = t * direction.dot(vec3(frame.forward));
    // Behind or at the eye: in front of every near plane.
    if z > 1e-18 { div(frame.near, z) } else { 2.0 }
}

/// A rectangle in normalised device coordinates (−1…1, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Left and lower edge.
    pub low: Vec2,
    /// Right and upper edge.
    pub high: Vec2,
}

/// A rectangle that holds every pixel whose ray can meet `triangle`, a pixel
/// too large on each side; empty (`low` = `high`) where none can.
///
/// Rasterising this rectangle, with the exact test of [`crate::facet`] in the
/// fragment, makes a picture that does not depend on the device's rules for
/// pixels on shared edges.
#[inline]
pub fn bounding_rectangle(frame: &Frame, triangle: &Triangle) -> Rectangle {
    let eye = vec3(frame.eye);
    let a = vec3(triangle.corners[0].position) - eye;
    let b = vec3(triangle.corners[1].position) - eye;
    let c = vec3(triangle.corners[2].position) - eye;
    let forward = vec3(frame.forward);
    let near = frame.near;
    let (za, zb, zc) = (a.dot(forward), b.dot(forward), c.dot(forward));
    let nothing = Rectangle {
        low: Vec2::ZERO,
        high: Vec2::ZERO,
    };
    // The facet shows its back to the eye. The margin leaves doubtful ones to
    // the exact test.
    let normal = (b - a).cross(c - a);
    let facing = normal.dot(a);
    if facing > 0.0 && facing * facing > 1e-8 * normal.dot(normal) * a.dot(a) {
        return nothing;
    }
    let behind = 0.99 * near;
    if za < behind && zb < behind && zc < behind {
        return nothing;
    }
    // A corner in front of the near plane has no bounded projection.
    if za < behind || zb < behind || zc < behind {
        return Rectangle {
            low: Vec2::new(-1.0, -1.0),
            high: Vec2::new(1.0, 1.0),
        };
    }
    let (right, up) = (vec3(frame.right), vec3(frame.up));
    let (ia, ib, ic) = (div(1.0, za), div(1.0, zb), div(1.0, zc));
    let (xa, xb, xc) = (a.dot(right) * ia, b.dot(right) * ib, c.dot(right) * ic);
    let (ya, yb, yc) = (a.dot(up) * ia, b.dot(up) * ib, c.dot(up) * ic);
    let pixel_x = div(2.0, frame.size[0]);
    let pixel_y = div(2.0, frame.size[1]);
    let low = Vec2::new(
        max(min(xa, min(xb, xc)) - pixel_x, -1.0),
        max(min(ya, min(yb, yc)) - pixel_y, -1.0),
    );
    let high = Vec2::new(
        min(max(xa, max(xb, xc)) + pixel_x, 1.0),
        min(max(ya, max(yb, yc)) + pixel_y, 1.0),
    );
    if low.x < high.x && low.y < high.y {
        Rectangle { low, high }
    } else {
        nothing
    }
}

/// Corner `index` (0…5) of the two triangles that make up `rectangle`.
#[inline]
pub fn rectangle_corner(rectangle: &Rectangle, index: u32) -> Vec2 {
    let right = index == 1 || index == 2 || index == 4;
    let top = index == 2 || index == 4 || index == 5;
    Vec2::new(
        if right {
            rectangle.high.x
        } else {
            rectangle.low.x
        },
        if top {
            rectangle.high.y
        } else {
            rectangle.low.y
        },
    )
}
