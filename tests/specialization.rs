//! What a scene does not need is left out, and nobody sees that in the picture.

use relievo::explain::explain;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Choice, EntryPoints, Extent, Memory, Pictures, Shaders};
use relievo::render::{GpuRenderer, Renderer};
use relievo::scene::{Scene, Tier};
use relievo::verify::matrix::for_each_variant;
use relievo_tests::{asset, every_adapter};

fn prepared(scene: &str, change: impl FnOnce(&mut Scene)) -> PreparedScene {
    let mut scene = Scene::load(&asset("scenes").join(scene)).unwrap();
    scene.size = [160, 120];
    change(&mut scene);
    prepare(&scene, &|_| ()).unwrap()
}

/// Every tier with every technique: words of colours and geometry.
#[test]
fn gpu_shaders_for_what_is_needed_draw_what_the_general_ones_draw() {
    let found = every_adapter().swap_remove(0);
    let mut scene = prepared("together.toml", |_| ());
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
    // Planar and fast, with each technique but relief mapping.
    assert_eq!(special, 2 * 6);
}

#[test]
fn a_planar_basic_shader_holds_half_the_instructions() {
    let scene = prepared("torus.toml", |scene| {
        for object in &mut scene.objects {
            object.tier = Tier::Planar;
            object.extrusion.bevel = 0.0;
        }
    });
    let explanation = explain(&scene).unwrap();
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

/// What is foreseen is what is made.
#[test]
fn gpu_memory_is_as_foreseen() {
    let found = every_adapter().swap_remove(0);
    for file in ["torus.toml", "torus_accurate.toml", "together.toml"] {
        let scene = prepared(file, |_| ());
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
    let scene = prepared("together.toml", |scene| {
        let mut again = scene.objects[0].clone();
        again.name = "again".to_string();
        scene.objects.push(again);
    });
    let explanation = explain(&scene).unwrap();
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
