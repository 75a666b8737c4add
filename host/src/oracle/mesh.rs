//! The oracle of arbitrary meshes: the accurate tier's prisms in f64, which
//! tells errors of f32 arithmetic from errors of the model (O2 of section 7).

use super::wide::{wide_object, wide_triangle};
use super::{Oracle, Sample};
use crate::prepare::PreparedScene;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::Ray;
use relievo_shared::normals::{CLASS_BEVEL, CLASS_MISS, CLASS_WALL};
use relievo_shared_f64::layout::Object;
use relievo_shared_f64::normals::class_of;
use relievo_shared_f64::prism::{Prism, search};
use relievo_shared_f64::profile::Profile;
use relievo_shared_f64::shape_map::ShapeMap;
use std::time::Duration;

/// Steps of one search, and bisections after it: more than any search needs.
const LINEAR_STEPS: u32 = 100_000;
const BINARY_STEPS: u32 = 60;

/// All prisms of a scene, and what each ray meets in them.
pub struct MeshOracle<'a> {
    prisms: Vec<ScenePrism>,
    objects: Vec<SceneObject<'a>>,
    hierarchy: Hierarchy,
    /// The scene's origin, world units.
    origin: DVec3,
}

struct ScenePrism {
    prism: Prism,
    object: usize,
}

struct SceneObject<'a> {
    parameters: Object,
    profile: Profile,
    map: ShapeMap,
    texels: &'a [u32],
}

/// What a ray meets, and what it took to find it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrismSample {
    /// The nearest hit.
    pub sample: Sample,
    /// Prisms searched.
    pub prisms: u32,
    /// Steps of all searches together.
    pub steps: u32,
    /// Prisms in which the ray could not be followed, since they are folded.
    pub lost: u32,
}

impl<'a> MeshOracle<'a> {
    /// Builds the prisms of all triangles of `scene`, which must not be drawn
    /// with another depth or pattern.
    pub fn new(scene: &'a PreparedScene) -> MeshOracle<'a> {
        let mut prisms = Vec::with_capacity(scene.triangle_count());
        let mut objects = Vec::with_capacity(scene.objects.len());
        for (index, object) in scene.objects.iter().enumerate() {
            let parameters = wide_object(&object.parameters);
            prisms.extend(object.triangles.iter().map(|triangle| ScenePrism {
                prism: Prism::new(&wide_triangle(triangle), parameters.depth),
                object: index,
            }));
            objects.push(SceneObject {
                profile: Profile::new(&parameters),
                map: ShapeMap::new(&parameters),
                texels: object.map.words(),
                parameters,
            });
        }
        let boxes = prisms.iter().map(|ScenePrism { prism, .. }| {
            let (low, high) = prism.bounds();
            (prism.anchor + low, prism.anchor + high)
        });
        MeshOracle {
            hierarchy: Hierarchy::new(boxes),
            prisms,
            objects,
            origin: scene.origin,
        }
    }

    /// The first hit on the ray from `eye` (world units) along the unit vector
    /// `direction`, with the effort.
    pub fn sample(&self, eye: DVec3, direction: DVec3) -> PrismSample {
        let eye = eye - self.origin;
        let mut found = PrismSample {
            sample: Sample::MISS,
            prisms: 0,
            steps: 0,
            lost: 0,
        };
        self.hierarchy.for_each(eye, direction, |leaf| {
            let ScenePrism { prism, object } = &self.prisms[leaf];
            let object = &self.objects[*object];
            let hit = search(
                prism,
                &object.profile,
                &object.map,
                object.texels,
                eye,
                direction,
                LINEAR_STEPS,
                BINARY_STEPS,
            );
            found.prisms += 1;
            found.steps += hit.march.steps;
            found.lost += u32::from(hit.lost);
            let class = match class_of(&hit.march, &object.parameters) {
                CLASS_BEVEL => CLASS_WALL,
                class => class,
            };
            let t = hit.march.s;
            if class != CLASS_MISS && (!found.sample.is_hit() || t < found.sample.t) {
                found.sample = Sample { class, t };
            }
        });
        found
    }
}

impl Oracle for MeshOracle<'_> {
    fn trace(&self, eye: DVec3, direction: DVec3) -> Sample {
        self.sample(eye, direction).sample
    }
}

