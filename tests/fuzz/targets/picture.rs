//! Pictures of scenes: any accepted scene gives a small picture of finite
//! colours or an error. Meshes and patterns are this project's.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::budget::plan_view;
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Scene, Shape};
use std::path::Path;

/// Maximum search steps; more only take longer.
const STEPS: u32 = 256;

fuzz_target!(|text: &str| {
    let Ok(mut scene) = Scene::parse(text, Path::new("scene.toml")) else {
        return;
    };
    scene.size = [8, 6];
    scene.objects.truncate(2);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for object in &mut scene.objects {
        let is_curved = object.mesh.to_string().len() % 2 == 0;
        let mesh = if is_curved { "cylinder" } else { "plane" };
        object.mesh = root
            .join("../../assets/meshes")
            .join(mesh)
            .with_extension("obj")
            .into();
        object.shape = Shape::File(root.join("seeds/pattern/gray.png"));
        object.raster = None;
        object.steps = object.steps.min(STEPS);
        // Trials would take most of the time.
        object.budget = None;
    }
    match plan_view(&scene, &|_| ()) {
        Ok(planned) => {
            let prepared = planned.scene;
            let frame = prepared.frame_with_samples(prepared.supersampling);
            let words = CpuRenderer::new(&prepared).color(&frame).unwrap();
            for pixel in &words.words {
                let color = [pixel[0], pixel[1], pixel[2]].map(f32::from_bits);
                assert!(color.iter().all(|channel| channel.is_finite()), "{color:?}");
                assert!(pixel[3] <= 4, "there is no class {}", pixel[3]);
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
