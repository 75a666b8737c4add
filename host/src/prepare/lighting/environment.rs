//! The environment: irradiance as spherical harmonics, and levels of growing roughness.

use super::super::memo::Memo;
use super::pictures::{Encoding, halve, linear};
use crate::Error;
use crate::limits::Account;
use crate::scene::{Environment, Scene};
use crate::shape_map::load_picture;
use glam::{DVec2, DVec3};
use image::Rgba32FImage;
use rayon::prelude::*;
use relievo_shared::gbuffer::octahedral_fold;
use relievo_shared::shading::Lighting;
use std::f64::consts::PI;
use std::path::PathBuf;

/// Side of the first level, texels, and of that of even light.
const SIDES: [u32; 2] = [256, 16];
/// Number of levels.
const LEVELS: u32 = 5;
/// Directions that a texel of a rough level is the mean of.
const SAMPLES: u32 = 256;
/// Brightest light of a picture: less than texels hold.
const BRIGHTEST: f32 = 6e4;
/// Bytes per pixel of the picture while it is read.
const PIXEL: u64 = 32;
/// Rows of the picture that irradiance is integrated over.
const ROWS: u32 = 128;

/// Light from all directions.
pub(super) struct Surroundings {
    /// What shading has to know of it. Its first word is the first of `words`.
    lighting: Lighting,
    words: Vec<u32>,
}

/// Bakes the environment of `scene` after `words`. Returns what shading has to know of it; nothing if it
/// is dark.
pub(super) fn bake(
    scene: &Scene,
    environment: &Environment,
    known: &mut Memo<Option<(PathBuf, f64)>, Surroundings>,
    words: &mut Vec<u32>,
    account: &mut Account<'_>,
) -> Result<Lighting, Error> {
    let color = environment
        .color
        .linear()
        .map(|channel| channel * environment.intensity as f32);
    if color == [0.0; 3] {
        return Ok(Lighting::default());
    }
    let image = environment.image.as_ref();
    let key = image.map(|path| (path.clone(), environment.turn));
    let baked = match (known.get(&key), image) {
        (Some(baked), _) => baked,
        (None, None) => {
            let even = baked_environment(SIDES[1], &|_, _| DVec3::ONE);
            known.insert(key, even)
        }
        (None, Some(path)) => {
            let max_pixels = scene.limits.pixels.min(account.left(PIXEL));
            let picture = load_picture(&scene.files, path, max_pixels)?;
            let pixels = u64::from(picture.width()) * u64::from(picture.height());
            account.take(path.display(), pixels, PIXEL)?;
            let picture = Panorama::new(linear(picture, Encoding::Color), environment.turn);
            let light = |direction: DVec3, width: f64| picture.light(direction, width);
            let baked = baked_environment(SIDES[0], &light);
            known.insert(key, baked)
        }
    };
    let first = words.len() as u32;
    words.extend(&baked.words);
    Ok(Lighting {
        environment: first,
        environment_color: color,
        ..baked.lighting
    })
}

/// A picture of all directions, and its smaller levels.
struct Panorama {
    levels: Vec<Rgba32FImage>,
    /// Part of a turn that is added to the longitude.
    turn: f64,
}

impl Panorama {
    fn new(mut picture: Rgba32FImage, degrees: f64) -> Panorama {
        // Pictures may hold infinities where the sun is.
        for channel in picture.iter_mut() {
            *channel = match channel.is_nan() {
                true => 0.0,
                false => channel.clamp(0.0, BRIGHTEST),
            };
        }
        let mut levels = vec![picture];
        while let Some(last) = levels.last().filter(|last| last.height() > 8) {
            levels.push(halve(last));
        }
        Panorama {
            levels,
            turn: degrees / 360.0,
        }
    }

