//! A scene in every tier with every technique.

use crate::prepare::PreparedScene;
use crate::scene::Tier;
use relievo_shared::layout::{
    Object, SEARCH_EXTRUSION, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF,
};

/// A technique as it changes an object; lengths are width units.
struct Technique {
    name: &'static str,
    extension: f32,
    bevel: f32,
    chamfer: f32,
    relief: bool,
    cut_out: bool,
    self_shadow: bool,
}

const BASIC: Technique = Technique {
    name: "basic",
    extension: 0.0,
    bevel: 0.0,
    chamfer: 1.0,
    relief: false,
    cut_out: false,
    self_shadow: false,
};

const TECHNIQUES: [Technique; 7] = [
    BASIC,
    Technique {
        name: "outward",
        extension: 0.03,
        ..BASIC
    },
    Technique {
        name: "beveled",
        extension: 0.01,
        bevel: 0.06,
        ..BASIC
    },
    Technique {
        name: "chamfered",
        bevel: 0.08,
        chamfer: 0.5,
        ..BASIC
    },
    Technique {
        name: "relief",
        bevel: 0.05,
        relief: true,
        ..BASIC
    },
    Technique {
        name: "cut out",
        cut_out: true,
        ..BASIC
    },
    Technique {
        name: "self-shadowed",
        bevel: 0.08,
        chamfer: 0.5,
        self_shadow: true,
        ..BASIC
    },
];

/// Calls `visit` with the scene in every tier with every technique that the
/// tier has, and with a name for each; then the scene is as it was.
///
/// # Errors
/// The first error of `visit`.
pub fn for_each_variant<E>(
    scene: &mut PreparedScene,
    mut visit: impl FnMut(&PreparedScene, &str) -> Result<(), E>,
) -> Result<(), E> {
    // Prisms are made for the depth, which stays.
    scene.make_all_shells();
    let original: Vec<Object> = scene.objects.iter().map(|o| o.parameters).collect();
    let mut result = Ok(());
    for technique in &TECHNIQUES {
        for tier in Tier::ALL {
            // Relief mapping has the paths of the planar and the fast tier.
            let has_relief = matches!(tier, Tier::Planar | Tier::Fast);
            if result.is_err() || (technique.relief && !has_relief) {
                continue;
            }
            for object in &mut scene.objects {
                let parameters = &mut object.parameters;
                parameters.tier = tier.code();
                parameters.extension = technique.extension;
                parameters.bevel = technique.bevel;
                parameters.chamfer = technique.chamfer;
                parameters.cut_out = technique.cut_out.into();
                parameters.self_shadow = technique.self_shadow.into();
                parameters.search = match (technique.relief, tier) {
                    (true, _) => SEARCH_RELIEF,
                    (false, Tier::Paper) => SEARCH_PAPER,
                    (false, Tier::Accurate) => SEARCH_PRISMS,
                    (false, _) => SEARCH_EXTRUSION,
                };
            }
            result = visit(scene, &format!("{}, {}", tier.name(), technique.name));
        }
    }
    for (object, parameters) in scene.objects.iter_mut().zip(original) {
        object.parameters = parameters;
    }
    result
}
