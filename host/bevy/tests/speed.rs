//! The time of a frame in Bevy, of the scene `assets/scenes/torus.toml` with one sample a pixel:
//!
//! `cargo test --profile checked --features window --test speed -- --ignored --nocapture`
//!
//! Beside it: `relievo bench scene assets/scenes/torus.toml --size 640x480` with
//! `image.supersample = false`.

mod studio;

use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::render_resource::PollType;
use bevy::render::renderer::RenderDevice;
use relievo::mesh::{Mesh as RelievoMesh, MeshOptions};
use relievo_bevy::{Carved, CarvedMaterial, Pattern, Technique};
use std::time::Instant;
use studio::{Studio, View, pattern};

const SIZE: [u32; 2] = [640, 480];
const FRAMES: usize = 15;

/// Returns the mesh of the scene.
fn torus() -> Mesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/meshes/torus.obj");
    let mesh = RelievoMesh::load(path.as_ref(), &MeshOptions::default()).expect("a mesh");
    let corners: Vec<_> = mesh
        .triangles
        .iter()
        .flat_map(|triangle| triangle.corners)
        .collect();
    let vectors = |get: &dyn Fn(usize) -> [f64; 3]| -> Vec<[f32; 3]> {
        (0..corners.len())
            .map(|i| get(i).map(|part| part as f32))
            .collect()
    };
    let uvs: Vec<[f32; 2]> = corners
        .iter()
        .map(|corner| [corner.uv.x as f32, 1.0 - corner.uv.y as f32])
        .collect();
    Mesh::new(
        bevy::mesh::PrimitiveTopology::TriangleList,
        Default::default(),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_POSITION,
        vectors(&|i| corners[i].position.to_array()),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_NORMAL,
        vectors(&|i| corners[i].normal.to_array()),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
}

/// Prints the median time of a frame.
fn time(studio: &mut Studio, name: &str) {
    studio.take().save(&format!("speed-{name}"));
    let device = studio
        .app
        .sub_app(RenderApp)
        .world()
        .resource::<RenderDevice>()
        .clone();
    let mut frame = || {
        let begin = Instant::now();
        studio.app.update();
        device
            .poll(PollType::wait_indefinitely())
            .expect("the device works");
        begin.elapsed().as_secs_f64() * 1e3
    };
    let begin = processor_time();
    let mut times: Vec<f64> = (0..FRAMES).map(|_| frame()).collect();
    let processors = (processor_time() - begin) / FRAMES as f64;
    times.sort_by(f64::total_cmp);
    println!(
        "{name}: {:.1} ms; of all processors {processors:.1} ms",
        times[FRAMES / 2]
    );
}

/// Returns the time that all threads of this process had a processor, milliseconds: other programs
/// do not change it. 0 where there is no /proc.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    let ticks = fields
        .skip(11)
        .take(2)
        .filter_map(|field| field.parse::<f64>().ok());
    10.0 * ticks.sum::<f64>()
}

#[test]
#[ignore = "it measures"]
fn frames() {
    let mut studio = Studio::open(SIZE);
    let view = View {
        eye: Vec3::new(0.0, 2.3, 3.4),
        target: Vec3::new(0.0, -0.08, 0.0),
        field_of_view: 38.0,
        near: 0.05,
    };
    studio.camera(&view);
    time(&mut studio, "nothing");
    let mesh: Handle<Mesh> = studio.add(torus());
    let carved = Carved {
        technique: Technique::Outward,
        extension: Some(0.05),
        ..Carved::new(mesh.clone(), studio.add::<Pattern>(pattern("discs.png")))
    }
    .repeat(24.0, 10.0)
    .depth(0.1);
    let unlit: Handle<StandardMaterial> = studio.add(StandardMaterial {
        unlit: true,
        ..default()
    });
    let lit: Handle<StandardMaterial> = studio.add(StandardMaterial::default());
    let smooth = (Mesh3d(mesh), MeshMaterial3d(lit.clone()));
    let sun = Transform::from_xyz(1.0, 2.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    let sun = studio
        .app
        .world_mut()
        .spawn((DirectionalLight::default(), sun))
        .id();
    let entity = studio.app.world_mut().spawn(smooth).id();
    time(&mut studio, "smooth");
    studio.app.world_mut().despawn(entity);
    let base = |base| CarvedMaterial { base, ..default() };
    let entity = studio.app.world_mut().spawn((carved, base(unlit))).id();
    time(&mut studio, "carved-unlit");
    studio.app.world_mut().entity_mut(entity).insert(base(lit));
    time(&mut studio, "carved");
    let shadows = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    studio.app.world_mut().entity_mut(sun).insert(shadows);
    time(&mut studio, "carved-shadows");
}
