//! Relievo in Bevy: a pattern is wrapped around a mesh and appears as carved geometry, outline
//! included, lit and shadowed by Bevy's own renderer.
//!
//! Add [`RelievoPlugin`], and spawn a [`Carved`]. docs/bevy.md has a whole program.

#![warn(missing_docs)]

mod carved;
mod hull;
mod material;
mod pattern;
mod preparation;
mod prepare;
mod scene;

pub use carved::{Carved, CarvedMaterial, Finish, LayerMaterial};
pub use material::Carving;
pub use pattern::{Pattern, PatternError, PatternLoader, PatternSettings};
pub use preparation::IsPrepared;
pub use relievo::scene::{Technique, Tier};
pub use scene::{CarvedScene, CarvedSceneRoot, SceneLoadError, SceneLoader};

use bevy::prelude::*;

/// Draws entities with a [`Carved`], and spawns those of a [`CarvedSceneRoot`].
pub struct RelievoPlugin;

impl Plugin for RelievoPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            pattern::PatternPlugin,
            material::CarvingPlugin,
            preparation::PreparationPlugin,
            scene::ScenePlugin,
        ));
    }
}
