//! Lights and environment of scenes that are lit physically.

use super::Color;
use std::path::PathBuf;

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSource {
    /// Name, for tracks.
    pub name: String,
    /// What kind of light.
    pub kind: LightKind,
    /// Its colour.
    pub color: Color,
    /// Brightness of a white matte surface that faces it, at a distance of 1 world unit if it
    /// has a position.
    pub intensity: f64,
    /// Direction towards a directional light; of any length but zero.
    pub direction: [f64; 3],
    /// Position of a point or spot light, world units.
    pub position: [f64; 3],
    /// Point that a spot light shines at, world units.
    pub target: [f64; 3],
    /// Distance beyond which a point or spot light is dark, world units; `None` is without end.
    pub range: Option<f64>,
    /// Angle from the axis of a spot light up to which it is as bright as on the axis, degrees.
    pub inner_angle: f64,
    /// Angle from the axis from which on it is dark, degrees.
    pub outer_angle: f64,
    /// Whether objects cast shadows in it.
    pub casts_shadows: bool,
    /// Width and height of its shadow map, texels.
    pub shadow_size: u32,
}

impl Default for LightSource {
    fn default() -> LightSource {
        LightSource {
            name: String::new(),
            kind: LightKind::default(),
            color: Color([1.0; 3]),
            intensity: 1.0,
            direction: [0.5, 0.8, 0.6],
            position: [0.0; 3],
            target: [0.0; 3],
            range: None,
            inner_angle: 0.0,
            outer_angle: 45.0,
            casts_shadows: true,
            shadow_size: 2048,
        }
    }
}

/// Kind of a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightKind {
    /// Far away, in one direction, as the sun.
    #[default]
    Directional,
    /// At a position, in all directions.
    Point,
    /// At a position, within a cone.
    Spot,
}

impl LightKind {
    /// All of them.
    pub const ALL: [LightKind; 3] = [LightKind::Directional, LightKind::Point, LightKind::Spot];

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            LightKind::Directional => "directional",
            LightKind::Point => "point",
            LightKind::Spot => "spot",
        }
    }
}

/// Light from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// A picture of all directions: longitude along its width, latitude along its height.
    /// `None` is even light.
    pub image: Option<PathBuf>,
    /// Factor of the light.
    pub color: Color,
    /// Factor of the light.
    pub intensity: f64,
    /// Angle by which the picture is turned about the y axis, degrees.
    pub turn: f64,
    /// Whether it is seen where no object is.
    pub is_visible: bool,
    /// How much carvings keep its light from their grounds and walls: 1 as the distance map says,
    /// 0 not at all.
    pub occlusion: f64,
}

impl Default for Environment {
    fn default() -> Environment {
        Environment {
            image: None,
            color: Color([1.0; 3]),
            intensity: 1.0,
            turn: 0.0,
            is_visible: false,
            occlusion: 1.0,
        }
    }
}
