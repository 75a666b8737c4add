//! The exported function `relievo_hit`, called by programs of others.

use super::cases::{Case, cases, exported, prepared};
use super::opengl::{self, text};
use super::webgpu::{self, parsed, wgsl};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use relievo::export::{ExportedFile, Interface, MapForm, Options, Output, Target, export};
use relievo::prepare::prepare;
use relievo::render::gpu::{Choice, GpuRenderer, Shaders};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Color, Layer, Material, Scene, Technique};
use relievo_bitwise::{Adapter, Device};
use relievo_tests::{asset, every_adapter, lacking};
use std::collections::BTreeSet;
use std::process::Command;

/// A fragment shader in WGSL that calls the function and writes what our geometry pictures
/// have: the place, or the class and the normal.
fn foreign_wgsl(files: &[ExportedFile], writes: &str) -> String {
    const REST: &str = "
struct Camera { at: array<f32> }
@group(0) @binding(0) var<storage> camera: Camera;
fn of_camera(i: u32) -> vec3<f32> { return vec3<f32>(camera.at[i], camera.at[i + 1u], camera.at[i + 2u]); }
fn unit(v: vec3<f32>) -> vec3<f32> { return v * (1.0 / sqrt(dot(v, v))); }
struct Out { @location(0) words: vec4<f32>, @builtin(frag_depth) depth: f32 }
@fragment
fn fs_main(@builtin(position) at: vec4<f32>, @location(0) @interpolate(flat) facet: u32) -> Out {
    let right = of_camera(16u);
    let down = of_camera(19u);
    let ray = unit(of_camera(13u) + right * floor(at.x) + down * floor(at.y));
    let forward = of_camera(10u);
    let near = camera.at[3];
    let hit = relievo_hit(of_camera(0u), ray, forward, right, down, near, facet);
    if hit.surface_class == 0u { discard; }
    let place = vec4<f32>(hit.t * camera.at[33], hit.uv, hit.depth_fraction);
    let axes = mat3x3<f32>(of_camera(34u), of_camera(37u), of_camera(40u));
    let surface = vec4<f32>(f32(hit.surface_class), axes * hit.normal);
    return Out(WRITES, near / (hit.t * dot(ray, forward)));
}
";
    text(files, "hit.wgsl") + &REST.replace("WRITES", writes)
}

/// The same in GLSL.
fn foreign_glsl(files: &[ExportedFile], writes: &str) -> String {
    const REST: &str = "
layout(std430, binding = 0) readonly buffer Camera { float camera[]; };
layout(location = 0) flat in uint facet;
layout(location = 0) out vec4 words;
vec3 of_camera(uint i) { return vec3(camera[i], camera[i + 1u], camera[i + 2u]); }
vec3 unit(vec3 v) { return v * (1.0 / sqrt(v.x * v.x + v.y * v.y + v.z * v.z)); }
void main() {
    vec3 right = of_camera(16u);
    vec3 down = of_camera(19u);
    float y = floor(camera[32] - gl_FragCoord.y);
    vec3 ray = unit(of_camera(13u) + right * floor(gl_FragCoord.x) + down * y);
    vec3 forward = of_camera(10u);
    float near = camera[3];
    RelievoHit hit = relievo_hit(of_camera(0u), ray, forward, right, down, near, facet);
    if (hit.surface_class == 0u) { discard; }
    vec4 place = vec4(hit.t * camera[33], hit.uv, hit.depth_fraction);
    mat3 axes = mat3(of_camera(34u), of_camera(37u), of_camera(40u));
    vec4 surface = vec4(float(hit.surface_class), axes * hit.normal);
    words = WRITES;
    gl_FragDepth = near / (hit.t * dot(ray, forward));
}
";
    let rest = REST.replace("WRITES", writes);
    format!("#version 450 core\n{}{rest}", text(files, "hit.glsl"))
}

/// Differences of a foreign program from our portable shaders that are accepted.
struct Bounds {
    /// Pixels with another class.
    classes: usize,
    /// Of a distance in relation to it, of texture coordinates (repeats), of a depth fraction, and of a
    /// normal's part.
    words: f32,
}

