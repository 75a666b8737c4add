use super::*;
use crate::arithmetic::normalize_or;
use crate::camera::tests::{frame, looking_down_z};
use crate::camera::{pixel_ray, reversed_depth};
use crate::facet;
use crate::layout::{Corner, FORMAT_FLOAT};
use crate::march::END_MISS;
use crate::prism::tests::test_prism;
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
        (found.low - Vec2::new(-0.4625, -0.325)).length() < 1e-6,
        "{found:?}"
    );
    assert!(
        (found.high - Vec2::new(0.2625, 0.725)).length() < 1e-6,
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
fn a_rectangle_lies_in_the_triangle_that_is_drawn_for_it() {
    let outline = Outline {
        grown: false,
        corners: [Vec2::ZERO; 3],
        rectangle: Rectangle {
            low: Vec2::new(-0.5, -1.0),
            high: Vec2::new(0.25, 0.5),
        },
    };
    for (x, y) in [(-0.5, -1.0), (0.25, -1.0), (-0.5, 0.5), (0.25, 0.5)] {
        assert!(is_drawn(&outline, Vec2::new(x, y)));
    }
    assert!(!is_drawn(&outline, Vec2::new(0.3, 0.5)));
}

/// Whether `point` lies in the triangle that is drawn for `outline`.
fn is_drawn(outline: &Outline, point: Vec2) -> bool {
    let [a, b, c] = [0, 1, 2].map(|index| outline_corner(outline, index));
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| (q - p).perp_dot(point - p));
    let area = (b - a).perp_dot(c - a);
    area != 0.0 && (sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0))
}

#[test]
fn the_outline_of_a_plain_triangle_is_a_quarter_of_a_pixel_wider() {
    let mut frame = looking_down_z();
    frame.size = [200.0, 100.0];
    let front = [(-0.4, -0.1), (0.2, -0.1), (-0.4, 0.3)].map(|(x, y)| Vec3::new(x, y, -1.0));
    let object = Object::default();
    let found = outline(&frame, &object, &triangle(front));
    assert!(found.grown);
    // A pixel is 0.01 and 0.02: the right angle moves by a quarter of each.
    let corner = Vec2::new(-0.4025, -0.205);
    assert!((found.corners[0] - corner).length() < 1e-5, "{found:?}");
    // Half the rectangle's area, and the margin.
    let [a, b, c] = found.corners;
    let area = 0.5 * (b - a).perp_dot(c - a);
    assert!((0.24..0.3).contains(&area), "{area}");
    // A sliver has its rectangle drawn.
    let sliver = [front[0], front[1], Vec3::new(-0.4, -0.095, -1.0)];
    assert!(!outline(&frame, &object, &triangle(sliver)).grown);
}

/// Slivers in pictures of up to 8,192 pixels: pixels along their sides and at their tips. From
/// about 13,000 on, the test of a ray against a sliver of two pixels is wrong by more than the
/// margin.
#[test]
fn every_pixel_that_meets_a_sliver_lies_in_its_outline() {
    let mut random = Random(3);
    let (mut sharp, mut met) = (0, 0);
    for _ in 0..20_000 {
        let size = random.whole(500, 8_192);
        let frame = frame(Vec3::ZERO, Vec3::NEG_Z, size, size, 0.5);
        // Of a picture that is 1 wide at distance 1.
        let (pixel, turn) = (
            1.0 / f64::from(size),
            random.within(0.0, std::f64::consts::TAU),
        );
        let length = random.magnitude(2.0 * pixel, 0.7);
        let sine = random.magnitude(0.01, 0.3);
        let tip = [0; 2].map(|_| random.within(-0.4, 0.4));
        let at = |angle: f64, length: f64, distance: f64| {
            let (x, y) = (tip[0] + angle.cos() * length, tip[1] + angle.sin() * length);
            Vec3::new(x as f32, y as f32, -1.0) * distance as f32
        };
        let mut distance = || random.magnitude(0.5, 2.0);
        let corners = [
            at(0.0, 0.0, distance()),
            at(turn, length, distance()),
            at(turn + sine.asin(), 0.9 * length, distance()),
        ];
        let triangle = triangle(corners);
        let outline = outline(&frame, &Object::default(), &triangle);
        sharp += u32::from(outline.grown && sine < 0.15);
        for _ in 0..40 {
            // Near a corner, or near a side.
            let near = random.magnitude(1e-4, 0.5) as f32;
            let across = random.magnitude(1e-4, 1.0) as f32;
            let [a, b, c] = corners;
            let point = a + (b - a) * near + (c - b) * (near * across);
            let place = |x: f32| (x / -point.z * size as f32 + 0.5 * size as f32) as i32;
            let [x, y] = [place(point.x), place(-point.y)];
            if x < 0 || y < 0 || x >= size as i32 || y >= size as i32 {
                continue;
            }
            let direction = pixel_ray(&frame, x as u32, y as u32);
            if facet::intersect(Vec3::ZERO, direction, &triangle).hit {
                met += 1;
                let centre = |i: i32| (i as f32 + 0.5) * (2.0 / size as f32) - 1.0;
                let centre = Vec2::new(centre(x), -centre(y));
                assert!(is_drawn(&outline, centre), "{size} {corners:?} {x} {y}");
            }
        }
    }
    assert!(sharp > 5_000 && met > 50_000, "{sharp} {met}");
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
            random.whole(1, 64),
            random.whole(1, 64),
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
    assert!(grown > 500, "{grown}");
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
        linear_steps: 100,
        ..Object::default()
    }
    .complete();
    let (mut met, mut spared, mut grown) = (0, 0, 0);
    for round in 0..3_000 {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|place| {
            let normal = (Vec3::Z + point(&mut random, 0.3)).normalize();
            (place + point(&mut random, 0.2), normal, Vec2::ZERO)
        });
        let mut data = test_prism(corners, object.depth);
        if round % 2 == 0 {
            data.neighbours = [0; 3];
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
        let outline = prism_outline(&frame, &object, &data);
        grown += u32::from(outline.grown);
        // The pattern is everything: a ray that comes in meets something.
        let field = Field {
            prisms: &[data][..],
            object: &object,
            tolerance: 1e-5,
            slack: 0.0,
            texels: &[(-0.5f32).to_bits()][..],
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
                        "pixel ({x}, {y}) outside {outline:?}: {frame:?} {data:?}"
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
