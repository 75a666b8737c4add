//! Copies of an object: as objects of their own would look, in no more memory.

use relievo::oracle::{MeshOracle, Truth};
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Choice, Extent, Memory, Pictures, Shaders};
use relievo::render::{CpuRenderer, GpuRenderer, Hits, Renderer};
use relievo::scene::{Camera, Grid, Instance, Instances, Scene, SceneObject, Tier};
use relievo::verify::compare;
use relievo_tests::{asset, every_adapter};
use std::sync::Arc;

const COPIES: [Instance; 3] = [
    Instance {
        scale: 1.0,
        rotate: [0.0, 0.0, 0.0],
        translate: [-2.2, 0.0, 0.0],
    },
    Instance {
        scale: 1.6,
        rotate: [50.0, 20.0, -10.0],
        translate: [1.5, 0.3, -1.0],
    },
    Instance {
        scale: 0.4,
        rotate: [0.0, 0.0, 90.0],
        translate: [0.0, 0.5, 2.5],
    },
];

fn object(tier: Tier) -> SceneObject {
    let torus = SceneObject::new(asset("meshes/torus.obj"), asset("patterns/discs.png"));
    torus.tier(tier).repeat(12, 6).depth(0.1)
}

fn scene(objects: impl IntoIterator<Item = SceneObject>) -> PreparedScene {
    let camera = Camera::new([2.0, 4.0, 8.0], [0.0, 0.0, 0.0]);
    let empty = Scene::default().size(200, 150).camera(camera);
    let scene = objects.into_iter().fold(empty, Scene::object);
    prepare(&scene, &|_| ()).unwrap()
}

fn shared(tier: Tier) -> PreparedScene {
    scene([object(tier).instances(Instances::List(COPIES.into()))])
}

/// The copies as objects that share nothing.
fn apart(tier: Tier) -> PreparedScene {
    scene((0..).zip(COPIES).map(|(number, copy)| {
        object(tier)
            .depth(0.1 * copy.scale)
            .scale(copy.scale)
            .rotate(copy.rotate)
            .translate(copy.translate)
            // Of no effect on a mesh with normals.
            .crease_angle(60.0 + f64::from(number))
    }))
}

#[test]
fn copies_look_like_objects_of_their_own() {
    for tier in [Tier::Planar, Tier::Fast, Tier::Accurate] {
        let (shared, apart) = (shared(tier), apart(tier));
        assert!(
            shared
                .objects
                .iter()
                .all(|object| object.placement.is_some())
        );
        assert!(
            apart
                .objects
                .iter()
                .all(|object| object.placement.is_none())
        );
        let [a, b] = [&shared, &apart].map(|scene| {
            let mut renderer = CpuRenderer::new(scene);
            renderer.geometry(&scene.frame).unwrap()
        });
        let (mut hits, mut other) = (0, 0);
        for i in 0..a.place.len() {
            hits += usize::from(a.class(i) != 0);
            if a.class(i) != b.class(i) {
                other += 1;
                continue;
            }
            // At a wall a ray may hit the next one.
            let far = (a.t(i) - b.t(i)).abs() > 1e-4 * b.t(i);
            let turned = (0..3).any(|axis| (a.normal(i)[axis] - b.normal(i)[axis]).abs() > 0.02);
            other += usize::from(far || turned);
        }
        assert!(
            hits > 5_000 && other * 200 < hits,
            "{tier:?}: {other} of {hits}"
        );
    }
}

#[test]
fn each_pixel_knows_its_copy() {
    let scene = shared(Tier::Fast);
    let words = CpuRenderer::new(&scene).geometry(&scene.frame).unwrap();
    let hits = Hits::new(&scene, &scene.frame, &words);
    let (mut seen, mut astray) = ([0; COPIES.len()], 0);
    for hit in hits.pixels().flatten() {
        let object = hit.prepared().unwrap();
        seen[object.instance] += 1;
        assert_eq!(object.number, 0);
        // On the torus of this copy, or carved into it.
        let own = object.transform.to_object(hit.position());
        let around = own.x.hypot(own.z) - 1.0;
        let depth = 0.4 - around.hypot(own.y);
        // Where the fast tier looks along the surface it is not always sure how far it sees.
        astray += usize::from(!(-0.02..0.12).contains(&depth));
    }
    assert!(seen.iter().all(|pixels| *pixels > 300), "{seen:?}");
    assert!(astray * 200 < seen.iter().sum(), "{astray} of {seen:?}");
}

