//! The components of a carved entity.

use crate::Pattern;
use bevy::prelude::*;
use relievo::scene::{Technique, Tier};

/// A mesh with a pattern wrapped around it. Where the pattern is, the mesh stays; the rest is
/// carved out.
///
/// Mesh and pattern are prepared in the background, as often as this component, the mesh or the
/// pattern changes. Until then the entity looks as before. The plugin adds `Mesh3d` and
/// `MeshMaterial3d`: what is drawn are the places where rays may enter the mesh.
///
/// The scale of the transform must be the same along all axes, and positive.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(CarvedMaterial, Transform, Visibility)]
pub struct Carved {
    /// A list of triangles with positions and texture coordinates; normals are computed where
    /// there are none.
    pub mesh: Handle<Mesh>,
    /// The pattern.
    pub pattern: Handle<Pattern>,
    /// Repeats of the pattern along u and v.
    pub repeat: Vec2,
    /// Depth of the floor, units of the mesh; `None` is 4 % of the mesh's diagonal.
    pub depth: Option<f32>,
    /// Form of walls and edges.
    pub technique: Technique,
    /// Extension of the pattern, its widths; `None` is the technique's default, as below.
    pub extension: Option<f32>,
    /// Growth of the pattern with the depth, its widths.
    pub bevel: Option<f32>,
    /// Share of the depth where the growth ends, 0…1.
    pub chamfer: Option<f32>,
    /// Model of the surface: speed or accuracy.
    pub tier: Tier,
    /// Whether the pattern rises from the mesh in place of being cut into it; needs a depth.
    pub raised: bool,
    /// Whether there is no floor: one sees through.
    pub cut_out: bool,
}

impl Default for Carved {
    fn default() -> Carved {
        Carved {
            mesh: Handle::default(),
            pattern: Handle::default(),
            repeat: Vec2::ONE,
            depth: None,
            technique: Technique::Basic,
            extension: None,
            bevel: None,
            chamfer: None,
            tier: Tier::Fast,
            raised: false,
            cut_out: false,
        }
    }
}

impl Carved {
    /// Wraps a pattern around a mesh once.
    pub fn new(mesh: Handle<Mesh>, pattern: Handle<Pattern>) -> Carved {
        Carved {
            mesh,
            pattern,
            ..Carved::default()
        }
    }

    /// Sets the repeats of the pattern along u and v.
    #[must_use]
    pub fn repeat(mut self, u: f32, v: f32) -> Carved {
        self.repeat = Vec2::new(u, v);
        self
    }

    /// Sets the depth of the floor, units of the mesh.
    #[must_use]
    pub fn depth(mut self, depth: f32) -> Carved {
        self.depth = Some(depth);
        self
    }
}

/// The materials of a carved entity.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct CarvedMaterial {
    /// Bevy's material of the whole; white by default. Its textures follow the texture coordinates of the mesh. It
    /// is drawn opaque and forward.
    pub base: Handle<StandardMaterial>,
    /// The mesh's own surface.
    pub cap: Finish,
    /// Upright walls.
    pub wall: Finish,
    /// Bevels and chamfers.
    pub bevel: Finish,
    /// The floor.
    pub floor: Finish,
    /// The further layers of a scene's object. Those that are left out have the materials of its own
    /// pattern.
    pub layers: Vec<LayerMaterial>,
}

/// The materials of a further layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerMaterial {
    /// Its caps and undersides.
    pub cap: Finish,
    /// Its upright walls.
    pub wall: Finish,
    /// Its bevels and chamfers.
    pub bevel: Finish,
}

/// What differs from the base material; `None` keeps its value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finish {
    /// Base colour, in place of base colour and texture.
    pub base_color: Option<Color>,
    /// Perceptual roughness, 0…1.
    pub roughness: Option<f32>,
    /// Metallic, 0…1.
    pub metallic: Option<f32>,
}

impl From<Color> for Finish {
    fn from(color: Color) -> Finish {
        Finish {
            base_color: Some(color),
            ..Finish::default()
        }
    }
}
