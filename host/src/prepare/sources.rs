//! Where the light of a physically lit scene comes from.

use crate::scene::{Environment, LightKind, LightSource, Scene};

/// Returns the lights of `scene`: its own, or that of the table `[light]`.
pub(super) fn lights_of(scene: &Scene) -> Vec<LightSource> {
    if !scene.lights.is_empty() {
        return scene.lights.clone();
    }
    vec![LightSource {
        kind: LightKind::Directional,
        color: scene.light.color,
        intensity: scene.light.intensity,
        direction: scene.light.direction,
        ..LightSource::default()
    }]
}

/// Returns the environment of `scene`; without one it is even light, of the ambient colour where
/// there are no lights of its own.
pub(super) fn environment_of(scene: &Scene) -> Environment {
    match &scene.environment {
        Some(environment) => environment.clone(),
        None if scene.lights.is_empty() => Environment {
            color: scene.light.ambient,
            ..Environment::default()
        },
        None => Environment {
            intensity: 0.0,
            ..Environment::default()
        },
    }
}

/// Returns whether a light of `scene` casts shadows, as that of the table `[light]` does where
/// it is used.
pub(super) fn has_shadows(scene: &Scene) -> bool {
    let mut lights = scene.lights.iter();
    scene.is_physical() && (scene.lights.is_empty() || lights.any(|light| light.casts_shadows))
}
