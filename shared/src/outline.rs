//! Outlines in the picture around the pixels whose rays may hit a triangle or a prism.

use crate::arithmetic::{abs, div, floor, max, min, sqrt};
use crate::camera::pixel_ray;
use crate::facet::{may_hit, may_surround_eye};
use crate::layout::{Frame, Object, PrismData, Triangle, vec3};
use crate::prism::{cap_hull, is_near, is_open, normal_hull};
use crate::{Real, Vec2, Vec3};

/// A rectangle in normalised device coordinates (−1…1, y up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Left and lower edge.
    pub low: Vec2,
    /// Right and upper edge.
    pub high: Vec2,
}

/// A triangle in the picture.
#[derive(Clone, Copy)]
struct Projection {
    /// Whether any pixel may see its front.
    visible: bool,
    /// Whether all corners lie behind the near plane; else `corners` are meaningless.
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
    // Back-facing. The margin leaves doubtful facets to the exact test.
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

/// Returns a rectangle that contains every pixel whose ray can hit `triangle` behind the
/// near plane, with a margin of [`MARGIN`]; empty (`low` = `high`) if there is none.
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
    let pixel_x = div(2.0 * MARGIN, frame.size[0]);
    let pixel_y = div(2.0 * MARGIN, frame.size[1]);
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

/// The shape that is rasterised for a triangle: the triangle grown by a margin, or its
/// bounding rectangle if it is too thin or too large for that, or if the grown triangle would be
/// larger.
///
/// Both contain every pixel whose ray can hit the triangle behind the near plane. With
/// the exact test of [`crate::facet`] in the fragment shader, the picture does not
/// depend on the device's rules for pixels on shared edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Whether to draw `corners`; else `rectangle`.
    pub grown: bool,
    /// The grown triangle, normalised device coordinates.
    pub corners: [Vec2; 3],
    /// The bounding rectangle.
    pub rectangle: Rectangle,
}

/// Margin of the outlines of triangles, pixels: more than devices round positions by, a
/// sixteenth at most, and than rounding errors of corners in pictures of 32,768 pixels. The
/// hit test itself may err by more at the tips of triangles two pixels wide in pictures of
/// more than 13,000 pixels.
pub const MARGIN: Real = 0.25;
/// The outlines of prisms extend beyond it by this share of their size: rays may enter beside a
/// prism's sides.
const PRISM_MARGIN: Real = 0.02;
/// Sine of the sharpest corner that is moved: at sharper ones, the rounding of short sides changes
/// the sine noticeably.
const SHARPEST: Real = 0.02;
/// Sine of the sharpest corner whose triangle is certainly smaller than its rectangle.
const SHARP: Real = 0.15;
/// Largest coordinate, pixels: beyond, rounding errors approach the margin.
const FURTHEST: Real = 16_384.0;

/// Returns the outline of `triangle` of `object` in `frame`: the whole picture if the eye
/// may lie in its shell.
#[inline]
pub fn outline(frame: &Frame, object: &Object, triangle: &Triangle) -> Outline {
    let mut projection = project(frame, triangle);
    if may_surround_eye(frame, object, triangle) {
        projection.visible = true;
        projection.bounded = false;
    }
    let mut rectangle = rectangle_of(frame, &projection);
    if projection.bounded {
        let found = hit_pixels(frame, triangle, &rectangle);
        projection.bounded = !found.is_known;
        rectangle = found.rectangle;
    }
    grown_triangle(
        frame,
        projection.corners,
        [MARGIN, MARGIN, MARGIN],
        projection.bounded,
        rectangle,
    )
}

/// The pixels of a rectangle whose rays hit a triangle.
struct HitPixels {
    /// Whether the rays were tried: not if there are many.
    is_known: bool,
    /// The rectangle around the pixels; the one that was given if they are not known.
    rectangle: Rectangle,
}

