//! Leaving out what a scene does not need does not change the picture.

use relievo::budget::{PlannedScene, Promise, plan};
use relievo::explain::explain;
use relievo::prepare::{PreparedScene, prepare, prepare_view};
use relievo::render::gpu::{Choice, EntryPoints, Extent, Memory, Pictures, Shaders};
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use relievo::scene::{Scene, Tier};
use relievo::verify::matrix::for_each_variant;
use relievo_tests::{asset, every_adapter};

fn planned(scene: &str, change: impl FnOnce(&mut Scene)) -> PlannedScene {
    let mut scene = Scene::load(&asset("scenes").join(scene)).unwrap();
    scene.size = [160, 120];
    change(&mut scene);
    plan(&scene, &|_| ()).unwrap()
}

/// Every tier with every technique: words of colours and geometry.
#[test]
fn gpu_shaders_for_what_is_needed_draw_what_the_general_ones_draw() {
    let found = every_adapter().swap_remove(0);
    let mut scene = planned("together.toml", |_| ()).scene;
    let mut special = 0;
    for_each_variant(&mut scene, |scene, name| {
        let differ = scene.objects.iter().any(|object| {
            EntryPoints::of(&object.parameters, Extent::Needed)
                != EntryPoints::of(&object.parameters, Extent::Everything)
        });
        if !differ {
            return Ok(());
        }
        special += 1;
        let pictures = [Extent::Needed, Extent::Everything].map(|extent| {
            let choice = Choice::These(Shaders::Exact);
            let mut gpu = GpuRenderer::with_extent(scene, &found, choice, extent).unwrap();
            let color = gpu.color(&scene.frame).unwrap();
            (color, gpu.geometry(&scene.frame).unwrap())
        });
        assert!(pictures[0] == pictures[1], "{name}");
        Ok::<(), ()>(())
    })
    .unwrap();
    // Planar, fast and accurate, with each straight technique but relief mapping.
    assert_eq!(special, 3 * 6);
}

#[test]
fn a_planar_basic_shader_holds_half_the_instructions() {
    let PlannedScene { scene, plans } = planned("torus.toml", |scene| {
        for object in &mut scene.objects {
            object.tier = Tier::Planar;
            object.extrusion.bevel = 0.0;
        }
    });
    let explanation = explain(&scene, &plans).unwrap();
    for shader in &explanation.objects[0].shaders {
        assert_eq!(shader.entry_point, "color_planar");
        assert_eq!(shader.general, "color_extrusion");
        assert!(shader.instructions > 500, "{shader:?}");
        assert!(
            2 * shader.instructions <= shader.general_instructions,
            "{shader:?}"
        );
    }
}

/// A budget shrinks the map, and unused data is not stored.
#[test]
fn a_planar_basic_scene_takes_half_the_memory() {
    let PlannedScene { scene, plans } = planned("plane.toml", |scene| {
        for object in &mut scene.objects {
            object.extrusion.bevel = 0.0;
        }
        // The plane's border, which has no cut sides in this tier, is left out.
        scene.field_of_view = 15.0;
        scene.set_budget(Some(2.0));
    });
    let explanation = explain(&scene, &plans).unwrap();
    let plan = explanation.objects[0].plan.as_ref().unwrap();
    assert_eq!(
        (plan.recipe.tier, &plan.promise),
        (Tier::Planar, &Promise::Kept)
    );
    let (needed, general) = (explanation.memory, explanation.general_memory);
    // No quadrics, no frames: 172 bytes of the 248 of a triangle.
    assert!(needed.triangles > 0 && needed.prisms == 0);
    assert_eq!(248 * needed.triangles, 172 * general.triangles);
    assert!(
        2 * needed.scene() <= general.scene(),
        "{needed:?} {general:?}"
    );
}

/// Objects outside the picture are not prepared, which does not change it.
#[test]
fn what_is_not_in_the_picture_is_not_prepared() {
    let mut scene = Scene::load(&asset("scenes/together.toml")).unwrap();
    scene.size = [160, 120];
    let camera = scene.camera.as_mut().unwrap();
    camera.target = [0.15, 0.85, 0.05];
    let frame_words = |prepared: &PreparedScene| {
        let mut cpu = CpuRenderer::new(prepared);
        (
            cpu.color(&prepared.frame).unwrap(),
            prepared.outside.clone(),
        )
    };
    // Only the ball, through a telephoto lens from above the ring.
    camera.eye = [0.15, 20.0, 0.15];
    scene.field_of_view = 0.5;
    let mut far = scene.objects[2].clone();
    far.name = "far".to_string();
    far.translate = [30.0, 0.0, 0.0];
    scene.objects.push(far);
    let (whole, all_in) = frame_words(&prepare(&scene, &|_| ()).unwrap());
    let (view, outside) = frame_words(&prepare_view(&scene, &|_| ()).unwrap());
    assert!(all_in.is_empty());
    assert_eq!(outside, ["far"]);
    assert!(whole == view);

    // Everything is behind the eye.
    let camera = scene.camera.as_mut().unwrap();
    camera.target = [0.15, 40.0, 0.05];
    camera.up = [0.0, 0.0, 1.0];
    let nothing = prepare_view(&scene, &|_| ()).unwrap();
    assert!(nothing.objects.is_empty() && nothing.outside.len() == 4);
    assert!(frame_words(&nothing).0 == frame_words(&prepare(&scene, &|_| ()).unwrap()).0);
    assert!(
        explain(&nothing, &[])
            .unwrap()
            .to_string()
            .contains("not in the picture")
    );
}

/// The memory estimate is exact.
#[test]
fn gpu_memory_is_as_foreseen() {
    let found = every_adapter().swap_remove(0);
    for file in ["torus.toml", "torus_accurate.toml", "together.toml"] {
        let scene = planned(file, |_| ()).scene;
        let mut gpu = GpuRenderer::new(&scene, &found, Choice::Trusted).unwrap();
        let frame = scene.frame_with_samples(scene.supersampling);
        gpu.color(&frame).unwrap();
        let foreseen = Memory::of(&scene, Extent::Needed, Pictures::Color);
        assert_eq!(gpu.bytes(), foreseen.total(), "{file}: {foreseen:?}");
        gpu.geometry(&frame).unwrap();
        let foreseen = Memory::of(&scene, Extent::Needed, Pictures::ColorAndGeometry);
        assert_eq!(gpu.bytes(), foreseen.total(), "{file}: {foreseen:?}");
    }
}

#[test]
fn the_reasons_name_keys_and_shared_assets() {
    let PlannedScene { scene, plans } = planned("together.toml", |scene| {
        let mut again = scene.objects[0].clone();
        again.name = "again".to_string();
        scene.objects.push(again);
    });
    let explanation = explain(&scene, &plans).unwrap();
    let again = explanation.objects.last().unwrap();
    for name in ["shared shape map", "shared mesh"] {
        let feature = again.features.iter().find(|f| f.name == name).unwrap();
        assert!(feature.is_in && feature.why.contains(&scene.objects[0].name));
    }
    let text = explanation.to_string();
    assert!(text.contains("together: "), "{text}");
    let memory = explanation.memory;
    assert!(memory.prisms == 0 && memory.triangles > 0);
    assert!(memory.total() < explanation.general_memory.total());
}
