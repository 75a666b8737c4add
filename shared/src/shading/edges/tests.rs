use super::*;
use crate::camera::tests::frame;
use crate::camera::through;
use crate::gbuffer::{Sample, octahedral};
use crate::normals::{CLASS_CAP, CLASS_WALL};

use crate::shading::{Chart, FacetMaterial, Finish, Image, Light, ShadowMap};
use crate::shape_map::Texels;
use glam::UVec4;
use proptest::prelude::*;
use std::vec::Vec;

const SIDE: u32 = 8;

/// One material, on a carving that is 0.02 deep.
struct Materials(Finish, FacetMaterial);

impl Materials {
    fn new() -> Materials {
        let finish = Finish {
            depth: 0.02,
            side: CLASS_WALL,
            ..Finish::default()
        };
        let facet = FacetMaterial {
            density: [2.0, 2.0],
            ..FacetMaterial::default()
        };
        Materials(finish, facet)
    }
}

impl Texels for Materials {
    fn word(&self, _: u32) -> u32 {
        unreachable!("no picture is read")
    }
}

impl Tables for Materials {
    fn finish(&self, _: u32) -> &Finish {
        &self.0
    }

    fn facet(&self, _: u32) -> &FacetMaterial {
        &self.1
    }

    fn light(&self, _: u32) -> &Light {
        unreachable!("nothing is lit")
    }

    fn shadow_map(&self, _: u32) -> &ShadowMap {
        unreachable!("nothing is lit")
    }
}

/// Returns how pixel (`x`, `y`) of `picture` is divided.
fn divided(frame: &Frame, picture: &Picture, x: u32, y: u32) -> Division {
    division(&Materials::new(), frame, picture, x, y)
}

/// Returns the share of a pixel that lies between it and its neighbours.
fn all_between(found: &Division) -> f32 {
    let [before, after] = found.between();
    before + after
}

/// Returns the floor of what lies between pixel (`x`, `y`) and the one neighbour where something does, or the rest:
/// its share of that, the direction towards it, and what is there.
fn part_between(
    materials: &Materials,
    frame: &Frame,
    picture: &Picture,
    (x, y): (u32, u32),
    is_floor: bool,
) -> (f32, Vec3, Sample) {
    let found = division(materials, frame, picture, x, y);
    let [before, after] = found.between();
    assert!(before > 0.0 || after > 0.0, "{found:?}");
    assert!(before == 0.0 || after == 0.0, "{found:?}");
    let part = Part {
        is_after: after > 0.0,
        is_floor,
    };
    let (share, direction, hit) = between(materials, frame, picture, (x, y), &found, part);
    (share / (before + after), direction, hit)
}

/// A picture of `SIDE`² pixels.
struct Picture(Vec<(UVec4, UVec4)>);

impl Hits for Picture {
    fn words(&self, x: u32, y: u32) -> (UVec4, UVec4) {
        self.0[(y * SIDE + x) as usize]
    }
}

/// Looks along −z; a pixel is 0.01 wide at distance 1.
fn looking() -> Frame {
    frame(Vec3::ZERO, Vec3::NEG_Z, SIDE, SIDE, 0.04)
}

/// Returns the words of a hit.
fn hit(class: u32, finish: u32, t: f32, normal: Vec3, edge: u32) -> (UVec4, UVec4) {
    let place = UVec4::new(t.to_bits(), 0, 0, 1.0f32.to_bits());
    let (distance, direction) = (edge & 0x7f, edge >> 7);
    let bits = class | finish << 5 | distance << 17 | 0xff << 24;
    let surface = UVec4::new(
        bits,
        octahedral(normal),
        octahedral(Vec3::X),
        direction << 26,
    );
    (place, surface)
}

/// No edge is near.
const FAR: u32 = 0x7f;

/// Draws what `of` says of the ray through each pixel's centre.
fn draw(frame: &Frame, of: impl Fn(Vec3) -> (UVec4, UVec4)) -> Picture {
    let pixels = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    Picture(
        pixels
            .map(|(x, y)| of(through(frame, x as f32, y as f32)))
            .collect(),
    )
}

/// Returns the hit of `ray` on the plane through `point`.
fn on_plane(ray: Vec3, point: Vec3, normal: Vec3) -> Vec3 {
    ray * (point.dot(normal) / ray.dot(normal))
}

