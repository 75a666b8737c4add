//! Relations between the techniques, and their normals.

use proptest::prelude::*;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::{ColorWords, CpuRenderer, GeometryWords, Renderer};
use relievo::scene::Scene;
use relievo_tests::asset;
use std::path::Path;

/// A scene with one object; `keys` are lines of its table.
fn scene(mesh: &str, shape: &Path, eye: [f64; 3], keys: &str) -> PreparedScene {
    let text = format!(
        "[image]\nsize = [192, 144]\n[camera]\neye = {eye:?}\nup = [0.0, 1.0, 0.1]\nfov = 40.0\n[[object]]\nmesh = {:?}\nshape = {shape:?}\ndepth = 0.1\n{keys}\n",
        asset(mesh),
    );
    let scene = Scene::parse(&text, Path::new("scene.toml")).unwrap();
    prepare(&scene, &|_| ()).unwrap()
}

fn draw(scene: &PreparedScene) -> (ColorWords, GeometryWords) {
    let mut cpu = CpuRenderer::new(scene);
    (
        cpu.color(&scene.frame).unwrap(),
        cpu.geometry(&scene.frame).unwrap(),
    )
}

#[test]
fn techniques_meet_where_their_parameters_do() {
    let letters = asset("patterns/letters.png");
    for tier in ["planar", "fast", "paper"] {
        let picture = |keys: &str| {
            let keys = format!("repeat = [8, 4]\ntier = {tier:?}\n{keys}");
            draw(&scene("meshes/torus.obj", &letters, [0.4, 1.6, 2.4], &keys))
        };
        let basic = picture("technique = \"basic\"");
        let outward = |e: f64| picture(&format!("technique = \"outward\"\nextension = {e:?}"));
        assert!(basic == outward(0.0), "outward, e = 0, {tier}");
        assert!(basic != outward(0.01), "outward, e = 0.01, {tier}");
        let beveled = |b: f64| picture(&format!("technique = \"beveled\"\nbevel = {b:?}"));
        let chamfered = |b: f64, c: f64| {
            picture(&format!(
                "technique = \"chamfered\"\nbevel = {b:?}\nchamfer = {c:?}"
            ))
        };
        assert!(
            beveled(0.08) == chamfered(0.08, 1.0),
            "chamfered, c = 1, {tier}"
        );
        assert!(
            beveled(0.08) != chamfered(0.08, 0.5),
            "chamfered, c = 0.5, {tier}"
        );
        assert!(basic == beveled(0.0), "beveled, b = 0, {tier}");
        assert!(basic == chamfered(0.0, 0.6), "chamfered, b = 0, {tier}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Increasing e only adds covered pixels.
    #[test]
    fn covered_pixels_grow_with_the_extension(
        cells in prop::collection::vec(any::<bool>(), 64),
        eye in (-2.0f64..2.0, 0.5f64..2.5, 1.5f64..3.0),
        extensions in (0.0f64..0.1, 0.0f64..0.1),
        tier in prop::sample::select(vec!["planar", "fast"]),
        cut_out in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pattern.png");
        let pixel = |x: u32, y: u32| image::Luma([if cells[(y / 6 * 8 + x / 6) as usize] { 0 } else { 255 }]);
        image::GrayImage::from_fn(48, 48, pixel).save(&path).unwrap();
        let covered = |e: f64| {
            // Enough steps that no search runs out, which would count as a hit.
            let keys = format!(
                "repeat = [6, 3]\ntier = {tier:?}\ncut_out = {cut_out}\ntechnique = \"outward\"\nextension = {e:?}\nsteps = 5000"
            );
            let words = draw(&scene("meshes/torus.obj", &path, eye.into(), &keys)).1;
            (0..words.surface.len()).map(|i| words.class(i) != 0).collect::<Vec<bool>>()
        };
        let (small, large) = (extensions.0.min(extensions.1), extensions.0.max(extensions.1));
        let lost = covered(small)
            .iter()
            .zip(&covered(large))
            .filter(|(before, after)| **before && !**after)
            .count();
        prop_assert_eq!(lost, 0);
    }
}

/// Errors of the normals of a class against a closed form of the texture
/// coordinates, degrees, sorted.
fn normal_errors(
    words: &GeometryWords,
    class: u32,
    truth: &dyn Fn(f32, f32) -> Option<[f64; 3]>,
) -> Vec<f64> {
    let mut errors = Vec::new();
    for (i, place) in words.place.iter().enumerate() {
        if words.class(i) != class {
            continue;
        }
        let [_, u, v, _] = place.map(f32::from_bits);
        let [_, x, y, z] = words.surface[i].map(f32::from_bits);
        if let Some(expected) = truth(u, v) {
            let found = glam::DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            errors.push(found.angle_between(expected.into()).to_degrees());
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

/// On a disc on a plane, walls, bevels and chamfers face away from its centre
/// within 1° of the closed form in every pixel. The map has 4096² texels,
/// because normals partly follow the staircase of a binary outline.
#[test]
fn normals_of_a_disc_on_a_plane() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("disc.png");
    let side = 4096u32;
    let inside = |x: u32, y: u32| {
        let centre = 0.5 * f64::from(side);
        let (dx, dy) = (f64::from(x) + 0.5 - centre, f64::from(y) + 0.5 - centre);
        dx.hypot(dy) <= 0.25 * f64::from(side)
    };
    image::GrayImage::from_fn(side, side, |x, y| {
        image::Luma([if inside(x, y) { 0 } else { 255 }])
    })
    .save(&path)
    .unwrap();
    let depth = 0.1;
    // The plane is 2 units wide: one repeat is 2 units.
    let width = 2.0;
    for (keys, class, slope) in [
        ("technique = \"basic\"", 2, 0.0),
        ("technique = \"beveled\"\nbevel = 0.08", 3, 0.08),
        (
            "technique = \"chamfered\"\nbevel = 0.1\nchamfer = 0.6",
            3,
            0.1,
        ),
        (
            "technique = \"chamfered\"\nbevel = 0.1\nchamfer = 0.6",
            2,
            0.0,
        ),
    ] {
        for eye in [[0.0, 2.2, 1.4], [1.3, 1.6, -1.0]] {
            let words = draw(&scene("meshes/plane.obj", &path, eye, keys)).1;
            let truth = |u: f32, v: f32| {
                // u runs along +x; v down the image, which is +z.
                let (x, z) = (f64::from(u) - 0.5, f64::from(v) - 0.5);
                let radius = x.hypot(z);
                // g = D − e − b δ: sideways by 1, up by b · width / S_z.
                let up = slope * width / depth;
                let length = 1.0f64.hypot(up);
                Some([x / radius / length, up / length, z / radius / length])
            };
            let errors = normal_errors(&words, class, &truth);
            let count = errors.len();
            assert!(count > 60, "{keys}: {count} pixels of class {class}");
            let mean = errors.iter().sum::<f64>() / count as f64;
            println!(
                "{keys:?} class {class}: {count} pixels, mean {mean:.3}°, 95 % {:.3}°, worst {:.3}°",
                errors[count * 95 / 100],
                errors[count - 1]
            );
            assert!(errors[count - 1] < 1.0, "{keys}: {}°", errors[count - 1]);
        }
    }
}