/// What was measured on Mesa's software drivers, rounded up: nothing in WGSL, nor in GLSL but for the
/// paper's algorithms, whose quotients magnify rounding errors. GPUs have not been measured yet.
fn bounds(case: &Case, target: Target, is_software: bool) -> Bounds {
    let is_paper = case.name.starts_with("color_paper");
    let (classes, words) = match (is_software, target) {
        (false, _) => (20, 1e-3),
        (true, Target::Glsl) if is_paper => (0, 2e-5),
        (true, _) => (0, 0.0),
    };
    Bounds { classes, words }
}

/// The scenes, one for each search and for several objects, on black.
fn scenes() -> Vec<Case> {
    let mut all = cases();
    all.retain(|case| !case.name.ends_with("_shadow"));
    for case in &mut all {
        case.scene.background = [0.0; 3];
    }
    all
}

/// Compares two pictures of a foreign program, of the places and of the surfaces, with ours.
fn check(
    case: &Case,
    adapter: &Adapter,
    bounds: &Bounds,
    place: &[[u32; 4]],
    surface: &[[u32; 4]],
) {
    let choice = Choice::These(Shaders::Portable);
    let mut renderer = GpuRenderer::new(&case.scene, adapter, choice).unwrap();
    let ours = renderer.geometry(&case.scene.frame).unwrap();
    let floats = |words: [u32; 4]| words.map(f32::from_bits);
    let (mut covered, mut classes, mut largest) = (0, 0, [0.0f32; 4]);
    for index in 0..ours.place.len() {
        let class = ours.surface[index][0] & 0xff;
        let theirs = floats(surface[index]);
        if theirs[0] != class as f32 {
            classes += 1;
            continue;
        }
        if class == 0 {
            continue;
        }
        covered += 1;
        let normals = (1..4).map(|i| (floats(ours.surface[index])[i] - theirs[i]).abs());
        let normal = normals.fold(0.0, f32::max);
        let (ours, theirs) = (floats(ours.place[index]), floats(place[index]));
        // Ours have no whole repeats.
        let turned = |i: usize| {
            let apart = (ours[i] - theirs[i]).rem_euclid(1.0);
            apart.min(1.0 - apart)
        };
        let apart = [
            (ours[0] - theirs[0]).abs() / ours[0],
            turned(1).max(turned(2)),
            (ours[3] - theirs[3]).abs(),
            normal,
        ];
        assert!(apart.iter().all(|apart| apart.is_finite()), "{apart:?}");
        largest = std::array::from_fn(|i| largest[i].max(apart[i]));
    }
    assert!(covered > 1000, "{}: there is something to see", case.name);
    eprintln!(
        "{}: {classes} classes; t, uv, depth fraction, normal: {largest:?}",
        case.name
    );
    let is_small = classes <= bounds.classes && largest.iter().all(|found| *found <= bounds.words);
    assert!(is_small, "{}: {classes} classes, {largest:?}", case.name);
}

#[test]
fn gpu_a_foreign_program_in_wgsl_calls_the_hit() {
    let adapter = every_adapter().swap_remove(0);
    let device = adapter.open().unwrap();
    for case in scenes() {
        let objects = exported(&case.scene, Target::Wgsl, Output::Hit);
        let [place, surface] = ["place", "surface"].map(|writes| {
            let load = |device: &Device, files: &[ExportedFile]| {
                let vertex = parsed(device, text(files, "vertex.wgsl"));
                [vertex, parsed(device, foreign_wgsl(files, writes))]
            };
            webgpu::draw(&device, &case.scene, &objects, Output::Hit, &load, None)
        });
        eprint!("WGSL on {}, ", device.describe());
        let bounds = bounds(&case, Target::Wgsl, adapter.is_software());
        check(&case, &adapter, &bounds, &place, &surface);
    }
}

#[test]
fn gpu_a_foreign_program_in_glsl_calls_the_hit() {
    let gl = match opengl::open() {
        Ok(gl) => gl,
        Err(reason) => return lacking(&format!("OpenGL 4.5 by way of EGL ({reason})")),
    };
    let adapter = every_adapter().swap_remove(0);
    for case in scenes() {
        let objects = exported(&case.scene, Target::Glsl, Output::Hit);
        let [place, surface] = ["place", "surface"].map(|writes| {
            opengl::draw(&gl, &case.scene, &objects, Output::Hit, |files| {
                foreign_glsl(files, writes)
            })
        });
        let bounds = bounds(&case, Target::Glsl, adapter.is_software());
        check(&case, &adapter, &bounds, &place, &surface);
    }
}

