//! How a pattern is carved and coloured, by an object or by a layer.

use super::Color;
use relievo_shared::profile;

/// Default luma below which a pixel is pattern.
pub(super) const DEFAULT_THRESHOLD: u8 = 128;

/// How the pattern grows with the depth (section 2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrusion {
    /// Number of the profile, see `relievo_shared::profile`; techniques set it.
    pub profile: u32,
    /// Extension e, pattern widths.
    pub extension: f64,
    /// Bevel b, pattern widths per unit of δ.
    pub bevel: f64,
    /// Chamfer c, 0…1: the δ where the growth ends.
    pub chamfer: f64,
    /// Number of parts of a profile that has parts.
    pub parts: u32,
}

impl Extrusion {
    /// Upright walls, without extension.
    pub const UPRIGHT: Extrusion = Extrusion {
        profile: profile::STRAIGHT,
        extension: 0.0,
        bevel: 0.0,
        chamfer: 1.0,
        parts: 1,
    };
}

impl Default for Extrusion {
    /// [`Extrusion::UPRIGHT`].
    fn default() -> Extrusion {
        Extrusion::UPRIGHT
    }
}

/// Colours and gloss of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Colour of the caps: the mesh surface on the pattern.
    pub cap: Color,
    /// Colour of upright walls.
    pub wall: Color,
    /// Colour of bevels and chamfers.
    pub bevel: Color,
    /// Colour of the floor between the columns.
    pub floor: Color,
    /// Strength of the highlight, 0…1.
    pub specular: f64,
    /// Exponent of the highlight, 1…127.
    pub shininess: u32,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            cap: Color::from_hex(0xd8b45c),
            wall: Color::from_hex(0xb0502e),
            bevel: Color::from_hex(0xe8cf94),
            floor: Color::from_hex(0x3d5a73),
            specular: 0.25,
            shininess: 40,
        }
    }
}
