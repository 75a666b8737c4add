//! Bevy's lights on carved geometry: shadows that it casts on a ground, on a wall and on itself, a
//! cube that cuts through it, and changes at run time, all against rays on the CPU.

mod studio;

use bevy::light::DirectionalLightShadowMap;
use bevy::prelude::*;
use relievo_bevy::{Carved, CarvedMaterial, Finish, Pattern};
use studio::{Hit, Picture, Studio, Twin, View, assert_no_messages, pattern};

const SIZE: [u32; 2] = [480, 360];
/// Pixels of a light's view on the CPU.
const LIGHT_SIZE: [u32; 2] = [1024, 1024];
/// Height of the ground, and depth of the wall.
const GROUND: f32 = 0.0;
const WALL: f32 = -1.1;
/// Share of the pixels that may differ in light and shadow: a texel of the shadow map covers
/// several pixels at the edges of shadows.
const MOST: f64 = 0.002;
/// Half the side of the cube.
const HALF: f32 = 0.35;

const CAMERA: View = View {
    eye: Vec3::new(1.4, 2.1, 3.6),
    target: Vec3::new(-0.2, 0.85, -0.3),
    field_of_view: 50.0,
    near: 0.1,
};

/// A light: far away in a direction, or at a point.
#[derive(Clone, Copy, Debug)]
enum Lamp {
    /// Towards the light.
    Sun(Vec3),
    Point(Vec3),
}

impl Lamp {
    fn eye(self, place: &Transform) -> Vec3 {
        match self {
            Lamp::Sun(towards) => place.translation + 1000.0 * towards.normalize(),
            Lamp::Point(position) => position,
        }
    }
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Thing {
    Nothing,
    /// The object, and its class and normal there.
    Carved(Hit),
    Cube,
    Ground,
    Wall,
}

/// The scene on the CPU.
struct World {
    twin: Twin,
    place: Transform,
    cube: Option<Vec3>,
}

impl World {
    /// Returns the view in the space of the object.
    fn turned(&self, view: &View) -> (View, Vec3) {
        let to_object = self.place.to_matrix().inverse();
        let turned = View {
            eye: to_object.transform_point3(view.eye),
            target: to_object.transform_point3(view.target),
            near: view.near / self.place.scale.x,
            ..*view
        };
        (
            turned,
            to_object.transform_vector3(view.transform().up().into()),
        )
    }

    fn hits(&self, view: &View, size: [u32; 2]) -> Vec<Hit> {
        let (turned, up) = self.turned(view);
        self.twin.hits(&turned, up, size)
    }

    /// Returns what the pixels of the camera show, and where.
    fn seen(&self) -> Vec<(Thing, Vec3)> {
        let hits = self.hits(&CAMERA, SIZE);
        let ray = |index: u32| CAMERA.ray(SIZE, index % SIZE[0], index / SIZE[0]);
        (0..SIZE[0] * SIZE[1])
            .map(|index| {
                let direction = ray(index);
                let hit = hits[index as usize];
                let mut nearest = (Thing::Nothing, f32::INFINITY);
                let mut meet = |thing, t: f32| {
                    if t > 0.0 && t < nearest.1 {
                        nearest = (thing, t);
                    }
                };
                meet(Thing::Ground, (GROUND - CAMERA.eye.y) / direction.y);
                meet(Thing::Wall, (WALL - CAMERA.eye.z) / direction.z);
                if let Some(t) = self
                    .cube
                    .and_then(|cube| meet_cube(cube, CAMERA.eye, direction))
                {
                    meet(Thing::Cube, t);
                }
                if hit.class != 0 {
                    meet(Thing::Carved(hit), hit.t * self.place.scale.x);
                }
                let (thing, t) = nearest;
                (thing, CAMERA.eye + direction * t)
            })
            .collect()
    }

