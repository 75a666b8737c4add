//! What Bevy draws is what Relievo's CPU renderer hits: classes and outline, in every tier.

mod studio;

use bevy::prelude::*;
use relievo_bevy::{Carved, Pattern, Technique, Tier};
use studio::{Studio, Twin, View, assert_no_messages, class_material, class_of, pattern, torus};

const SIZE: [u32; 2] = [320, 240];

/// Draws `carved` in `place` and compares the classes with the CPU's. Returns the differences.
fn differences(
    studio: &mut Studio,
    carved: Carved,
    place: Transform,
    view: &View,
    name: &str,
) -> usize {
    let twin = Twin::new(&torus(), pattern("discs.png"), &carved);
    let material = class_material(studio);
    let entity = studio.app.world_mut().spawn((carved, material, place)).id();
    let picture = studio.take();
    studio.app.world_mut().entity_mut(entity).despawn();
    picture.save(name);
    // The view in the space of the object.
    let to_object = place.to_matrix().inverse();
    let turned = View {
        eye: to_object.transform_point3(view.eye),
        target: to_object.transform_point3(view.target),
        near: view.near / place.scale.x,
        ..*view
    };
    let up = to_object.transform_vector3(Vec3::Y);
    let hits = twin.hits(&turned, up, SIZE);
    let covered = hits.iter().filter(|hit| hit.class != 0).count();
    assert!(covered > 5000, "there is something to see");
    let classes = picture.pixels.iter().map(|pixel| class_of(*pixel));
    let different = classes
        .zip(&hits)
        .filter(|(class, hit)| *class != hit.class);
    let different = different.count();
    eprintln!("{name}: {different} of {covered} pixels have another class");
    different
}

#[test]
fn classes_are_those_of_the_cpu() {
    let mut studio = Studio::open(SIZE);
    let view = View {
        eye: Vec3::new(0.3, 2.0, 2.6),
        target: Vec3::ZERO,
        field_of_view: 45.0,
        near: 0.05,
    };
    let camera = studio.camera(&view);
    let mesh: Handle<Mesh> = studio.add(torus());
    let pattern: Handle<Pattern> = studio.add(pattern("discs.png"));
    let carved = Carved {
        mesh,
        pattern,
        repeat: Vec2::new(12.0, 5.0),
        depth: Some(0.12),
        ..default()
    };
    let turned = Transform::from_xyz(0.1, -0.2, 0.1)
        .with_rotation(Quat::from_euler(EulerRot::XYZ, 0.4, 0.3, 0.2))
        .with_scale(Vec3::splat(1.2));
    for (name, tier, technique, place) in [
        ("fast", Tier::Fast, Technique::Basic, Transform::IDENTITY),
        ("turned", Tier::Fast, Technique::Chamfered, turned),
        ("accurate", Tier::Accurate, Technique::Basic, turned),
        ("planar", Tier::Planar, Technique::Beveled, turned),
    ] {
        let carved = Carved {
            tier,
            technique,
            ..carved.clone()
        };
        let different = differences(&mut studio, carved, place, &view, name);
        assert!(different <= 40, "{name}: {different}");
    }
    // A pixel's ray decides for all of its samples, in the prisms of the accurate tier, too.
    let mut with_samples = studio.app.world_mut().entity_mut(camera);
    with_samples.insert(Msaa::Sample4);
    for (name, tier) in [
        ("samples", Tier::Fast),
        ("samples-accurate", Tier::Accurate),
    ] {
        let carved = Carved {
            tier,
            ..carved.clone()
        };
        let different = differences(&mut studio, carved, turned, &view, name);
        assert!(different <= 40, "{name}: {different}");
    }
    // The eye in the shell: between two discs of the torus.
    studio.app.world_mut().entity_mut(camera).despawn();
    let inside = View {
        eye: Vec3::new(0.02, 0.36, 1.05),
        target: Vec3::new(1.0, 0.3, 0.6),
        field_of_view: 80.0,
        near: 0.01,
    };
    studio.camera(&inside);
    let different = differences(&mut studio, carved, Transform::IDENTITY, &inside, "inside");
    assert!(different <= 40, "inside: {different}");
    assert_no_messages();
}
