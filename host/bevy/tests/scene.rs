//! A scene file of Relievo in Bevy: objects with places, instances and tiers.

mod studio;

use bevy::prelude::*;
use relievo::scene::Scene;
use relievo_bevy::{CarvedMaterial, CarvedSceneRoot, IsPrepared};
use studio::{Studio, Twin, View, assert_no_messages, class_material, class_of};

const SIZE: [u32; 2] = [320, 240];

#[test]
fn the_objects_of_a_scene_file_are_where_they_should() {
    let mut studio = Studio::open(SIZE);
    for name in ["together", "instances"] {
        let path = format!(
            "{}/../../assets/scenes/{name}.toml",
            env!("CARGO_MANIFEST_DIR")
        );
        let mut scene = Scene::load(path.as_ref()).expect("a scene");
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
