//! What shading reads: materials with their pictures, lights with the frames of their shadow
//! maps, and the environment, in the layouts of the shared code.
//!
//! ```text
//! pictures      image files → words, with their smaller levels
//! environment   picture of all directions → irradiance, levels of growing roughness
//! reflectance   what microfacets reflect of even light
//! lights        lights → their layouts, and frames of shadow maps
//! finishes      materials of objects
//! of_meshes     materials of mesh files
//! cells         pattern → its connected pieces
//! chart         pattern → what it is on average
//! far           chart → from which width of a pixel on that is all it shows
//! bakes         pictures, environment, cells and charts, kept for the next scene
//! ```

mod bakes;
mod cells;
mod chart;
mod environment;
mod far;
mod finishes;
mod lights;
mod of_meshes;
mod pictures;
mod reflectance;

pub(super) use bakes::Bakes;

use super::lit::PreparedLighting;
use super::prepared::PreparedObject;
use super::sources::{environment_of, lights_of};
use crate::Error;
use crate::limits::Account;
use crate::mesh::Bounds;
use crate::scene::Scene;
use crate::tone::Developer;
use reflectance::reflectance;
use relievo_shared::shading::Lighting;

/// Prepares the lighting of `scene`, and numbers the materials of `objects`.
pub(super) fn prepare_lighting(
    scene: &Scene,
    objects: &mut [PreparedObject],
    bounds: &Bounds,
    bakes: &mut Bakes,
    account: &mut Account<'_>,
) -> Result<PreparedLighting, Error> {
    // Its first word is that of the table.
    let mut words = reflectance();
    let (finishes, facets) = finishes::finishes(scene, objects, bakes, &mut words, account)?;
    let environment = environment_of(scene);
    let baked = environment::bake(
        scene,
        &environment,
        &mut bakes.environments,
        &mut words,
        account,
    )?;
    let sources = lights_of(scene);
    let lights = lights::lights(&sources, bounds, words.len(), account)?;
    Ok(PreparedLighting {
        lighting: Lighting {
            // What is shown of a dark environment is black.
            background: match environment.is_visible {
                true => [0.0; 3],
                false => scene.background.linear(),
            },
            shows_environment: u32::from(environment.is_visible && baked.environment_levels > 0),
            lights: lights.lights.len() as u32,
            reflectance: 0,
            shoulder: Developer::new(&scene.development).shoulder(),
            occlusion: environment.occlusion as f32,
            ..baked
        },
        has_smooth_edges: scene.smooth_edges,
        finishes,
        facets,
        words,
        ..lights
    })
}