proptest! {
    #[test]
    fn two_planes_meet_where_their_line_is(
        at in -0.018f32..0.018,
        left in 0.3f32..2.5,
        right in 0.3f32..2.5,
    ) {
        // A ridge along y at x = `at`, whose sides fall to the left and the right.
        let frame = looking();
        let ridge = Vec3::new(at, 0.0, -1.0);
        let sides = [Vec3::new(-left, 0.0, 1.0), Vec3::new(right, 0.0, 1.0)];
        let picture = draw(&frame, |ray| {
            let normal = sides[usize::from(ray.x > at)].normalize();
            hit(CLASS_WALL, 0, on_plane(ray, ridge, normal).length(), normal, FAR)
        });
        for x in 0..SIDE {
            let found = divided(&frame, &picture, x, 4);
            let centre = through(&frame, x as f32, 4.0).x / 0.01;
            // The part of the pixel on the other side of the ridge.
            let beyond = 0.5 - (centre - at / 0.01).abs();
            let expected = beyond.max(0.0);
            let others = found.before.beyond() + found.after.beyond();
            prop_assert!((others - expected).abs() < 0.02, "{x}: {others} {expected}");
            prop_assert!(all_between(&found) == 0.0 && found.first == 0);
        }
    }

    #[test]
    fn a_slanted_edge_has_its_share_of_the_area(place in 0.0f32..1.0, slant in 0.0f32..1.0) {
        let lines = 1_000;
        let area: f32 = (0..lines)
            .map(|i| (i as f32 + 0.5) / lines as f32 - 0.5)
            .map(|across| (0.5 - place - slant * across).clamp(0.0, 1.0))
            .sum();
        let found = Ends::meeting(place).slanted(slant);
        prop_assert!((found.beyond() - area / lines as f32).abs() < 1e-3);
        prop_assert_eq!(found.between(), 0.0);
    }

    #[test]
    fn shares_survive_their_code(
        before in 0.0f32..0.5,
        after in 0.0f32..0.5,
        between in 0.0f32..1.0,
        is_down: bool,
    ) {
        let shares = Shares { is_down, before, after, between };
        let (class, found) = from_code(shares.code(CLASS_FLOOR));
        prop_assert_eq!((class, found.is_down), (CLASS_FLOOR, is_down));
        prop_assert!((found.before - before).abs() < 1e-3);
        prop_assert!((found.after - after).abs() < 1e-3);
        prop_assert!((found.between - between).abs() < 4e-3);
    }

    #[test]
    fn lights_survive_their_words(own in 1e-9f32..4e9, between in 1e-9f32..4e9, share in 0.01f32..1.0) {
        let of = |between| Shares { is_down: true, before: 0.5, after: 0.0, between }.code(CLASS_FLOOR);
        let light = |x: f32| Vec3::new(x, 0.5 * x, 0.0);
        let read = |own: f32, between: f32, code| {
            let words = light_words(light(own), light(between), code);
            lights_of(UVec4::new(words.x, words.y, words.z, code))
        };
        // Bit for bit alone, else to 2⁻¹¹.
        prop_assert_eq!(read(own, between, of(0.0)), (light(own), Vec3::ZERO));
        let (found, found_between) = read(own, between, of(share));
        for (found, right) in [(found, light(own)), (found_between, light(between))] {
            let error = (found - right).abs();
            prop_assert!(error.cmple(right * 5e-4).all(), "{found} {right}");
        }
    }
}

#[test]
fn light_beyond_the_range_of_its_words_is_the_nearest_in_it() {
    let code = Shares {
        is_down: false,
        before: 0.0,
        after: 0.0,
        between: 0.5,
    }
    .code(CLASS_CAP);
    let words = light_words(Vec3::splat(1e17), Vec3::splat(1e-20), code);
    let (own, between) = lights_of(UVec4::new(words.x, words.y, words.z, code));
    assert!(own.x > 4.29e9 && own.x.is_finite() && between == Vec3::ZERO);
}

#[test]
fn an_even_surface_and_the_border_of_the_picture_are_no_edges() {
    let frame = looking();
    let tilted = Vec3::new(0.9, 0.3, 0.3).normalize();
    let picture = draw(&frame, |ray| {
        let at = on_plane(ray, Vec3::new(0.0, 0.0, -1.0), tilted);
        hit(CLASS_CAP, 0, at.length(), tilted, FAR)
    });
    for i in 0..SIDE * SIDE {
        let found = divided(&frame, &picture, i % SIDE, i / SIDE);
        assert_eq!(found.others(), 0.0, "{found:?}");
    }
}

/// Draws a ball whose surface has no edge.
fn draw_ball(frame: &Frame, centre: Vec3, radius: f32) -> Picture {
    draw(frame, |ray| {
        let direction = ray.normalize();
        let middle = direction.dot(centre);
        let square = radius * radius - (centre.length_squared() - middle * middle);
        if square < 0.0 {
            return (UVec4::ZERO, UVec4::ZERO);
        }
        let t = middle - square.sqrt();
        hit(CLASS_CAP, 0, t, (direction * t - centre) / radius, FAR)
    })
}

