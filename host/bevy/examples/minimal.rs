use bevy::prelude::*;
use relievo_bevy::{Carved, RelievoPlugin};
fn main() {
    App::new()
        .add_plugins((DefaultPlugins, RelievoPlugin))
        .add_systems(Startup, setup)
        .run();
}
fn setup(mut commands: Commands, assets: Res<AssetServer>, mut meshes: ResMut<Assets<Mesh>>) {
    let (mesh, pattern) = (meshes.add(Torus::default()), assets.load("bricks.png"));
    let view = Transform::from_xyz(0.0, 2.0, 2.5).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn(Carved::new(mesh, pattern).repeat(12.0, 6.0));
    commands.spawn((DirectionalLight::default(), view));
    commands.spawn((Camera3d::default(), view));
}