    /// Returns the light from `direction`, the mean over about `width` radians. The middle of the
    /// picture is −z, its right +x.
    fn light(&self, direction: DVec3, width: f64) -> DVec3 {
        let u = 0.5 + direction.x.atan2(-direction.z) / (2.0 * PI) + self.turn;
        let v = direction.y.clamp(-1.0, 1.0).acos() / PI;
        let height = f64::from(self.levels[0].height());
        let level = (width * height / PI).max(1.0).log2();
        let level = (level.floor() as usize).min(self.levels.len() - 1);
        let picture = &self.levels[level];
        let [width, height] = [picture.width(), picture.height()];
        let at = DVec2::new(
            (u - u.floor()) * f64::from(width) - 0.5,
            (v * f64::from(height) - 0.5).clamp(0.0, f64::from(height - 1)),
        );
        let (low, rest) = (at.floor(), at - at.floor());
        let pixel = |x: f64, y: f64| {
            let x = x.rem_euclid(f64::from(width)) as u32;
            let [r, g, b, _] = picture.get_pixel(x, (y as u32).min(height - 1)).0;
            DVec3::new(r.into(), g.into(), b.into())
        };
        let row = |y: f64| pixel(low.x, y).lerp(pixel(low.x + 1.0, y), rest.x);
        row(low.y).lerp(row(low.y + 1.0), rest.y)
    }
}

/// Light from a direction, the mean over about as many radians.
type Sky<'a> = dyn Fn(DVec3, f64) -> DVec3 + Sync + 'a;

/// Bakes light from all directions: levels whose first has `side` texels on each side.
fn baked_environment(side: u32, light: &Sky<'_>) -> Surroundings {
    let mut words = Vec::new();
    for level in 0..LEVELS {
        let roughness = f64::from(level) / f64::from(LEVELS - 1);
        let side = side >> level;
        let texels: Vec<u32> = (0..(side + 2) * (side + 2))
            .into_par_iter()
            .map(|index| {
                let direction = direction(index % (side + 2), index / (side + 2), side);
                let width = PI / (2.0 * f64::from(side));
                shared_exponent(if level == 0 {
                    light(direction, width)
                } else {
                    blurred(direction, roughness, light)
                })
            })
            .collect();
        words.extend(texels);
    }
    let lighting = Lighting {
        environment_size: side,
        environment_levels: LEVELS,
        environment_color: [1.0; 3],
        irradiance: irradiance(light),
        ..Lighting::default()
    };
    Surroundings { lighting, words }
}

/// Returns the direction of a texel of a level with a border, which shows what is beyond the
/// edge.
fn direction(x: u32, y: u32, side: u32) -> DVec3 {
    let part = |x: u32| 2.0 * (f64::from(x) - 0.5) / f64::from(side) - 1.0;
    let (mut x, mut y) = (part(x), part(y));
    // Beyond an edge lies the other half of the same edge.
    if x.abs() > 1.0 {
        (x, y) = (x.signum() * 2.0 - x, -y);
    }
    if y.abs() > 1.0 {
        (x, y) = (-x, y.signum() * 2.0 - y);
    }
    let z = 1.0 - x.abs() - y.abs();
    let at = octahedral_fold(x as f32, y as f32, z as f32).as_dvec2();
    DVec3::new(at.x, at.y, z).normalize()
}

/// Returns the mean of the light around `normal` that a surface of this roughness reflects,
/// seen from there (Karis, 2013).
fn blurred(normal: DVec3, roughness: f64, light: &Sky<'_>) -> DVec3 {
    let square = roughness.powi(4);
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for i in 0..SAMPLES {
        let x = (f64::from(i) + 0.5) / f64::from(SAMPLES);
        // Van der Corput's sequence.
        let y = f64::from(i.reverse_bits()) / 4_294_967_296.0;
        let z = ((1.0 - x) / (1.0 + (square - 1.0) * x)).sqrt();
        let (sine, cosine) = (2.0 * PI * y).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let half = tangent * (radius * cosine) + bitangent * (radius * sine) + normal * z;
        let direction = half * (2.0 * z) - normal;
        let weight = direction.dot(normal);
        if weight <= 0.0 {
            continue;
        }
        // The solid angle of a sample: the denser, the smaller.
        let base = z * z * (square - 1.0) + 1.0;
        let density = square / (PI * base * base) / 4.0;
        let width = (1.0 / (f64::from(SAMPLES) * density)).sqrt();
        sum += light(direction, width) * weight;
        weights += weight;
    }
    sum / weights
}