proptest! {
    /// The shortcut finds what the search finds.
    #[test]
    fn no_edge_is_found_in_a_pixel_that_is_inside(
        size in -4.0f32..1.0, x in -1.0f32..1.0, y in -1.0f32..1.0,
    ) {
        // From a fiftieth of a pixel wide to flat.
        let radius = 10f32.powf(size);
        let frame = looking();
        let centre = Vec3::new(x * radius, y * radius, -1.0 - radius);
        let picture = draw_ball(&frame, centre, radius);
        for i in 0..(SIDE * SIDE) as i32 {
            let at = IVec2::new(i % SIDE as i32, i / SIDE as i32);
            if is_inside(&frame, &picture, at) {
                let found = at_edges(&Materials::new(), &frame, &picture, at);
                prop_assert!(found.others() == 0.0, "{at}: {found:?}");
            }
        }
    }
}

#[test]
fn the_middle_of_a_ball_and_of_nothing_is_inside() {
    let frame = looking();
    let is_inside = |picture: &Picture, x, y| is_inside(&frame, picture, IVec2::new(x, y));
    let large = draw_ball(&frame, Vec3::new(0.0, 0.0, -2.0), 1.0);
    assert!((0..8).all(|i| is_inside(&large, i, i)));
    let small = draw_ball(&frame, Vec3::new(0.0, 0.0, -1.0), 0.03);
    assert!(is_inside(&small, 0, 0) && !is_inside(&small, 1, 4));
}

#[test]
fn a_ball_ends_at_its_horizon() {
    // 3.3 pixels wide and high; it turns away evenly.
    let frame = looking();
    let centre = Vec3::new(0.002, -0.001, -1.0);
    let radius = 0.033;
    let picture = draw_ball(&frame, centre, radius);
    let mut covered = 0.0;
    for i in 0..SIDE * SIDE {
        let (x, y) = (i % SIDE, i / SIDE);
        let found = divided(&frame, &picture, x, y);
        let step = |sign: i32| match found.first == 2 {
            true => (x as i32, y as i32 + sign),
            false => (x as i32 + sign, y as i32),
        };
        let is_hit = |(x, y): (i32, i32)| {
            let is_inside = (0..SIDE as i32).contains(&x) && (0..SIDE as i32).contains(&y);
            is_inside && picture.words(x as u32, y as u32).1.x != 0
        };
        for (share, sign) in [(found.before.beyond(), -1), (found.after.beyond(), 1)] {
            // Its surface has no edge, however fast it curves.
            let is_one = is_hit((x as i32, y as i32)) && is_hit(step(sign));
            assert!(share == 0.0 || !is_one, "{x} {y}: {found:?}");
        }
        covered += (1.0 - found.before.beyond() - found.after.beyond())
            * f32::from(u8::from(is_hit((x as i32, y as i32))))
            + found.before.beyond() * f32::from(u8::from(is_hit(step(-1))))
            + found.after.beyond() * f32::from(u8::from(is_hit(step(1))));
    }
    let area = std::f32::consts::PI * (radius / 0.01).powi(2);
    assert!((covered / area - 1.0).abs() < 0.02, "{covered} {area}");
}

/// Draws a cap at z = −1 up to x = `outline`, and a floor at −1.02 that is seen from x = `foot`
/// on, or from the outline on.
fn draw_step(frame: &Frame, outline: f32, foot: f32) -> Picture {
    let code = |pixels: f32, turn: u32| match pixels < 1.0 {
        true => (pixels * 126.0).round() as u32 | turn << 7,
        false => FAR,
    };
    draw(frame, |ray| {
        if ray.x < outline {
            let edge = code((outline - ray.x) / 0.01, 0);
            hit(CLASS_CAP, 7, ray.length(), Vec3::Z, edge)
        } else {
            // Two quarter turns: to the left.
            let edge = code((ray.x - foot).abs() / 0.01, 32);
            hit(CLASS_FLOOR, 7, 1.02 * ray.length(), Vec3::Z, edge)
        }
    })
}