/// Tries the rays of the pixels in `rectangle` if they are at most two by two: most of the
/// triangles that are smaller than a pixel hit none, and cost no fragment then.
#[inline]
fn hit_pixels(frame: &Frame, triangle: &Triangle, rectangle: &Rectangle) -> HitPixels {
    let half = Vec2::new(0.5 * frame.size[0], 0.5 * frame.size[1]);
    let Rectangle { low, high } = *rectangle;
    // The first and the last column and row of pixel centres.
    let left = -floor(0.5 - (low.x + 1.0) * half.x);
    let right = floor((high.x + 1.0) * half.x - 0.5);
    let top = -floor(0.5 - (1.0 - high.y) * half.y);
    let bottom = floor((1.0 - low.y) * half.y - 0.5);
    if right - left > 1.0 || bottom - top > 1.0 {
        return HitPixels {
            is_known: false,
            rectangle: *rectangle,
        };
    }
    // −1 or less for a column or row that is not there.
    let next_column = if right > left { right } else { -1.0 };
    let next_row = if bottom > top { bottom } else { -1.0 };
    let column = if right >= left { left } else { -1.0 };
    let row = if bottom >= top { top } else { -1.0 };
    let mut hits = Hits {
        // Beyond every picture.
        low: Vec2::new(1e6, 1e6),
        high: Vec2::new(-1.0, -1.0),
    };
    hits.attempt(frame, triangle, column, row);
    hits.attempt(frame, triangle, next_column, row);
    hits.attempt(frame, triangle, column, next_row);
    hits.attempt(frame, triangle, next_column, next_row);
    let none = hits.high.x < 0.0;
    let pixel = Vec2::new(div(2.0, frame.size[0]), div(2.0, frame.size[1]));
    let (first, last) = (0.5 - MARGIN, 0.5 + MARGIN);
    HitPixels {
        is_known: true,
        rectangle: if none {
            Rectangle {
                low: Vec2::ZERO,
                high: Vec2::ZERO,
            }
        } else {
            Rectangle {
                low: Vec2::new(
                    (hits.low.x + first) * pixel.x - 1.0,
                    1.0 - (hits.high.y + last) * pixel.y,
                ),
                high: Vec2::new(
                    (hits.high.x + last) * pixel.x - 1.0,
                    1.0 - (hits.low.y + first) * pixel.y,
                ),
            }
        },
    }
}

/// First and last column and row of the pixels that hit something.
struct Hits {
    low: Vec2,
    high: Vec2,
}

impl Hits {
    /// Tries the ray of a pixel, unless its column or row is negative.
    #[inline]
    fn attempt(&mut self, frame: &Frame, triangle: &Triangle, column: Real, row: Real) {
        let is_there = column >= 0.0 && row >= 0.0;
        let direction = pixel_ray(frame, column as u32, row as u32);
        if is_there && may_hit(vec3(frame.eye), direction, triangle) {
            self.low = Vec2::new(min(self.low.x, column), min(self.low.y, row));
            self.high = Vec2::new(max(self.high.x, column), max(self.high.y, row));
        }
    }
}

/// Returns the triangle of `corners` with each side (from corner 0 to 1, 1 to 2, 2 to 0)
/// moved out by `beyond` pixels, or else `rectangle`.
#[inline]
fn grown_triangle(
    frame: &Frame,
    corners: [Vec2; 3],
    beyond: [Real; 3],
    bounded: bool,
    rectangle: Rectangle,
) -> Outline {
    // In pixels, so that the margin is the same in both directions.
    let scale = Vec2::new(0.5 * frame.size[0], 0.5 * frame.size[1]);
    let [a, b, c] = corners;
    let (a, b, c) = (a * scale, b * scale, c * scale);
    let (ab, bc, ca) = (unit(b - a), unit(c - b), unit(a - c));
    let (at_a, at_b, at_c) = (sine(ca, ab), sine(ab, bc), sine(bc, ca));
    let reach = max(largest(a), max(largest(b), largest(c)));
    let [by_ab, by_bc, by_ca] = beyond;
    // The intersection of the two moved sides of a corner.
    let grow = |corner: Vec2, before: (Vec2, Real), after: (Vec2, Real), sine: Real| {
        let out = before.0 * after.1 - after.0 * before.1;
        corner + out * div(1.0, max(sine, SHARPEST))
    };
    let (a, b, c) = (
        grow(a, (ca, by_ca), (ab, by_ab), at_a),
        grow(b, (ab, by_ab), (bc, by_bc), at_b),
        grow(c, (bc, by_bc), (ca, by_ca), at_c),
    );
    let sharpest = min(at_a, min(at_b, at_c));
    // The triangle that is drawn around the rectangle has twice its area.
    let sides = (rectangle.high - rectangle.low) * scale;
    let is_smaller = sine(b - a, c - a) < 4.0 * (sides.x * sides.y);
    let grown = bounded
        && sharpest > SHARPEST
        && (sharpest > SHARP || is_smaller)
        && reach < FURTHEST
        && max(by_ab, max(by_bc, by_ca)) < FURTHEST
        && rectangle.low.x < rectangle.high.x;
    let pixel = Vec2::new(div(2.0, frame.size[0]), div(2.0, frame.size[1]));
    Outline {
        grown,
        corners: [a * pixel, b * pixel, c * pixel],
        rectangle,
    }
}

