//! Cameras and passes beside the usual ones: orthographic cameras, prepasses and motion vectors;
//! materials that change, and bad input.

mod studio;

use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::pbr::MaterialPipelineKey;
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::{Shader, ShaderRef};
use relievo_bevy::{Carved, CarvedMaterial, Finish, IsPrepared, Pattern};
use std::sync::Mutex;
use studio::{MESSAGES, Picture, Studio, Twin, View, class_material, class_of, pattern, torus};

const SIZE: [u32; 2] = [240, 180];

/// The messages are those of one test at a time.
static ALONE: Mutex<()> = Mutex::new(());

const VIEW: View = View {
    eye: Vec3::new(0.4, 1.8, 2.8),
    target: Vec3::new(0.1, 0.0, 0.0),
    field_of_view: 45.0,
    near: 0.05,
};

fn carved(studio: &mut Studio) -> Carved {
    Carved::new(
        studio.add(torus()),
        studio.add::<Pattern>(pattern("discs.png")),
    )
    .repeat(12.0, 5.0)
    .depth(0.12)
}

/// Returns how many pixels differ in any channel by more than `most`.
fn different(a: &Picture, b: &Picture, most: u8) -> usize {
    let apart = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).any(|i| a[i].abs_diff(b[i]) > most);
    a.pixels
        .iter()
        .zip(&b.pixels)
        .filter(|pair| apart(*pair))
        .count()
}

/// From far away, a perspective camera sees what an orthographic one sees.
#[test]
fn an_orthographic_camera_sees_what_one_far_away_sees() {
    let _alone = ALONE.lock().expect("the other tests passed");
    let mut studio = Studio::open(SIZE);
    let carved = carved(&mut studio);
    let twin = Twin::new(&torus(), pattern("discs.png"), &carved);
    let material = class_material(&mut studio);
    studio.app.world_mut().spawn((carved, material));
    let towards = Vec3::new(0.3, 0.7, 1.0).normalize();
    let view = View {
        eye: 4.0 * towards,
        target: Vec3::ZERO,
        ..VIEW
    };
    let height = 3.2;
    let projection = OrthographicProjection {
        near: 0.1,
        far: 20.0,
        scaling_mode: bevy::camera::ScalingMode::FixedVertical {
            viewport_height: height,
        },
        ..OrthographicProjection::default_3d()
    };
    studio.camera_with(&view, projection.into());
    let picture = studio.take();
    picture.save("orthographic");
    let distance = 2000.0;
    let far = View {
        eye: distance * towards,
        target: Vec3::ZERO,
        field_of_view: 2.0 * (0.5 * height / distance).atan().to_degrees(),
        near: 1.0,
    };
    let hits = twin.hits(&far, Vec3::Y, SIZE);
    let covered = hits.iter().filter(|hit| hit.class != 0).count();
    let pairs = picture.pixels.iter().zip(&hits);
    let other = pairs
        .filter(|(pixel, hit)| class_of(**pixel) != hit.class)
        .count();
    eprintln!("orthographic: {other} of {covered} pixels have another class");
    // The distance rounds to 1/8192, and rays that are almost parallel differ at edges.
    assert!(
        covered > 8000 && other * 100 < covered,
        "{other} of {covered}"
    );
    studio::assert_no_messages();
}

/// Shows the motion vectors of the prepass.
#[derive(Asset, AsBindGroup, TypePath, Clone)]
struct ShowMotion {}

const SHOW_MOTION: Handle<Shader> =
    bevy::asset::uuid_handle!("2f0c7f5e-8f65-4c4e-9c1d-3a1b4f6a7d10");

impl Material for ShowMotion {
    fn fragment_shader() -> ShaderRef {
        SHOW_MOTION.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        // After what is opaque, and not in the prepass.
        AlphaMode::Blend
    }

    fn specialize(
        _: &bevy::pbr::MaterialPipeline,
        descriptor: &mut bevy::render::render_resource::RenderPipelineDescriptor,
        _: &bevy::mesh::MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), bevy::render::render_resource::SpecializedMeshPipelineError> {
        if let Some(depth) = &mut descriptor.depth_stencil {
            depth.depth_compare = Some(bevy::render::render_resource::CompareFunction::Always);
        }
        Ok(())
    }
}