#[test]
fn a_side_that_no_pixel_shows_is_found() {
    // 0.3 pixels of it lie in pixel 3, and 0.1 in pixel 4.
    let frame = looking();
    let picture = draw_step(&frame, -0.003, 0.001);
    for (x, width) in [(2, 0.0), (3, 0.3), (4, 0.1), (5, 0.0)] {
        let found = divided(&frame, &picture, x, 3);
        assert!((all_between(&found) - width).abs() < 0.01, "{x}: {found:?}");
        assert_eq!((found.before.beyond(), found.after.beyond()), (0.0, 0.0));
        if width > 0.0 {
            let (share, direction, hit) =
                part_between(&Materials::new(), &frame, &picture, (x, 3), false);
            assert_eq!(share, 1.0);
            assert_eq!((hit.class, hit.finish), (CLASS_WALL, 7));
            assert!(hit.normal.dot(Vec3::X) > 0.999, "{}", hit.normal);
            let place = direction * hit.t;
            let middle = Vec3::new(-0.001, 0.005, -1.01);
            assert!((place - middle).length() < 1e-3, "{place}");
        }
    }
}

#[test]
fn a_cap_hides_the_foot_behind_it() {
    let frame = looking();
    let picture = draw_step(&frame, 0.002, -0.001);
    let found = divided(&frame, &picture, 4, 3);
    // Pixel 4 begins at 0, and the floor in it at 0.002.
    assert!((found.before.beyond() - 0.2).abs() < 0.01, "{found:?}");
    assert_eq!((found.after.beyond(), all_between(&found)), (0.0, 0.0));
    let found = divided(&frame, &picture, 3, 3);
    assert_eq!(found.others(), 0.0, "{found:?}");
}

#[test]
fn a_side_faces_the_eye_and_leans_as_its_bevel_does() {
    // The ground, seen from 1 unit above at a flat angle; a cap in the upper half of the picture
    // ends towards the eye.
    let tilt = Vec3::new(0.0, -0.5, -1.0).normalize();
    let frame = frame(Vec3::new(0.0, 1.0, 0.0), tilt, SIDE, SIDE, 0.04);
    let up = |y: f32, ray: Vec3| ray * ((y - 1.0) / ray.y);
    let picture = {
        let is_cap = |ray: Vec3| ray.y / ray.z < 0.498;
        draw(&frame, |ray| match is_cap(ray) {
            // The cap ends below, 0.5 pixels away, and the foot is 0.3 pixels above.
            true => hit(CLASS_CAP, 1, up(0.0, ray).length(), Vec3::Y, 63 | 16 << 7),
            false => hit(
                CLASS_FLOOR,
                1,
                up(-0.02, ray).length(),
                Vec3::Y,
                38 | 48 << 7,
            ),
        })
    };
    let mut materials = Materials::new();
    let pixels = (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE));
    let mut sides = 0;
    for (x, y) in pixels {
        let found = division(&materials, &frame, &picture, x, y);
        if all_between(&found) == 0.0 {
            continue;
        }
        sides += 1;
        for (growth, class, expected) in [
            ([0.0, 0.0], CLASS_WALL, Vec3::Z),
            // As wide as it is deep: 45 degrees. Only growth along v counts.
            (
                [0.5, 0.04],
                CLASS_BEVEL,
                Vec3::new(0.0, 1.0, 1.0).normalize(),
            ),
        ] {
            (materials.0.growth, materials.0.side) = (growth, class);
            let (share, direction, hit) = part_between(&materials, &frame, &picture, (x, y), false);
            assert_eq!((share, hit.class), (1.0, class));
            assert!(hit.normal.dot(expected) > 0.99, "{x} {y}: {}", hit.normal);
            assert!(hit.normal.dot(direction) < 0.0);
        }
    }
    assert!(sides > 0);
}

#[test]
fn edges_of_what_is_far_behind_do_not_count() {
    // A cap of the same object, far in front of a floor whose foot is near.
    let frame = looking();
    let picture = draw(&frame, |ray| match ray.x < 0.0 {
        true => hit(CLASS_CAP, 7, ray.length(), Vec3::Z, FAR),
        false => hit(CLASS_FLOOR, 7, 3.0 * ray.length(), Vec3::Z, 25 | 32 << 7),
    });
    for x in [3, 4] {
        let found = divided(&frame, &picture, x, 3);
        assert_eq!(found.others(), 0.0, "{found:?}");
    }
}

/// Returns the words of [`hit`] at the depth fraction δ.
fn at_depth((place, surface): (UVec4, UVec4), depth: f32) -> (UVec4, UVec4) {
    let depth = (depth * 1_023.0).round() as u32;
    (place | UVec4::new(0, 0, 0, depth), surface)
}