/// Copies are drawn at once where they follow each other: here they do, do not, are alone, and lie
/// outside the picture. In the fast tier the tori ask for their exits.
#[test]
fn copies_have_the_same_words_on_gpu_and_cpu() {
    let grid = |count, spacing| Instances::Grid(Grid { count, spacing });
    for tier in [Tier::Planar, Tier::Fast, Tier::Accurate] {
        let tori = || object(tier).scale(0.3);
        let scene = scene([
            tori().instances(grid([40, 1, 12], [0.9, 1.0, 0.9])),
            object(tier).scale(0.5).translate([0.0, 1.0, 0.0]),
            tori().instances(grid([3, 3, 3], [0.8; 3])),
            tori().depth(0.05).instances(Instances::List(COPIES.into())),
        ]);
        let mut cpu = CpuRenderer::new(&scene);
        let color = cpu.color(&scene.frame).unwrap();
        let geometry = cpu.geometry(&scene.frame).unwrap();
        for adapter in every_adapter()
            .iter()
            .filter(|adapter| adapter.takes_spirv())
        {
            let choice = Choice::These(Shaders::Exact);
            let mut gpu = GpuRenderer::new(&scene, adapter, choice).unwrap();
            let own_color = gpu.color(&scene.frame).unwrap();
            let own_geometry = gpu.geometry(&scene.frame).unwrap();
            let agreement = compare([&own_color, &color], [&own_geometry, &geometry]);
            assert!(
                agreement.is_exact(),
                "{tier:?}, {}: {agreement:?}",
                adapter.describe()
            );
        }
    }
}

#[test]
fn the_oracle_knows_copies() {
    let scene = shared(Tier::Accurate);
    let words = CpuRenderer::new(&scene).geometry(&scene.frame).unwrap();
    let truth = Truth::of(
        &MeshOracle::new(&scene),
        scene.camera.eye.into(),
        &scene.frame,
    );
    let accuracy = truth.compare(&words);
    assert!(accuracy.silhouette_iou > 0.999, "{accuracy:?}");
}

#[test]
fn copies_share_memory() {
    let memory = |scene: &PreparedScene| Memory::of(scene, Extent::Needed, Pictures::Color);
    let grid = |count| {
        Instances::Grid(Grid {
            count,
            spacing: [3.0; 3],
        })
    };
    let one = memory(&scene([object(Tier::Accurate).instances(grid([1, 1, 1]))]));
    let prepared = scene([object(Tier::Accurate).instances(grid([20, 1, 20]))]);
    let many = memory(&prepared);
    assert_eq!(prepared.objects.len(), 400);
    assert_eq!((many.prisms, many.maps), (one.prisms, one.maps));
    // A frame each, with room beyond the last one, and outlines.
    assert!(many.parameters - one.parameters < 400 * 512);
    assert!(many.outlines < 25 << 20);
    let first = &prepared.objects[0];
    for object in &prepared.objects {
        assert!(Arc::ptr_eq(&object.triangles, &first.triangles));
        assert!(Arc::ptr_eq(&object.prisms, &first.prisms));
        assert!(Arc::ptr_eq(&object.mesh, &first.mesh));
    }
}

/// 100,000 copies: most of them smaller than a pixel, many behind the eye.
#[test]
fn a_hundred_thousand_copies_are_drawn() {
    let copies = Instances::Grid(Grid {
        count: [100, 10, 100],
        spacing: [0.7, 3.0, 0.7],
    });
    let square = SceneObject::new(asset("meshes/plane.obj"), asset("patterns/discs.png"));
    let object = square.depth(0.02).scale(0.3).instances(copies);
    let scene = scene([object]);
    assert_eq!(scene.objects.len(), 100_000);
    let colors = CpuRenderer::new(&scene).color(&scene.frame).unwrap();
    let hits = colors.words.iter().filter(|word| word[3] != 0).count();
    assert!(hits > 5_000, "{hits}");
}