/// Returns `v` scaled to length 1; zero if it is too short.
#[inline]
fn unit(v: Vec2) -> Vec2 {
    let squared = v.dot(v);
    if squared > 1e-12 {
        v * div(1.0, sqrt(squared))
    } else {
        Vec2::ZERO
    }
}

/// Returns the sine of the angle from `a` to `b`, times their lengths.
#[inline]
fn sine(a: Vec2, b: Vec2) -> Real {
    a.x * b.y - a.y * b.x
}

#[inline]
fn largest(v: Vec2) -> Real {
    max(abs(v.x), abs(v.y))
}

/// The projection of a convex hull, built point by point.
struct Hull {
    eye: Vec3,
    near: Real,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// Half the picture's size, pixels.
    half: Vec2,
    /// The sides of the triangle inside: a point and a unit vector along each, pixels.
    sides: [(Vec2, Vec2); 3],
    /// Distance by which the hull extends beyond each side, pixels.
    beyond: [Real; 3],
    low: Vec2,
    high: Vec2,
    /// Whether a point lies behind the near plane.
    some_visible: bool,
    /// Whether a point lies in front of the near plane.
    some_hidden: bool,
    /// Whether all points are back-facing: see [`PrismData::spread`].
    turned_away: bool,
    axis: Vec3,
    /// Square of the sine of the angle from which on a point is back-facing.
    away: Real,
}

impl Hull {
    /// Projects a point relative to the eye to normalised device coordinates.
    #[inline]
    fn project(&self, point: Vec3) -> Vec2 {
        let scale = div(1.0, max(point.dot(self.forward), self.near));
        Vec2::new(point.dot(self.right) * scale, point.dot(self.up) * scale)
    }

    /// Returns the distance by which the hull with `point` (pixels) extends beyond side `index`.
    #[inline]
    fn outside(&self, index: usize, point: Vec2) -> Real {
        let (start, along) = self.sides[index];
        max(-sine(along, point - start), self.beyond[index])
    }

    /// Adds a point relative to the anchor.
    #[inline]
    fn hold(&mut self, point: Vec3) {
        let point = point - self.eye;
        if point.dot(self.forward) < self.near {
            self.some_hidden = true;
        } else {
            self.some_visible = true;
        }
        let back = point.dot(self.axis);
        if back <= 0.0 || back * back <= self.away * point.dot(point) {
            self.turned_away = false;
        }
        let at = self.project(point);
        self.low = Vec2::new(min(self.low.x, at.x), min(self.low.y, at.y));
        self.high = Vec2::new(max(self.high.x, at.x), max(self.high.y, at.y));
        let at = at * self.half;
        self.beyond = [
            self.outside(0, at),
            self.outside(1, at),
            self.outside(2, at),
        ];
    }
}