/// Looks down at 63 degrees from 1 unit above the ground. Returns the frame, the row of what is seen along a
/// vector, and the way along a ray to a height above the ground.
fn above_ground() -> (Frame, impl Fn(Vec3) -> f32, impl Fn(f32, Vec3) -> Vec3) {
    let tilt = Vec3::new(0.0, -1.0, -0.5).normalize();
    let frame = frame(Vec3::new(0.0, 1.0, 0.0), tilt, SIDE, SIDE, 0.04);
    let (first, down) = (vec3(frame.ray_first), vec3(frame.ray_down));
    let row = move |way: Vec3| (way / way.dot(tilt) - first).dot(down) / down.length_squared();
    let up = |y: f32, ray: Vec3| ray * ((y - 1.0) / ray.y);
    (frame, row, up)
}

#[test]
fn the_rim_of_a_bevel_hides_its_wall() {
    // The ground, seen from above at 63 degrees. A cap ends where it falls away from the eye: by a
    // bevel of 45 degrees that is seen, and a wall that is not.
    let (frame, row, up) = above_ground();
    let eye = vec3(frame.eye);
    let mut materials = Materials::new();
    materials.0.growth = [0.3, 0.012];
    materials.0.rim = 0.3;
    materials.0.side = CLASS_BEVEL;
    for edge in [-0.495, -0.498, -0.501] {
        let outline = row(Vec3::new(0.0, 0.0, edge) - eye);
        let rim = row(Vec3::new(0.0, -0.006, edge - 0.006) - eye);
        assert!(outline - rim > 0.1);
        let picture = draw(&frame, |ray| {
            let distance = row(ray) - outline;
            if distance >= 0.0 {
                let code = ((distance * 126.0) as u32).min(FAR);
                hit(CLASS_CAP, 1, up(0.0, ray).length(), Vec3::Y, code | 48 << 7)
            } else {
                hit(CLASS_FLOOR, 1, up(-0.02, ray).length(), Vec3::Y, FAR)
            }
        });
        let between = |y| all_between(&division(&materials, &frame, &picture, 4, y));
        let found: f32 = (0..SIDE).map(between).sum();
        assert!(
            (found - (outline - rim)).abs() < 0.02,
            "{found} {outline} {rim}"
        );
    }
}

#[test]
fn a_side_knows_where_bevel_and_wall_end() {
    let frame = looking();
    let mut materials = Materials::new();
    materials.0.rim = 0.5;
    let lower = Vec3::new(0.0, -0.7, 0.7).normalize();
    // Four pixels of cap, one of the side, and three of floor. The side's edge is 0.4 pixels above.
    let picture = |class, depth: f32, edge: u32| {
        draw(&frame, |ray| {
            let (row, t) = ((0.04 - ray.y) / 0.01, ray.length());
            if row > 4.0 && row < 5.0 {
                let t = (1.0 + 0.02 * depth) * t;
                at_depth(hit(class, 7, t, lower, 50 | 48 << 7), depth)
            } else if row > 4.0 {
                hit(CLASS_FLOOR, 7, 1.02 * t, Vec3::Z, FAR)
            } else {
                hit(CLASS_CAP, 7, t, Vec3::Z, edge)
            }
        })
    };
    // Under the cap; half of the depth from the rim, which hides the wall, to the floor below.
    let found = division(&materials, &frame, &picture(CLASS_BEVEL, 0.3, FAR), 4, 4);
    assert!(found.first == 2 && all_between(&found) == 0.0);
    assert!((found.before.beyond() - 0.1).abs() < 0.01, "{found:?}");
    assert!(
        (found.after.beyond() - (0.5 - 0.4 * 0.2 / 0.3)).abs() < 0.01,
        "{found:?}"
    );
    // Between a wall and its cap, which both know the same edge, is a bevel.
    materials.0.side = CLASS_BEVEL;
    let picture = picture(CLASS_WALL, 0.9, 76 | 16 << 7);
    let found = division(&materials, &frame, &picture, 4, 4);
    assert!((found.before.beyond() - 0.1).abs() < 0.01, "{found:?}");
    let width = 0.4 * 0.5 / 0.9;
    assert!((all_between(&found) - width).abs() < 0.01, "{found:?}");
    let (share, _, hit) = part_between(&materials, &frame, &picture, (4, 4), false);
    assert_eq!((share, hit.class), (1.0, CLASS_BEVEL));
    let found = division(&materials, &frame, &picture, 4, 3);
    assert_eq!(found.others(), 0.0, "{found:?}");
}

