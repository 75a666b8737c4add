//! From pixels to rays and from triangles to the pixels that may see them.

use crate::arithmetic::{abs, div, max, min, normalize_or, sqrt};
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

/// A triangle as the picture sees it.
#[derive(Clone, Copy)]
struct Projection {
    /// Whether any pixel can see its front.
    visible: bool,
    /// Whether all corners lie behind the near plane, so that `corners` mean something.
    bounded: bool,
    /// The corners in normalised device coordinates.
    corners: [Vec2; 3],
}

#[inline]
fn project(frame: &Frame, triangle: &Triangle) -> Projection {
    let eye = vec3(frame.eye);
    let a = vec3(triangle.corners[0].position) - eye;
    let b = vec3(triangle.corners[1].position) - eye;
    let c = vec3(triangle.corners[2].position) - eye;
    let forward = vec3(frame.forward);
    let (za, zb, zc) = (a.dot(forward), b.dot(forward), c.dot(forward));
    let mut projection = Projection {
        visible: false,
        bounded: false,
        corners: [Vec2::ZERO, Vec2::ZERO, Vec2::ZERO],
    };
    // The facet shows its back to the eye. The margin leaves doubtful ones to
    // the exact test.
    let normal = (b - a).cross(c - a);
    let facing = normal.dot(a);
    if facing > 0.0 && facing * facing > 1e-8 * normal.dot(normal) * a.dot(a) {
        return projection;
    }
    let behind = 0.99 * frame.near;
    if za < behind && zb < behind && zc < behind {
        return projection;
    }
    projection.visible = true;
    // A corner in front of the near plane has no bounded projection.
    if za < behind || zb < behind || zc < behind {
        return projection;
    }
    projection.bounded = true;
    let (right, up) = (vec3(frame.right), vec3(frame.up));
    let (ia, ib, ic) = (div(1.0, za), div(1.0, zb), div(1.0, zc));
    projection.corners = [
        Vec2::new(a.dot(right) * ia, a.dot(up) * ia),
        Vec2::new(b.dot(right) * ib, b.dot(up) * ib),
        Vec2::new(c.dot(right) * ic, c.dot(up) * ic),
    ];
    projection
}

/// A rectangle that holds every pixel whose ray can meet `triangle` behind the
/// near plane, a pixel too large on each side; empty (`low` = `high`) where
/// none can.
#[inline]
pub fn bounding_rectangle(frame: &Frame, triangle: &Triangle) -> Rectangle {
    rectangle_of(frame, &project(frame, triangle))
}

#[inline]
fn rectangle_of(frame: &Frame, projection: &Projection) -> Rectangle {
    let nothing = Rectangle {
        low: Vec2::ZERO,
        high: Vec2::ZERO,
    };
    if !projection.visible {
        return nothing;
    }
    if !projection.bounded {
        return Rectangle {
            low: Vec2::new(-1.0, -1.0),
            high: Vec2::new(1.0, 1.0),
        };
    }
    let [a, b, c] = projection.corners;
    let pixel_x = div(2.0, frame.size[0]);
    let pixel_y = div(2.0, frame.size[1]);
    let low = Vec2::new(
        max(min(a.x, min(b.x, c.x)) - pixel_x, -1.0),
        max(min(a.y, min(b.y, c.y)) - pixel_y, -1.0),
    );
    let high = Vec2::new(
        min(max(a.x, max(b.x, c.x)) + pixel_x, 1.0),
        min(max(a.y, max(b.y, c.y)) + pixel_y, 1.0),
    );
    if low.x < high.x && low.y < high.y {
        Rectangle { low, high }
    } else {
        nothing
    }
}

/// What is rasterised for a triangle: the triangle grown by a pixel, or, where
/// it is too thin or too large for that, its bounding rectangle.
///
/// Either holds every pixel whose ray can meet the triangle behind the near
/// plane. With the exact test of [`crate::facet`] in the fragment this makes a
/// picture that does not depend on the device's rules for pixels on shared edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Whether `corners` are to be drawn, and not `rectangle`.
    pub grown: bool,
    /// The grown triangle, normalised device coordinates.
    pub corners: [Vec2; 3],
    /// The bounding rectangle.
    pub rectangle: Rectangle,
}

/// Corners sharper than this sine would be moved too far.
const SHARPEST: Real = 0.15;
/// Beyond this, pixels, rounding errors come near the margin of a pixel.
const FURTHEST: Real = 16_384.0;