/// Returns the outline of all faces through which a ray from the eye of `frame` may enter
/// the curved prism of `data` from outside: of its cap if that may face the eye, of the
/// whole prism if a side is open, and the whole picture if the eye may lie in it.
#[inline]
pub fn prism_outline(frame: &Frame, object: &Object, data: &PrismData) -> Outline {
    let nothing = Rectangle {
        low: Vec2::ZERO,
        high: Vec2::ZERO,
    };
    let everything = Rectangle {
        low: Vec2::new(-1.0, -1.0),
        high: Vec2::new(1.0, 1.0),
    };
    let mut outline = Outline {
        grown: false,
        corners: [Vec2::ZERO, Vec2::ZERO, Vec2::ZERO],
        rectangle: everything,
    };
    let eye = vec3(frame.eye) - vec3(data.anchor);
    if is_near(data, eye) {
        return outline;
    }
    let cap = cap_hull(data);
    let is_open = is_open(data);
    let mut hull = Hull {
        eye,
        near: 0.99 * frame.near,
        forward: vec3(frame.forward),
        right: vec3(frame.right),
        up: vec3(frame.up),
        half: Vec2::new(0.5 * frame.size[0], 0.5 * frame.size[1]),
        sides: [(Vec2::ZERO, Vec2::ZERO); 3],
        beyond: [0.0, 0.0, 0.0],
        low: Vec2::new(2.0, 2.0),
        high: Vec2::new(-2.0, -2.0),
        some_visible: false,
        some_hidden: false,
        turned_away: !is_open && data.spread < 1.0,
        axis: vec3(data.facet),
        away: data.spread * data.spread + 1e-6,
    };
    let a = hull.project(cap[0] - eye);
    let mut b = hull.project(cap[1] - eye);
    let mut c = hull.project(cap[2] - eye);
    // Seen from behind, the winding is reversed.
    if sine(b - a, c - a) < 0.0 {
        (b, c) = (c, b);
    }
    let half = hull.half;
    hull.sides = [
        (a * half, unit((b - a) * half)),
        (b * half, unit((c - b) * half)),
        (c * half, unit((a - c) * half)),
    ];
    hull.hold(cap[0]);
    hull.hold(cap[1]);
    hull.hold(cap[2]);
    hull.hold(cap[3]);
    hull.hold(cap[4]);
    hull.hold(cap[5]);
    if is_open {
        let down = normal_hull(data);
        hull.hold(cap[0] - down[0] * object.depth);
        hull.hold(cap[1] - down[1] * object.depth);
        hull.hold(cap[2] - down[2] * object.depth);
        hull.hold(cap[3] - down[3] * object.depth);
        hull.hold(cap[4] - down[4] * object.depth);
        hull.hold(cap[5] - down[5] * object.depth);
    }
    if hull.turned_away || !hull.some_visible {
        outline.rectangle = nothing;
        return outline;
    }
    // A point in front of the near plane has no bounded projection.
    if hull.some_hidden {
        return outline;
    }
    let size = (hull.high - hull.low) * half;
    let margin = MARGIN + PRISM_MARGIN * max(size.x, size.y);
    let scale = Vec2::new(div(2.0, frame.size[0]), div(2.0, frame.size[1])) * margin;
    let low = Vec2::new(
        max(hull.low.x - scale.x, -1.0),
        max(hull.low.y - scale.y, -1.0),
    );
    let high = Vec2::new(
        min(hull.high.x + scale.x, 1.0),
        min(hull.high.y + scale.y, 1.0),
    );
    if low.x >= high.x || low.y >= high.y {
        outline.rectangle = nothing;
        return outline;
    }
    let beyond = [
        margin + hull.beyond[0],
        margin + hull.beyond[1],
        margin + hull.beyond[2],
    ];
    grown_triangle(frame, [a, b, c], beyond, true, Rectangle { low, high })
}

/// Returns corner `index` (0…2) of the triangle that is drawn for `outline`, normalised
/// device coordinates: one around its rectangle unless it is grown.
#[inline]
pub fn outline_corner(outline: &Outline, index: u32) -> Vec2 {
    let Rectangle { low, high } = outline.rectangle;
    if outline.grown {
        if index == 0 {
            outline.corners[0]
        } else if index == 1 {
            outline.corners[1]
        } else {
            outline.corners[2]
        }
    } else if index == 0 {
        low
    } else if index == 1 {
        Vec2::new(low.x + 2.0 * (high.x - low.x), low.y)
    } else {
        Vec2::new(low.x, low.y + 2.0 * (high.y - low.y))
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests;
