//! The model against the formulas of its sources.

use super::brdf::{Reflector, distribution, schlick, visibility};
use super::image::Footprint;
use super::layout::{LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SPOT, Light};
use super::lights::{half_way, incoming};
use super::{image, lit};
use crate::camera::tests::frame;
use crate::edge::Edge;
use crate::gbuffer::Sample;
use crate::normals::{CLASS_CAP, CLASS_WALL};
use crate::shading::layout::{
    FOLLOWS_MESH, FOLLOWS_MESH_EVERYWHERE, FacetMaterial, Finish, Image, Material,
};
use crate::shading::material::coordinates;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::PI;

/// Appendix B of the glTF 2.0 specification in f64: the reflected share times the cosine
/// and π.
fn reference(
    base: DVec3,
    metallic: f64,
    roughness: f64,
    [normal, light, view]: [DVec3; 3],
) -> DVec3 {
    let half = (light + view).normalize();
    let alpha2 = roughness.powi(4);
    let nh = normal.dot(half);
    let d = alpha2 / (PI * (nh * nh * (alpha2 - 1.0) + 1.0).powi(2));
    let part = |x: f64| x + (alpha2 + (1.0 - alpha2) * x * x).sqrt();
    // Smith's height-correlated form, written as in Filament's documentation.
    let (nl, nv) = (normal.dot(light), normal.dot(view));
    let lambda = |x: f64| (part(x) / x - 2.0) / 2.0;
    let g = 1.0 / (1.0 + lambda(nl) + lambda(nv));
    let v = g / (4.0 * nl * nv);
    let f = |f0: DVec3| f0 + (DVec3::ONE - f0) * (1.0 - view.dot(half).abs()).powi(5);
    let dielectric = {
        let f = f(DVec3::splat(0.04));
        base / PI * (DVec3::ONE - f) + f * (v * d)
    };
    let metal = f(base) * (v * d);
    dielectric.lerp(metal, metallic) * nl * PI
}

fn direction(polar: f64, turn: f64) -> DVec3 {
    let (polar, turn) = (polar.to_radians(), turn.to_radians());
    DVec3::new(
        polar.sin() * turn.cos(),
        polar.sin() * turn.sin(),
        polar.cos(),
    )
}