/// A depth prepass has the depths of the colours in every bit: what is drawn passes as equal.
#[test]
fn gpu_colours_and_depths_alone_agree_in_every_bit() {
    let adapter = every_adapter().swap_remove(0);
    let device = adapter.open().unwrap();
    for case in scenes() {
        let objects = exported(&case.scene, Target::Wgsl, Output::Hit);
        let [alone, after] = [None, Some("fs_depth")].map(|prepass| {
            webgpu::draw(&device, &case.scene, &objects, Output::Hit, &wgsl, prepass)
        });
        let covered = alone.iter().filter(|pixel| pixel[..3] != [0; 3]).count();
        assert!(covered > 1000, "{}: there is something to see", case.name);
        let is_there = |pixel: &[u32; 4]| pixel[..3] != [0; 3];
        let largest = |a: &[u32; 4], b: &[u32; 4]| {
            let apart = |i: usize| (f32::from_bits(a[i]) - f32::from_bits(b[i])).abs();
            apart(0).max(apart(1)).max(apart(2))
        };
        // Where two prisms find the hit at the same depth, the first is drawn alone, and the last
        // after a prepass.
        let most = if case.name.starts_with("color_prisms") {
            2e-5
        } else {
            0.0
        };
        for (alone, after) in alone.iter().zip(&after) {
            assert_eq!(is_there(alone), is_there(after), "{}", case.name);
            assert!(largest(alone, after) <= most, "{}", case.name);
        }
    }
}

/// Colours of cap, wall, bevel and floor that tell a number.
fn numbered(number: u32) -> Material {
    let color = Color::from_hex(0x100000 * (number + 1));
    Material {
        cap: color,
        wall: color,
        bevel: color,
        floor: color,
        specular: 0.0,
        ..Material::default()
    }
}

/// Hits know their object and their layer: in colours without light each has its own.
#[test]
fn gpu_hits_tell_object_and_layer() {
    let device = every_adapter().swap_remove(0).open().unwrap();
    let load = |device: &Device, files: &[ExportedFile]| {
        let writes = "vec4<f32>(f32(hit.surface_class), f32(hit.object), f32(hit.layer), 1.0)";
        let vertex = parsed(device, text(files, "vertex.wgsl"));
        [vertex, parsed(device, foreign_wgsl(files, writes))]
    };
    for (name, count) in [("together.toml", 3), ("torus.toml", 2)] {
        let mut scene = Scene::load(&asset("scenes").join(name)).unwrap();
        scene.size = [160, 120];
        scene.supersampling = 1;
        scene.light.color = Color::from_hex(0);
        scene.light.ambient = Color::from_hex(0xffffff);
        if let [object] = &mut scene.objects[..] {
            let wider = Layer::new(object.shape.clone()).with_technique(Technique::Beveled);
            object.layers = vec![Layer {
                material: numbered(1),
                ..wider.top(0.4)
            }];
        }
        for (number, object) in (0..).zip(&mut scene.objects) {
            object.material = numbered(number);
        }
        let scene = prepare(&scene, &|_| ()).unwrap();
        let is_layered = scene.objects.len() == 1;
        let objects = exported(&scene, Target::Wgsl, Output::Hit);
        let found = webgpu::draw(&device, &scene, &objects, Output::Hit, &load, None);
        let colors = CpuRenderer::new(&scene).color(&scene.frame).unwrap();
        let reds: Vec<f32> = (0..count)
            .map(|number| numbered(number).cap.linear()[0])
            .collect();
        let mut seen = BTreeSet::new();
        for ([class, object, layer, _], color) in found.iter().zip(&colors.words) {
            let [class, object, layer] = [class, object, layer].map(|bits| f32::from_bits(*bits));
            // Of the background, and where a floor has the object's colour.
            if class != color[3] as f32 || class == 0.0 || (class == 4.0 && is_layered) {
                continue;
            }
            let told = if is_layered { layer } else { object };
            assert!(!is_layered || object == 0.0);
            assert_eq!(reds[told as usize], f32::from_bits(color[0]), "{name}");
            seen.insert(told as u32);
        }
        assert_eq!(seen, (0..count).collect(), "{name}: all are seen");
    }
}