/// A bounding volume hierarchy, in f32 with boxes a little wider than given.
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
        Hierarchy(build_bvh2(
            &boxes,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        ))
    }

    /// Calls `visit` with the number of each box that the ray may meet.
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
    use crate::oracle::{AnalyticOracle, Truth};
    use crate::prepare::prepare;
    use crate::render::{CpuRenderer, GeometryWords, Renderer};
    use crate::scene::Scene;
    use rayon::prelude::*;
    use relievo_shared as single;
    use std::path::Path;
    use std::time::Instant;

    /// A scene of one mesh of the assets, carved with discs.
    fn scene(mesh: &str, repeat: [u32; 2], eye: [f64; 3], size: [u32; 2]) -> Scene {
        let text = format!(
            "[image]\nsize = {size:?}\n[camera]\neye = {eye:?}\nfov = 38.0\n[[object]]\nmesh = \"../meshes/{mesh}.obj\"\nshape = \"../patterns/discs.png\"\nrepeat = {repeat:?}\ndepth = 0.08\n"
        );
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/test.toml");
        Scene::parse(&text, &folder).unwrap()
    }

    /// Each pixel's sample, and the sums of the efforts.
    fn render(
        scene: &PreparedScene,
        name: &str,
        trace: impl Fn(DVec3, DVec3) -> PrismSample + Sync,
    ) -> GeometryWords {
        let start = Instant::now();
        let frame = &scene.frame;
        let [width, height] = scene.size.map(|side| side as usize);
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let samples: Vec<PrismSample> = (0..width * height)
            .into_par_iter()
            .map(|i| {
                let raw = wide(frame.ray_first)
                    + wide(frame.ray_right) * (i % width) as f64
                    + wide(frame.ray_down) * (i / width) as f64;
                trace(DVec3::from(scene.camera.eye), raw.normalize())
            })
            .collect();
        let sum =
            |of: fn(&PrismSample) -> u32| samples.iter().map(|s| u64::from(of(s))).sum::<u64>();
        let prisms = sum(|s| s.prisms);
        let hits = samples.iter().filter(|s| s.sample.is_hit()).count();
        println!(
            "{name}: {:.2?}, {:.1} prisms a hit pixel, {:.2} steps a prism, {} lost",
            start.elapsed(),
            prisms as f64 / hits as f64,
            sum(|s| s.steps) as f64 / prisms as f64,
            sum(|s| s.lost),
        );
        GeometryWords {
            width: scene.size[0],
            height: scene.size[1],
            place: samples
                .iter()
                .map(|s| [(s.sample.t as f32).to_bits(), 0, 0, 0])
                .collect(),
            surface: samples.iter().map(|s| [s.sample.class, 0, 0, 0]).collect(),
        }
    }

    /// The same prisms in f32, as a renderer would search them.
    fn narrow_sample(
        scene: &PreparedScene,
        oracle: &MeshOracle<'_>,
        eye: DVec3,
        direction: DVec3,
    ) -> PrismSample {
        let mut found = PrismSample {
            sample: Sample::MISS,
            prisms: 0,
            steps: 0,
            lost: 0,
        };
        let eye = eye - oracle.origin;
        let object = &scene.objects[0];
        let parameters = &object.parameters;
        oracle.hierarchy.for_each(eye, direction, |leaf| {
            let prism = single::prism::Prism::new(&object.triangles[leaf], parameters.depth);
            let hit = single::prism::search(
                &prism,
                &single::profile::Profile::new(parameters),
                &single::shape_map::ShapeMap::new(parameters),
                object.map.words(),
                eye.as_vec3(),
                direction.as_vec3(),
                256,
                20,
            );
            found.prisms += 1;
            found.steps += hit.march.steps;
            found.lost += u32::from(hit.lost);
            let class = single::normals::class_of(&hit.march, parameters);
            let t = f64::from(hit.march.s);
            if class != CLASS_MISS && (!found.sample.is_hit() || t < found.sample.t) {
                found.sample = Sample { class, t };
            }
        });
        found
    }

    /// A mesh, its repeats, the eye, and the least IoU and the most interior
    /// holes there, as measured. One was looked into: a column missed by 0.88
    /// texel, likely since texture coordinates are linear in a triangle and
    /// not on the torus. Those of the sphere lie near its pole.
    type View = (&'static str, [u32; 2], [f64; 3], f64, usize);
    const VIEWS: [View; 3] = [
        ("torus", [24, 10], [0.0, 2.3, 3.4], 0.998, 2),
        ("sphere", [16, 8], [0.6, 0.9, 3.4], 0.998, 9),
        ("cylinder", [16, 8], [3.4, 0.0, 3.4], 0.9995, 0),
    ];

    fn prisms_agree(size: [u32; 2]) {
        for (mesh, repeat, eye, least, most) in VIEWS {
            let scene = scene(mesh, repeat, eye, size);
            let prepared = prepare(&scene, &|_| ()).unwrap();
            let analytic = AnalyticOracle::find(&scene.objects[0], &prepared.objects[0]).unwrap();
            let truth = Truth::of(&analytic, DVec3::from(prepared.camera.eye), &prepared.frame);
            let oracle = MeshOracle::new(&prepared);
            let judge = |name: &str, trace: &(dyn Fn(DVec3, DVec3) -> PrismSample + Sync)| {
                let accuracy = truth.judge(&render(&prepared, name, trace));
                println!("    {accuracy:?}");
                accuracy
            };
            let double = judge(&format!("{mesh} f64"), &|eye, direction| {
                oracle.sample(eye, direction)
            });
            let single = judge(&format!("{mesh} f32"), &|eye, direction| {
                narrow_sample(&prepared, &oracle, eye, direction)
            });
            for accuracy in [double, single] {
                assert!(accuracy.silhouette_iou >= least, "{mesh} {accuracy:?}");
                assert!(accuracy.interior_holes <= most, "{mesh} {accuracy:?}");
                // Where the truth is the floor, a hole would be a leak.
                assert_eq!(accuracy.confusion[3][0], 0, "{mesh} {accuracy:?}");
                assert!(accuracy.class_errors < 0.02, "{mesh} {accuracy:?}");
            }
            assert!((double.silhouette_iou - single.silhouette_iou).abs() < 1e-4);
            assert!(single.interior_holes <= double.interior_holes);

            // The fast tier is worse by both counts.
            let mut fast = CpuRenderer::new(&prepared);
            let fast = truth.judge(&fast.geometry(&prepared.frame).unwrap());
            assert!(fast.silhouette_iou < least, "{fast:?}");
            assert!(fast.class_errors > double.class_errors, "{fast:?}");
        }
    }

    #[test]
    fn prisms_agree_with_closed_forms_and_f32_with_f64() {
        prisms_agree([240, 180]);
    }

    #[test]
    #[ignore = "the figures of section 6, for --nocapture"]
    fn prisms_agree_in_a_larger_picture() {
        prisms_agree([480, 360]);
    }
}