/// Returns the irradiance over π of normals, as the coefficients that
/// [`relievo_shared::shading::environment::irradiance`] reads.
fn irradiance(light: &Sky<'_>) -> [[f32; 3]; 9] {
    let rows = (0..ROWS).into_par_iter().map(|row| {
        let mut sums = [DVec3::ZERO; 9];
        let latitude = PI * (f64::from(row) + 0.5) / f64::from(ROWS);
        let step = PI / f64::from(ROWS);
        for column in 0..2 * ROWS {
            let longitude = step * (f64::from(column) + 0.5);
            let (sine, cosine) = longitude.sin_cos();
            let n = DVec3::new(
                latitude.sin() * cosine,
                latitude.cos(),
                latitude.sin() * sine,
            );
            let light = light(n, step) * (latitude.sin() * step * step);
            for (sum, basis) in sums.iter_mut().zip(basis(n)) {
                *sum += light * basis;
            }
        }
        sums
    });
    let zero = || [DVec3::ZERO; 9];
    let sums = rows.reduce(zero, |a, b| std::array::from_fn(|i| a[i] + b[i]));
    // Of a cosine's convolution, over π: π, 2 π / 3 and π / 4, squared constants of the basis.
    let [one, two, three] = [1.0, 2.0 / 3.0, 0.25];
    let squares = [
        one / (4.0 * PI),
        two * 3.0 / (4.0 * PI),
        two * 3.0 / (4.0 * PI),
        two * 3.0 / (4.0 * PI),
        three * 15.0 / (4.0 * PI),
        three * 15.0 / (4.0 * PI),
        three * 15.0 / (4.0 * PI),
        three * 5.0 / (16.0 * PI),
        three * 15.0 / (16.0 * PI),
    ];
    let mut found: [DVec3; 9] = std::array::from_fn(|i| sums[i] * squares[i]);
    // 3 z² − 1 is the basis; its constant belongs to the first.
    found[0] -= found[7];
    found[7] *= 3.0;
    found.map(|v| {
        v.to_array()
            .map(|x| if x.abs() < 1e-9 { 0.0 } else { x as f32 })
    })
}

/// The basis without its constants.
fn basis(n: DVec3) -> [f64; 9] {
    [
        1.0,
        n.x,
        n.y,
        n.z,
        n.x * n.y,
        n.y * n.z,
        n.z * n.x,
        3.0 * n.z * n.z - 1.0,
        n.x * n.x - n.y * n.y,
    ]
}