/// The outline of `triangle` in `frame`.
#[inline]
pub fn outline(frame: &Frame, triangle: &Triangle) -> Outline {
    let projection = project(frame, triangle);
    let rectangle = rectangle_of(frame, &projection);
    // In pixels, so that the margin is the same in both directions.
    let scale = Vec2::new(0.5 * frame.size[0], 0.5 * frame.size[1]);
    let [a, b, c] = projection.corners;
    let (a, b, c) = (a * scale, b * scale, c * scale);
    let (ab, bc, ca) = (unit(b - a), unit(c - b), unit(a - c));
    let (at_a, at_b, at_c) = (sine(ca, ab), sine(ab, bc), sine(bc, ca));
    let reach = max(largest(a), max(largest(b), largest(c)));
    let grown = projection.bounded
        && at_a > SHARPEST
        && at_b > SHARPEST
        && at_c > SHARPEST
        && reach < FURTHEST
        && rectangle.low.x < rectangle.high.x;
    let pixel = Vec2::new(div(2.0, frame.size[0]), div(2.0, frame.size[1]));
    // Both edges of a corner move outwards by a pixel, and it with them.
    let grow = |corner: Vec2, before: Vec2, after: Vec2, sine: Real| {
        (corner + (before - after) * div(1.0, max(sine, SHARPEST))) * pixel
    };
    Outline {
        grown,
        corners: [
            grow(a, ca, ab, at_a),
            grow(b, ab, bc, at_b),
            grow(c, bc, ca, at_c),
        ],
        rectangle,
    }
}

/// `v` at length 1; zero where it has none.
#[inline]
fn unit(v: Vec2) -> Vec2 {
    let squared = v.dot(v);
    if squared > 1e-12 {
        v * div(1.0, sqrt(squared))
    } else {
        Vec2::ZERO
    }
}

/// The sine of the angle from the unit vector `a` to the unit vector `b`.
#[inline]
fn sine(a: Vec2, b: Vec2) -> Real {
    a.x * b.y - a.y * b.x
}

#[inline]
fn largest(v: Vec2) -> Real {
    max(abs(v.x), abs(v.y))
}