    /// Returns for each place whether the object or the cube is between it and the lamp. Those
    /// that belong to the object keep `bias` from it.
    fn shadows(&self, lamp: Lamp, places: &[(Thing, Vec3)]) -> Vec<bool> {
        let eye = lamp.eye(&self.place);
        let distance = eye.distance(self.place.translation);
        let view = View {
            eye,
            target: self.place.translation,
            field_of_view: 2.0 * (1.7 / distance).atan().to_degrees(),
            near: 0.1,
        };
        let hits = self.hits(&view, LIGHT_SIZE);
        let transform = view.transform();
        let tangent = (0.5 * view.field_of_view.to_radians()).tan();
        let blocks = |place: Vec3, bias: f32| {
            let local = transform.rotation.inverse() * (place - eye);
            let at = Vec2::new(local.x, -local.y) / (-local.z * tangent);
            let pixel = (0.5 * (at + 1.0) * LIGHT_SIZE[0] as f32).floor();
            let is_in = pixel.min_element() >= 0.0 && pixel.max_element() < LIGHT_SIZE[0] as f32;
            let hit = match is_in {
                true => hits[pixel.y as usize * LIGHT_SIZE[0] as usize + pixel.x as usize],
                false => return false,
            };
            hit.class != 0 && hit.t * self.place.scale.x < place.distance(eye) - bias
        };
        places
            .iter()
            .map(|(thing, place)| {
                let bias = match thing {
                    Thing::Carved(_) => 0.02,
                    _ => 0.0,
                };
                let to_lamp = (eye - *place).normalize();
                let by_cube = self.cube.is_some_and(|cube| {
                    *thing != Thing::Cube && meet_cube(cube, *place, to_lamp).is_some()
                });
                by_cube || blocks(*place, bias)
            })
            .collect()
    }
}

/// Returns the distance at which a ray meets the cube.
fn meet_cube(centre: Vec3, origin: Vec3, direction: Vec3) -> Option<f32> {
    let first = (centre - HALF - origin) / direction;
    let second = (centre + HALF - origin) / direction;
    let enter = first.min(second).max_element();
    let leave = first.max(second).min_element();
    (enter > 0.0 && enter < leave).then_some(enter)
}

/// Whether a pixel differs from none that is at most `reach` pixels away.
fn is_inside<T: PartialEq>(values: &[T], index: usize, reach: i32) -> bool {
    let [width, height] = SIZE.map(|side| side as i32);
    let (x, y) = (index as i32 % width, index as i32 / width);
    (-reach..=reach).all(|dy| {
        (-reach..=reach).all(|dx| {
            let (x, y) = (x + dx, y + dy);
            let is_in = x >= 0 && y >= 0 && x < width && y < height;
            is_in && values[(y * width + x) as usize] == values[index]
        })
    })
}

fn torus() -> Mesh {
    let torus = Torus {
        minor_radius: 0.4,
        major_radius: 0.8,
    };
    torus
        .mesh()
        .minor_resolution(24)
        .major_resolution(48)
        .build()
}

struct Set {
    studio: Studio,
    carved: Entity,
    world: World,
    description: Carved,
    sun: Entity,
    lamp: Entity,
}

/// Returns the ring, upright, before the wall.
fn place() -> Transform {
    Transform::from_xyz(0.0, 1.2, 0.0)
        .with_rotation(Quat::from_euler(EulerRot::XYZ, 1.3, 0.2, 0.1))
        .with_scale(Vec3::splat(0.95))
}

fn set() -> Set {
    let mut studio = Studio::open(SIZE);
    studio.camera(&CAMERA);
    let white = StandardMaterial {
        base_color: Color::WHITE,
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..default()
    };
    let white: Handle<StandardMaterial> = studio.add(white);
    let plane: Handle<Mesh> = studio.add(Plane3d::new(Vec3::Y, Vec2::splat(30.0)));
    let description = Carved {
        mesh: studio.add(torus()),
        pattern: studio.add::<Pattern>(pattern("discs.png")),
        repeat: Vec2::new(10.0, 4.0),
        depth: Some(0.16),
        ..default()
    };
    let twin = Twin::new(&torus(), pattern("discs.png"), &description);
    let world = studio.app.world_mut();
    for transform in [
        Transform::from_xyz(0.0, GROUND, 0.0),
        Transform::from_xyz(0.0, 0.0, WALL)
            .with_rotation(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2)),
    ] {
        world.spawn((
            Mesh3d(plane.clone()),
            MeshMaterial3d(white.clone()),
            transform,
        ));
    }
    let material = CarvedMaterial {
        base: white.clone(),
        cap: Finish::from(Color::srgb(1.0, 0.6, 0.2)),
        wall: Finish::from(Color::srgb(0.9, 0.3, 0.2)),
        floor: Finish::from(Color::srgb(0.4, 0.6, 1.0)),
        ..default()
    };
    let carved = world.spawn((description.clone(), material, place())).id();
    let sun = DirectionalLight {
        illuminance: 3_000.0,
        shadow_maps_enabled: true,
        ..default()
    };
    world.insert_resource(DirectionalLightShadowMap { size: 4096 });
    let cascades = bevy::light::CascadeShadowConfigBuilder {
        num_cascades: 1,
        first_cascade_far_bound: 7.0,
        maximum_distance: 7.0,
        ..default()
    };
    let sun = world
        .spawn((sun, cascades.build(), Visibility::Hidden))
        .id();
    let lamp = PointLight {
        intensity: 300_000.0,
        range: 40.0,
        shadow_maps_enabled: true,
        ..default()
    };
    let lamp = world.spawn((lamp, Visibility::Hidden)).id();
    Set {
        studio,
        carved,
        world: World {
            twin,
            place: place(),
            cube: None,
        },
        description,
        sun,
        lamp,
    }
}

