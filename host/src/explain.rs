//! Explains which parts of the model a scene uses, and what they cost.
//!
//! ```
//! use relievo::explain::explain;
//! use relievo::prepare::prepare;
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let explanation = explain(&prepare(&scene, &|_| ())?, &[])?;
//! assert_eq!(explanation.memory.prisms, 0);
//! println!("{explanation}");
//! # Ok::<(), relievo::Error>(())
//! ```

use crate::budget::{FAST, PLANAR, Plan};
use crate::prepare::{PreparedLighting, PreparedObject, PreparedScene};
use crate::render::RenderError;
use crate::render::gpu::{Memory, Module, Pass, Pictures, Shaders};
use crate::shaders::{EntryPoints, Extent};
use relievo_shaders::Compiled;
use relievo_shared::layout::{
    FORMAT_CODES, Object, SEARCH_PAPER, SEARCH_PRISMS, SEARCH_RELIEF, TIER_PLANAR,
};
use relievo_shared::profile::{self, grows};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

/// A part of the model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feature {
    /// Its name.
    pub name: &'static str,
    /// Whether the scene uses it.
    pub is_in: bool,
    /// The key or file that decides it.
    pub why: String,
}

/// Size of an object's shader, and of the general shader that has all features.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderCost {
    /// The entry point used.
    pub entry_point: &'static str,
    /// Its instructions.
    pub instructions: usize,
    /// The general entry point.
    pub general: &'static str,
    /// Its instructions.
    pub general_instructions: usize,
    /// What a compiler for GPUs made of the entry point used, by generation of GPUs.
    pub compiled: Vec<Compiled<'static>>,
}

/// Explanation of one object.
#[derive(Clone, Debug)]
pub struct ObjectPlan {
    /// The object's name.
    pub name: String,
    /// Its plan, if it has a budget.
    pub plan: Option<Plan>,
    /// All features, used or not.
    pub features: Vec<Feature>,
    /// The shader that draws it, in the exact module, in the one with fused sums, and in the fast
    /// one.
    pub shaders: [ShaderCost; 3],
}

/// Explanation of the materials and lights of a scene.
#[derive(Clone, Debug)]
pub struct LightingPlan {
    /// All features, used or not.
    pub features: Vec<Feature>,
    /// The shaders that shade a pixel, with their instructions in the exact module, in the one
    /// with fused sums, and in the fast one.
    pub shaders: Vec<(&'static str, [usize; 3])>,
}

/// Explanation of a scene.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// Each object in the picture.
    pub objects: Vec<ObjectPlan>,
    /// What shades the picture of a scene with materials or lights.
    pub lighting: Option<LightingPlan>,
    /// Names of the objects outside the picture, which are not prepared.
    pub outside: Vec<String>,
    /// Memory of a device to draw its picture.
    pub memory: Memory,
    /// The same with triangles and prisms, colours and geometry for every object.
    pub general_memory: Memory,
}

/// Explains `scene` and the plans of its objects, if any (see
/// [`crate::budget::PlannedScene`]).
///
/// # Errors
/// [`RenderError::Device`] if a built-in shader module is malformed.
pub fn explain(scene: &PreparedScene, plans: &[Option<Plan>]) -> Result<Explanation, RenderError> {
    let modules = [
        ("relievo_exact", Shaders::Exact.module()?),
        ("relievo_fused", Shaders::Fused.module()?),
        ("relievo_fast", Shaders::Fast.module()?),
    ];
    // Instances are drawn alike.
    let objects = scene.objects.iter().enumerate();
    let objects = objects.filter(|(_, object)| object.instance == 0);
    Ok(Explanation {
        objects: objects
            .map(|(index, object)| ObjectPlan {
                name: object.name.clone(),
                plan: plans.get(index).cloned().flatten(),
                features: features(object, &scene.objects[..index], copies(scene, object)),
                shaders: modules
                    .each_ref()
                    .map(|(folder, module)| shader_cost(scene, object, folder, module)),
            })
            .collect(),
        lighting: scene.lighting.as_deref().map(|lighting| LightingPlan {
            features: lighting_features(lighting),
            shaders: Pass::of(lighting)
                .iter()
                .map(|pass| {
                    let shader = pass.fragment();
                    let count = |module: &Module| module.instructions(shader).unwrap_or_default();
                    (shader, modules.each_ref().map(|(_, module)| count(module)))
                })
                .collect(),
        }),
        outside: scene.outside.clone(),
        memory: Memory::of(scene, Extent::Needed, Pictures::Color),
        general_memory: Memory::of(scene, Extent::Everything, Pictures::ColorAndGeometry),
    })
}

fn shader_cost(
    scene: &PreparedScene,
    object: &PreparedObject,
    folder: &str,
    module: &Module,
) -> ShaderCost {
    let drawn = |extent| {
        let entry_points = EntryPoints::of(&object.parameters, extent);
        match scene.lighting {
            Some(_) => entry_points.surface,
            None => entry_points.color,
        }
    };
    let entry_point = drawn(Extent::Needed);
    let general = drawn(Extent::Everything);
    let count = |name| module.instructions(name).unwrap_or_default();
    ShaderCost {
        entry_point,
        instructions: count(entry_point),
        general,
        general_instructions: count(general),
        compiled: Compiled::of(folder, entry_point).collect(),
    }
}