#[test]
fn between_two_sides_is_floor_and_beyond_one_that_hides_the_other_its_cap() {
    // Sides that fall by their depth in a pixel, to the right and to the left, with their feet at −0.001 and 0.002.
    let frame = looking();
    let depth = 0.02;
    let side = |ray: Vec3, foot: f32, sign: f32| {
        let up = (ray.x - foot) * sign / 0.01;
        let normal = Vec3::new(-sign * depth, 0.0, 0.01).normalize();
        let code = ((1.0 - up) * 126.0) as u32 | if sign > 0.0 { 0 } else { 32 << 7 };
        let t = (1.0 + depth * (1.0 - up)) * ray.length();
        let (place, mut surface) = at_depth(hit(CLASS_BEVEL, 7, t, normal, code), 1.0 - up);
        surface.z = octahedral(Vec3::Z);
        (place, surface)
    };
    let picture = draw(&frame, |ray| match ray.x {
        x if x.abs() > 0.01 => hit(CLASS_CAP, 7, ray.length(), Vec3::Z, FAR),
        x if x < 0.0 => side(ray, -0.001, -1.0),
        _ => side(ray, 0.002, 1.0),
    });
    let mut materials = Materials::new();
    (materials.0.rim, materials.0.side) = (1.0, CLASS_BEVEL);
    for (x, width) in [(3, 0.1), (4, 0.2)] {
        let found = division(&materials, &frame, &picture, x, 4);
        assert!((all_between(&found) - width).abs() < 0.02, "{x}: {found:?}");
        let (share, direction, hit) = part_between(&materials, &frame, &picture, (x, 4), true);
        assert_eq!((share, hit.class), (1.0, CLASS_FLOOR));
        let place = direction * hit.t;
        assert!(
            (place - Vec3::new(0.0005, 0.0, -1.02)).length() < 0.006,
            "{place}"
        );
    }
    // One that rises to its cap at 0.001, which hides the one that is farther to the right, or a floor.
    for is_floor in [false, true] {
        let picture = draw(&frame, |ray| match ray.x < 0.0 {
            true => side(ray, -0.009, 1.0),
            false if is_floor => hit(CLASS_FLOOR, 7, 1.03 * ray.length(), Vec3::Z, FAR),
            false => {
                let normal = Vec3::new(-0.02, 0.0, 0.01).normalize();
                let far = hit(CLASS_WALL, 7, 1.5 * ray.length(), normal, FAR);
                at_depth(far, 0.5)
            }
        });
        let found = division(&materials, &frame, &picture, 3, 4);
        assert_eq!(all_between(&found), 0.0);
        // Its cap is seen from there up to the centre of pixel 4.
        let found = division(&materials, &frame, &picture, 4, 4);
        assert!((all_between(&found) - 0.4).abs() < 0.02, "{found:?}");
        let (share, direction, hit) = part_between(&materials, &frame, &picture, (4, 4), false);
        assert_eq!((share, hit.class), (1.0, CLASS_CAP));
        assert!(((direction * hit.t).z + 1.0).abs() < 1e-3);
        assert!(hit.normal.dot(Vec3::Z) > 0.9999);
    }
}

#[test]
fn a_border_that_no_hit_knows_is_the_line_through_its_stairs() {
    // A flat mesh before nothing. Its border falls by a pixel in four.
    let frame = looking();
    let border = |x: f32| 0.0012 - 0.25 * x;
    let picture = draw(&frame, |ray| match ray.y < border(ray.x) {
        true => hit(CLASS_CAP, 0, ray.length(), Vec3::Z, FAR),
        false => (UVec4::ZERO, UVec4::ZERO),
    });
    // Where steps are not cut off by the picture's border.
    for x in 2..6 {
        let column = (0..SIDE).map(|y| {
            let found = divided(&frame, &picture, x, y);
            assert!(found.first == 2 || found.before.beyond() + found.after.beyond() == 0.0);
            assert_eq!(all_between(&found), 0.0);
            let is_hit = |y: u32| picture.words(x, y).1.x != 0;
            let part = |is_hit: bool| if is_hit { 1.0 } else { 0.0 };
            let mut covered =
                (1.0 - found.before.beyond() - found.after.beyond()) * part(is_hit(y));
            if found.before.beyond() > 0.0 {
                covered += found.before.beyond() * part(is_hit(y - 1));
            }
            if found.after.beyond() > 0.0 {
                covered += found.after.beyond() * part(is_hit(y + 1));
            }
            covered
        });
        let covered: f32 = column.sum();
        let expected = (border(through(&frame, x as f32, 0.0).x) + 0.04) / 0.01;
        assert!(
            (covered - expected).abs() < 0.13,
            "{x}: {covered} {expected}"
        );
    }
}