impl Set {
    /// Takes a picture in the light of a lamp.
    fn take(&mut self, lamp: Lamp, name: &str) -> Picture {
        let world = self.studio.app.world_mut();
        let (sun, point) = (self.sun, self.lamp);
        let (on, off, transform) = match lamp {
            Lamp::Sun(towards) => {
                let transform =
                    Transform::from_translation(towards).looking_at(Vec3::ZERO, Vec3::Y);
                (sun, point, transform)
            }
            Lamp::Point(position) => (point, sun, Transform::from_translation(position)),
        };
        world
            .entity_mut(on)
            .insert((transform, Visibility::Visible));
        world.entity_mut(off).insert(Visibility::Hidden);
        let picture = self.studio.take();
        picture.save(name);
        picture
    }

    /// Compares light and shadow of a picture with the CPU's rays. Returns the pixels of the
    /// ground, the wall and the object that lie in shadow and not at an edge, and the share of
    /// all pixels not at an edge that differ.
    fn compare(
        &self,
        world: &World,
        lamp: Lamp,
        picture: &Picture,
        name: &str,
    ) -> ([usize; 3], f64) {
        let seen = world.seen();
        let shadows = world.shadows(lamp, &seen);
        // What must be the same around a pixel that is compared.
        let row = |thing: &Thing| match thing {
            Thing::Ground => Some(0),
            Thing::Wall => Some(1),
            Thing::Carved(_) => Some(2),
            _ => None,
        };
        let areas: Vec<_> = seen
            .iter()
            .zip(&shadows)
            .map(|((thing, _), shadow)| {
                let class = match thing {
                    Thing::Carved(hit) => hit.class,
                    _ => 0,
                };
                (row(thing), class, *shadow)
            })
            .collect();
        let (mut found, mut different, mut checked) = ([0; 3], 0, 0);
        let mut marked = picture.clone();
        for (index, pixel) in picture.pixels.iter().enumerate() {
            let (Some(row), ..) = areas[index] else {
                continue;
            };
            let (thing, place) = seen[index];
            if let Thing::Carved(hit) = thing {
                // What turns away from the lamp is dark without a shadow.
                let normal = world.place.rotation * hit.normal;
                if normal.dot((lamp.eye(&world.place) - place).normalize()) < 0.3 {
                    continue;
                }
            }
            if !is_inside(&areas, index, 3) {
                continue;
            }
            let brightness = pixel[..3].iter().copied().max().unwrap_or(0);
            checked += 1;
            found[row] += usize::from(shadows[index]);
            if (brightness < 30) != shadows[index] {
                different += 1;
                marked.pixels[index] = [255, 0, 255, 255];
            }
        }
        if different > 0 {
            marked.save(&format!("{name}-marked"));
        }
        eprintln!("{name}: {different} of {checked} pixels differ; in shadow {found:?}");
        (found, different as f64 / checked as f64)
    }
}

