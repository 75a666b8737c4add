//! Uses Relievo as a library: loads a scene, changes it, draws it and saves the picture.
//!
//! `cargo run --release -p relievo --example library -- assets/scenes/torus.toml OUT.png [cpu]`

use relievo::picture::Picture;
use relievo::prepare::prepare;
use relievo::render::gpu::{Choice, choose};
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use relievo::scene::Scene;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (scene, output, on_cpu) = match arguments.as_slice() {
        [scene, output] => (scene, output, false),
        [scene, output, cpu] if cpu == "cpu" => (scene, output, true),
        _ => return Err("usage: library SCENE.toml OUT.png [cpu]".into()),
    };

    // The scene may be changed before meshes and patterns are loaded.
    let mut scene = Scene::load(Path::new(scene))?;
    scene.size = [320, 240];
    for object in &mut scene.objects {
        object.self_shadow = true;
    }
    let prepared = prepare(&scene, &|_| ())?;

    // Both renderers give the same words on a device that rounds by IEEE 754.
    let mut renderer: Box<dyn Renderer + '_> = match choose(None) {
        Ok(adapter) if !on_cpu => Box::new(GpuRenderer::new(&prepared, &adapter, Choice::Trusted)?),
        _ => Box::new(CpuRenderer::new(&prepared)),
    };
    println!("{}", renderer.name());

    // A frame is plain data. Move the light to the left.
    let mut frame = prepared.frame_with_samples(prepared.supersampling);
    frame.light_direction = [-0.6, 0.8, 0.0];
    let words = renderer.color(&frame)?;
    Picture::develop(&words, prepared.supersampling, &prepared.development)?
        .save_png(Path::new(output), &[])?;
    println!("{output}");
    Ok(())
}