/// Returns a colour as a word: 9 bits for each channel, and an exponent of 5 bits.
fn shared_exponent(color: DVec3) -> u32 {
    let color = color.clamp(DVec3::ZERO, DVec3::splat(65_408.0));
    let largest = color.max_element();
    if largest < 1e-7 {
        return 0;
    }
    let mut exponent = (largest.log2().floor() as i32 + 1 + 15).clamp(0, 31);
    let scaled = |exponent: i32| color * f64::powi(2.0, 24 - exponent);
    if scaled(exponent).max_element().round() > 511.0 {
        exponent += 1;
    }
    let [r, g, b] = scaled(exponent).round().to_array().map(|x| x as u32);
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use relievo_shared::shading::environment;

    #[test]
    fn texels_keep_colours_to_half_a_percent() {
        for color in [[1.0, 0.5, 0.25], [511.9, 0.0, 3.0], [1e-3, 2e-3, 1e-3]] {
            let color = DVec3::from(color);
            let found = environment::from_shared_exponent(shared_exponent(color)).as_dvec3();
            let error = (found - color).abs().max_element();
            assert!(error <= color.max_element() / 510.0, "{found} {color}");
        }
        assert_eq!(shared_exponent(DVec3::ZERO), 0);
    }

    /// Light of a cosine's power from above: its irradiance is known.
    #[test]
    fn irradiance_is_the_integral_of_cosine_and_light() {
        let light = |d: DVec3, _: f64| DVec3::splat(d.y.max(0.0));
        let Surroundings { lighting, .. } = baked_environment(16, &light);
        let at = |n: Vec3| environment::irradiance(&lighting, n).x;
        // ∫ cos² over the hemisphere, over π: 2 / 3.
        assert!((at(Vec3::Y) - 2.0 / 3.0).abs() < 0.03, "{}", at(Vec3::Y));
        assert!(at(Vec3::NEG_Y).abs() < 0.03, "{}", at(Vec3::NEG_Y));
        // Half of the sky: 2 / (3 π) to the side.
        assert!((at(Vec3::X) - 0.2122).abs() < 0.03, "{}", at(Vec3::X));
    }

    /// A sun of four pixels in 1024 × 512: its light is in every level.
    #[test]
    fn small_bright_suns_light_what_is_rough() {
        let mut picture = Rgba32FImage::new(1024, 512);
        for (x, y) in [(512, 100), (513, 100), (512, 101), (513, 101)] {
            picture.put_pixel(x, y, image::Rgba([2e4, f32::INFINITY, f32::NAN, 1.0]));
        }
        let sun = Panorama::new(picture, 0.0);
        let light = |d: DVec3, width: f64| sun.light(d, width);
        let Surroundings { lighting, words } = baked_environment(64, &light);
        let polar = PI * 101.0 / 512.0;
        let towards = DVec3::new(0.0, polar.cos(), -polar.sin());
        // The irradiance over π of a small source: its light times its solid angle, over π.
        let angle = (PI / 512.0).powi(2) * 4.0 * polar.sin();
        let found = environment::irradiance(&lighting, towards.as_vec3());
        let expected = 2e4 * angle / PI;
        // Three bands of harmonics give 17 / 16 of it on the axis.
        assert!(
            (f64::from(found.x) / expected - 1.0625).abs() < 0.05,
            "{found} {expected}"
        );
        assert!(found.y > 2.9 * found.x && found.z == 0.0, "{found}");
        let blurred = environment::radiance(&words[..], &lighting, towards.as_vec3(), 1.0);
        assert!(
            f64::from(blurred.x) > 0.5 * expected,
            "{blurred} {expected}"
        );
    }

    #[test]
    fn even_light_is_even_in_every_level() {
        let Surroundings { lighting, words } =
            baked_environment(16, &|_, _| DVec3::new(1.0, 0.5, 0.25));
        let directions = [[0.0, 0.0, 1.0], [0.6, -0.8, 0.0], [-0.6, 0.0, -0.8]];
        for direction in directions.map(Vec3::from) {
            for roughness in [0.0, 0.3, 0.5, 0.99, 1.0] {
                let found =
                    environment::radiance(&words[..], &lighting, direction, roughness).as_dvec3();
                let error = (found - DVec3::new(1.0, 0.5, 0.25)).abs().max_element();
                assert!(error < 1e-5, "{found}");
            }
            let found = environment::irradiance(&lighting, direction).as_dvec3();
            let error = (found - DVec3::new(1.0, 0.5, 0.25)).abs().max_element();
            assert!(error < 1e-4, "{found}");
        }
    }

    /// The first level shows what is there, across the edges of the octahedron, too.
    #[test]
    fn directions_are_found_again() {
        let light = |d: DVec3, _: f64| d * 0.5 + 0.5;
        let Surroundings { lighting, words } = baked_environment(64, &light);
        let mut random = fastrand::Rng::with_seed(5);
        for _ in 0..2000 {
            let mut part = || random.f64() * 2.0 - 1.0;
            let direction = DVec3::new(part(), part(), part()).normalize();
            let found = environment::radiance(&words[..], &lighting, direction.as_vec3(), 0.0);
            let error = (found.as_dvec3() - light(direction, 0.0))
                .abs()
                .max_element();
            assert!(error < 0.01, "{direction}: {found} {error}");
        }
    }
}