/// Vertex `index` (0…5) of the two triangles that are drawn for `outline`.
#[inline]
pub fn outline_vertex(outline: &Outline, index: u32) -> Vec2 {
    if !outline.grown {
        rectangle_corner(&outline.rectangle, index)
    } else if index == 1 {
        outline.corners[1]
    } else if index == 2 {
        outline.corners[2]
    } else {
        // The second triangle is none.
        outline.corners[0]
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

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::facet;
    use crate::layout::Corner;
    use crate::shape_map::tests::Random;

    /// A picture of `width` × `height` pixels along `forward` from `eye`, and
    /// half the vertical field of view by its tangent.
    fn frame(eye: Vec3, forward: Vec3, width: u32, height: u32, tan_y: f32) -> Frame {
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
            ..Frame::default()
        }
    }

    fn triangle(corners: [Vec3; 3]) -> Triangle {
        Triangle {
            corners: corners.map(|position| Corner {
                position: position.to_array(),
                ..Corner::default()
            }),
            ..Triangle::default()
        }
    }

    fn looking_down_z() -> Frame {
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

    #[test]
    fn the_rectangle_of_a_plain_triangle() {
        let frame = looking_down_z();
        let front = [(-0.4, -0.1), (0.2, -0.1), (-0.4, 0.3)].map(|(x, y)| Vec3::new(x, y, -1.0));
        // The picture is 1 high and 2 wide at this distance; a pixel is ¼ and ½.
        let found = bounding_rectangle(&frame, &triangle(front));
        assert!(
            (found.low - Vec2::new(-0.65, -0.7)).length() < 1e-6,
            "{found:?}"
        );
        assert!(
            (found.high - Vec2::new(0.45, 1.0)).length() < 1e-6,
            "{found:?}"
        );

        let nothing = Rectangle {
            low: Vec2::ZERO,
            high: Vec2::ZERO,
        };
        // From the back, behind the eye, and beside the picture.
        let back = [front[0], front[2], front[1]];
        assert_eq!(bounding_rectangle(&frame, &triangle(back)), nothing);
        let behind = front.map(|p| p + Vec3::new(0.0, 0.0, 2.0));
        assert_eq!(bounding_rectangle(&frame, &triangle(behind)), nothing);
        let beside = front.map(|p| p + Vec3::new(3.0, 0.0, 0.0));
        assert_eq!(bounding_rectangle(&frame, &triangle(beside)), nothing);
        // A corner behind the eye: everywhere.
        let through = [front[0], front[1], Vec3::new(-0.4, 5.0, 1.0)];
        let found = bounding_rectangle(&frame, &triangle(through));
        assert_eq!((found.low, found.high), (-Vec2::ONE, Vec2::ONE));
    }

    #[test]
    fn six_corners_make_two_triangles_that_fill_the_rectangle() {
        let rectangle = Rectangle {
            low: Vec2::new(-0.5, -1.0),
            high: Vec2::new(0.25, 0.5),
        };
        let corners: Vec<Vec2> = (0..6).map(|i| rectangle_corner(&rectangle, i)).collect();
        let doubled = |a: Vec2, b: Vec2, c: Vec2| (b - a).perp_dot(c - a);
        let first = doubled(corners[0], corners[1], corners[2]);
        let second = doubled(corners[3], corners[4], corners[5]);
        assert_eq!(first.abs() + second.abs(), 2.0 * 0.75 * 1.5);
        for wanted in [
            rectangle.low,
            rectangle.high,
            Vec2::new(rectangle.low.x, rectangle.high.y),
            Vec2::new(rectangle.high.x, rectangle.low.y),
        ] {
            assert!(corners.contains(&wanted));
        }
    }

    /// Whether `point` lies in one of the two triangles drawn for `outline`.
    fn is_drawn(outline: &Outline, point: Vec2) -> bool {
        let corner = |i| outline_vertex(outline, i);
        [0, 3].iter().any(|&first| {
            let [a, b, c] = [corner(first), corner(first + 1), corner(first + 2)];
            let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (q - p).perp_dot(point - p));
            let area = (b - a).perp_dot(c - a);
            area != 0.0 && (sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0))
        })
    }

    #[test]
    fn the_outline_of_a_plain_triangle_is_a_pixel_wider() {
        let mut frame = looking_down_z();
        frame.size = [200.0, 100.0];
        let front = [(-0.4, -0.1), (0.2, -0.1), (-0.4, 0.3)].map(|(x, y)| Vec3::new(x, y, -1.0));
        let found = outline(&frame, &triangle(front));
        assert!(found.grown);
        // A pixel is 0.01 and 0.02: the right angle moves by one of each.
        let corner = Vec2::new(-0.41, -0.22);
        assert!((found.corners[0] - corner).length() < 1e-5, "{found:?}");
        // Half the rectangle's area, and the margin.
        let [a, b, c] = found.corners;
        let area = 0.5 * (b - a).perp_dot(c - a);
        assert!((0.24..0.3).contains(&area), "{area}");
        // A sliver has its rectangle drawn.
        let sliver = [front[0], front[1], Vec3::new(-0.4, -0.095, -1.0)];
        assert!(!outline(&frame, &triangle(sliver)).grown);
    }

    fn point(random: &mut Random, size: f64) -> Vec3 {
        let mut number = || random.within(-size, size) as f32;
        Vec3::new(number(), number(), number())
    }

    /// Triangles of all sizes around the eye, many with corners behind it. A
    /// facet in front of the near plane is not drawn, so only meetings behind
    /// the near plane count.
    #[test]
    fn every_pixel_that_meets_a_triangle_lies_in_its_outline() {
        let mut random = Random(1);
        let (mut met, mut everywhere, mut far_outside) = (0, 0, 0);
        let mut grown = 0;
        for _ in 0..20_000 {
            let eye = point(&mut random, 2.0);
            let middle = eye + point(&mut random, 3.0);
            // Half of the time towards the triangle, more or less.
            let aim = random.choose(&[0.0, 1.0]) as f32;
            let forward = (middle - eye) * aim + point(&mut random, 1.0);
            let forward = normalize_or(forward, Vec3::X);
            let size = random.magnitude(0.02, 5.0);
            let corners = [0; 3].map(|_| middle + point(&mut random, size));
            let tan_y = random.within(0.1, 2.0) as f32;
            let frame = frame(
                eye,
                forward,
                random.whole(1, 16),
                random.whole(1, 16),
                tan_y,
            );
            let triangle = triangle(corners);
            let rectangle = bounding_rectangle(&frame, &triangle);
            let outline = outline(&frame, &triangle);
            grown += u32::from(outline.grown);
            let whole = rectangle.low == -Vec2::ONE && rectangle.high == Vec2::ONE;
            for y in 0..frame.size[1] as u32 {
                for x in 0..frame.size[0] as u32 {
                    let direction = pixel_ray(&frame, x, y);
                    let hit = facet::intersect(eye, direction, &triangle);
                    let centre = Vec2::new(
                        (2 * x + 1) as f32 / frame.size[0] - 1.0,
                        1.0 - (2 * y + 1) as f32 / frame.size[1],
                    );
                    let inside =
                        centre.cmpge(rectangle.low).all() && centre.cmple(rectangle.high).all();
                    if hit.hit && reversed_depth(&frame, direction, hit.t) <= 1.0 {
                        met += 1;
                        everywhere += u32::from(whole);
                        assert!(
                            is_drawn(&outline, centre),
                            "pixel ({x}, {y}) at {centre} outside {outline:?}: {frame:?} {triangle:?}"
                        );
                        assert!(
                            inside,
                            "pixel ({x}, {y}) at {centre} outside {rectangle:?}: {frame:?} {triangle:?}"
                        );
                    } else if !inside {
                        far_outside += 1;
                    }
                }
            }
        }
        println!(
            "{met} meetings, {everywhere} of them in a whole picture, {far_outside} pixels spared"
        );
        assert!(met > 10_000 && met - everywhere > 5_000 && everywhere > 1_000);
        assert!(far_outside > 100_000);
        assert!(grown > 1_000, "{grown}");
    }
}