/// A shape map in a texture is read as one in a buffer.
#[test]
fn gpu_a_map_in_a_texture_gives_the_same_words() {
    let device = every_adapter().swap_remove(0).open().unwrap();
    let gl = opengl::open();
    for name in ["color_extrusion", "color_prisms", "color_layers"] {
        let case = scenes().into_iter().find(|case| case.name == name).unwrap();
        let [buffer, texture] = [MapForm::Buffer, MapForm::Texture].map(|map| {
            let options = Options {
                targets: vec![Target::Wgsl, Target::Glsl],
                output: Output::Hit,
                interface: Interface {
                    map,
                    ..Interface::default()
                },
                ..Options::default()
            };
            [export(&case.scene, &options).unwrap()]
        });
        let rows = webgpu::map_size(&texture[0]).unwrap()[1];
        assert!(rows > 1 && webgpu::map_size(&buffer[0]).is_none());
        let [words, found] = [&buffer, &texture]
            .map(|objects| webgpu::draw(&device, &case.scene, objects, Output::Hit, &wgsl, None));
        let covered = words.iter().filter(|pixel| pixel[..3] != [0; 3]).count();
        assert!(covered > 1000, "{name}: there is something to see");
        assert!(words == found, "{name}, WGSL");
        match &gl {
            Ok(gl) => {
                let [words, found] = [&buffer, &texture].map(|objects| {
                    let fragment = |files: &[ExportedFile]| text(files, "fragment.frag");
                    opengl::draw(gl, &case.scene, objects, Output::Hit, fragment)
                });
                assert!(words == found, "{name}, GLSL");
            }
            Err(reason) => lacking(&format!("OpenGL 4.5 by way of EGL ({reason})")),
        }
    }
}

/// Two objects' functions and their buffers do not meet in one shader.
#[test]
fn two_hits_fit_in_one_shader() {
    let scene = prepared("torus.toml", |_| ());
    let of = |prefix: &str, first_binding| {
        let options = Options {
            targets: vec![Target::Wgsl, Target::Glsl],
            output: Output::Hit,
            interface: Interface {
                prefix: prefix.to_string(),
                group: 1,
                first_binding,
                ..Interface::default()
            },
            ..Options::default()
        };
        export(&scene, &options).unwrap()
    };
    let [wall, roof] = [of("my_wall", 4), of("roof", 8)];
    let both = text(&wall, "hit.wgsl") + &text(&roof, "hit.wgsl");
    let wgsl = format!(
        "{both}
@fragment fn fs_main(@location(0) at: vec3<f32>) -> @location(0) vec4<f32> {{
    let first: MyWallHit = my_wall_hit(at, at, at, at, at, 1.0, 0u);
    let second: RoofHit = roof_hit(at, at, at, at, at, 1.0, 0u);
    return vec4<f32>(first.normal, second.t);
}}"
    );
    let module = naga::front::wgsl::parse_str(&wgsl)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&wgsl)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&wgsl)));
    let bindings: BTreeSet<(u32, u32)> = module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| variable.binding)
        .map(|binding| (binding.group, binding.binding))
        .collect();
    let wanted = [5, 6, 7, 9, 10, 11].map(|binding| (1, binding));
    assert_eq!(bindings, wanted.into());

    let both = text(&wall, "hit.glsl") + &text(&roof, "hit.glsl");
    let glsl = format!(
        "#version 450 core
{both}
layout(location = 0) in vec3 at;
layout(location = 0) out vec4 color;
void main() {{
    MyWallHit first = my_wall_hit(at, at, at, at, at, 1.0, 0u);
    RoofHit second = roof_hit(at, at, at, at, at, 1.0, 0u);
    color = vec4(first.normal, second.t);
}}"
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.frag");
    std::fs::write(&file, glsl).unwrap();
    match Command::new("glslangValidator").arg(&file).output() {
        Ok(run) => assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stdout)
        ),
        Err(_) => lacking("glslangValidator"),
    }
}