#[test]
fn the_floor_before_an_opposite_side_is_found() {
    // The floor between a cap, up to 0, and the foot of the opposite bevel is 0.6 pixels wide and lies
    // between the centres of pixels 3 and 4.
    let frame = looking();
    let (cap, foot) = (-0.003, 0.003);
    let slope = Vec3::new(-1.0, 0.0, 1.0).normalize();
    let picture = draw(&frame, |ray| {
        if ray.x < cap {
            let code = (((cap - ray.x) / 0.01 * 126.0) as u32).min(FAR);
            hit(CLASS_CAP, 7, ray.length(), Vec3::Z, code)
        } else if ray.x < 0.011 {
            // At three quarters of the depth, three times as far from its cap as from the foot.
            let code = (3.0 * (ray.x - foot) / 0.01 * 126.0) as u32;
            let t = (1.0 + 0.75 * 0.02) * ray.length();
            at_depth(hit(CLASS_BEVEL, 7, t, slope, code), 0.75)
        } else {
            hit(CLASS_CAP, 7, ray.length(), Vec3::Z, FAR)
        }
    });
    let mut materials = Materials::new();
    materials.0.rim = 1.0;
    materials.0.side = CLASS_BEVEL;
    for (x, width) in [(3, 0.3), (4, 0.3)] {
        let found = division(&materials, &frame, &picture, x, 4);
        assert!((all_between(&found) - width).abs() < 0.02, "{x}: {found:?}");
        assert_eq!((found.before.beyond(), found.after.beyond()), (0.0, 0.0));
        let (share, direction, hit) = part_between(&materials, &frame, &picture, (x, 4), true);
        // A little of the side below the cap is seen.
        assert!(share > 0.98, "{share}");
        assert_eq!((hit.class, hit.finish), (CLASS_FLOOR, 7));
        assert!(hit.normal.dot(Vec3::Z) > 0.9999);
        let place = direction * hit.t;
        assert!(
            (place.z + 1.02).abs() < 1e-3 && place.x.abs() < 1e-3,
            "{place}"
        );
        assert!(hit.openness > 0.0 && hit.openness < 0.5, "{}", hit.openness);
    }
}

/// Returns the code of an edge that is at `place` on the x axis at distance 1, to the left or the right.
fn edge_at(ray: Vec3, place: f32) -> u32 {
    let pixels = (ray.x - place).abs() / 0.01;
    let direction = if place < ray.x { 32 } else { 0 };
    ((pixels * 126.0) as u32).min(FAR) | direction << 7
}

/// Returns materials on a pattern whose gaps are 0.006 wide and run along u or v.
fn with_gaps() -> Materials {
    let mut materials = Materials::new();
    materials.0.rim = 1.0;
    materials.0.side = CLASS_BEVEL;
    // 100 texels are 0.5 wide.
    materials.0.chart = Chart {
        image: Image {
            width: 100,
            height: 100,
            levels: 1,
            ..Image::default()
        },
        gap: 1.2,
        order: 1.0,
        ..Chart::default()
    };
    materials
}

#[test]
fn a_cap_that_knows_another_edge_begins_a_gap_after_the_opposite_one() {
    // Caps up to -0.001 and from 0.005. The bevel at 45 degrees between them is seen in pixel 4, from
    // the first cap to the second one; that one is nearer to its edge at 0.017.
    let frame = looking();
    let slope = Vec3::new(1.0, 0.0, 1.0).normalize();
    let picture = draw(&frame, |ray| {
        if ray.x < -0.001 || ray.x > 0.01 {
            let place = if ray.x < 0.0 { -0.001 } else { 0.017 };
            let code = edge_at(ray, place);
            hit(CLASS_CAP, 7, ray.length(), Vec3::Z, code)
        } else {
            let deep = 0.02 * (ray.x + 0.001) / 0.02;
            let code = edge_at(ray, -0.001);
            let bevel = hit(CLASS_BEVEL, 7, (1.0 + deep) * ray.length(), slope, code);
            at_depth(bevel, deep / 0.02)
        }
    });
    let mut materials = with_gaps();
    let found = division(&materials, &frame, &picture, 4, 4);
    // The pixel is from 0 to 0.01.
    assert!(found.first == 0 && all_between(&found) == 0.0);
    assert!((found.after.beyond() - 0.5).abs() < 0.02, "{found:?}");
    // Without gaps that are known, the foot of the bevel would be its end.
    materials.0.chart = Chart::default();
    let found = division(&materials, &frame, &picture, 4, 4);
    assert_eq!((found.before.beyond(), found.after.beyond()), (0.0, 0.0));
}