#[test]
fn light_and_shadow_are_those_of_rays_on_the_cpu() {
    let mut set = set();
    let sun = Lamp::Sun(Vec3::new(-1.1, 1.0, 1.0));
    let moved = Lamp::Sun(Vec3::new(1.0, 0.8, 0.9));
    let mut pictures = Vec::new();
    for (name, lamp) in [("sun", sun), ("sun-moved", moved)] {
        let picture = set.take(lamp, name);
        let (shadow, different) = set.compare(&set.world, lamp, &picture, name);
        assert!(
            shadow[0] > 300 && shadow[1] > 300,
            "{name}: shadow on ground and wall"
        );
        assert!(different < MOST, "{name}: {different}");
        pictures.push(picture);
    }
    assert!(pictures[0] != pictures[1]);
    // The shadow of the smooth mesh is another one: the comparison notices the carving.
    let smooth = Carved {
        depth: Some(0.002),
        ..set.description.clone()
    };
    let smooth = World {
        twin: Twin::new(&torus(), pattern("discs.png"), &smooth),
        place: place(),
        cube: None,
    };
    let (_, different) = set.compare(&smooth, sun, &pictures[0], "the smooth ring's shadow");
    assert!(
        different > 5.0 * MOST,
        "the shadow's outline is carved: {different}"
    );

    // A change at run time.
    let flatter = Carved {
        depth: Some(0.06),
        ..set.description.clone()
    };
    set.world.twin = Twin::new(&torus(), pattern("discs.png"), &flatter);
    set.studio
        .app
        .world_mut()
        .entity_mut(set.carved)
        .insert(flatter);
    let picture = set.take(sun, "flatter");
    let (_, different) = set.compare(&set.world, sun, &picture, "flatter");
    assert!(different < MOST, "flatter: {different}");

    // The six sides of a point light's shadow map. The last one: Bevy 0.19.1 loses the shadows of
    // a light that was hidden and is shown again.
    let lamp = Lamp::Point(Vec3::new(-1.6, 2.0, 1.8));
    let picture = set.take(lamp, "lamp");
    let (shadow, different) = set.compare(&set.world, lamp, &picture, "lamp");
    assert!(shadow[0] > 300 && shadow[1] > 300, "lamp: {shadow:?}");
    assert!(different < MOST, "lamp: {different}");
    assert_no_messages();
}

#[test]
fn a_cube_cuts_through_where_it_should() {
    let mut set = set();
    let centre = Vec3::new(0.55, 1.65, 0.3);
    let yellow = [255, 255, 0];
    let unlit = |studio: &mut Studio, color| -> Handle<StandardMaterial> {
        studio.add(StandardMaterial {
            base_color: color,
            unlit: true,
            ..default()
        })
    };
    let material = unlit(&mut set.studio, Color::srgb_u8(255, 255, 0));
    let cube: Handle<Mesh> = set.studio.add(Cuboid::from_length(2.0 * HALF));
    let classes = studio::class_material(&mut set.studio);
    let world = set.studio.app.world_mut();
    world.spawn((
        Mesh3d(cube),
        MeshMaterial3d(material),
        Transform::from_translation(centre),
    ));
    world.entity_mut(set.carved).insert(classes);
    set.world.cube = Some(centre);
    let picture = set.take(Lamp::Sun(Vec3::Y), "cube");
    let (mut both, mut different) = (0, 0);
    let seen = set.world.seen();
    for (index, (thing, _)) in seen.iter().enumerate() {
        let pixel = picture.pixels[index];
        let expected = match thing {
            Thing::Cube => yellow,
            Thing::Carved(hit) => studio::COLORS[hit.class as usize - 1],
            _ => continue,
        };
        both += 1;
        different += usize::from(pixel[..3] != expected);
    }
    eprintln!("cube: {different} of {both} pixels differ");
    let count = |wanted: Thing| seen.iter().filter(|(thing, _)| *thing == wanted).count();
    assert!(count(Thing::Cube) > 500, "the cube is seen");
    assert!(different <= 40, "{different}");

    // The cube's shadow falls on the object.
    let white: Handle<StandardMaterial> = set.studio.add(StandardMaterial {
        perceptual_roughness: 1.0,
        ..default()
    });
    let material = CarvedMaterial {
        base: white,
        ..default()
    };
    set.studio
        .app
        .world_mut()
        .entity_mut(set.carved)
        .insert(material);
    let sun = Lamp::Sun(Vec3::new(-1.1, 1.0, 1.0));
    let picture = set.take(sun, "cube-lit");
    let (shadow, different) = set.compare(&set.world, sun, &picture, "cube-lit");
    assert!(shadow[2] > 300, "the object receives shadow: {shadow:?}");
    assert!(different < MOST, "{different}");
    assert_no_messages();
}
