//! Where the light of a physically lit scene comes from.

use crate::scene::{Environment, LightKind, LightSource, Scene};

/// Returns the lights of `scene`: its own, or that of the table `[light]`. Those that are dark cast no
/// shadows.
pub(super) fn lights_of(scene: &Scene) -> Vec<LightSource> {
    let mut lights = match scene.lights.is_empty() {
        true => vec![LightSource {
            kind: LightKind::Directional,
            color: scene.light.color,
            intensity: scene.light.intensity,
            direction: scene.light.direction,
            ..LightSource::default()
        }],
        false => scene.lights.clone(),
    };
    for light in &mut lights {
        let is_dark = light.intensity == 0.0 || light.color.linear() == [0.0; 3];
        light.casts_shadows &= !is_dark;
    }
    lights
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

/// Returns whether a light of `scene` casts shadows.
pub(super) fn has_shadows(scene: &Scene) -> bool {
    let mut lights = lights_of(scene).into_iter();
    scene.is_physical() && lights.any(|light| light.casts_shadows)
}
