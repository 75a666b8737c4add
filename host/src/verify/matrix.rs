//! Varies a scene: every tier with every technique.
//!
//! ```
//! use relievo::prepare::prepare;
//! use relievo::scene::Scene;
//! use relievo::verify::matrix::for_each_variant;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = Scene::load(Path::new("../assets/scenes/plane.toml"))?;
//! let mut names = Vec::new();
//! for_each_variant(&mut prepare(&scene, &|_| ())?, |_, name| {
//!     names.push(name.to_string());
//!     Ok::<_, std::convert::Infallible>(())
//! })?;
//! assert!(names.contains(&"fast, beveled".to_string()));
//! # Ok(())
//! # }
//! ```

use crate::prepare::PreparedScene;
use crate::scene::Tier;
use relievo_shared::layout::Object;
use relievo_shared::shaders::search_of;

/// Parameters that a variant changes; lengths are in pattern widths.
struct Variation {
    name: &'static str,
    extension: f32,
    bevel: f32,
    chamfer: f32,
    relief: bool,
    cut_out: bool,
    self_shadow: bool,
}

const BASIC: Variation = Variation {
    name: "basic",
    extension: 0.0,
    bevel: 0.0,
    chamfer: 1.0,
    relief: false,
    cut_out: false,
    self_shadow: false,
};

const VARIATIONS: [Variation; 7] = [
    BASIC,
    Variation {
        name: "outward",
        extension: 0.03,
        ..BASIC
    },
    Variation {
        name: "beveled",
        extension: 0.01,
        bevel: 0.06,
        ..BASIC
    },
    Variation {
        name: "chamfered",
        bevel: 0.08,
        chamfer: 0.5,
        ..BASIC
    },
    Variation {
        name: "relief",
        bevel: 0.05,
        relief: true,
        ..BASIC
    },
    Variation {
        name: "cut out",
        cut_out: true,
        ..BASIC
    },
    Variation {
        name: "self-shadowed",
        bevel: 0.08,
        chamfer: 0.5,
        self_shadow: true,
        ..BASIC
    },
];

/// Calls `visit` with the scene in every tier with every technique of that tier, and
/// with the variant's name, "tier, technique". Restores the scene afterwards.
///
/// # Errors
/// The first error of `visit`, which ends the loop.
pub fn for_each_variant<E>(
    scene: &mut PreparedScene,
    mut visit: impl FnMut(&PreparedScene, &str) -> Result<(), E>,
) -> Result<(), E> {
    // Prisms depend on the depth only, which no variant changes.
    scene.make_all_shells();
    let original: Vec<Object> = scene.objects.iter().map(|o| o.parameters).collect();
    let mut result = Ok(());
    for variation in &VARIATIONS {
        for tier in Tier::ALL {
            // Relief mapping exists for the paths of the planar and the fast tier.
            let has_relief = matches!(tier, Tier::Planar | Tier::Fast);
            if result.is_err() || (variation.relief && !has_relief) {
                continue;
            }
            for object in &mut scene.objects {
                let parameters = &mut object.parameters;
                parameters.tier = tier.code();
                parameters.extension = variation.extension;
                parameters.bevel = variation.bevel;
                parameters.chamfer = variation.chamfer;
                parameters.cut_out = variation.cut_out.into();
                parameters.self_shadow = variation.self_shadow.into();
                parameters.search = search_of(tier.code(), variation.relief);
            }
            result = visit(scene, &format!("{}, {}", tier.name(), variation.name));
        }
    }
    for (object, parameters) in scene.objects.iter_mut().zip(original) {
        object.parameters = parameters;
    }
    result
}
