//! From triangles and prisms to the pixels that may see them.

use crate::arithmetic::{abs, div, max, min, sqrt};
use crate::facet::may_surround_eye;
use crate::layout::{Frame, Object, Shell, Triangle, vec3};
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

/// The outline of `triangle` of `object` in `frame`: the whole picture where the
/// eye may lie in its shell.
#[inline]
pub fn outline(frame: &Frame, object: &Object, triangle: &Triangle) -> Outline {
    let mut projection = project(frame, triangle);
    if may_surround_eye(frame, object, triangle) {
        projection.visible = true;
        projection.bounded = false;
    }
    let rectangle = rectangle_of(frame, &projection);
    grown_triangle(
        frame,
        projection.corners,
        [0.0, 0.0, 0.0],
        projection.bounded,
        rectangle,
    )
}

/// The triangle of `corners` with each side (from corner 0 to 1, 1 to 2, 2 to 0)
/// moved out by a pixel and by `beyond` pixels, or else `rectangle`.
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
    let grown = bounded
        && at_a > SHARPEST
        && at_b > SHARPEST
        && at_c > SHARPEST
        && reach < FURTHEST
        && max(beyond[0], max(beyond[1], beyond[2])) < FURTHEST
        && rectangle.low.x < rectangle.high.x;
    let pixel = Vec2::new(div(2.0, frame.size[0]), div(2.0, frame.size[1]));
    let (by_ab, by_bc, by_ca) = (1.0 + beyond[0], 1.0 + beyond[1], 1.0 + beyond[2]);
    // Where the two sides of a corner meet when they have moved.
    let grow = |corner: Vec2, before: (Vec2, Real), after: (Vec2, Real), sine: Real| {
        let out = before.0 * after.1 - after.0 * before.1;
        (corner + out * div(1.0, max(sine, SHARPEST))) * pixel
    };
    Outline {
        grown,
        corners: [
            grow(a, (ca, by_ca), (ab, by_ab), at_a),
            grow(b, (ab, by_ab), (bc, by_bc), at_b),
            grow(c, (bc, by_bc), (ca, by_ca), at_c),
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

/// The picture of a convex hull, point by point.
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
    /// How far the hull reaches beyond the sides, pixels.
    beyond: [Real; 3],
    low: Vec2,
    high: Vec2,
    /// Whether a point lies behind the near plane, and whether one does not.
    some_visible: bool,
    some_hidden: bool,
    /// Whether all points turn their back: see [`Shell::spread`].
    turned_away: bool,
    axis: Vec3,
    /// The square of the sine that they must have.
    away: Real,
}

impl Hull {
    /// A point relative to the eye in normalised device coordinates.
    #[inline]
    fn project(&self, point: Vec3) -> Vec2 {
        let scale = div(1.0, max(point.dot(self.forward), self.near));
        Vec2::new(point.dot(self.right) * scale, point.dot(self.up) * scale)
    }

    /// How far `point` (pixels) lies beyond side `index`.
    #[inline]
    fn outside(&self, index: usize, point: Vec2) -> Real {
        let (start, along) = self.sides[index];
        max(-sine(along, point - start), self.beyond[index])
    }

    /// Takes in a point relative to the shell's anchor.
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

/// The outline of everything through which a ray from the eye of `frame` may
/// come into the curved prism of `shell` from outside: its cap where that may
/// face the eye, the whole of it where a side is open, and the whole picture
/// where the eye lies in it.
#[inline]
pub fn shell_outline(frame: &Frame, object: &Object, shell: &Shell) -> Outline {
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
    let eye = vec3(frame.eye) - vec3(shell.anchor);
    if is_near(shell, eye) {
        return outline;
    }
    let cap = cap_hull(shell);
    let is_open = is_open(shell);
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
        turned_away: !is_open && shell.spread < 1.0,
        axis: vec3(shell.facet),
        away: shell.spread * shell.spread + 1e-6,
    };
    let a = hull.project(cap[0] - eye);
    let mut b = hull.project(cap[1] - eye);
    let mut c = hull.project(cap[2] - eye);
    // Seen from behind it runs the other way.
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
        let down = normal_hull(shell);
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
    let pixel = Vec2::new(div(2.0, frame.size[0]), div(2.0, frame.size[1]));
    let low = Vec2::new(
        max(hull.low.x - pixel.x, -1.0),
        max(hull.low.y - pixel.y, -1.0),
    );
    let high = Vec2::new(
        min(hull.high.x + pixel.x, 1.0),
        min(hull.high.y + pixel.y, 1.0),
    );
    if low.x >= high.x || low.y >= high.y {
        outline.rectangle = nothing;
        return outline;
    }
    grown_triangle(frame, [a, b, c], hull.beyond, true, Rectangle { low, high })
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
    use crate::arithmetic::normalize_or;
    use crate::camera::tests::{frame, looking_down_z};
    use crate::camera::{pixel_ray, reversed_depth};
    use crate::facet;
    use crate::layout::{Corner, FORMAT_FLOAT};
    use crate::march::END_MISS;
    use crate::prism::tests::test_shell;
    use crate::profile::Profile;
    use crate::shape_map::ShapeMap;
    use crate::shape_map::tests::Random;
    use crate::walk::{self, Field};

    fn triangle(corners: [Vec3; 3]) -> Triangle {
        Triangle {
            corners: corners.map(|position| Corner {
                position: position.to_array(),
                ..Corner::default()
            }),
            ..Triangle::default()
        }
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
        let object = Object::default();
        let found = outline(&frame, &object, &triangle(front));
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
        assert!(!outline(&frame, &object, &triangle(sliver)).grown);
    }

    fn point(random: &mut Random, size: f64) -> Vec3 {
        let mut number = || random.within(-size, size) as f32;
        Vec3::new(number(), number(), number())
    }

    /// Triangles of all sizes around the eye, many with corners behind it, some
    /// with the eye in their shells.
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
            let object = Object {
                depth: random.choose(&[0.0, 0.1, 1.0]) as f32,
                ..Object::default()
            };
            let outline = outline(&frame, &object, &triangle);
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

    /// Rays around random prisms: where one comes in through a prism, it is drawn.
    #[test]
    fn every_pixel_that_comes_in_through_a_prism_lies_in_its_outline() {
        let mut random = Random(2);
        let object = Object {
            map_size: [1.0, 1.0],
            map_format: FORMAT_FLOAT,
            map_reach: 1.0,
            depth: 0.3,
            ..Object::default()
        };
        let (mut met, mut spared, mut grown) = (0, 0, 0);
        for round in 0..3_000 {
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|place| {
                let normal = (Vec3::Z + point(&mut random, 0.3)).normalize();
                (place + point(&mut random, 0.2), normal, Vec2::ZERO)
            });
            let mut shell = test_shell(corners, object.depth);
            if round % 2 == 0 {
                shell.neighbours = [0; 3];
            }
            let away = normalize_or(point(&mut random, 1.0), Vec3::X);
            let eye = away * random.magnitude(0.05, 20.0) as f32;
            let forward = normalize_or(point(&mut random, 0.5) - eye, Vec3::X);
            let tan_y = random.within(0.1, 2.0) as f32;
            let frame = frame(
                eye,
                forward,
                random.whole(1, 24),
                random.whole(1, 24),
                tan_y,
            );
            let outline = shell_outline(&frame, &object, &shell);
            grown += u32::from(outline.grown);
            // The pattern is everything: a ray that comes in meets something.
            let field = Field {
                shells: &[shell][..],
                depth: object.depth,
                blur: 1e-5,
                slack: 0.0,
                profile: &Profile::new(&object),
                map: &ShapeMap::new(&object),
                texels: &[(-0.5f32).to_bits()][..],
                linear_steps: 100,
                binary_steps: 0,
            };
            for y in 0..frame.size[1] as u32 {
                for x in 0..frame.size[0] as u32 {
                    let direction = pixel_ray(&frame, x, y);
                    let found = walk::search(&field, 0, eye, direction);
                    let centre = Vec2::new(
                        (2 * x + 1) as f32 / frame.size[0] - 1.0,
                        1.0 - (2 * y + 1) as f32 / frame.size[1],
                    );
                    let drawn = is_drawn(&outline, centre);
                    let t = found.march.s;
                    if found.march.end != END_MISS && reversed_depth(&frame, direction, t) <= 1.0 {
                        met += 1;
                        assert!(
                            drawn,
                            "pixel ({x}, {y}) outside {outline:?}: {frame:?} {shell:?}"
                        );
                    } else if !drawn {
                        spared += 1;
                    }
                }
            }
        }
        println!("{met} pixels come in, {spared} are spared, {grown} outlines are triangles");
        assert!(met > 20_000 && spared > 50_000 && grown > 300);
    }
}
