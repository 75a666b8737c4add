//! A plane in four prisms, and what both halves of the search find there.

use super::*;
use crate::layout::{FORMAT_FLOAT, NO_NEIGHBOUR, Object, PrismData};
use crate::march::{END_CAP, END_FLOOR, END_SIDE};
use crate::prism::tests::test_prism;

/// The plane z = 0 over (0, 0) to (2, 1) in four triangles, half a unit deep,
/// with one column: texels 0 and 1 of 4 along u = x.
///
/// ```text
/// (0, 1) ─── (1, 1) ─── (2, 1)
///   │  1   ╱   │   3  ╱   │
///   │   ╱   0  │  ╱    2  │
/// (0, 0) ─── (1, 0) ─── (2, 0)
/// ```
pub(super) fn plane() -> [PrismData; 4] {
    let corner = |x: f32, y: f32| (Vec3::new(x, y, 0.0), Vec3::Z, Vec2::new(x, y));
    let triangle = |a, b, c| test_prism([a, b, c], 0.5);
    let [a, b, c] = [0.0, 1.0, 2.0].map(|x| corner(x, 0.0));
    let [d, e, f] = [0.0, 1.0, 2.0].map(|x| corner(x, 1.0));
    let mut prisms = [
        triangle(a, b, e),
        triangle(a, e, d),
        triangle(b, c, f),
        triangle(b, f, e),
    ];
    let mut join = |(first, side): (u32, u32), (second, other): (u32, u32)| {
        prisms[first as usize].neighbours[side as usize] = 4 * second + other;
        prisms[second as usize].neighbours[other as usize] = 4 * first + side;
    };
    // Sides are counted by the corner opposite to them.
    join((0, 1), (1, 2));
    join((0, 0), (3, 1));
    join((2, 1), (3, 2));
    prisms
}

fn object() -> Object {
    Object {
        map_size: [4.0, 1.0],
        map_step: 1.0,
        map_format: FORMAT_FLOAT,
        map_reach: 1.0,
        depth: 0.5,
        linear_steps: 1000,
        ..Object::default()
    }
    .complete()
}

const TEXELS: [f32; 4] = [-0.5, -0.5, 0.5, 0.5];

fn with_field<R>(prisms: &[PrismData], run: impl Fn(&Field<'_, [PrismData], [u32]>) -> R) -> R {
    let object = object();
    run(&Field {
        prisms,
        object: &object,
        tolerance: 1e-5,
        slack: 0.0,
        texels: &TEXELS.map(f32::to_bits)[..],
        binary_steps: 24,
    })
}

fn hit(home: u32, eye: [f32; 3], direction: [f32; 3]) -> Found {
    let direction = Vec3::from(direction).normalize();
    with_field(&plane(), |field| {
        search(field, home, Vec3::from(eye), direction)
    })
}

#[test]
fn cap_and_floor_are_found_by_the_triangle_above_them_only() {
    let cap = hit(0, [0.25, 0.1, 2.0], [0.0, 0.0, -1.0]);
    assert_eq!(cap.march.end, END_CAP);
    assert!((cap.march.s - 2.0).abs() < 1e-4, "{cap:?}");
    let floor = hit(0, [0.75, 0.1, 2.0], [0.0, 0.0, -1.0]);
    assert_eq!(floor.march.end, END_FLOOR);
    assert!((floor.march.s - 2.5).abs() < 2e-4, "{floor:?}");
    for other in 1..4 {
        let nothing = hit(other, [0.25, 0.1, 2.0], [0.0, 0.0, -1.0]);
        assert_eq!(nothing.march.end, END_MISS);
    }
    // From below there is nothing.
    let below = hit(0, [0.75, 0.1, -2.0], [0.0, 0.0, 1.0]);
    assert_eq!(below.march.end, END_MISS);
}

#[test]
fn a_ray_is_followed_into_the_neighbours() {
    // In over triangle 2 at x = 1.9, against the column's side at u = 1.5.
    let wall = hit(2, [2.1, 0.6, 0.2], [-1.0, 0.0, -1.0]);
    assert_eq!(wall.march.end, END_SIDE);
    assert!((wall.march.uv.x - 1.5).abs() < 1e-2, "{wall:?}");
    assert!((wall.march.depth_fraction - 0.8).abs() < 2e-2, "{wall:?}");
    assert_eq!((wall.prism, wall.prisms), (3, 2));
    // All the way along the trench between u = 0.5 and u = 1.
    let end = hit(3, [1.6, 0.9, 0.01], [0.1, -1.0, -0.1]);
    assert_eq!(end.march.end, END_MISS, "{end:?}");
    // Where the neighbours are unknown, the surface ends.
    let mut alone = plane();
    alone[2].neighbours = [NO_NEIGHBOUR; 3];
    let direction = Vec3::new(-1.0, 0.0, -1.0).normalize();
    let lost = with_field(&alone, |field| {
        search(field, 2, Vec3::new(2.1, 0.6, 0.2), direction)
    });
    assert_eq!(lost.march.end, END_MISS);
}

#[test]
fn open_sides_and_the_eye_inside_let_rays_in() {
    // Through the cut at y = 0, below the cap, along the trench's floor.
    let cut = hit(0, [0.75, -1.0, -0.2], [0.0, 1.0, -0.05]);
    assert_eq!(cut.march.end, END_MISS);
    let cut = hit(0, [0.75, -1.0, -0.2], [0.0, 1.0, -0.25]);
    assert_eq!(cut.march.end, END_FLOOR);
    // Into the column's own cut: no cap.
    let cut = hit(0, [0.25, -1.0, -0.2], [0.0, 1.0, 0.0]);
    assert_eq!(cut.march.end, END_SIDE);
    assert!((cut.march.s - 1.0).abs() < 1e-3, "{cut:?}");
    // The side between two triangles lets nothing in by itself.
    let closed = hit(1, [0.75, -1.0, -0.2], [0.0, 1.0, -0.25]);
    assert_eq!(closed.march.end, END_MISS);
    // From within the trench against the column, and away from it.
    let inside = hit(0, [0.7, 0.1, -0.1], [-1.0, 0.0, 0.0]);
    assert_eq!(inside.march.end, END_SIDE);
    assert!((inside.march.s - 0.2).abs() < 1e-2, "{inside:?}");
    let away = hit(0, [0.7, 0.1, -0.1], [0.0, 0.0, 1.0]);
    assert_eq!(away.march.end, END_MISS);
}

#[test]
fn light_comes_from_where_no_column_stands() {
    let prisms = plane();
    // On the trench's floor at (0.6, 0.1): the column's edge is 0.1 away.
    let x = Vec3::new(0.5, 0.1, 1.0);
    let lit = |direction: Vec3| {
        with_field(&prisms, |field| {
            leaves(field, 0, x, Vec3::ZERO, direction.normalize())
        })
    };
    assert!(lit(Vec3::Z));
    assert!(lit(Vec3::new(1.0, 0.0, 3.0)));
    assert!(!lit(Vec3::new(-1.0, 0.0, 1.0)));
    // Through the neighbour, against the next column at u = 1.
    assert!(!lit(Vec3::new(1.0, 0.0, 0.5)));
}