#[test]
fn reflection_is_that_of_gltf_at_stated_angles() {
    let base = DVec3::new(0.9, 0.5, 0.2);
    for metallic in [0.0, 1.0] {
        for roughness in [0.1, 0.3, 0.6, 1.0] {
            for (light, view) in [(0.0, 0.0), (30.0, 30.0), (60.0, 10.0), (75.0, 75.0)] {
                for turn in [0.0, 90.0, 180.0] {
                    let vectors = [DVec3::Z, direction(light, 0.0), direction(view, turn)];
                    let expected = reference(base, metallic, roughness, vectors);
                    let [n, l, v] = vectors.map(|v| v.as_vec3());
                    let surface =
                        Reflector::new(base.as_vec3(), metallic as f32, roughness as f32, n.dot(v));
                    let found = lit(
                        &surface,
                        n,
                        v,
                        &super::lights::Incoming {
                            direction: l,
                            color: Vec3::ONE,
                        },
                        n.dot(l),
                    );
                    let error = (found.as_dvec3() - expected).abs().max_element();
                    let scale = expected.max_element().max(1e-3);
                    assert!(
                        error < 2e-3 * scale,
                        "{metallic} {roughness} {light} {view} {turn}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// Values computed from the specification's formulas, to notice if both sides change.
#[test]
fn values_at_stated_angles() {
    let close = |found: f32, expected: f32| {
        assert!((found - expected).abs() < 1e-4 * expected, "{found}");
    };
    // Roughness 0.5: α² = 0.0625. D at the normal is 1 / (π α²).
    close(distribution(0.0625, 0.0), 16.0);
    close(distribution(0.0625, 0.75), 0.106_622_24);
    close(visibility(0.0625, 1.0, 1.0), 0.25);
    close(visibility(0.0625, 0.5, 0.5), 0.917_662_9);
    assert_eq!(schlick(Vec3::splat(0.04), 1.0), Vec3::splat(0.04));
    assert_eq!(schlick(Vec3::splat(0.04), 0.0), Vec3::ONE);
    close(schlick(Vec3::splat(0.04), 0.5).x, 0.07);
}

#[test]
fn even_light_is_kept() {
    // Whatever the table says.
    for reflectance in [
        Vec2::new(0.6, 0.1),
        Vec2::new(0.2, 0.3),
        Vec2::new(1.0, 0.0),
    ] {
        for (base, metallic) in [(Vec3::ONE, 1.0), (Vec3::ONE, 0.0)] {
            let surface = Reflector {
                reflectance,
                ..Reflector::new(base, metallic, 0.7, 0.4)
            };
            let found = surface.surrounded(Vec3::ONE, Vec3::ONE);
            assert!((found - Vec3::ONE).length() < 1e-5, "{found}");
        }
    }
}

#[test]
fn light_falls_with_the_square_of_the_distance_and_ends_at_its_range() {
    let light = |kind, inverse_range| Light {
        color: [4.0, 2.0, 1.0],
        kind,
        position: [0.0, 0.0, 2.0],
        direction: [0.0, 0.0, 1.0],
        inverse_range,
        // Inner angle 0, outer angle 60°.
        spot_scale: 2.0,
        spot_offset: -1.0,
        ..Light::default()
    };
    let at = |light: &Light, z: f32| incoming(light, Vec3::new(0.0, 0.0, 2.0 - z)).color.x;
    let endless = light(LIGHT_POINT, 0.0);
    for z in [0.5f32, 1.0, 3.0, 100.0] {
        assert!((at(&endless, z) - 4.0 / (z * z)).abs() < 1e-5 * 4.0 / (z * z));
    }
    let limited = light(LIGHT_POINT, 0.25);
    assert!((at(&limited, 2.0) - (1.0 - 0.0625)).abs() < 1e-5);
    assert_eq!(at(&limited, 4.0), 0.0);
    assert_eq!(at(&limited, 40.0), 0.0);
    // At the light itself.
    assert!(at(&endless, 0.0).is_finite());
    let spot = light(LIGHT_SPOT, 0.0);
    assert!((at(&spot, 1.0) - 4.0).abs() < 1e-5);
    // At 45° the share is (2 cos 45° − 1)².
    let aside = incoming(&spot, Vec3::new(1.0, 0.0, 1.0)).color.x;
    assert!((aside - 2.0 * 0.171_572_9).abs() < 1e-5, "{aside}");
    assert_eq!(incoming(&spot, Vec3::new(2.0, 0.0, 1.0)).color.x, 0.0);
    assert_eq!(incoming(&spot, Vec3::new(0.0, 0.0, 3.0)).color.x, 0.0);
    let far = incoming(&light(LIGHT_DIRECTIONAL, 0.0), Vec3::splat(9.0));
    assert_eq!((far.direction, far.color.x), (Vec3::Z, 4.0));
}

#[test]
fn half_way_vectors_also_of_opposite_directions() {
    let (half, cosine) = half_way(Vec3::X, Vec3::Z, Vec3::Y);
    assert!((half - Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt())).length() < 1e-6);
    assert!((cosine - 0.5f32.sqrt()).abs() < 1e-6);
    assert_eq!(half_way(Vec3::X, Vec3::NEG_X, Vec3::Y), (Vec3::Y, 0.0));
}

/// A picture of 4 × 2 texels, whose red is the column and green the row, and its levels.
fn picture() -> (Vec<u32>, Image) {
    let texel = |r: u32, g: u32| [r | g << 16, 65_535 << 16];
    let mut words = vec![0; 6];
    for y in 0..2 {
        for x in 0..4 {
            words.extend(texel(x * 10_000, y * 10_000));
        }
    }
    words.extend(texel(5_000, 5_000));
    words.extend(texel(25_000, 5_000));
    words.extend(texel(15_000, 5_000));
    let image = Image {
        first: 6,
        width: 4,
        height: 2,
        levels: 3,
    };
    (words, image)
}

#[test]
fn pictures_are_filtered_within_and_between_levels() {
    let (words, image) = picture();
    let at = |x: f32, y: f32, spread: f32| {
        let found = image::sample(&words[..], &image, Vec2::new(x, y), spread) * 65_535.0;
        [found.x, found.y, found.w].map(f32::round)
    };
    let one = 65_535.0;
    assert_eq!(at(0.375, 0.25, 1.0), [10_000.0, 0.0, one]);
    assert_eq!(at(0.5, 0.5, 1.0), [15_000.0, 5_000.0, one]);
    // Half-way between the last and the first column.
    assert_eq!(at(0.0, 0.25, 1.0), [15_000.0, 0.0, one]);
    assert_eq!(at(1.0, 0.25, 0.1), [15_000.0, 0.0, one]);
    assert_eq!(at(-0.625, 7.25, 1.0), [10_000.0, 0.0, one]);
    assert_eq!(at(0.25, 0.1, 4.0), [5_000.0, 5_000.0, one]);
    assert_eq!(at(0.25, 0.25, 2.5), [5_000.0, 2_500.0, one]);
    assert_eq!(at(0.25, 0.25, 10.0), [10_000.0, 5_000.0, one]);
    for spread in [16.0, 1e6, f32::INFINITY, f32::NAN] {
        assert_eq!(at(0.3, 0.3, spread), [15_000.0, 5_000.0, one]);
    }
}

#[test]
fn the_variance_of_a_lookup_grows_with_its_spread() {
    // A row of texels, one of which is bright, and its levels. Texels of a level have different places beside it:
    // the mean of eight.
    const SIZE: usize = 64;
    for spread in [0.5, 1.0, 1.3, 2.5, 4.0, 9.0, 16.0, 40.0, 64.0f32] {
        let (mut sum, mut moment) = (0.0, 0.0);
        for bright in 32..40 {
            let mut words = Vec::new();
            for level in 0..7 {
                let of = |x: usize| u32::from(x == bright >> level) * (65_535 >> level);
                words.extend((0..SIZE >> level).flat_map(|x| [of(x), 0]));
            }
            let image = Image {
                first: 0,
                width: SIZE as u32,
                height: 1,
                levels: 7,
            };
            for place in 0..SIZE * 16 {
                let x = (place as f32 + 0.5) / 16.0;
                let at = Vec2::new(x / SIZE as f32, 0.5);
                let value = image::sample(&words[..], &image, at, spread).x;
                let away = x - (bright as f32 + 0.5);
                sum += value;
                moment += value * away * away;
            }
        }
        let expected = 0.25 * spread.max(1.0) - 1.0 / 12.0;
        let ratio = moment / sum / expected;
        assert!((ratio - 1.0).abs() < 0.02, "{spread}: {ratio}");
    }
}

#[test]
fn pictures_are_filtered_along_a_pixel() {
    let (words, image) = picture();
    let over = |x: f32, y: f32, right: Vec2, down: Vec2| {
        let footprint = Footprint { right, down };
        let found = image::sample_over(&words[..], &image, Vec2::new(x, y), &footprint);
        [found.x, found.y].map(|x| (x * 65_535.0).round())
    };
    let texel = Vec2::new(0.25, 0.5);
    let (x, y) = (Vec2::X * texel.x, Vec2::Y * texel.y);
    // Much less than a texel, then one, which sees a little of the next row.
    assert_eq!(over(0.375, 0.25, 0.2 * x, 0.2 * y), [10_000.0, 0.0]);
    assert_eq!(over(0.375, 0.25, x, y), [10_000.0, 383.0]);
    // The second and the third one, in the finest level, whichever side is the longer one.
    assert_eq!(over(0.5, 0.25, 2.0 * x, y), [15_000.0, 383.0]);
    assert_eq!(over(0.5, 0.25, y, -2.0 * x), [15_000.0, 383.0]);
    // Both rows, in one column.
    assert_eq!(over(0.375, 0.5, x, 2.0 * y), [10_000.0, 5_000.0]);
    // A pixel that is much longer than wide: no more than eight lookups, in a coarser level.
    let found = over(0.5, 0.25, 64.0 * x, y);
    assert!((found[0] - 15_000.0).abs() < 10.0, "{found:?}");
}

#[test]
fn pictures_follow_pattern_mesh_or_outline() {
    let sample = Sample {
        class: CLASS_CAP,
        t: 10.0,
        uv: Vec2::new(1.25, 0.5),
        depth_fraction: 0.5,
        unit: 2.0,
        normal: Vec3::Z,
        tangent: Vec3::X,
        is_mirrored: false,
        is_along_v: true,
        finish: 0,
        facet: 0,
        edge: Edge::from_codes(0, 0),
        openness: 1.0,
    };
    let mut finish = Finish {
        material: Material {
            tiles: [2.0, 3.0],
            offset: [0.5, 0.0],
            ..Material::default()
        },
        depth: 0.2,
        inverse_repeat: [0.25, 0.5],
        ..Finish::default()
    };
    let facet = FacetMaterial {
        whole: [2.0, -1.0],
        density: [4.0, 5.0],
        ..FacetMaterial::default()
    };
    // A pixel is 0.01 wide at distance 1.
    let frame = frame(Vec3::ZERO, Vec3::NEG_Z, 4, 4, 0.02);
    let at = |sample: &Sample, finish: &Finish| {
        coordinates(&[0][..], &frame, Vec3::NEG_Z, sample, false, finish, &facet)
    };
    let found = at(&sample, &finish);
    assert_eq!(found.at, Vec2::new(7.0, -1.5));
    // A pixel is 0.1 world units, 0.05 object units.
    assert!((found.footprint.right - Vec2::new(0.4, 0.0)).length() < 1e-5);
    assert!((found.footprint.down - Vec2::new(0.0, -0.75)).length() < 1e-5);
    let wall = Sample {
        class: CLASS_WALL,
        ..sample
    };
    // Along v, and 0.1 object units down.
    assert!((at(&wall, &finish).at - Vec2::new(-0.5, 1.5)).length() < 1e-5);
    finish.material.follows = FOLLOWS_MESH;
    assert!((at(&sample, &finish).at - Vec2::new(2.125, -0.75)).length() < 1e-5);
    // Half as many repeats along v as of the pattern.
    assert!((at(&wall, &finish).at - Vec2::new(0.0, 0.75)).length() < 1e-5);
    finish.material.follows = FOLLOWS_MESH_EVERYWHERE;
    assert_eq!(at(&wall, &finish).at, at(&sample, &finish).at);
}
