//! The landscape on the CPU: its noise, its heights, and pictures from anywhere.

use glam::{UVec2, UVec3, Vec2, Vec3, Vec4};
use proptest::prelude::*;
use relievo_kernel::{Kernel, table};
use relievo_test::{Picture, Pixels, assert_differs, assert_equal_for, assert_picture, words};
use terrain::noise::{Sample, fbm, gradient_noise, hash, ridges};
use terrain::terrain::{FULL_DETAIL, HIGHEST, LOWEST, coarse_height, cover, height, normal};
use terrain::view::{View, color};

const SIZE: UVec2 = UVec2::new(64, 40);

/// Returns `count` points, up to ± `range`, on no grid.
fn points(count: u32, range: f32) -> impl Iterator<Item = Vec2> {
    (0..count).map(move |i| {
        let words = hash(UVec3::new(i, 0, 99));
        (Vec2::new(words.x as f32, words.y as f32) / 2f32.powi(31) - 1.0) * range
    })
}

fn picture(view: &View) -> Vec<Vec4> {
    let pixels = 0..SIZE.x * SIZE.y;
    pixels
        .map(|i| color(UVec2::new(i % SIZE.x, i / SIZE.x), SIZE, view))
        .collect()
}

/// Returns the FNV-1a hash of words.
fn fingerprint(words: impl Iterator<Item = u32>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        (hash ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn the_hash_has_known_values() {
    // Of the original in GLSL, computed with unlimited whole numbers.
    let known = [
        (
            UVec3::ZERO,
            UVec3::new(0x9baf_d7c6, 0xa8e8_8a6b, 0x3f15_482c),
        ),
        (
            UVec3::new(1, 2, 3),
            UVec3::new(0xfa9f_79a6, 0x48f2_f44c, 0x596f_5ab1),
        ),
        (
            UVec3::new(u32::MAX, 7, 2026),
            UVec3::new(0x5e8a_573c, 0xb921_e318, 0x7da8_59b0),
        ),
    ];
    for (words, expected) in known {
        assert_eq!(hash(words), expected);
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let check = |noise: &dyn Fn(Vec2) -> Sample, tolerance: f32| {
        const STEP: f32 = 1.0 / 512.0;
        for p in points(2000, 50.0) {
            let along = |d: Vec2| (noise(p + d).value - noise(p - d).value) / (2.0 * STEP);
            let differences = Vec2::new(along(Vec2::X * STEP), along(Vec2::Y * STEP));
            let slope = noise(p).slope;
            assert!(
                (slope - differences).length() < tolerance,
                "{p}: {slope}, {differences}"
            );
        }
    };
    check(&|p| gradient_noise(p, 7), 0.003);
    check(&|p| fbm(p, 7, 3), 0.03);
}

#[test]
fn noise_is_continuous_across_cells() {
    const STEP: f32 = 1.0 / 65_536.0;
    for p in points(2000, 300.0) {
        let corner = p.floor();
        for (edge, across) in [
            (Vec2::new(corner.x, p.y), Vec2::X),
            (Vec2::new(p.x, corner.y), Vec2::Y),
            (corner, Vec2::ONE),
        ] {
            let before = gradient_noise(edge - across * STEP, 3);
            let after = gradient_noise(edge + across * STEP, 3);
            assert!((before.value - after.value).abs() < 1e-4, "{edge}");
            assert!((before.slope - after.slope).length() < 1e-3, "{edge}");
        }
        assert_eq!(gradient_noise(corner, 3).value, 0.0);
    }
}

#[test]
fn noise_has_the_documented_bounds() {
    for p in points(20_000, 1000.0) {
        assert!(gradient_noise(p, 1).value.abs() <= 1.0);
        assert!(fbm(p, 1, 8).value.abs() < 2.0);
        assert!((0.0..2.0).contains(&ridges(p, 1, 12.0)));
    }
}

#[test]
fn far_and_tiny_coordinates_are_no_exception() {
    for x in [
        0.0,
        1e-40,
        -1e-40,
        1e-20,
        1e30,
        -1e30,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
    ] {
        let sample = gradient_noise(Vec2::new(x, 0.5), 1);
        assert!(sample.value.abs() <= 1.0 && sample.slope.is_finite(), "{x}");
    }
    let at_zero = gradient_noise(Vec2::new(0.0, 0.5), 1);
    assert_eq!(gradient_noise(Vec2::new(1e-40, 0.5), 1), at_zero);
}

#[test]
fn heights_are_bounded_and_the_last_octave_fades_in() {
    for p in points(5000, 1e6) {
        let y = height(p);
        assert!((LOWEST..=HIGHEST).contains(&y), "{p}: {y}");
        let before = coarse_height(p, 6.999);
        assert!((coarse_height(p, 7.001) - before).abs() < 0.1, "{p}");
    }
}

#[test]
fn weights_of_the_cover_sum_to_one() {
    for p in points(5000, 1e5) {
        let cover = cover(p, height(p), normal(p, 1.0, FULL_DETAIL));
        let weights = [
            cover.snow,
            cover.rock,
            cover.forest,
            cover.grass,
            cover.sand,
        ];
        assert!(
            weights.iter().all(|w| (-1e-6..=1.000_001).contains(w)),
            "{cover:?}"
        );
        assert!(
            (weights.iter().sum::<f32>() - 1.0).abs() < 1e-5,
            "{cover:?}"
        );
    }
}

#[test]
fn pictures_are_finite_from_anywhere() {
    let eye = Vec3::new(4600.0, 610.0, 4200.0);
    let sun = Vec3::new(-0.75, 0.3, 0.9);
    for (name, eye, toward, sun) in [
        ("down", eye, Vec3::NEG_Y, sun),
        ("up", eye, Vec3::Y, sun),
        ("level", eye, Vec3::X, sun),
        (
            "over the lake, down",
            Vec3::new(750.0, 60.0, 3300.0),
            Vec3::NEG_Y,
            sun,
        ),
        ("into the sun", eye, sun, sun),
        ("by night", eye, Vec3::Z, Vec3::NEG_Y),
        ("nowhere", eye, Vec3::ZERO, Vec3::ZERO),
        (
            "below the ground",
            Vec3::new(4600.0, 10.0, 4200.0),
            Vec3::Z,
            sun,
        ),
        (
            "below the water",
            Vec3::new(750.0, -5.0, 1875.0),
            Vec3::Y,
            sun,
        ),
        ("below all", Vec3::new(0.0, -1e5, 0.0), Vec3::Z, sun),
        (
            "from high above",
            Vec3::new(0.0, 30_000.0, 0.0),
            Vec3::NEG_Y,
            sun,
        ),
        ("from space", Vec3::new(0.0, 1e9, 0.0), Vec3::NEG_Y, sun),
        (
            "at the end of the world",
            Vec3::new(1e9, 900.0, -1e9),
            Vec3::X,
            sun,
        ),
        ("at the origin", Vec3::ZERO, Vec3::X, sun),
    ] {
        let view = View::new(eye, eye + toward * 1e3, sun, 1e4);
        for (i, pixel) in picture(&view).into_iter().enumerate() {
            let is_color = pixel.is_finite() && pixel.min_element() >= 0.0;
            assert!(
                is_color && pixel.max_element() <= 1.0,
                "{name}, pixel {i}: {pixel}"
            );
        }
    }
}

#[test]
fn heights_and_a_picture_are_these_words() {
    let heights = points(1000, 1e5).map(|p| height(p).to_bits());
    let heights = fingerprint(heights);
    let pixels = picture(&View::overlook(10.0));
    let words = pixels.iter().flat_map(|p| p.to_array().map(f32::to_bits));
    assert_eq!(
        (heights, fingerprint(words)),
        (1_507_830_163_382_390_944, 17_309_903_542_957_160_109)
    );
}

#[test]
fn gpu_the_picture_is_the_cpus() {
    let size = UVec2::new(160, 100);
    let view = View::overlook(10.0);
    let picture = Picture {
        vertex: "cover",
        fragment: "landscape",
        pixels: Pixels::Floats,
        size: size.to_array(),
        vertices: 3,
        buffers: &[&words((view, size))],
    };
    assert_picture(&picture, |pixel| color(pixel, size, &view));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn gpu_heights_far_away_are_the_cpus(places in prop::collection::vec((-1e9_f32..1e9, -1e9_f32..1e9), 1000)) {
        let places: Vec<_> = places.into_iter().map(|(x, z)| (Vec2::new(x, z),)).collect();
        assert_equal_for(&height::KERNEL, &places);
    }
}

/// The height of a world that is 1 ULP higher where it is highest.
fn taller(p: Vec2) -> f32 {
    let y = height(p);
    if y > 1500.0 { y.next_up() } else { y }
}

#[test]
fn gpu_a_height_that_is_off_by_one_ulp_is_seen() {
    const TWIN: &[Kernel] = table! {
        taller(Vec2: height::KERNEL.arguments[0].domain) -> f32 = taller;
    };
    assert_differs(&height::KERNEL, &TWIN[0]);
}
