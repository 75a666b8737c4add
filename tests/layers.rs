//! Objects with layers: against closed forms, on GPU and CPU, and what is refused.

use glam::DVec3;
use relievo::oracle::{Accuracy, AnalyticOracle, MeshOracle, Truth};
use relievo::prepare::prepare;
use relievo::render::gpu::{Choice, Shaders, signature};
use relievo::render::{CpuRenderer, GpuRenderer, Renderer};
use relievo::scene::Scene;
use relievo::shape_map::{Pattern, Storage, bake};
use relievo::verify::compare;
use relievo::{Files, Limits};
use relievo_shared::normals::CLASS_CAP;
use relievo_tests::{asset, every_adapter};
use std::path::Path;

/// An SVG document of 100 × 100 units with one path.
fn drawing(path: &str) -> String {
    format!(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 100 100'><path fill-rule='evenodd' d='{path}'/></svg>"
    )
}

const WALL: &str = "M0 0H100V100H0Z M25 20H75V80H25Z";
const FRAME: &str = "M25 20H75V80H25Z M33 28H67V72H33Z";
const BARS: &str = "M47 20H53V80H47Z M25 47H75V53H25Z";

/// A mesh of `assets/` with windows: a wall, frames that grow with the depth, and bars before
/// the floor.
fn windows(mesh: &str, eye: [f64; 3], repeat: [u32; 2], tier: &str) -> Scene {
    let [wall, frame, bars] = [WALL, FRAME, BARS].map(drawing);
    let text = format!(
        r##"
        [image]
        size = [320, 240]
        [camera]
        eye = {eye:?}
        fov = 38.0
        [[object]]
        mesh = "../meshes/{mesh}.obj"
        shape = {{ svg = "{wall}" }}
        raster = 128
        repeat = {repeat:?}
        depth = 0.08
        tier = "{tier}"
        self_shadow = true
        [[object.layer]]
        shape = {{ svg = "{frame}" }}
        top = 0.4
        bevel = 0.04
        chamfer = 0.5
        material = {{ cap = "#ff6347", wall = "#008080", bevel = "#ffd700" }}
        [[object.layer]]
        shape = {{ svg = "{bars}" }}
        top = 0.6
        bottom = 0.8
        material = {{ cap = "#ffffff" }}
        "##
    );
    Scene::parse(&text, &asset("scenes/test.toml")).unwrap()
}

const PLACES: [(&str, [f64; 3], [u32; 2]); 3] = [
    ("cylinder", [1.0, 0.6, 2.6], [16, 8]),
    ("sphere", [0.6, 0.9, 3.4], [16, 8]),
    ("torus", [0.0, 2.3, 3.4], [24, 10]),
];

/// Compares the accurate tier with the closed form of a mesh and with its prisms in f64.
fn accuracy(scene: &Scene) -> [Accuracy; 2] {
    let prepared = prepare(scene, &|_| ()).unwrap();
    let words = CpuRenderer::new(&prepared)
        .geometry(&prepared.frame)
        .unwrap();
    let eye = DVec3::from(prepared.camera.eye);
    let closed = AnalyticOracle::find(&scene.objects[0], &prepared.objects[0]).unwrap();
    let closed = Truth::of(&closed, eye, &prepared.frame).compare(&words);
    let prisms = MeshOracle::new(&prepared);
    let prisms = Truth::of(&prisms, eye, &prepared.frame).compare(&words);
    [closed, prisms]
}

#[test]
fn layers_of_curved_surfaces_are_those_of_closed_forms() {
    for (mesh, eye, repeat) in PLACES {
        let [closed, prisms] = accuracy(&windows(mesh, eye, repeat, "accurate"));
        println!("{mesh}: {closed:?}\n    {prisms:?}");
        assert!(closed.silhouette_iou > 0.998, "{mesh}: {closed:?}");
        // Just above the measured values: the meshes are not quite these surfaces.
        assert!(closed.class_errors < 0.022, "{mesh}: {closed:?}");
        assert!(prisms.silhouette_iou > 0.9999, "{mesh}: {prisms:?}");
        assert_eq!(prisms.interior_holes, 0, "{mesh}: {prisms:?}");
        assert!(prisms.class_errors < 0.002, "{mesh}: {prisms:?}");
    }
}

#[test]
fn layers_have_the_same_words_on_gpu_and_cpu_in_every_tier() {
    for found in every_adapter()
        .into_iter()
        .filter(|found| found.takes_spirv())
    {
        let fuses = Shaders::Fused.suit(&signature(&found.open().unwrap()).unwrap());
        for tier in ["planar", "fast", "accurate"] {
            let mut scene = windows("torus", [0.0, 2.3, 3.4], [12, 5], tier);
            scene.size = [160, 120];
            let scene = prepare(&scene, &|_| ()).unwrap();
            let mut cpu = CpuRenderer::new(&scene);
            let color = cpu.color(&scene.frame).unwrap();
            let geometry = cpu.geometry(&scene.frame).unwrap();
            for shaders in [Shaders::Exact, Shaders::Fused] {
                if shaders == Shaders::Fused && !fuses {
                    continue;
                }
                let mut gpu = GpuRenderer::new(&scene, &found, Choice::These(shaders)).unwrap();
                let on_gpu = gpu.color(&scene.frame).unwrap();
                let geometry_on_gpu = gpu.geometry(&scene.frame).unwrap();
                let agreement = compare([&on_gpu, &color], [&geometry_on_gpu, &geometry]);
                assert!(
                    agreement.is_exact(),
                    "{tier}, {shaders:?}, {}: {agreement:?}",
                    found.describe()
                );
            }
        }
    }
}

