//! The oracle of arbitrary meshes: the accurate tier's prisms in f64, which
//! separates errors of f32 arithmetic from errors of the model (O2 of section 7).

use super::prism_search::{HulledPrism, Opening, search};
use super::wide::{wide_object, wide_prism};
use super::{Oracle, Sample};
use crate::hierarchy;
use crate::prepare::{Placement, PreparedScene};
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ray::Ray;
use relievo_shared::normals::{CLASS_BEVEL, CLASS_CAP, CLASS_MISS, CLASS_WALL};
use relievo_shared_f64::layers;
use relievo_shared_f64::layout::{NO_NEIGHBOUR, Object, PrismData, Slab};
use relievo_shared_f64::normals::class_of;
use relievo_shared_f64::profile::{LAYERED, Profile};
use relievo_shared_f64::shape_map::ShapeMap;
use relievo_shared_f64::stack::Stacked;

/// Maximum steps and bisections of a search: more than any search needs.
const LINEAR_STEPS: u32 = 100_000;
const BINARY_STEPS: u32 = 60;

/// Maximum number of prisms that a ray is followed back through.
const MOST_CROSSED: u32 = 1000;

/// Maximum number of times that a ray from below comes into the same prism.
const MOST_RETURNS: u32 = 16;

/// All prisms of a scene.
pub struct MeshOracle<'a> {
    prisms: Vec<ScenePrism>,
    objects: Vec<SceneObject<'a>>,
    hierarchy: Hierarchy,
    /// The scene's origin, world units.
    origin: DVec3,
}

struct ScenePrism {
    prism: HulledPrism,
    object: usize,
}

struct SceneObject<'a> {
    /// Number of the object's first prism in the scene.
    first: usize,
    parameters: Object,
    profile: Profile,
    map: ShapeMap,
    texels: &'a [u32],
}

/// The hit of a ray, and the work to find it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrismSample {
    /// The nearest hit.
    pub sample: Sample,
    /// Number of prisms searched.
    pub prisms: u32,
    /// Total steps of all searches.
    pub steps: u32,
    /// Number of prisms in which the ray was lost because they fold.
    pub lost: u32,
}

