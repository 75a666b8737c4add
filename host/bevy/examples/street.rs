//! A carved ring that turns in the sun, a cube that cuts through a carved wall, and a lamp.
//!
//! `cargo run --profile checked --features window --example street`, in host/bevy.

use bevy::light::CascadeShadowConfigBuilder;
use bevy::prelude::*;
use relievo_bevy::{Carved, CarvedMaterial, Pattern, RelievoPlugin, Technique};

fn main() {
    let assets = AssetPlugin {
        file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets").to_string(),
        ..default()
    };
    App::new()
        .add_plugins((DefaultPlugins.set(assets), RelievoPlugin))
        .add_systems(Startup, setup)
        .add_systems(Update, turn)
        .run();
}

#[derive(Component)]
struct Turns;

fn turn(time: Res<Time>, mut turning: Query<&mut Transform, With<Turns>>) {
    for mut transform in &mut turning {
        transform.rotate_y(0.4 * time.delta_secs());
    }
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let stone = materials.add(StandardMaterial {
        base_color: Color::srgb(0.75, 0.72, 0.66),
        perceptual_roughness: 0.9,
        ..default()
    });
    let ground = Plane3d::new(Vec3::Y, Vec2::splat(12.0));
    commands.spawn((Mesh3d(meshes.add(ground)), MeshMaterial3d(stone.clone())));

    // A wall of bricks, and a cube in it.
    let wall: Mesh = Plane3d::new(Vec3::Z, Vec2::new(3.0, 1.5)).into();
    let bricks: Handle<Pattern> = assets.load("patterns/bricks.png");
    commands.spawn((
        Carved::new(meshes.add(wall), bricks)
            .repeat(6.0, 3.0)
            .depth(0.12),
        CarvedMaterial {
            base: stone.clone(),
            cap: Color::srgb(0.62, 0.25, 0.16).into(),
            wall: Color::srgb(0.5, 0.2, 0.14).into(),
            ..default()
        },
        Transform::from_xyz(0.0, 1.5, -1.6),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::from_length(0.8))),
        MeshMaterial3d(materials.add(Color::srgb(0.9, 0.75, 0.2))),
        Transform::from_xyz(-1.5, 1.2, -1.6).with_rotation(Quat::from_rotation_y(0.5)),
    ));

    // A ring of discs.
    let ring = Torus {
        minor_radius: 0.35,
        major_radius: 0.8,
    };
    let ring = ring
        .mesh()
        .minor_resolution(24)
        .major_resolution(64)
        .build();
    commands.spawn((
        Carved {
            repeat: Vec2::new(10.0, 4.0),
            depth: Some(0.08),
            technique: Technique::Rounded,
            ..Carved::new(meshes.add(ring), assets.load("patterns/discs.png"))
        },
        CarvedMaterial {
            base: stone,
            floor: Color::srgb(0.2, 0.35, 0.5).into(),
            ..default()
        },
        Transform::from_xyz(0.6, 1.3, 0.6).with_rotation(Quat::from_rotation_x(1.2)),
        Turns,
    ));

    let shadows = CascadeShadowConfigBuilder {
        maximum_distance: 20.0,
        ..default()
    };
    commands.spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        shadows.build(),
        Transform::from_xyz(2.0, 4.0, 3.5).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    commands.spawn((
        PointLight {
            color: Color::srgb(1.0, 0.7, 0.4),
            intensity: 400_000.0,
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::from_xyz(-2.4, 2.2, 1.2),
    ));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.8, 2.4, 5.5).looking_at(Vec3::new(0.0, 1.1, 0.0), Vec3::Y),
    ));
}