#[test]
fn prepasses_change_nothing_and_have_the_motion() {
    let _alone = ALONE.lock().expect("the other tests passed");
    let mut studio = Studio::open_with(SIZE, |app| {
        app.add_plugins(MaterialPlugin::<ShowMotion>::default());
    });
    let carved = carved(&mut studio);
    let twin = Twin::new(&torus(), pattern("discs.png"), &carved);
    let white = StandardMaterial {
        base_color: Color::srgb(0.6, 0.6, 0.6),
        ..default()
    };
    let base: Handle<StandardMaterial> = studio.add(white);
    let material = CarvedMaterial { base, ..default() };
    let object = studio.app.world_mut().spawn((carved, material)).id();
    let light = Transform::from_xyz(1.0, 2.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    studio
        .app
        .world_mut()
        .spawn((DirectionalLight::default(), light));
    let camera = studio.camera(&VIEW);
    let plain = studio.take();
    plain.save("plain");
    let prepasses = (DepthPrepass, NormalPrepass, MotionVectorPrepass);
    studio.app.world_mut().entity_mut(camera).insert(prepasses);
    let after = studio.take();
    after.save("after-prepasses");
    // The prepass rounds normals to 10 bits.
    let other = different(&plain, &after, 6);
    eprintln!("prepasses: {other} of {} pixels differ", plain.pixels.len());
    assert!(other * 500 < plain.pixels.len(), "{other}");

    // The object moves right by the same distance in each frame.
    let text = "
#import bevy_pbr::forward_io::VertexOutput
#import bevy_pbr::prepass_utils::prepass_motion_vector
@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    let motion = prepass_motion_vector(in.position, 0u);
    return vec4<f32>(0.5 + 8.0 * motion, 0.0, 1.0);
}";
    let shader = Shader::from_wgsl(text, "show_motion.wgsl");
    let inserted = studio
        .app
        .world_mut()
        .resource_mut::<Assets<Shader>>()
        .insert(&SHOW_MOTION, shader);
    assert!(inserted.is_ok());
    let screen: Handle<Mesh> = studio.add(Rectangle::new(8.0, 8.0));
    let show: Handle<ShowMotion> = studio.add(ShowMotion {});
    let before = VIEW.transform();
    let screen_at = Transform::from_translation(VIEW.eye + before.forward() * 1.0)
        .with_rotation(before.rotation);
    studio
        .app
        .world_mut()
        .spawn((Mesh3d(screen), MeshMaterial3d(show), screen_at));
    let still = studio.take();
    const STEP: f32 = 0.05;
    let picture = studio.take_moving(|world| {
        let transform = world.get_mut::<Transform>(object);
        transform.expect("it has one").translation.x += STEP;
    });
    picture.save("motion");
    let world = studio.app.world();
    let moved = world.get::<Transform>(object).expect("it has one");
    let view = View {
        eye: VIEW.eye - moved.translation,
        target: VIEW.target - moved.translation,
        ..VIEW
    };
    let hits = twin.hits(&view, Vec3::Y, SIZE);
    let (mut all, mut wrong) = (0, 0);
    for (index, hit) in hits.iter().enumerate().filter(|(_, hit)| hit.class != 0) {
        let (x, y) = (index as u32 % SIZE[0], index as u32 / SIZE[0]);
        let place = VIEW.eye + VIEW.ray(SIZE, x, y) * hit.t;
        let motion = VIEW.project(SIZE, place) - VIEW.project(SIZE, place - STEP * Vec3::X);
        let [red, green, ..] = picture.pixels[index];
        let linear = [red, green].map(|part| Color::srgb_u8(part, 0, 0).to_linear().red);
        let apart = Vec2::from(linear) - (0.5 + 8.0 * motion);
        all += 1;
        // A step of 8 bits is up to 0.007.
        wrong += usize::from(apart.abs().max_element() > 0.01);
    }
    eprintln!("motion: {wrong} of {all} pixels have another motion");
    assert!(all > 5000 && wrong * 200 < all, "{wrong} of {all}");
    let [red, green, ..] = still.pixels[0];
    assert!(red == green && red.abs_diff(187) <= 1, "{red}, {green}");
    let same = still.pixels.iter().all(|pixel| *pixel == still.pixels[0]);
    assert!(same, "what is still has no motion");
    studio::assert_no_messages();
}

