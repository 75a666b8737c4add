//! A headless Bevy app that takes pictures, and the same scene in Relievo's CPU renderer.

#![allow(dead_code)] // Each test uses a part.

use bevy::app::PluginsState;
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::camera::ShadowLodOrigin;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::log::LogPlugin;
use bevy::log::tracing::{Event, Level, Subscriber, field};
use bevy::log::tracing_subscriber::layer::{Context, Layer};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{PipelineCache, TextureFormat};
use bevy::render::settings::{InstanceFlags, RenderCreation, WgpuSettings};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::render::{RenderApp, render_resource::CachedPipelineState};
use bevy::window::ExitCondition;
use relievo::mesh::MeshData;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Camera as RelievoCamera, Scene, SceneObject};
use relievo_bevy::{Carved, CarvedMaterial, Finish, IsPrepared, RelievoPlugin};
use relievo_shared::layout::Frame;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Returns a ring of 24 × 48 faces.
pub fn torus() -> Mesh {
    let torus = Torus {
        minor_radius: 0.4,
        major_radius: 1.0,
    };
    torus
        .mesh()
        .minor_resolution(24)
        .major_resolution(48)
        .build()
}

/// Every warning and error since the program began, those of the validation layers included.
pub static MESSAGES: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Collects [`MESSAGES`].
struct Collector;

impl<S: Subscriber> Layer<S> for Collector {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if *event.metadata().level() > Level::WARN {
            return;
        }
        let mut text = format!("{}:", event.metadata().target());
        event.record(&mut |field: &field::Field, value: &dyn std::fmt::Debug| {
            write!(text, " {field}={value:?}").expect("a string takes it");
        });
        // Bevy says so of lavapipe.
        if text.contains("only supports software rendering") {
            return;
        }
        MESSAGES.lock().expect("no test panicked in it").push(text);
    }
}

/// The pattern of the tests, which is as large as it is fine.
pub fn pattern(name: &str) -> relievo::shape_map::Pattern {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets/patterns");
    relievo::shape_map::Pattern::load(path.join(name), &Default::default()).expect("a pattern")
}

/// A picture, rows from the top.
#[derive(Clone, PartialEq)]
pub struct Picture {
    pub size: [u32; 2],
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    /// Saves it for people, in the folder of the tests' outputs.
    pub fn save(&self, name: &str) {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pictures");
        std::fs::create_dir_all(&folder).expect("a folder");
        let bytes: Vec<u8> = self.pixels.iter().flatten().copied().collect();
        let path = folder.join(format!("{name}.png"));
        image::save_buffer(
            &path,
            &bytes,
            self.size[0],
            self.size[1],
            image::ColorType::Rgba8,
        )
        .expect("a file");
        eprintln!("{}", path.display());
    }
}

#[derive(Resource, Default)]
struct Taken(Option<Picture>);

/// The app.
pub struct Studio {
    pub app: App,
    pub size: [u32; 2],
    target: Handle<Image>,
}

impl Studio {
    /// Opens an app that draws pictures of `size` pixels.
    pub fn open(size: [u32; 2]) -> Studio {
        Studio::open_with(size, |_| ())
    }

    /// The same, with more plugins.
    pub fn open_with(size: [u32; 2], add: impl FnOnce(&mut App)) -> Studio {
        // One app of the process collects the messages of all.
        static COLLECTS: AtomicBool = AtomicBool::new(false);
        let mut app = App::new();
        let settings = WgpuSettings {
            instance_flags: InstanceFlags::VALIDATION | InstanceFlags::DEBUG,
            ..default()
        };
        let plugins = DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                render_creation: RenderCreation::Automatic(Box::new(settings)),
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .set(AssetPlugin {
                file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets").to_string(),
                ..default()
            })
            .set(LogPlugin {
                level: Level::WARN,
                filter: String::new(),
                custom_layer: |_| Some(Box::new(Collector)),
                ..default()
            });
        let plugins = match COLLECTS.swap(true, Ordering::Relaxed) {
            false => plugins,
            true => plugins.disable::<LogPlugin>(),
        };
        // Pipelines are looked at between frames.
        let plugins = plugins.disable::<PipelinedRenderingPlugin>();
        #[cfg(feature = "window")]
        let plugins = plugins.disable::<bevy::winit::WinitPlugin>();
        app.add_plugins((plugins, RelievoPlugin))
            .insert_resource(ClearColor(Color::BLACK))
            .insert_resource(GlobalAmbientLight::NONE)
            .init_resource::<Taken>()
            .add_observer(
                |captured: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| {
                    let image = captured.image.clone().try_into_dynamic().expect("pixels");
                    let image = image.into_rgba8();
                    taken.0 = Some(Picture {
                        size: [image.width(), image.height()],
                        pixels: image.pixels().map(|pixel| pixel.0).collect(),
                    });
                },
            );
        add(&mut app);
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = Image::new_target_texture(size[0], size[1], format, None);
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        Studio { app, size, target }
    }