#[test]
fn a_gap_between_two_caps_that_no_pixel_shows_is_found() {
    // From -0.004 to 0.002, between the centres of pixels 3 and 4. Both know it, or one of them, the other
    // one being nearer to another edge.
    let frame = looking();
    for (knows_left, knows_right) in [(true, true), (true, false), (false, true)] {
        let picture = draw(&frame, |ray| {
            let (near, far, knows) = match ray.x < 0.0 {
                true => (-0.004, -0.0155, knows_left),
                false => (0.002, 0.0155, knows_right),
            };
            let code = edge_at(ray, if knows { near } else { far });
            hit(CLASS_CAP, 7, ray.length(), Vec3::Z, code)
        });
        let mut materials = with_gaps();
        for (x, width) in [(3, 0.4), (4, 0.2)] {
            let found = division(&materials, &frame, &picture, x, 4);
            assert!((all_between(&found) - width).abs() < 0.02, "{x}: {found:?}");
            let (sides, ..) = part_between(&materials, &frame, &picture, (x, 4), false);
            let (floor, direction, hit) = part_between(&materials, &frame, &picture, (x, 4), true);
            assert!(floor > 0.9 && (sides + floor - 1.0).abs() < 1e-6, "{floor}");
            assert_eq!(hit.class, CLASS_FLOOR);
            assert!(((direction * hit.t).z + 1.02).abs() < 1e-3);
        }
        // Bevels that are 0.001 wide lie at the ends of the gap, and the floor in its middle.
        materials.0.growth = [0.002, 0.0];
        for (x, floor, facing) in [(3, 0.75, 1.0), (4, 0.5, -1.0)] {
            let (sides, _, hit) = part_between(&materials, &frame, &picture, (x, 4), false);
            assert!((sides - (1.0 - floor)).abs() < 0.06, "{x}: {sides}");
            assert_eq!(hit.class, CLASS_BEVEL);
            assert!(hit.normal.x * facing > 0.9, "{x}: {}", hit.normal);
            let (share, ..) = part_between(&materials, &frame, &picture, (x, 4), true);
            assert!((sides + share - 1.0).abs() < 1e-6, "{x}: {share}");
        }
        // Where outlines run in all directions, they are not so straight.
        materials.0.chart.order = 0.0;
        let found = division(&materials, &frame, &picture, 3, 4);
        assert_eq!(all_between(&found), 0.0);
    }
}

#[test]
fn the_wall_between_a_floor_and_its_bevel_is_found() {
    // The ground, seen from above at 63 degrees: a floor, whose wall rises away from the eye up to the
    // rim of a bevel. The wall is less than a pixel wide, and no pixel's centre is on it. The floor knows
    // its foot, or the opposite edge only.
    let (frame, row, up) = above_ground();
    let eye = vec3(frame.eye);
    let mut materials = Materials::new();
    materials.0.rim = 0.6;
    for (place, is_opposite) in [(-0.51, false), (-0.507, true)] {
        let foot = row(Vec3::new(0.0, -0.02, place) - eye);
        let rim = row(Vec3::new(0.0, -0.012, place) - eye);
        assert!(foot - rim > 0.2 && foot.floor() == rim.floor());
        let code = |pixels: f32| ((pixels * 126.0) as u32).min(FAR);
        let picture = draw(&frame, |ray| {
            let distance = row(ray) - foot;
            if distance >= 0.0 {
                let edge = if is_opposite {
                    code(1.2 - distance) | 16 << 7
                } else {
                    code(distance) | 48 << 7
                };
                hit(CLASS_FLOOR, 1, up(-0.02, ray).length(), Vec3::Y, edge)
            } else if row(ray) < foot.floor() - 0.5 {
                hit(CLASS_CAP, 1, up(0.0, ray).length(), Vec3::Y, FAR)
            } else {
                let slope = Vec3::new(0.0, 1.0, 1.0).normalize();
                // At two thirds of the way from its cap to the rim.
                let edge = code(2.0 * (rim - row(ray))) | 48 << 7;
                let t = up(-0.008, ray).length();
                at_depth(hit(CLASS_BEVEL, 1, t, slope, edge), 0.4)
            }
        });
        let mut width = 0.0;
        for y in 0..SIDE {
            let found = division(&materials, &frame, &picture, 4, y);
            width += all_between(&found);
            if all_between(&found) > 0.0 {
                let (share, direction, hit) =
                    part_between(&materials, &frame, &picture, (4, y), false);
                assert_eq!((share, hit.class), (1.0, CLASS_WALL));
                assert!(hit.normal.dot(Vec3::Z) > 0.99, "{}", hit.normal);
                // Half way up the wall, at the place where it is seen.
                let place = eye + direction * hit.t;
                assert!((place.y + 0.016).abs() < 2e-3, "{place}");
            }
        }
        assert!((width - (foot - rim)).abs() < 0.02, "{width} {foot} {rim}");
    }
}