/// Returns what the shading of a scene uses.
fn lighting_features(lighting: &PreparedLighting) -> Vec<Feature> {
    let materials = lighting.finishes.iter().map(|finish| &finish.material);
    let pictures: BTreeSet<u32> = materials
        .flat_map(|material| {
            [
                material.base_color_image,
                material.metallic_roughness_image,
                material.normal_image,
                material.emission_image,
            ]
        })
        .filter(|image| image.levels != 0)
        .map(|image| image.first)
        .collect();
    let cells = lighting.finishes.iter();
    let cells = cells.filter(|finish| finish.cells.levels != 0).count();
    let counted = |name, count: usize, what: &str| Feature {
        name,
        is_in: count > 0,
        why: match count {
            0 => "none".to_string(),
            _ => format!("{count} {what}"),
        },
    };
    vec![
        counted("lights", lighting.lights.len(), "in each pixel"),
        counted("shadow maps", lighting.shadow_maps.len(), "drawn once"),
        counted(
            "environment",
            lighting.lighting.environment_levels as usize,
            "levels of roughness",
        ),
        counted("pictures of materials", pictures.len(), "read"),
        counted("variation by cell", cells, "parts of objects vary"),
        Feature {
            name: "smooth edges",
            is_in: lighting.has_smooth_edges,
            why: match lighting.has_smooth_edges {
                true => "pixels are blended with their neighbours".to_string(),
                false => "image.smooth_edges is off".to_string(),
            },
        },
        Feature {
            name: "means of small patterns",
            is_in: lighting.has_charts(),
            why: match (lighting.has_charts(), lighting.has_smooth_edges) {
                (true, _) => "pixels that are wider than a groove show the mean".to_string(),
                (_, true) => "all objects are cut out or have the paper's map".to_string(),
                _ => "image.smooth_edges is off".to_string(),
            },
        },
    ]
}

/// Returns the number of objects that share the facets of `object`.
fn copies(scene: &PreparedScene, object: &PreparedObject) -> usize {
    let objects = scene.objects.iter();
    objects.filter(|other| object.shares_facets(other)).count()
}

/// Returns all features for `object`, which comes after the `earlier` ones and whose facets
/// are drawn `copies` times.
fn features(object: &PreparedObject, earlier: &[PreparedObject], copies: usize) -> Vec<Feature> {
    let parameters = &object.parameters;
    let feature = |name, is_in, why: &str, why_not: &str| Feature {
        name,
        is_in,
        why: if is_in { why } else { why_not }.to_string(),
    };
    let layers = &object.layers;
    let any_layer = |is_so: fn(&Object) -> bool| match layers.is_empty() {
        true => is_so(parameters),
        false => layers.iter().any(|layer| is_so(&layer.parameters)),
    };
    let is_planar = parameters.tier == TIER_PLANAR;
    let search = match parameters.search {
        SEARCH_RELIEF => "equal steps: technique = \"relief\"",
        SEARCH_PAPER => "the paper's: tier = \"paper\"",
        SEARCH_PRISMS => "from prism to prism: tier = \"accurate\"",
        _ => "steps that cannot skip the pattern",
    };
    let is_bent = !is_planar && parameters.search != SEARCH_PRISMS;
    let shared_map = earlier
        .iter()
        .find(|other| Arc::ptr_eq(&other.map, &object.map));
    let shared_mesh = earlier
        .iter()
        .find(|other| Arc::ptr_eq(&other.mesh, &object.mesh));
    let shared = |other: Option<&PreparedObject>| match other {
        Some(other) => format!("that of object {:?}", other.name),
        None => "no object before has the same".to_string(),
    };
    vec![
        feature("search", true, search, ""),
        feature(
            "rays bent along quadrics",
            is_bent,
            "the tier models curvature",
            if is_planar {
                "tier = \"planar\""
            } else {
                "prisms take their place"
            },
        ),
        feature(
            "prisms",
            object.has_prisms(),
            "tier = \"accurate\"",
            "the tier is not \"accurate\"",
        ),
        feature(
            "growth with depth",
            any_layer(grows),
            "bevel is not 0",
            "no bevel, no chamfer",
        ),
        feature(
            "profiles other than straight",
            any_layer(|parameters| parameters.profile != profile::STRAIGHT),
            "technique",
            "the technique has a straight profile",
        ),
        Feature {
            name: "layers",
            is_in: !layers.is_empty(),
            why: match layers.len() {
                0 => "no [[object.layer]]".to_string(),
                count => format!("{count} patterns, each read at each step"),
            },
        },
        feature(
            "self-shadows",
            parameters.self_shadow != 0,
            "self_shadow = true",
            "self_shadow = false",
        ),
        feature(
            "floor",
            parameters.cut_out == 0,
            "cut_out = false",
            "cut_out = true",
        ),
        feature(
            "map of floats or in the paper's form",
            parameters.map_format != FORMAT_CODES,
            "the shape file holds one",
            "codes of 8 or 16 bits",
        ),
        Feature {
            name: "instances",
            is_in: copies > 1,
            why: match copies {
                1 => "no other object differs by its place only".to_string(),
                _ => format!("{copies} objects share one preparation"),
            },
        },
        Feature {
            name: "shared shape map",
            is_in: shared_map.is_some(),
            why: shared(shared_map),
        },
        Feature {
            name: "shared mesh",
            is_in: shared_mesh.is_some(),
            why: shared(shared_mesh),
        },
    ]
}

