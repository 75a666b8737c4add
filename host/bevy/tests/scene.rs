//! A scene file of Relievo in Bevy: objects with places, instances and tiers.

mod studio;

use bevy::prelude::*;
use relievo::scene::{Color as SceneColor, Material, Scene};
use relievo_bevy::{CarvedMaterial, CarvedSceneRoot, Finish, IsPrepared, LayerMaterial};
use std::path::PathBuf;
use studio::{Studio, Twin, View, assert_no_messages, class_material, class_of};

const SIZE: [u32; 2] = [320, 240];

fn path(name: &str) -> PathBuf {
    PathBuf::from(format!(
        "{}/../../assets/scenes/{name}.toml",
        env!("CARGO_MANIFEST_DIR")
    ))
}

/// Spawns the scene file and waits until it is there.
fn spawn(studio: &mut Studio, name: &str) -> Entity {
    let scene = studio
        .app
        .world()
        .resource::<AssetServer>()
        .load(format!("scenes/{name}.toml"));
    let root = studio.app.world_mut().spawn(CarvedSceneRoot(scene)).id();
    let begin = std::time::Instant::now();
    while studio.app.world().get::<IsPrepared>(root).is_none() {
        studio.app.update();
        assert!(begin.elapsed().as_secs() < 120, "{name} is not prepared");
    }
    root
}

#[test]
fn the_objects_of_a_scene_file_are_where_they_should() {
    let mut studio = Studio::open(SIZE);
    for name in ["together", "instances"] {
        let mut scene = Scene::load(&path(name)).expect("a scene");
        scene.supersampling = 1;
        for object in &mut scene.objects {
            object.budget = None;
        }
        let twin = Twin::of(scene);
        let view = View {
            near: 0.05,
            ..twin.view()
        };
        let camera = studio.camera(&view);
        let root = spawn(&mut studio, name);
        let classes = class_material(&mut studio);
        let world = studio.app.world_mut();
        let mut materials = world.query::<&mut CarvedMaterial>();
        for mut material in materials.iter_mut(world) {
            *material = classes.clone();
        }
        let picture = studio.take();
        picture.save(name);
        let hits = twin.hits(&view, Vec3::Y, SIZE);
        let covered = hits.iter().filter(|hit| hit.class != 0).count();
        let pairs = picture.pixels.iter().zip(&hits);
        let different = pairs
            .filter(|(pixel, hit)| class_of(**pixel) != hit.class)
            .count();
        eprintln!("{name}: {different} of {covered} pixels have another class");
        assert!(
            covered > 5000 && different * 500 < covered,
            "{name}: {different}"
        );
        let world = studio.app.world_mut();
        world.despawn(root);
        world.despawn(camera);
    }
    assert_no_messages();
}

/// Colours of cap, wall, bevel and floor of the own pattern, and of the three further layers.
const LAYERS: [[u32; 4]; 4] = [
    [0xff0000, 0x00ff00, 0x0000ff, 0xffffff],
    [0xffff00, 0xff00ff, 0x00ffff, 0],
    [0x00ffff, 0xff0000, 0x00ff00, 0],
    [0x0000ff, 0xffff00, 0xff00ff, 0],
];

#[test]
fn the_layers_of_a_scene_file_have_their_materials() {
    let mut studio = Studio::open(SIZE);
    let mut scene = Scene::load(&path("windows")).expect("a scene");
    let named = |name: &str| {
        let all = &scene.materials;
        let found = all.iter().find(|material| material.name == name);
        let [red, green, blue] = found.expect("a material").base_color.linear();
        Some(Color::linear_rgb(red, green, blue))
    };
    let wanted = ["plaster", "paint", "paint"].map(named);

    // Colours without light, on the CPU.
    scene.supersampling = 1;
    scene.lights.clear();
    scene.environment = None;
    scene.materials.clear();
    scene.smooth_edges = false;
    scene.light.color = SceneColor::from_hex(0);
    scene.light.ambient = SceneColor::from_hex(0xffffff);
    let object = &mut scene.objects[0];
    let material = |colors: [u32; 4]| {
        let [cap, wall, bevel, floor] = colors.map(SceneColor::from_hex);
        Material {
            cap,
            wall,
            bevel,
            floor,
            specular: 0.0,
            ..Material::default()
        }
    };
    object.finish = Default::default();
    object.material = material(LAYERS[0]);
    for (layer, colors) in object.layers.iter_mut().zip(&LAYERS[1..]) {
        layer.finish = Default::default();
        layer.material = material(*colors);
    }
    let twin = Twin::of(scene);
    let view = View {
        near: 0.05,
        ..twin.view()
    };
    studio.camera(&view);

    spawn(&mut studio, "windows");
    let base = class_material(&mut studio).base;
    let world = studio.app.world_mut();
    let mut materials = world.query::<&mut CarvedMaterial>();
    for mut material in materials.iter_mut(world) {
        let caps = material.layers.iter().map(|layer| layer.cap.base_color);
        assert_eq!(caps.collect::<Vec<_>>(), wanted);
        let finishes = LAYERS.map(|colors| {
            colors.map(|color| {
                let [_, red, green, blue] = color.to_be_bytes();
                Finish::from(Color::srgb_u8(red, green, blue))
            })
        });
        let [[cap, wall, bevel, floor], ..] = finishes;
        let further = finishes[1..].iter();
        *material = CarvedMaterial {
            base: base.clone(),
            cap,
            wall,
            bevel,
            floor,
            layers: further
                .map(|[cap, wall, bevel, _]| LayerMaterial {
                    cap: *cap,
                    wall: *wall,
                    bevel: *bevel,
                })
                .collect(),
        };
    }
    let picture = studio.take();
    picture.save("windows");
    let colors = twin.colors(&view, Vec3::Y, SIZE);
    let mut seen = std::collections::BTreeSet::new();
    let mut different = 0;
    for (pixel, color) in picture.pixels.iter().zip(&colors) {
        let is_black = pixel[..3] == [0; 3];
        match color {
            Some(color) => {
                seen.insert(*color);
                different += usize::from(pixel[..3] != *color);
            }
            None => different += usize::from(!is_black),
        }
    }
    eprintln!("windows: {different} of {} pixels", colors.len());
    assert_eq!(seen.len(), 7, "all colours are seen");
    assert!(different * 200 < colors.len(), "windows: {different}");
    assert_no_messages();
}