/// Nothing stands on the surface of the mesh.
#[test]
fn the_cap_of_the_first_layer_has_no_shadow() {
    for tier in ["fast", "accurate"] {
        let mut scene = windows("cylinder", [1.0, 0.6, 2.6], [16, 8], tier);
        let draw = |scene: &Scene| {
            let prepared = prepare(scene, &|_| ()).unwrap();
            let mut cpu = CpuRenderer::new(&prepared);
            let color = cpu.color(&prepared.frame).unwrap();
            (color, cpu.geometry(&prepared.frame).unwrap())
        };
        let (shadowed, geometry) = draw(&scene);
        scene.objects[0].self_shadow = false;
        let (lit, _) = draw(&scene);
        let (mut caps, mut shadows) = (0, 0);
        for (pixel, (with, without)) in shadowed.words.iter().zip(&lit.words).enumerate() {
            let is_cap = with[3] == CLASS_CAP && geometry.delta(pixel) < 1e-3;
            caps += u32::from(is_cap);
            shadows += u32::from(!is_cap && with != without);
            assert!(!is_cap || with == without, "{tier}, pixel {pixel}");
        }
        assert!(caps > 5_000 && shadows > 500, "{caps} {shadows}");
    }
}

#[test]
fn patterns_of_several_sizes_and_baked_maps_are_refused() {
    let mut scene = windows("plane", [0.0, 2.0, 2.0], [2, 2], "fast");
    scene.objects[0].layers[1].shape = asset("patterns/discs.png").into();
    let size = prepare(&scene, &|_| ())
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(
        size.contains("layer 2") && size.contains("discs.png") && size.contains("128 × 128"),
        "{size}"
    );
    let pattern = Pattern::from_fn(8, 8, |x, _| x < 4).unwrap();
    let map = bake(&pattern, Storage::R16, &|_| ()).to_bytes().unwrap();
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let files = Files::memory([
        ("quad.obj".into(), quad.as_bytes().into()),
        ("map.png".into(), map.into()),
    ]);
    let text = "[[object]]\nmesh = 'quad.obj'\nshape = { text = 'A' }\nprojection = 'planar-z'\n[[object.layer]]\nshape = 'map.png'\n";
    let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files).unwrap();
    let baked = prepare(&scene, &|_| ())
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(baked.contains("map.png is a baked shape map"), "{baked}");
    let text = text.replacen(
        "shape = { text = 'A' }",
        "shape = 'map.png'\npieces = [1, 2]",
        1,
    );
    let text = text.split("[[object.layer]]").next().unwrap();
    let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), scene.files).unwrap();
    let pieces = prepare(&scene, &|_| ())
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(
        pieces.contains("map.png is a baked shape map, whose pieces are not known"),
        "{pieces}"
    );
}

/// Nine squares in three parts: three at each of three heights, as wide as they are together.
#[test]
fn pieces_of_a_pattern_stand_at_their_heights() {
    let squares: String = (0..9)
        .map(|i| format!("M{} {}h20v20h-20Z ", 7 + i % 3 * 33, 7 + i / 3 * 33))
        .collect();
    let square = drawing(&squares);
    let part = |number: u32| format!("shape = {{ svg = \"{square}\" }}\npieces = [{number}, 3]\n");
    let text = format!(
        "[image]\nsize = [240, 240]\n[camera]\neye = [0.0, 9.0, 0.01]\nfov = 14.0\n[[object]]\nmesh = \"../meshes/plane.obj\"\nraster = 100\ndepth = 0.08\n{}[[object.layer]]\ntop = 0.25\n{}[[object.layer]]\ntop = 0.5\n{}",
        part(1),
        part(2),
        part(3)
    );
    // The number of pixels with a cap at each height.
    let caps = |text: &str| {
        let scene = Scene::parse(text, &asset("scenes/test.toml")).unwrap();
        let prepared = prepare(&scene, &|_| ()).unwrap();
        let geometry = CpuRenderer::new(&prepared)
            .geometry(&prepared.frame)
            .unwrap();
        let mut caps = [0_u32; 3];
        for pixel in 0..240 * 240 {
            if geometry.class(pixel) == CLASS_CAP {
                let height = 4.0 * geometry.delta(pixel);
                assert!((height - height.round()).abs() < 0.05, "{height}");
                caps[height.round() as usize] += 1;
            }
        }
        caps
    };
    let parts = caps(&text);
    let [whole, ..] = caps(
        &text
            .split("[[object.layer]]")
            .next()
            .unwrap()
            .replace("[1, 3]", "[1, 1]"),
    );
    for pixels in parts {
        assert!(pixels.abs_diff(whole / 3) < whole / 30, "{parts:?} {whole}");
    }
}