impl fmt::Display for Explanation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for object in &self.objects {
            writeln!(formatter, "object {:?}", object.name)?;
            if let Some(plan) = &object.plan {
                explain_plan(plan, formatter)?;
            }
            for feature in &object.features {
                let place = if feature.is_in { "in " } else { "out" };
                writeln!(formatter, "  {place} {}: {}", feature.name, feature.why)?;
            }
            for (cost, module) in object.shaders.iter().zip(["exact", "fused", "fast"]) {
                writeln!(
                    formatter,
                    "  {module} shader {}: {} instructions; with everything, {}: {} ({})",
                    cost.entry_point,
                    cost.instructions,
                    cost.general,
                    cost.general_instructions,
                    share(cost.instructions as u64, cost.general_instructions as u64),
                )?;
                for compiled in &cost.compiled {
                    explain_compiled(compiled, formatter)?;
                }
            }
        }
        if let Some(lighting) = &self.lighting {
            writeln!(formatter, "materials and lights")?;
            for feature in &lighting.features {
                let place = if feature.is_in { "in " } else { "out" };
                writeln!(formatter, "  {place} {}: {}", feature.name, feature.why)?;
            }
            for (shader, [exact, fused, fast]) in &lighting.shaders {
                writeln!(
                    formatter,
                    "  shader {shader}, once a pixel: {exact} instructions exact, {fused} fused, {fast} fast"
                )?;
            }
        }
        for name in &self.outside {
            writeln!(
                formatter,
                "object {name:?}: out, not in the picture; its mesh and pattern are not prepared"
            )?;
        }
        let (needed, general) = (&self.memory, &self.general_memory);
        writeln!(formatter, "GPU memory, bytes; in brackets with everything")?;
        for (name, bytes, of) in [
            ("triangles", needed.triangles, general.triangles),
            ("prisms", needed.prisms, general.prisms),
            ("shape maps", needed.maps, general.maps),
            ("parameters", needed.parameters, general.parameters),
            ("outlines", needed.outlines, general.outlines),
            ("materials and lights", needed.lighting, general.lighting),
            ("pictures", needed.pictures, general.pictures),
        ] {
            writeln!(formatter, "  {name}: {bytes} ({of})")?;
        }
        let (scene, of) = (needed.scene(), general.scene());
        writeln!(
            formatter,
            "  without pictures: {scene} ({of}), {}",
            share(scene, of)
        )?;
        let (total, of) = (needed.total(), general.total());
        write!(
            formatter,
            "  together: {total} ({of}), {}",
            share(total, of)
        )
    }
}

fn explain_compiled(compiled: &Compiled<'_>, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
    let spilled = match compiled.spills() {
        true => format!(
            "{} + {} spilled",
            compiled.spilled_vgprs, compiled.spilled_sgprs
        ),
        false => "none spilled".to_string(),
    };
    writeln!(
        formatter,
        "    {}: {} + {} registers (vector + scalar), {spilled}; {} waves of 32 at once, {} instructions, {} cycles",
        compiled.generation,
        compiled.vgprs,
        compiled.sgprs,
        compiled.waves,
        compiled.instructions,
        compiled.latency,
    )
}

fn explain_plan(plan: &Plan, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
    writeln!(formatter, "  budget {plan}")?;
    for (tier, model) in [("planar", PLANAR), ("fast", FAST)] {
        writeln!(
            formatter,
            "  model: the {tier} tier is likely wrong by {:.2} px ({:.2} to {:.2})",
            model.predict(&plan.metrics),
            model.predict(&plan.metrics) * model.low,
            model.predict(&plan.metrics) * model.high,
        )?;
    }
    for (recipe, trial) in &plan.trials {
        match trial {
            Some(trial) => writeln!(
                formatter,
                "  tried {recipe}: worse than the budget on {:.2} % of {} rays, after at most {} steps",
                100.0 * trial.share_above,
                trial.rays,
                trial.steps,
            )?,
            None => writeln!(
                formatter,
                "  tried {recipe}: the map cannot hold the extrusion"
            )?,
        }
    }
    Ok(())
}

fn share(part: u64, whole: u64) -> String {
    format!("{:.0} %", 100.0 * part as f64 / whole.max(1) as f64)
}
