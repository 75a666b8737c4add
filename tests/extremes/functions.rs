//! Functions of the shared mathematics on their whole domains.

use proptest::prelude::*;
use proptest::test_runner::Config;
use relievo_shared::contract::LARGEST;
use relievo_shared::layout::{Corner, Triangle};
use relievo_shared::layout::{FORMAT_FLOAT, Object, TIER_FAST, TIER_PLANAR};
use relievo_shared::march::{END_FLOOR, END_MISS, END_SIDE, Limits, TOLERANCE, march};
use relievo_shared::path::{Path, QuadraticPath, test_surface};
use relievo_shared::profile::Profile;
use relievo_shared::shape_map::ShapeMap;
use relievo_shared::{Vec2, Vec3, arithmetic, facet};

use relievo_tests::is_long;

fn config() -> Config {
    Config {
        cases: if is_long() { 500_000 } else { 20_000 },
        failure_persistence: None,
        ..Config::default()
    }
}

/// 0, or any magnitude from 2^low to 2^high, with either sign.
fn number(low: i32, high: i32) -> impl Strategy<Value = f32> {
    let signed = (f64::from(low)..f64::from(high), any::<bool>()).prop_map(|(power, negative)| {
        let x = power.exp2() as f32;
        if negative { -x } else { x }
    });
    prop_oneof![1 => Just(0.0_f32), 8 => signed]
}

/// Directions with V_z from 1 through 1e-30 to 0 and up.
fn direction() -> impl Strategy<Value = Vec3> {
    let v_z = prop_oneof![number(-100, 0), Just(1.0_f32), Just(-1.0), Just(1e-30)];
    (v_z, 0.0..std::f64::consts::TAU).prop_map(|(v_z, angle)| {
        let around = (1.0 - f64::from(v_z) * f64::from(v_z)).max(0.0).sqrt();
        let (y, x) = angle.sin_cos();
        Vec3::new((around * x) as f32, (around * y) as f32, -v_z)
    })
}

/// Curvatures from 0 through 1e-30 to 1e6, mixed signs, sometimes the cross
/// term alone.
fn quadric() -> impl Strategy<Value = [f32; 3]> {
    prop_oneof![
        3 => [number(-100, 20), number(-100, 20), number(-100, 20)],
        1 => number(-100, 20).prop_map(|xy| [0.0, xy, 0.0]),
        1 => number(-100, 20).prop_map(|q| [q, 0.0, -q]),
    ]
}

/// Depths of 2^-30 to 2^10 units.
fn depth() -> impl Strategy<Value = f32> {
    (-30.0..10.0_f64).prop_map(|power| power.exp2() as f32)
}

/// Maps of f32 distances: width, height, and the distance of every texel.
#[derive(Clone, Debug)]
struct Map {
    size: [u32; 2],
    words: Vec<u32>,
}

fn map() -> impl Strategy<Value = Map> {
    let size = prop_oneof![
        Just([1, 1]),
        Just([1, 37]),
        Just([37, 1]),
        Just([2, 2]),
        Just([16, 16]),
    ];
    (size, 0..5_u32, 0..64_u32).prop_map(|(size, kind, at)| {
        let [width, height] = size;
        let at = at % (width * height);
        let distance = |i: u32| {
            let (x, y) = (i % width, i / width);
            let (dx, dy) = (x.abs_diff(at % width), y.abs_diff(at / width));
            let (dx, dy) = (dx.min(width - dx), dy.min(height - dy));
            match kind {
                // All pattern or all floor.
                0 => -40.0,
                1 => 40.0,
                // One texel of pattern, and one of floor.
                2 => (dx as f32).hypot(dy as f32) - 0.5,
                3 => 0.5 - (dx as f32).hypot(dy as f32),
                _ => [-0.5, 0.5][((x + y) % 2) as usize],
            }
        };
        Map {
            size,
            words: (0..width * height).map(|i| distance(i).to_bits()).collect(),
        }
    })
}

fn object(map: &Map, depth: f32, extension: f32, bevel: f32, chamfer: f32) -> Object {
    Object {
        map_size: map.size.map(|side| side as f32),
        map_reach: 0.5,
        depth,
        extension,
        bevel,
        chamfer,
        linear_steps: 64,
        binary_steps: 12,
        map_format: FORMAT_FLOAT,
        ..Object::default()
    }
    .complete()
}

