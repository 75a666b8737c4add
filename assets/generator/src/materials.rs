//! Pictures of materials and of an environment. Pictures of materials repeat in both directions
//! without a seam.

use anyhow::{Context, Result};
use glam::DVec3;
use image::codecs::hdr::HdrEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, Rgb, RgbImage};

/// Side of the pictures of materials, pixels.
const SIDE: u32 = 256;

/// A picture with its name.
pub struct Picture {
    /// Path of the file.
    pub path: &'static str,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// Returns all pictures.
///
/// # Errors
///
/// If one cannot be encoded.
pub fn all() -> Result<Vec<Picture>> {
    Ok(vec![
        png("materials/stone.png", &colors())?,
        png("materials/stone_normal.png", &normals())?,
        png("materials/wood.png", &wood())?,
        Picture {
            path: "environments/studio.hdr",
            bytes: studio()?,
        },
        Picture {
            path: "environments/sky.hdr",
            bytes: sky()?,
        },
    ])
}

fn png(path: &'static str, image: &RgbImage) -> Result<Picture> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(
            image,
            image.width(),
            image.height(),
            ExtendedColorType::Rgb8,
        )
        .with_context(|| format!("cannot encode {path}"))?;
    Ok(Picture { path, bytes })
}

/// Returns a random number of 0…1 for a point of a lattice that repeats.
fn random(x: u32, y: u32, period: u32, seed: u32) -> f64 {
    let mut hash = (x % period)
        .wrapping_mul(0x9e37_79b9)
        .wrapping_add((y % period).wrapping_mul(0x85eb_ca6b))
        .wrapping_add(seed.wrapping_mul(0xc2b2_ae35));
    for _ in 0..2 {
        hash = (hash ^ (hash >> 16)).wrapping_mul(0x7feb_352d);
        hash = (hash ^ (hash >> 15)).wrapping_mul(0x846c_a68b);
    }
    f64::from(hash ^ (hash >> 16)) / f64::from(u32::MAX)
}

/// Smooth noise with `period` lattice points along each side.
fn noise(x: f64, y: f64, period: u32, seed: u32) -> f64 {
    let (u, v) = (x * f64::from(period), y * f64::from(period));
    let (i, j) = (u.floor(), v.floor());
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (smooth(u - i), smooth(v - j));
    let at = |dx: u32, dy: u32| random(i as u32 + dx, j as u32 + dy, period, seed);
    let row = |dy: u32| at(0, dy) * (1.0 - s) + at(1, dy) * s;
    row(0) * (1.0 - t) + row(1) * t
}

/// Noise of several sizes, 0…1.
fn roughness(x: f64, y: f64) -> f64 {
    let octaves = [(4, 0.35), (9, 0.25), (21, 0.18), (47, 0.12), (101, 0.1)];
    octaves
        .into_iter()
        .map(|(period, weight)| weight * noise(x, y, period, period))
        .sum()
}

/// Grains that are darker or lighter than what is around them.
fn colors() -> RgbImage {
    RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let [u, v] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE));
        let base = 0.62 + 0.5 * (roughness(u, v) - 0.5);
        let grain = 0.12 * (noise(u, v, 128, 5) - 0.5);
        let warmth = 0.05 * (noise(u, v, 6, 9) - 0.5);
        Rgb([base + grain + warmth, base + grain, base + grain - warmth]
            .map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8))
    })
}

/// Grain of wood along the rows.
fn wood() -> RgbImage {
    const LIGHT: DVec3 = DVec3::new(0.74, 0.53, 0.33);
    const DARK: DVec3 = DVec3::new(0.45, 0.27, 0.14);
    RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let [u, v] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE));
        let bend = 0.10 * noise(u, v, 3, 31) + 0.03 * noise(u, v, 8, 32);
        let rings = (std::f64::consts::TAU * 9.0 * (v + bend)).sin();
        let fibre = noise(u, v * 16.0 % 1.0, 12, 33) * 0.4 + noise(u, v, 128, 34) * 0.6;
        let share = 0.45 + 0.3 * rings.powi(3) + 0.5 * (fibre - 0.5);
        let color = LIGHT.lerp(DARK, share.clamp(0.0, 1.0));
        Rgb(color.to_array().map(|value| (value * 255.0).round() as u8))
    })
}