    pub fn add<A: Asset>(&mut self, asset: impl Into<A>) -> Handle<A> {
        self.app
            .world_mut()
            .resource_mut::<Assets<A>>()
            .add(asset.into())
    }

    /// Places a perspective camera.
    pub fn camera(&mut self, view: &View) -> Entity {
        let projection = PerspectiveProjection {
            fov: view.field_of_view.to_radians(),
            near: view.near,
            ..default()
        };
        self.camera_with(view, projection.into())
    }

    pub fn camera_with(&mut self, view: &View, projection: Projection) -> Entity {
        let target = RenderTarget::Image(self.target.clone().into());
        let camera = (
            Camera3d::default(),
            target,
            Msaa::Off,
            Tonemapping::None,
            // It would change colours that stand for classes.
            DebandDither::Disabled,
            ShadowLodOrigin,
            projection,
            view.transform(),
        );
        self.app.world_mut().spawn(camera).id()
    }

    /// Draws until every carved entity is prepared and every pipeline compiled, and takes a
    /// picture.
    pub fn take(&mut self) -> Picture {
        self.take_moving(|_| ())
    }

    /// The same, and calls `change` before each frame up to that of the picture.
    pub fn take_moving(&mut self, mut change: impl FnMut(&mut World)) -> Picture {
        let begin = std::time::Instant::now();
        let mut quiet = 0;
        while quiet < 3 {
            change(self.app.world_mut());
            self.app.update();
            let world = self.app.world_mut();
            let waiting = world
                .query_filtered::<(), (With<Carved>, Without<IsPrepared>)>()
                .iter(world)
                .count();
            quiet = if waiting == 0 { quiet + 1 } else { 0 };
            assert!(
                begin.elapsed().as_secs() < 300,
                "{waiting} entities are not prepared"
            );
        }
        self.check_pipelines();
        let world = self.app.world_mut();
        world.resource_mut::<Taken>().0 = None;
        world.spawn(Screenshot::image(self.target.clone()));
        change(world);
        loop {
            self.app.update();
            if let Some(picture) = self.app.world_mut().resource_mut::<Taken>().0.take() {
                return picture;
            }
            assert!(begin.elapsed().as_secs() < 300, "no picture came");
        }
    }

    fn check_pipelines(&self) {
        let render = self.app.sub_app(RenderApp).world();
        for pipeline in render.resource::<PipelineCache>().pipelines() {
            if let CachedPipelineState::Err(error) = &pipeline.state {
                panic!("{error}");
            }
        }
    }
}

/// Fails if there were warnings or errors.
pub fn assert_no_messages() {
    let messages = MESSAGES.lock().expect("no test panicked in it");
    assert!(messages.is_empty(), "{messages:#?}");
}

/// Where a camera stands.
#[derive(Clone, Copy, Debug)]
pub struct View {
    pub eye: Vec3,
    pub target: Vec3,
    /// Vertical, degrees.
    pub field_of_view: f32,
    /// Distance of the near plane.
    pub near: f32,
}

impl View {
    pub fn transform(&self) -> Transform {
        Transform::from_translation(self.eye).looking_at(self.target, Vec3::Y)
    }

    /// Returns the unit vector from the eye through a pixel.
    pub fn ray(&self, size: [u32; 2], x: u32, y: u32) -> Vec3 {
        let tangent = (0.5 * self.field_of_view.to_radians()).tan();
        let [width, height] = size.map(|side| side as f32);
        let right = (2.0 * (x as f32 + 0.5) / width - 1.0) * tangent * width / height;
        let up = (1.0 - 2.0 * (y as f32 + 0.5) / height) * tangent;
        (self.transform().rotation * Vec3::new(right, up, -1.0)).normalize()
    }

    /// Returns where in the picture a point is, from 0 at the left and the top to 1.
    pub fn project(&self, size: [u32; 2], point: Vec3) -> Vec2 {
        let tangent = (0.5 * self.field_of_view.to_radians()).tan();
        let local = self.transform().rotation.inverse() * (point - self.eye);
        let aspect = size[0] as f32 / size[1] as f32;
        0.5 + 0.5 * Vec2::new(local.x / aspect, -local.y) / (-local.z * tangent)
    }
}

/// The colours of the classes, cap first.
pub const COLORS: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];

/// A material that shows the class of each pixel.
pub fn class_material(studio: &mut Studio) -> CarvedMaterial {
    let [cap, wall, bevel, floor] = COLORS.map(|[r, g, b]| Finish::from(Color::srgb_u8(r, g, b)));
    CarvedMaterial {
        base: studio.add(StandardMaterial {
            unlit: true,
            ..default()
        }),
        cap,
        wall,
        bevel,
        floor,
        ..default()
    }
}

