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
use crate::scene::{Search, Technique, Tier};
use relievo_shared::layout::Object;
use relievo_shared::profile::{self, LAYERED};
use relievo_shared::shaders::search_of;

/// What a variant changes.
struct Variation {
    name: &'static str,
    technique: Technique,
    cut_out: bool,
    self_shadow: bool,
}

/// Every technique, and the features beside.
fn variations() -> Vec<Variation> {
    let techniques = Technique::ALL.into_iter().map(|technique| Variation {
        name: technique.name(),
        technique,
        cut_out: false,
        self_shadow: false,
    });
    let features = [
        Variation {
            name: "cut out",
            technique: Technique::Basic,
            cut_out: true,
            self_shadow: false,
        },
        Variation {
            name: "self-shadowed",
            technique: Technique::Chamfered,
            cut_out: false,
            self_shadow: true,
        },
    ];
    techniques.chain(features).collect()
}

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
    scene.make_all_prisms();
    let original: Vec<Object> = scene.objects.iter().map(|o| o.parameters).collect();
    let mut result = Ok(());
    for variation in &variations() {
        let extrusion = variation.technique.default_extrusion();
        let relief = variation.technique.search() == Search::Relief;
        let straight = extrusion.profile == profile::STRAIGHT;
        for tier in Tier::ALL {
            // Relief mapping exists for the paths of the planar and the fast tier.
            let has_relief = matches!(tier, Tier::Planar | Tier::Fast);
            let is_drawn = (has_relief || !relief) && (straight || tier != Tier::Paper);
            if result.is_err() || !is_drawn {
                continue;
            }
            for object in &mut scene.objects {
                let parameters = &mut object.parameters;
                let is_stack = parameters.profile == LAYERED;
                // Neither draws layers.
                if is_stack && (relief || tier == Tier::Paper) {
                    continue;
                }
                parameters.tier = tier.code();
                if !is_stack {
                    parameters.extension = extrusion.extension as f32;
                    parameters.bevel = extrusion.bevel as f32;
                    parameters.chamfer = extrusion.chamfer as f32;
                    parameters.profile = extrusion.profile;
                    parameters.parts = extrusion.parts;
                }
                parameters.cut_out = variation.cut_out.into();
                parameters.self_shadow = variation.self_shadow.into();
                parameters.search = search_of(tier.code(), relief);
                *parameters = parameters.complete();
            }
            result = visit(scene, &format!("{}, {}", tier.name(), variation.name));
        }
    }
    for (object, parameters) in scene.objects.iter_mut().zip(original) {
        object.parameters = parameters;
    }
    result
}
