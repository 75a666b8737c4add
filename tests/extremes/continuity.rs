//! Small parameter changes cause small picture changes, also where a formula
//! switches to another one.

use super::material::{Folder, ball, look, over};
use rayon::prelude::*;
use relievo::prepare::prepare;
use relievo::render::{ColorWords, CpuRenderer, Renderer};
use relievo::scene::{Scene, Tier};
use relievo_shared::normals::{CLASS_BEVEL, CLASS_WALL};
use std::path::Path;

/// Largest fraction of pixels with another class.
const CLASSES: f64 = 4e-3;
/// Largest change of a colour channel elsewhere, linear; wall normals turn at
/// texel edges.
const COLORS: f32 = 0.02;
/// Largest fraction of pixels with a larger change.
const BRIGHTER: f64 = 4e-3;

type Change = Box<dyn Fn(&mut Scene, f64) + Sync>;

/// Name, range of the parameter, and the scene for a value.
fn changes(folder: &Folder) -> Vec<(&'static str, [f64; 2], Change)> {
    let flat = folder.patch(8, |_, _| 0.0, |x, z| [x, z]);
    let object = |change: fn(&mut relievo::scene::SceneObject, f64)| -> Change {
        Box::new(move |scene, value| change(&mut scene.objects[0], value))
    };
    let bent = move |folder: &Path, value: f64| {
        // The same patch, bent by `value`, in its own file.
        let name = format!("bent{:+e}.obj", value);
        let path = folder.join(name);
        let text = std::fs::read_to_string(&flat).unwrap();
        let line = |line: &str| {
            let numbers: Vec<&str> = line.split(' ').collect();
            match numbers.as_slice() {
                ["v", x, _, z] => {
                    let [a, b]: [f64; 2] = [x, z].map(|text| text.parse().unwrap());
                    format!("v {x} {} {z}\n", value * (a * a - 0.5 * b * b + a * b))
                }
                _ => format!("{line}\n"),
            }
        };
        std::fs::write(&path, text.lines().map(line).collect::<String>()).unwrap();
        path
    };
    let root = folder.path().to_path_buf();
    vec![
        (
            "depth",
            [0.08, 0.08 * (1.0 + 1e-6)],
            object(|o, x| o.depth = Some(x)),
        ),
        (
            "a little depth",
            [1e-6, 2e-6],
            object(|o, x| o.depth = Some(x)),
        ),
        (
            "extension through 0",
            [-1e-6, 1e-6],
            object(|o, x| o.extrusion.extension = x),
        ),
        (
            "bevel from 0",
            [0.0, 1e-6],
            object(|o, x| o.extrusion.bevel = x),
        ),
        (
            "chamfer from 0",
            [0.0, 1e-6],
            object(|o, x| o.extrusion.chamfer = x),
        ),
        (
            "chamfer to 1",
            [1.0 - 1e-6, 1.0],
            object(|o, x| o.extrusion.chamfer = x),
        ),
        (
            "repeats",
            [12.0, 12.0 + 1e-6],
            object(|o, x| o.repeat[0] = x),
        ),
        ("slack from 0", [0.0, 1e-4], object(|o, x| o.slack = x)),
        (
            "specular from 0",
            [0.0, 1e-6],
            object(|o, x| o.material.specular = x),
        ),
        ("turn", [0.0, 1e-5], object(|o, x| o.rotate = [x, 0.0, x])),
        (
            "eye",
            [2.6, 2.6 + 1e-6],
            Box::new(|scene, x| look(scene, [0.4, 0.6, x], [0.0; 3])),
        ),
        (
            "eye through the cap's tangent plane",
            [-1e-6, 1e-6],
            Box::new(|scene, x| {
                scene.objects[0].mesh = over("plane.obj").objects.remove(0).mesh;
                look(scene, [0.0, 0.3 + x, 2.0], [0.0, 0.0, 0.0]);
            }),
        ),
        (
            "field of view",
            [50.0, 50.0 + 1e-5],
            Box::new(|scene, x| scene.field_of_view = x),
        ),
        (
            "curvature through 0",
            [-1e-7, 1e-7],
            Box::new({
                move |scene, x| {
                    scene.objects[0].mesh = bent(&root, x).into();
                    look(scene, [0.3, 1.6, 1.9], [0.0; 3]);
                }
            }),
        ),
    ]
}