/// Whether a number is a valid input of other functions.
fn is_kept(x: f32) -> bool {
    x.is_finite() && x.abs() <= LARGEST
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn arithmetic_gives_numbers(a in any::<f32>(), b in any::<f32>()) {
        if a.is_finite() && b.is_finite() {
            prop_assert!(arithmetic::div(a, b).is_finite(), "{a:e} / {b:e}");
            prop_assert!(arithmetic::sqrt(a).is_finite());
        }
        // Also for NaN.
        prop_assert!(arithmetic::floor(a).is_finite());
        let limited = arithmetic::clamp(a, -1.0, 1.0);
        prop_assert!((-1.0..=1.0).contains(&limited), "{a:e}");
    }

    /// For any surface and ray, a path is finite, has a start and an end, and
    /// its depth is a fraction.
    #[test]
    fn paths_are_numbers(
        quadric in quadric(),
        facet_depth in number(-100, 10),
        direction in direction(),
        facet_t in number(-40, 40),
        depth in depth(),
        planar in any::<bool>(),
    ) {
        let surface = test_surface(quadric, facet_depth);
        let tier = if planar { TIER_PLANAR } else { TIER_FAST };
        let path = QuadraticPath::new(&surface, direction, facet_t, depth, tier);
        if path.enters {
            for x in [path.entry_t, path.slope, path.bend, path.start(), path.end()] {
                prop_assert!(x.is_finite(), "{path:?}");
            }
            prop_assert!(path.start() >= 0.0 && path.end() >= 0.0, "{path:?}");
            for share in [0.0, 0.25, 0.5, 0.75, 1.0_f32] {
                let s = path.end() * share;
                let fraction = path.depth_fraction(s);
                prop_assert!(
                    (-1e-4..=1.0 + 1e-4).contains(&fraction),
                    "{fraction} at {share} of {path:?}"
                );
                prop_assert!(path.uv(s).is_finite(), "{path:?}");
                let normal = path.surface_normal(&surface, direction, s);
                prop_assert!((normal.length() - 1.0).abs() < 1e-5, "{normal} on {path:?}");
            }
        }
    }

    /// Searches end within their steps, at the solid or at the end of the path.
    #[test]
    fn searches_end_where_something_is(
        map in map(),
        quadric in [number(-40, 4), number(-40, 4), number(-40, 4)],
        direction in direction(),
        depth in (-10.0..4.0_f64).prop_map(|power| power.exp2() as f32),
        uv in [number(-20, 20), number(-20, 20)],
        extension in prop_oneof![Just(0.0_f32), -0.4..3.0_f32],
        bevel in prop_oneof![Just(0.0_f32), 0.0..3.0_f32],
        chamfer in prop_oneof![Just(0.0_f32), Just(1.0_f32), 0.0..1.0_f32],
    ) {
        let object = object(&map, depth, extension, bevel, chamfer);
        let mut surface = test_surface(quadric, 0.0);
        surface.uv = Vec2::from(uv);
        let path = QuadraticPath::new(&surface, direction, 1.0, depth, TIER_FAST);
        // A path that ends before the eye has no hit.
        if !path.enters || path.start() > path.end() {
            return Ok(());
        }
        let profile = Profile::new(&object);
        let shape_map = ShapeMap::new(&object);
        let effort = Limits {
            linear_steps: object.linear_steps,
            binary_steps: object.binary_steps,
            slack: 0.0,
        };
        let found = march(&path, &profile, &shape_map, &map.words[..], &effort);
        prop_assert!(found.steps <= object.linear_steps);
        prop_assert!(is_kept(found.s) && found.s >= 0.0, "{found:?}");
        prop_assert!(found.uv.is_finite(), "{found:?}");
        prop_assert!((0.0..=1.0).contains(&found.depth_fraction), "{found:?}");
        prop_assert!(found.end <= END_FLOOR);
        if found.end == END_SIDE && found.steps < object.linear_steps {
            let distance = shape_map.distance(&map.words[..], found.uv);
            let gap = distance - profile.radius(found.depth_fraction);
            // A texture coordinate of a million has a resolution of a
            // sixteenth, equally in the search and here.
            prop_assert!(gap <= TOLERANCE + 1e-5 * map.size[0].max(map.size[1]) as f32, "{gap} {found:?}");
        }
        if found.end == END_MISS || found.end == END_FLOOR {
            prop_assert!(found.s <= path.end());
        }
    }

    /// Rays hit triangles of any shape and size, also without area, at finite
    /// parameters.
    #[test]
    fn facets_are_met_at_numbers(
        corners in prop::array::uniform3([number(-30, 20), number(-30, 20), number(-30, 20)]),
        eye in [number(-30, 20), number(-30, 20), number(-30, 20)],
        same in 0..4_u32,
        direction in direction(),
    ) {
        let mut corners = corners;
        if same == 1 {
            corners[2] = corners[0];
        }
        if same == 2 {
            corners = [corners[0]; 3];
        }
        let triangle = Triangle {
            corners: corners.map(|position| Corner { position, ..Corner::default() }),
            handedness: 1.0,
            depth_reductions: 0,
        };
        let found = facet::intersect(Vec3::from(eye), direction, &triangle);
        if found.hit {
            prop_assert!(found.t.is_finite(), "{found:?}");
            let weights = found.weights;
            prop_assert!(weights.is_finite() && weights.min_element() >= 0.0, "{found:?}");
            prop_assert!((weights.x + weights.y + weights.z - 1.0).abs() < 1e-6, "{found:?}");
        }
        prop_assert!(same == 0 || same == 3 || !found.hit, "no area is met: {found:?}");
    }
}