#[test]
fn materials_change_at_once() {
    let _alone = ALONE.lock().expect("the other tests passed");
    let mut studio = Studio::open(SIZE);
    studio.camera(&VIEW);
    let carved = carved(&mut studio);
    let material = class_material(&mut studio);
    let base = material.base.clone();
    let entity = studio.app.world_mut().spawn((carved, material)).id();
    let before = studio.take();
    let yellow = [255, 255, 0, 255];
    let mut material = studio
        .app
        .world_mut()
        .get_mut::<CarvedMaterial>(entity)
        .expect("it has one");
    material.cap = Finish::from(Color::srgb(1.0, 1.0, 0.0));
    let after = studio.take();
    for (before, after) in before.pixels.iter().zip(&after.pixels) {
        let expected = if class_of(*before) == 1 {
            yellow
        } else {
            *before
        };
        assert_eq!(*after, expected);
    }
    // What the finishes leave open is the base material's.
    studio
        .app
        .world_mut()
        .entity_mut(entity)
        .insert(CarvedMaterial {
            base: base.clone(),
            ..default()
        });
    let mut materials = studio
        .app
        .world_mut()
        .resource_mut::<Assets<StandardMaterial>>();
    let mut base = materials.get_mut(&base).expect("it is there");
    base.base_color = Color::srgb(0.0, 1.0, 1.0);
    drop(base);
    let plain = studio.take();
    let cyan = [0, 255, 255, 255];
    for (before, plain) in before.pixels.iter().zip(&plain.pixels) {
        let expected = if class_of(*before) == 0 {
            *before
        } else {
            cyan
        };
        assert_eq!(*plain, expected);
    }
    studio::assert_no_messages();
}

#[test]
fn bad_input_is_an_error_that_names_the_entity() {
    let _alone = ALONE.lock().expect("the other tests passed");
    let mut studio = Studio::open(SIZE);
    let good = carved(&mut studio);
    let mut bare = torus();
    bare.remove_attribute(Mesh::ATTRIBUTE_UV_0);
    let bare: Handle<Mesh> = studio.add(bare);
    let missing: Handle<Pattern> = studio
        .app
        .world()
        .resource::<AssetServer>()
        .load("patterns/none.png");
    let cases = [
        (
            Carved {
                mesh: bare,
                ..good.clone()
            },
            "no texture coordinates",
        ),
        (
            Carved {
                pattern: missing,
                ..good.clone()
            },
            "patterns/none.png",
        ),
        (
            Carved {
                mesh: Handle::default(),
                ..good.clone()
            },
            "its mesh is not set",
        ),
        (
            Carved {
                depth: Some(-1.0),
                ..good.clone()
            },
            "depth",
        ),
        (
            Carved {
                repeat: Vec2::ZERO,
                ..good.clone()
            },
            "repeat",
        ),
    ];
    for (carved, text) in cases {
        MESSAGES.lock().expect("no test panicked in it").clear();
        let name = Name::new("the broken one");
        let entity = studio.app.world_mut().spawn((carved, name)).id();
        let begin = std::time::Instant::now();
        let is_said = || {
            let messages = MESSAGES.lock().expect("no test panicked in it");
            messages
                .iter()
                .any(|message| message.contains("the broken one") && message.contains(text))
        };
        while !is_said() {
            studio.app.update();
            let messages = MESSAGES.lock().expect("no test panicked in it");
            assert!(begin.elapsed().as_secs() < 60, "{text}: {messages:#?}");
        }
        assert!(studio.app.world().get::<IsPrepared>(entity).is_none());
        studio.app.world_mut().despawn(entity);
    }
    // The others are drawn all the same.
    studio.camera(&VIEW);
    let material = class_material(&mut studio);
    studio.app.world_mut().spawn((good, material));
    let picture = studio.take();
    let covered = picture
        .pixels
        .iter()
        .filter(|pixel| class_of(**pixel) != 0)
        .count();
    assert!(covered > 8000, "{covered}");
    MESSAGES.lock().expect("no test panicked in it").clear();
}
