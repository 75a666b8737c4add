//! Small pictures of every technique on every path with every storage form,
//! compared exactly with those in `tests/golden/`. A picture that differs is
//! written to `target/golden` with the difference. Run with
//! `RELIEVO_UPDATE_GOLDEN=1` to accept the pictures as they are now.

use relievo::picture::Picture;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Shaders, adapters};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Scene, Search, Technique};
use relievo::shape_map::{Encoding, Pattern, PatternOptions, Storage, bake};
use relievo::verify::compare;
use relievo_shared::profile;
use relievo_tests::{Renderers, asset, root};
use std::path::{Path, PathBuf};

/// Name and keys of an object.
const VARIANTS: [(&str, &str); 7] = [
    ("basic", "technique = \"basic\""),
    ("outward", "technique = \"outward\"\nextension = 0.03"),
    (
        "beveled",
        "technique = \"beveled\"\nbevel = 0.06\nextension = 0.01",
    ),
    (
        "chamfered",
        "technique = \"chamfered\"\nbevel = 0.08\nchamfer = 0.5",
    ),
    ("relief", "technique = \"relief\"\nbevel = 0.05"),
    ("cut_out", "cut_out = true"),
    (
        "shadow",
        "self_shadow = true\ntechnique = \"chamfered\"\nbevel = 0.08\nchamfer = 0.5",
    ),
];
const TIERS: [&str; 3] = ["planar", "fast", "paper"];

/// [`VARIANTS`], and the other techniques with their default parameters.
fn variants() -> Vec<(&'static str, String)> {
    let variants = VARIANTS.map(|(name, keys)| (name, keys.to_string()));
    let others = Technique::ALL.map(|technique| technique.name());
    let others = others.into_iter().filter(|name| {
        let mut variants = VARIANTS.iter();
        !variants.any(|(variant, _)| variant == name)
    });
    let others = others.map(|name| (name, format!("technique = {name:?}")));
    variants.into_iter().chain(others).collect()
}

/// Every valid combination: name and scene.
fn cases(maps: &Path) -> Vec<(String, Scene)> {
    let mut cases = Vec::new();
    for (variant, keys) in variants() {
        for tier in TIERS {
            // The paper's tier has its own search, for straight profiles.
            let mut all = Technique::ALL.into_iter();
            let technique = all.find(|technique| technique.name() == variant);
            let is_papers = technique.is_none_or(|technique| {
                technique.search() == Search::Extrusion
                    && technique.default_extrusion().profile == profile::STRAIGHT
            });
            if tier == "paper" && !is_papers {
                continue;
            }
            for storage in Storage::ALL {
                let name = format!("{variant}-{tier}-{}", storage.name());
                let text = format!(
                    "[image]\nsize = [80, 60]\n[camera]\neye = [0.0, 1.2, 2.2]\ntarget = [0.2, 0.0, 0.8]\nfov = 32.0\n[[object]]\nmesh = {:?}\nshape = {:?}\nrepeat = [8, 3]\ndepth = 0.12\ntier = {tier:?}\n{keys}\n",
                    asset("meshes/torus.obj"),
                    maps.join(storage.name())
                        .with_extension(storage.extension()),
                );
                let scene = Scene::parse(&text, Path::new("golden.toml")).unwrap();
                cases.push((name, scene));
            }
        }
    }
    for tier in ["planar", "fast", "accurate"] {
        let text = format!(
            "[image]\nsize = [80, 60]\n[camera]\neye = [0.0, 1.2, 2.2]\ntarget = [0.2, 0.0, 0.8]\nfov = 32.0\n{LIT}[[object]]\nmesh = {:?}\nshape = {:?}\nrepeat = [8, 3]\ndepth = 0.12\nbevel = 0.02\nchamfer = 0.5\ntier = {tier:?}\nmaterial = {{ cap = 'gold', wall = 'stone', bevel = '#406080', floor = 'stone' }}\n",
            asset("meshes/torus.obj"),
            maps.join("r16.png"),
        )
        .replace("ASSETS", &asset("").display().to_string());
        let scene = Scene::parse(&text, Path::new("golden.toml")).unwrap();
        let smooth = scene.clone().smooth_edges(true);
        cases.push((format!("lit-{tier}"), scene));
        // Nearer pixels march, those farther away show the mean only.
        let mut far = smooth.clone();
        let object = &mut far.objects[0];
        (object.repeat, object.depth) = ([480.0, 180.0], Some(0.004));
        cases.push((format!("lit-{tier}-smooth"), smooth));
        if tier != "accurate" {
            cases.push((format!("lit-{tier}-far"), far));
        }
    }
    cases
}

/// Lights of every kind, a picture of the environment, and materials that differ from cell to cell.
const LIT: &str = "
[[light]]
direction = [1, 2, 1]
shadow_size = 256
[[light]]
type = 'point'
position = [-0.2, 0.9, 1.6]
color = '#ff8040'
intensity = 0.5
shadow_size = 128
[[light]]
type = 'spot'
position = [1.5, 1.5, 2.0]
target = [0.3, 0.0, 0.9]
color = '#4080ff'
intensity = 3.0
outer_angle = 20
shadow_size = 128
[environment]
image = 'ASSETS/environments/studio.hdr'
intensity = 0.5
turn = 30
visible = true
[[material]]
name = 'gold'
base_color = '#ffd080'
metallic = 1
roughness = 0.35
shade_variation = 0.5
[[material]]
name = 'stone'
base_color_image = 'ASSETS/materials/stone.png'
normal_image = 'ASSETS/materials/stone_normal.png'
roughness = 0.8
turn_pictures = true
shift_pictures = true
";