/// Returns the class of a pixel that is drawn with [`class_material`]; 0 for the background.
pub fn class_of(pixel: [u8; 4]) -> u32 {
    let [r, g, b, _] = pixel;
    let found = COLORS.iter().position(|color| *color == [r, g, b]);
    match ([r, g, b], found) {
        ([0, 0, 0], _) => 0,
        (_, Some(index)) => index as u32 + 1,
        _ => u32::MAX,
    }
}

/// The carved object in Relievo, in its own space.
pub struct Twin {
    scene: Scene,
    prepared: PreparedScene,
}

/// What a pixel of [`Twin`] hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// 0 for nothing.
    pub class: u32,
    /// Distance from the eye, object units.
    pub t: f32,
    /// Unit normal of the carved surface, object space.
    pub normal: Vec3,
}

impl Twin {
    pub fn new(mesh: &Mesh, pattern: relievo::shape_map::Pattern, carved: &Carved) -> Twin {
        let floats = |id| mesh.attribute(id).expect("an attribute");
        let positions = floats(Mesh::ATTRIBUTE_POSITION)
            .as_float3()
            .expect("vectors");
        let normals = floats(Mesh::ATTRIBUTE_NORMAL).as_float3().expect("vectors");
        let bevy::mesh::VertexAttributeValues::Float32x2(uvs) = floats(Mesh::ATTRIBUTE_UV_0) else {
            panic!("pairs");
        };
        let indices: Vec<u32> = mesh
            .indices()
            .expect("indices")
            .iter()
            .map(|i| i as u32)
            .collect();
        let triangles = indices.as_chunks::<3>().0.to_vec();
        let wide = |v: &[f32; 3]| v.map(f64::from);
        let data = MeshData::new(
            "mesh",
            positions.iter().map(wide).collect::<Vec<_>>(),
            triangles,
        )
        .with_normals(normals.iter().map(wide).collect::<Vec<_>>())
        .with_uvs(
            uvs.iter()
                .map(|[u, v]| [f64::from(*u), 1.0 - f64::from(*v)])
                .collect::<Vec<_>>(),
        );
        let mut object = SceneObject::new(data, pattern)
            .with_technique(carved.technique)
            .tier(carved.tier)
            .repeat(carved.repeat.x, carved.repeat.y)
            .cut_out(carved.cut_out)
            .raised(carved.raised);
        object.depth = carved.depth.map(f64::from);
        let scene = Scene::default().supersample(false).object(object);
        Twin::of(scene)
    }

    /// Prepares a scene.
    pub fn of(scene: Scene) -> Twin {
        let prepared = prepare(&scene, &|_| ()).expect("a scene");
        Twin { scene, prepared }
    }

    /// Returns the view of the scene's own camera.
    pub fn view(&self) -> View {
        let RelievoCamera { eye, target, .. } = self.prepared.camera;
        View {
            eye: Vec3::from(eye.map(|part| part as f32)),
            target: Vec3::from(target.map(|part| part as f32)),
            field_of_view: self.scene.field_of_view as f32,
            near: 0.1,
        }
    }

    /// Returns the frame of a picture; the view is in the space of the object.
    fn frame(&self, view: &View, up: Vec3, size: [u32; 2]) -> Frame {
        let camera = RelievoCamera {
            eye: view.eye.to_array().map(f64::from),
            target: view.target.to_array().map(f64::from),
            up: up.to_array().map(f64::from),
        };
        let scene = self
            .scene
            .clone()
            .field_of_view(f64::from(view.field_of_view));
        let mut frame = self.prepared.frame_from(&scene, &camera, size);
        frame.near = view.near;
        frame
    }

    /// Returns the colour of each pixel of a picture, none for the background.
    pub fn colors(&self, view: &View, up: Vec3, size: [u32; 2]) -> Vec<Option<[u8; 3]>> {
        let words = CpuRenderer::new(&self.prepared)
            .color(&self.frame(view, up, size))
            .expect("a picture");
        let byte = |bits: &u32| (255.0 * f32::from_bits(*bits)) as u8;
        let color = |[red, green, blue, class]: &[u32; 4]| {
            (*class != 0).then(|| [red, green, blue].map(byte))
        };
        words.words.iter().map(color).collect()
    }

    /// Returns what each pixel of a picture hits; the view is in the space of the object.
    pub fn hits(&self, view: &View, up: Vec3, size: [u32; 2]) -> Vec<Hit> {
        let words = CpuRenderer::new(&self.prepared)
            .geometry(&self.frame(view, up, size))
            .expect("a picture");
        (0..(size[0] * size[1]) as usize)
            .map(|index| Hit {
                class: words.class(index),
                t: words.t(index),
                normal: words.normal(index).into(),
            })
            .collect()
    }
}

/// A mesh that stays in memory.
pub fn kept(mesh: impl Into<Mesh>) -> Mesh {
    let mut mesh: Mesh = mesh.into();
    mesh.asset_usage = RenderAssetUsages::default();
    mesh
}