fn tiered(mut scene: Scene, tier: Tier) -> Scene {
    scene.objects[0].tier = tier;
    scene
}

/// `None` if the accurate tier cannot draw the scene.
fn picture(change: &Change, tier: Tier, value: f64) -> Option<ColorWords> {
    let mut scene = tiered(ball(), tier);
    scene.size = [160, 120];
    // A bevel has its colour at any size; that is no change of shape.
    let material = &mut scene.objects[0].material;
    material.bevel = material.wall;
    change(&mut scene, value);
    scene.objects[0].tier = tier;
    let scene = match prepare(&scene, &|_| ()) {
        Ok(scene) => scene,
        Err(relievo::Error::Object { .. }) if tier == Tier::Accurate => return None,
        Err(error) => panic!("{error}"),
    };
    Some(CpuRenderer::new(&scene).color(&scene.frame).unwrap())
}

/// Returns the class, with bevels as walls.
fn class(pixel: &[u32; 4]) -> u32 {
    if pixel[3] == CLASS_BEVEL {
        CLASS_WALL
    } else {
        pixel[3]
    }
}

/// Fractions of the pixels with another class, and with the same class but
/// another colour.
fn differences(a: &ColorWords, b: &ColorWords) -> [f64; 2] {
    let mut counts = [0; 2];
    for (a, b) in a.words.iter().zip(&b.words) {
        let apart = |i: usize| (f32::from_bits(a[i]) - f32::from_bits(b[i])).abs();
        if class(a) != class(b) {
            counts[0] += 1;
        } else if (0..3).any(|i| apart(i) > COLORS) {
            counts[1] += 1;
        }
    }
    counts.map(|count| f64::from(count) / a.words.len() as f64)
}

#[test]
fn a_small_change_is_a_small_change() {
    let folder = Folder::new();
    let tiers = [Tier::Planar, Tier::Fast, Tier::Accurate];
    let changes = changes(&folder);
    let cases: Vec<_> = changes
        .iter()
        .flat_map(|change| tiers.map(|tier| (change, tier)))
        .collect();
    let lines: Vec<(bool, String)> = cases
        .par_iter()
        .map(|((name, values, change), tier)| {
            let pictures = values.map(|value| picture(change, *tier, value));
            let [Some(before), Some(after)] = pictures else {
                return (true, format!("{name}, {}: not drawn", tier.name()));
            };
            let [classes, colors] = differences(&before, &after);
            let small = classes <= CLASSES && colors <= BRIGHTER;
            let line = format!("{name}, {}: {classes:.5} {colors:.5}", tier.name());
            (small, line)
        })
        .collect();
    let all: Vec<&String> = lines.iter().map(|(_, line)| line).collect();
    println!("{all:#?}");
    let not_drawn = all.iter().filter(|line| line.contains("not drawn")).count();
    assert!(not_drawn <= 1, "{all:#?}");
    let large: Vec<&String> = lines
        .iter()
        .filter(|(small, _)| !small)
        .map(|(_, line)| line)
        .collect();
    assert!(large.is_empty(), "{large:#?}");
}

/// A visible change is detected.
#[test]
fn a_large_change_is_seen() {
    let change: Change = Box::new(|scene, x| scene.objects[0].depth = Some(x));
    for tier in [Tier::Planar, Tier::Fast, Tier::Accurate] {
        let [before, after] = [0.08, 0.1].map(|depth| picture(&change, tier, depth).unwrap());
        let [classes, _] = differences(&before, &after);
        assert!(classes > 2.0 * CLASSES, "{}: {classes}", tier.name());
    }
}