impl<'a> MeshOracle<'a> {
    /// Builds the prisms of all triangles of `scene`. Renderings to compare must
    /// have the same depth and pattern.
    pub fn new(scene: &'a PreparedScene) -> MeshOracle<'a> {
        let mut prisms = Vec::with_capacity(scene.triangle_count());
        let mut objects = Vec::with_capacity(scene.objects.len());
        for (index, object) in scene.objects.iter().enumerate() {
            let parameters = wide_object(&object.parameters);
            let placement = object.placement.unwrap_or_default();
            let depth = placement.scale * parameters.depth;
            let first = prisms.len();
            let all = object.all_prisms(scene.origin);
            prisms.extend(all.iter().map(|data| {
                let prism = placed(&wide_prism(data), &placement);
                ScenePrism {
                    prism: HulledPrism::new(&prism, depth),
                    object: index,
                }
            }));
            objects.push(SceneObject {
                first,
                profile: Profile::new(&parameters),
                map: ShapeMap::new(&parameters),
                texels: object.map.words(),
                parameters,
            });
        }
        let boxes = prisms.iter().map(|prism| prism.prism.bounds());
        MeshOracle {
            hierarchy: Hierarchy::new(boxes),
            prisms,
            objects,
            origin: scene.origin,
        }
    }

    /// Returns the first hit of the ray from `eye` (world units) along the unit
    /// vector `direction`, with the work to find it.
    pub fn sample(&self, eye: DVec3, direction: DVec3) -> PrismSample {
        let eye = eye - self.origin;
        let mut found = PrismSample {
            sample: Sample::MISS,
            prisms: 0,
            steps: 0,
            lost: 0,
        };
        for (enter, leaf) in self.entered(eye, direction) {
            if found.sample.is_hit() && enter > found.sample.t {
                break;
            }
            let ScenePrism { prism, object } = &self.prisms[leaf];
            let object = &self.objects[*object];
            let is_stack = object.parameters.profile == LAYERED;
            let mut from = 0.0;
            for _ in 0..MOST_RETURNS {
                let hit = search(
                    prism,
                    &object.profile,
                    &object.map,
                    object.texels,
                    is_stack,
                    eye + direction * from,
                    direction,
                    LINEAR_STEPS,
                    BINARY_STEPS,
                );
                found.prisms += 1;
                found.steps += hit.march.steps;
                found.lost += u32::from(hit.lost);
                // The oracle does not distinguish bevels from walls: no distance is needed.
                let class = if is_stack {
                    layers::class_of(&hit.march, &object.parameters, &Stacked(object.texels)).0
                } else {
                    class_of(&hit.march, &object.parameters, || 0.0)
                };
                let class = match class {
                    CLASS_BEVEL => CLASS_WALL,
                    class => class,
                };
                let t = from + hit.march.s;
                if class == CLASS_MISS || (found.sample.is_hit() && t >= found.sample.t) {
                    break;
                }
                if class == CLASS_CAP || !self.is_from_below(leaf, eye, direction, t) {
                    found.sample = Sample { class, t };
                    break;
                }
                // The ray may come back into this prism, through the cap.
                from = prism.beyond(eye, direction, t);
            }
        }
        found
    }

    /// Returns the distances at which the ray enters the hulls of prisms, ascending, with the
    /// numbers of these prisms.
    fn entered(&self, eye: DVec3, direction: DVec3) -> Vec<(f64, usize)> {
        let mut entered = Vec::new();
        self.hierarchy.for_each(eye, direction, |leaf| {
            let (enter, leave) = self.prisms[leaf].prism.range(eye, direction);
            if enter < leave {
                entered.push((enter, leaf));
            }
        });
        entered.sort_by(|a, b| a.0.total_cmp(&b.0));
        entered
    }

    /// Returns whether the ray, which is in prism `leaf` at the distance `t`, came into the
    /// shell from below: through a floor, which has no back.
    fn is_from_below(&self, leaf: usize, eye: DVec3, direction: DVec3, t: f64) -> bool {
        let (mut leaf, mut t) = (leaf, t);
        for _ in 0..MOST_CROSSED {
            let ScenePrism { prism, object } = &self.prisms[leaf];
            match prism.opening(eye, direction, t) {
                (Opening::Floor, _) => return true,
                (Opening::Side(link), before) if link != NO_NEIGHBOUR => {
                    leaf = self.objects[*object].first + (link >> 2) as usize;
                    t = before;
                }
                _ => return false,
            }
        }
        false
    }
}

/// Returns `prism` in world space.
fn placed(prism: &PrismData, placement: &Placement) -> PrismData {
    let Placement {
        scale, rotation, ..
    } = *placement;
    let turned = |v: [f64; 3]| (rotation * DVec3::from(v)).to_array();
    let scaled = |v: [f64; 3]| (rotation * (scale * DVec3::from(v))).to_array();
    PrismData {
        anchor: placement.point(prism.anchor.into()).to_array(),
        surface: prism.surface.map(scaled),
        normal: prism.normal.map(turned),
        corner_normals: prism.corner_normals.map(turned),
        facet: turned(prism.facet),
        least_determinant: prism.least_determinant * scale.powi(3),
        slabs: prism.slabs.map(|slab| Slab {
            axis: (rotation * DVec3::from(slab.axis) / scale).to_array(),
            ..slab
        }),
        centre: scaled(prism.centre),
        radius: prism.radius * scale,
        inverse_altitude: prism.inverse_altitude / scale,
        ..*prism
    }
}

impl Oracle for MeshOracle<'_> {
    fn trace(&self, eye: DVec3, direction: DVec3) -> Sample {
        self.sample(eye, direction).sample
    }
}

/// A bounding volume hierarchy in f32, with slightly widened boxes.
struct Hierarchy(Bvh2);