/// Bakes small letters in every storage form.
fn bake_maps(folder: &Path) {
    let letters = image::open(asset("patterns/letters.png")).unwrap();
    let small = letters.resize_exact(96, 96, image::imageops::FilterType::Triangle);
    let path = folder.join("letters.png");
    small.save(&path).unwrap();
    let pattern = Pattern::load(&path, &PatternOptions::default()).unwrap();
    for storage in Storage::ALL {
        let map = bake(&pattern, Encoding::from(*storage), &|_| ());
        let file = folder
            .join(storage.name())
            .with_extension(storage.extension());
        map.save(&file).unwrap();
    }
}

fn prepared() -> Vec<(String, PreparedScene)> {
    let folder = tempfile::tempdir().unwrap();
    bake_maps(folder.path());
    cases(folder.path())
        .into_iter()
        .map(|(name, scene)| (name, prepare(&scene, &|_| ()).unwrap()))
        .collect()
}

/// Three times the difference of two pictures; grey where they agree.
fn difference(found: &Picture, golden: &Picture) -> Picture {
    let bytes = found
        .bytes
        .iter()
        .zip(&golden.bytes)
        .map(|(&a, &b)| (128 + 3 * (i32::from(a) - i32::from(b))).clamp(0, 255) as u8)
        .collect();
    Picture {
        bytes,
        ..golden.clone()
    }
}

fn load(path: &Path) -> Option<Picture> {
    let image = image::open(path).ok()?.into_rgb8();
    Some(Picture {
        width: image.width(),
        height: image.height(),
        bytes: image.into_raw(),
    })
}

/// Compares with the golden pictures in `folder`; returns the names of those
/// that differ.
fn compare_with(folder: &Path, pictures: &[(String, Picture)], evidence: &Path) -> Vec<String> {
    let mut wrong = Vec::new();
    for (name, picture) in pictures {
        let golden = load(&folder.join(name).with_extension("png"));
        if golden.as_ref() == Some(picture) {
            continue;
        }
        wrong.push(name.clone());
        let put = |picture: &Picture, kind: &str| {
            picture
                .save_png(&evidence.join(format!("{name}.{kind}.png")), &[])
                .unwrap();
        };
        put(picture, "found");
        if let Some(golden) = golden.filter(|golden| golden.bytes.len() == picture.bytes.len()) {
            put(&difference(picture, &golden), "difference");
        }
    }
    wrong
}

fn draw(scene: &PreparedScene) -> Picture {
    let words = CpuRenderer::new(scene).color(&scene.frame).unwrap();
    Picture::develop(&words, 1, &scene.development).unwrap()
}

#[test]
fn cpu_pictures_are_the_golden_ones() {
    let pictures: Vec<(String, Picture)> = prepared()
        .iter()
        .map(|(name, scene)| (name.clone(), draw(scene)))
        .collect();
    let not_papers = pictures.len() - (6 * 3 + 2) * 4 - 8;
    assert_eq!(not_papers, (variants().len() - VARIANTS.len()) * 2 * 4);
    let folder = root().join("tests/golden");
    if std::env::var_os("RELIEVO_UPDATE_GOLDEN").is_some() {
        for (name, picture) in &pictures {
            let path = folder.join(name).with_extension("png");
            picture.save_png(&path, &[]).unwrap();
        }
        return;
    }
    let evidence = root().join("target/golden");
    let wrong = compare_with(&folder, &pictures, &evidence);
    assert!(
        wrong.is_empty(),
        "{} pictures differ (see {}): {}",
        wrong.len(),
        evidence.display(),
        wrong.join(", ")
    );
}

/// One changed byte is detected and shown.
#[test]
fn a_changed_picture_is_shown_as_a_difference() {
    let folder = tempfile::tempdir().unwrap();
    let golden = Picture {
        width: 2,
        height: 1,
        bytes: vec![10, 20, 30, 40, 50, 60],
    };
    golden
        .save_png(&folder.path().join("case.png"), &[])
        .unwrap();
    let evidence: PathBuf = folder.path().join("evidence");
    let same = [("case".to_string(), golden.clone())];
    assert!(compare_with(folder.path(), &same, &evidence).is_empty());
    let mut changed = golden;
    changed.bytes[4] += 1;
    let wrong = compare_with(folder.path(), &[("case".to_string(), changed)], &evidence);
    assert_eq!(wrong, ["case"]);
    let shown = load(&evidence.join("case.difference.png")).unwrap();
    assert_eq!(shown.bytes, [128, 128, 128, 128, 131, 128]);
}

/// The same combinations on every adapter: the exact shaders match the CPU's
/// words, the others the CPU's classes nearly everywhere.
#[test]
fn gpu_draws_every_combination() {
    let all = adapters();
    assert!(!all.is_empty(), "no GPU adapter: see tests/run");
    let mut wrong = Vec::new();
    let mut renderers = Renderers::default();
    for (name, scene) in prepared() {
        let frame = &scene.frame;
        let mut cpu = CpuRenderer::new(&scene);
        let (color, geometry) = (cpu.color(frame).unwrap(), cpu.geometry(frame).unwrap());
        for found in &all {
            let shaders = if found.takes_spirv() {
                Shaders::Exact
            } else {
                Shaders::Portable
            };
            let gpu = renderers.show(&scene, found, shaders);
            let agreement = compare(
                [&gpu.color(frame).unwrap(), &color],
                [&gpu.geometry(frame).unwrap(), &geometry],
            );
            let good = if shaders == Shaders::Exact {
                agreement.is_exact()
            } else {
                agreement.class_pixels as u64 * 200 <= agreement.color.inputs
            };
            if !good {
                wrong.push(format!("{name}, {}: {agreement:?}", found.describe()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
