//! Maps rendered words to screen colours.
//!
//! `present.wgsl` does the same on the GPU; a test compares the two.

use glam::DVec3;
use relievo::overlay::heat;
use relievo::picture::srgb;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::Content;
use relievo::render::{ColorWords, GeometryWords};
use relievo::scene::{Camera, Development};
use relievo::tone::Developer;
use relievo_shared::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_FLOOR, CLASS_MISS, CLASS_WALL};

/// Quantity that the viewer shows for each pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Show {
    /// The picture.
    #[default]
    Color,
    /// Surface class: cap, wall, bevel or floor.
    Class,
    /// Normal of the carved surface.
    Normal,
    /// Distance from the eye, brightest at the nearest point.
    Distance,
    /// Texture coordinates, wrapped at each repeat: u red, v green.
    Coordinates,
    /// Depth below the surface, 0 black to 1 white.
    Depth,
    /// Search steps, from dark blue through green to yellow.
    Steps,
}

impl Show {
    /// All variants, in menu order.
    pub const ALL: [Show; 7] = [
        Show::Color,
        Show::Class,
        Show::Normal,
        Show::Distance,
        Show::Coordinates,
        Show::Depth,
        Show::Steps,
    ];

    /// Returns the name shown to the user.
    pub fn name(self) -> &'static str {
        match self {
            Show::Color => "Picture",
            Show::Class => "Surface class",
            Show::Normal => "Normal",
            Show::Distance => "Distance",
            Show::Coordinates => "Texture coordinates",
            Show::Depth => "Depth",
            Show::Steps => "Steps",
        }
    }

    /// Returns the render output it is computed from.
    pub fn content(self) -> Content {
        match self {
            Show::Color => Content::Color,
            _ => Content::Geometry,
        }
    }

    /// Returns its code in `present.wgsl`.
    pub fn code(self) -> u32 {
        self as u32
    }
}

/// Ranges that map to full brightness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scale {
    /// Distances shown as white and as black, world units.
    pub distances: [f32; 2],
    /// Number of steps shown in the brightest colour.
    pub steps: f32,
}

impl Scale {
    /// Largest number of steps that the colours resolve.
    const MOST_STEPS: u32 = 64;

    /// Computes the ranges for `scene` seen from `camera`.
    pub fn of(scene: &PreparedScene, camera: &Camera) -> Scale {
        let distance = DVec3::from(camera.eye).distance(scene.bounds.centre());
        let half = 0.5 * scene.bounds.diagonal();
        let objects = scene.objects.iter();
        let steps = objects.map(|object| object.parameters.linear_steps).max();
        Scale {
            distances: [(distance - half).max(0.0) as f32, (distance + half) as f32],
            steps: steps.unwrap_or(Self::MOST_STEPS).min(Self::MOST_STEPS) as f32,
        }
    }
}

/// Returns sRGB, 0…1, of a geometry pixel.
pub fn geometry(show: Show, place: [u32; 4], surface: [u32; 4], scale: &Scale) -> [f32; 3] {
    let class = surface[0] & 255;
    if class == CLASS_MISS {
        return [0.5; 3];
    }
    let [t, u, v, depth] = place.map(f32::from_bits);
    match show {
        Show::Color => [0.5; 3],
        Show::Class => match class {
            CLASS_CAP => [0.95, 0.78, 0.25],
            CLASS_WALL => [0.80, 0.35, 0.20],
            CLASS_BEVEL => [0.55, 0.75, 0.40],
            CLASS_FLOOR => [0.20, 0.40, 0.65],
            _ => [1.0, 0.0, 1.0],
        },
        Show::Normal => {
            let [_, x, y, z] = surface.map(f32::from_bits);
            [x, y, z].map(|axis| 0.5 * axis + 0.5)
        }
        Show::Distance => {
            let [near, far] = scale.distances;
            [1.0 - ((t - near) / (far - near)).clamp(0.0, 1.0); 3]
        }
        Show::Coordinates => [u - u.floor(), v - v.floor(), 0.0],
        Show::Depth => [depth.clamp(0.0, 1.0); 3],
        Show::Steps => heat((surface[0] >> 8) as f32 / scale.steps),
    }
}

/// Converts colour words to RGBA bytes. A transparent background keeps its colour.
pub fn color_bytes(words: &ColorWords, development: &Development) -> Vec<u8> {
    let developer = Developer::new(development);
    let rows = 0..words.height;
    let pixels = rows.flat_map(|y| (0..words.width).map(move |x| (x, y)));
    bytes(pixels.map(|(x, y)| developer.pixel(words, x, y).map(srgb)))
}

/// Converts geometry words to RGBA bytes.
pub fn geometry_bytes(show: Show, words: &GeometryWords, scale: &Scale) -> Vec<u8> {
    let pixels = words.place.iter().zip(&words.surface);
    bytes(pixels.map(|(&place, &surface)| geometry(show, place, surface, scale)))
}

fn bytes(pixels: impl Iterator<Item = [f32; 3]>) -> Vec<u8> {
    pixels
        .flat_map(|rgb| {
            let [r, g, b] = rgb.map(|channel| (255.0 * channel + 0.5) as u8);
            [r, g, b, 255]
        })
        .collect()
}