/// Slopes of the same noise.
fn normals() -> RgbImage {
    let step = 1.0 / f64::from(SIDE);
    RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let [u, v] = [x, y].map(|at| (f64::from(at) + 0.5) * step);
        let height = |u: f64, v: f64| 0.03 * roughness(u.rem_euclid(1.0), v.rem_euclid(1.0));
        let slope = |a: f64, b: f64| (b - a) / (2.0 * step);
        let across = slope(height(u - step, v), height(u + step, v));
        let down = slope(height(u, v - step), height(u, v + step));
        // y points up.
        let normal = DVec3::new(-across, down, 1.0).normalize();
        Rgb(normal
            .to_array()
            .map(|part| ((0.5 * part + 0.5) * 255.0).round() as u8))
    })
}

/// A dim room with three bright windows.
fn studio() -> Result<Vec<u8>> {
    // Centre (longitude and latitude, degrees), half width and height, light.
    let windows = [
        ([-50.0, 45.0], [24.0, 16.0], [9.0, 8.6, 8.0]),
        ([70.0, 25.0], [14.0, 26.0], [4.0, 4.4, 5.2]),
        ([180.0, 60.0], [40.0, 12.0], [3.0, 3.0, 3.0]),
    ];
    environment(|longitude, latitude| {
        // Darker towards the ground.
        let room = 0.12 + 0.18 * (latitude + 90.0) / 180.0;
        let mut light = [room, room, 1.05 * room];
        for ([centre, middle], [across, up], window) in windows {
            let beside = (longitude - centre + 180.0_f64).rem_euclid(360.0) - 180.0;
            if beside.abs() < across && (latitude - middle).abs() < up {
                light = window;
            }
        }
        light
    })
}

/// A clear sky, brighter at the horizon and around the place of the sun, which is a light of its
/// own; below it a meadow.
fn sky() -> Result<Vec<u8>> {
    const ZENITH: DVec3 = DVec3::new(0.20, 0.38, 0.75);
    const HORIZON: DVec3 = DVec3::new(0.82, 0.90, 0.97);
    const MEADOW: DVec3 = DVec3::new(0.16, 0.17, 0.10);
    const GLOW: DVec3 = DVec3::new(1.2, 1.0, 0.7);
    // Towards the sun: longitude and latitude, degrees.
    const SUN: [f64; 2] = [140.0, 40.0];
    environment(|longitude, latitude| {
        if latitude < 0.0 {
            return MEADOW.to_array();
        }
        let high = latitude.to_radians().sin();
        let sky = ZENITH + (HORIZON - ZENITH) * (1.0 - high).powi(4);
        let [turn, up, sun] = [longitude - SUN[0], latitude, SUN[1]].map(f64::to_radians);
        let cosine = up.sin() * sun.sin() + up.cos() * sun.cos() * turn.cos();
        (sky + GLOW * cosine.max(0.0).powi(12)).to_array()
    })
}

/// Returns the picture of the light from all directions: of longitude and latitude, degrees.
fn environment(light: impl Fn(f64, f64) -> [f64; 3]) -> Result<Vec<u8>> {
    let (width, height) = (128_u32, 64_u32);
    let pixels: Vec<Rgb<f32>> = (0..width * height)
        .map(|index| {
            let longitude = (f64::from(index % width) + 0.5) / f64::from(width) * 360.0 - 180.0;
            let latitude = 90.0 - (f64::from(index / width) + 0.5) / f64::from(height) * 180.0;
            Rgb(light(longitude, latitude).map(|channel| channel as f32))
        })
        .collect();
    let mut bytes = Vec::new();
    HdrEncoder::new(&mut bytes)
        .encode(&pixels, width as usize, height as usize)
        .context("cannot encode the environment")?;
    Ok(bytes)
}