impl Hierarchy {
    fn new(boxes: impl Iterator<Item = (DVec3, DVec3)>) -> Hierarchy {
        let boxes: Vec<Aabb> = boxes
            .map(|(low, high)| {
                let (low, high): (Vec3, Vec3) = (low.as_vec3(), high.as_vec3());
                let largest = low.abs().max(high.abs()).max_element();
                let margin = Vec3::splat(1e-5 * largest) + 1e-4 * (high - low);
                Aabb::new((low - margin).into(), (high + margin).into())
            })
            .collect();
        Hierarchy(hierarchy::build(&boxes))
    }

    /// Calls `visit` with the index of each box that the ray may hit.
    fn for_each(&self, eye: DVec3, direction: DVec3, mut visit: impl FnMut(usize)) {
        let ray = Ray::new_inf(Vec3A::from(eye.as_vec3()), Vec3A::from(direction.as_vec3()));
        self.0.ray_traverse_anyhit(ray, |_, leaf| {
            visit(self.0.primitive_indices[leaf] as usize);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{Accuracy, AnalyticOracle, Truth};
    use crate::prepare::prepare;
    use crate::render::{CpuRenderer, Renderer};
    use crate::scene::Scene;
    use std::path::Path;

    /// A scene of one mesh of the assets, carved with discs.
    fn scene(mesh: &str, tier: &str, repeat: [u32; 2], eye: [f64; 3], size: [u32; 2]) -> Scene {
        let text = format!(
            "[image]\nsize = {size:?}\n[camera]\neye = {eye:?}\nfov = 38.0\n[[object]]\nmesh = \"../meshes/{mesh}.obj\"\nshape = \"../patterns/discs.png\"\nrepeat = {repeat:?}\ndepth = 0.08\ntier = \"{tier}\"\n"
        );
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/test.toml");
        Scene::parse(&text, &folder).unwrap()
    }

    /// Compares the CPU's picture of `scene` with `truth`.
    fn compare(scene: &PreparedScene, truth: &Truth) -> Accuracy {
        let words = CpuRenderer::new(scene).geometry(&scene.frame).unwrap();
        truth.compare(&words)
    }

    /// A mesh, its repeats, the eye, and the least IoU against its closed form.
    type Case = (&'static str, [u32; 2], [f64; 3], f64);
    const CASES: [Case; 3] = [
        ("torus", [24, 10], [0.0, 2.3, 3.4], 0.998),
        ("sphere", [16, 8], [0.6, 0.9, 3.4], 0.998),
        ("cylinder", [16, 8], [3.4, 0.0, 3.4], 0.9995),
    ];

    /// The two oracles and the accurate tier agree; the fast tier is worse.
    #[test]
    fn prisms_agree_with_closed_forms_and_with_the_accurate_tier() {
        for (mesh, repeat, eye, least) in CASES {
            let accurate = scene(mesh, "accurate", repeat, eye, [240, 180]);
            let prepared = prepare(&accurate, &|_| ()).unwrap();
            let eye = DVec3::from(prepared.camera.eye);
            let analytic =
                AnalyticOracle::find(&accurate.objects[0], &prepared.objects[0]).unwrap();
            let analytic = Truth::of(&analytic, eye, &prepared.frame);
            let prisms = Truth::of(&MeshOracle::new(&prepared), eye, &prepared.frame);

            let against_analytic = compare(&prepared, &analytic);
            let against_prisms = compare(&prepared, &prisms);
            println!("{mesh}: {against_analytic:?}\n    {against_prisms:?}");
            assert!(
                against_analytic.silhouette_iou >= least,
                "{against_analytic:?}"
            );
            assert!(against_analytic.class_errors < 0.02, "{against_analytic:?}");
            assert!(against_prisms.silhouette_iou > 0.9999, "{against_prisms:?}");
            assert_eq!(against_prisms.interior_holes, 0, "{against_prisms:?}");

            let fast = scene(mesh, "fast", repeat, eye.to_array(), [240, 180]);
            let prepared = prepare(&fast, &|_| ()).unwrap();
            let fast = compare(&prepared, &analytic);
            assert!(fast.silhouette_iou < least, "{fast:?}");
            assert!(
                fast.class_errors > against_analytic.class_errors,
                "{fast:?}"
            );
        }
    }
}
