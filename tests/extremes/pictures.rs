//! Scenes at the limits of their ranges, in every tier: no NaN, every value in
//! its range, every hit on the surface, and the exact shaders match the CPU's
//! words.

use super::material::{Folder, ball, look, over, scale};
use glam::DVec3;
use rayon::prelude::*;
use relievo::mesh::Projection;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Choice, Shaders};
use relievo::render::{CpuRenderer, GeometryWords, GpuRenderer, RenderError, Renderer};
use relievo::scene::{Scene, Shape, Tier};
use relievo_shared::layout::FORMAT_PAPER;
use relievo_shared::march::TOLERANCE;
use relievo_shared::normals::{CLASS_BEVEL, CLASS_FLOOR, CLASS_MISS, CLASS_WALL};
use relievo_shared::profile::Profile;
use relievo_shared::shape_map::ShapeMap;
use relievo_shared::{Vec2, Vec3};
use relievo_tests::{asset, every_adapter, is_long};

/// Name, scene, and smallest number of pixels with a hit.
type Extreme = (String, Scene, usize);

/// Name, size, and which pixels are pattern.
type Map = (&'static str, [u32; 2], fn(u32, u32) -> bool);

fn extremes(folder: &Folder) -> Vec<Extreme> {
    let mut all = Vec::new();
    let mut add =
        |name: &str, scene: Scene, least: usize| all.push((name.to_string(), scene, least));
    let with = |mut scene: Scene, change: &dyn Fn(&mut Scene)| {
        change(&mut scene);
        scene
    };
    let object = |change: &dyn Fn(&mut relievo::scene::SceneObject)| {
        let mut scene = ball();
        change(&mut scene.objects[0]);
        scene
    };

    // Along the surface.
    for height in [1e-2, 1e-4, 1e-6] {
        let scene = with(over("plane.obj"), &|scene| {
            look(scene, [0.0, height, 0.9], [0.0, 0.0, -1.0]);
        });
        add(&format!("along a plane, {height} above it"), scene, 100);
    }
    // Depths from a scratch to more than the radius of curvature.
    for depth in [1e-6, 1e-3, 0.4, 0.95, 1.0, 1.7, 30.0] {
        add(
            &format!("{depth} deep"),
            object(&|object| object.depth = Some(depth)),
            300,
        );
    }
    for repeat in [[1e-3, 1e-3], [1e5, 1e5], [1e5, 1e-3], [1.0, 1.0]] {
        add(
            &format!("repeats {repeat:?}"),
            object(&|object| object.repeat = repeat),
            300,
        );
    }
    // Sizes, and places far from the world's origin.
    for factor in [1e-6, 1e-3, 1e3, 1e6] {
        add(
            &format!("{factor} as large"),
            with(ball(), &|scene| scale(scene, factor)),
            300,
        );
    }
    let away = |distance: f64| {
        with(ball(), &|scene| {
            let centre = [distance, -distance, 0.5 * distance];
            scene.objects[0].translate = centre;
            let eye = DVec3::from(centre) + DVec3::new(0.4, 0.6, 2.6);
            look(scene, eye.to_array(), centre);
        })
    };
    add("1e5 from the origin", away(1e5), 300);
    add("1e8 from the origin", away(1e8), 300);

    // The eye in unusual places: the ball's poles are at y = ±1.
    let from = |eye: [f64; 3], target: [f64; 3]| with(ball(), &|scene| look(scene, eye, target));
    add("eye on the cap", from([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]), 0);
    add(
        "eye on a facet",
        from([0.0, 0.0, 0.9938], [1.0, 0.0, 0.9]),
        0,
    );
    add(
        "eye in the shell",
        from([0.0, 0.0, 0.95], [1.0, 0.0, 0.9]),
        0,
    );
    add(
        "eye in the solid",
        from([0.0, 0.0, 0.5], [1.0, 0.0, 0.4]),
        0,
    );
    let vertex = [0.0, -0.987_688_34, 0.156_434_47];
    add("eye at a vertex", from(vertex, [0.0, 0.0, 2.0]), 0);
    add(
        "at a vertex",
        from([0.0, -1.975_376_68, 0.312_868_94], [0.0, 0.0, 0.0]),
        300,
    );
    add(
        "along an edge",
        from(
            [-2.0, -0.98, 0.154],
            [0.030_518_85, -0.987_688_34, 0.153_428_62],
        ),
        0,
    );
    add("pole", from([1e-3, 1.5, 0.0], [0.0, 0.0, 0.0]), 300);
    for (fov, eye) in [(0.01, 2.6), (179.0, 1.01)] {
        let scene = with(ball(), &|scene| {
            scene.field_of_view = fov;
            look(scene, [0.0, 0.0, eye], [0.0; 3]);
        });
        add(&format!("field of view {fov}°"), scene, 1);
    }

    // Techniques at their borders; the pattern is 1 wide.
    let extruded = |extension: f64, bevel: f64, chamfer: f64| {
        object(&|object| {
            object.extrusion.extension = extension;
            object.extrusion.bevel = bevel;
            object.extrusion.chamfer = chamfer;
        })
    };
    add("wider than the map", extruded(1.5, 0.0, 1.0), 300);
    add(
        "no bevel, chamfered at the cap",
        extruded(0.0, 0.0, 0.0),
        300,
    );
    add("bevel, chamfered at the cap", extruded(0.0, 0.3, 0.0), 300);
    add("hair's breadth of a bevel", extruded(0.0, 1e-9, 1e-9), 300);
    add("bevel wider than the map", extruded(0.0, 2.0, 1.0), 300);
    for (steps, bisections) in [(1, 0), (65_536, 64)] {
        let scene = object(&|object| (object.steps, object.bisections) = (steps, bisections));
        add(&format!("{steps} steps"), scene, 300);
    }

    // Maps.
    let mut maps: Vec<Map> = vec![
        ("one pixel, pattern", [1, 1], |_, _| true),
        ("one pixel, floor", [1, 1], |_, _| false),
        ("a row of 4096", [4096, 1], |x, _| x % 3 == 0),
        ("a column of 4096", [1, 4096], |_, y| y % 5 < 2),
        ("all pattern", [64, 64], |_, _| true),
        ("all floor", [64, 64], |_, _| false),
        ("a single pixel of pattern", [64, 64], |x, y| {
            (x, y) == (17, 40)
        }),
        ("a single pixel of floor", [64, 64], |x, y| {
            (x, y) != (17, 40)
        }),
        ("checkerboard", [64, 64], |x, y| (x + y) % 2 == 0),
        ("two pixels", [2, 1], |x, _| x == 0),
    ];
    if is_long() {
        maps.push(("as large as may be", [16_384, 16_384], |x, y| {
            (x / 64 + y / 64) % 3 == 0
        }));
    }
    for (name, size, is_pattern) in maps {
        let shape = folder.pattern(size, is_pattern);
        add(
            &format!("map: {name}"),
            object(&|object| object.shape = Shape::File(shape.clone())),
            200,
        );
    }

    // Meshes.
    let corner = |x: f64, y: f64, z: f64, uv: [f64; 2]| (DVec3::new(x, y, z), uv);
    let square = [
        corner(-1.0, 0.0, 1.0, [0.0, 0.0]),
        corner(1.0, 0.0, 1.0, [1.0, 0.0]),
        corner(1.0, 0.0, -1.0, [1.0, 1.0]),
        corner(-1.0, 0.0, -1.0, [0.0, 1.0]),
        corner(0.0, 0.0, 1.0, [0.5, 0.0]),
        corner(1e-7, 0.0, 1.0, [0.5, 0.0]),
    ];
    let mut meshes = vec![
        (
            "no area, and the same again",
            folder.mesh(
                &square,
                &[[0, 1, 2], [0, 1, 1], [3, 3, 3], [0, 1, 2], [0, 2, 3]],
            ),
        ),
        (
            "slivers",
            folder.mesh(&square, &[[0, 4, 3], [4, 5, 3], [5, 1, 2], [5, 2, 3]]),
        ),
        ("one triangle", folder.mesh(&square, &[[0, 1, 2]])),
        (
            "texture coordinates at a million",
            folder.patch(4, |_, _| 0.0, |x, z| [1e6 + x, -1e6 + z]),
        ),
        (
            "mirrored texture coordinates",
            folder.patch(4, |_, _| 0.0, |x, z| [x.abs(), z]),
        ),
        (
            "texture coordinates that stand still",
            folder.patch(4, |_, _| 0.0, |_, _| [0.3, 0.3]),
        ),
        (
            "texture coordinates that run in one direction",
            folder.patch(4, |_, _| 0.0, |x, _| [x, 2.0 * x]),
        ),
        (
            "hardly a saddle",
            folder.patch(8, |x, z| 1e-12 * x * z, |x, z| [x, z]),
        ),
        (
            "a saddle by its cross term",
            folder.patch(8, |x, z| 0.4 * x * z, |x, z| [x, z]),
        ),
        (
            "needles",
            folder.patch(
                6,
                |x, z| ((37.0 * x * x + 91.0 * z) as i64 % 2) as f64,
                |x, z| [x, z],
            ),
        ),
    ];
    meshes.push(("a corner that many triangles share", {
        let corners: Vec<_> = std::iter::once(corner(0.0, 0.3, 0.0, [0.5, 0.5]))
            .chain((0..200).map(|i| {
                let (z, x) = (f64::from(i) * std::f64::consts::TAU / 200.0).sin_cos();
                corner(x, 0.0, z, [0.5 + 0.5 * x, 0.5 + 0.5 * z])
            }))
            .collect();
        let fan: Vec<_> = (0..200).map(|i| [0, 1 + (i + 1) % 200, 1 + i]).collect();
        folder.mesh(&corners, &fan)
    }));
    for (name, mesh) in meshes {
        let scene = with(ball(), &|scene| {
            scene.objects[0].mesh = mesh.clone().into();
            look(scene, [0.5, 1.6, 1.6], [0.0, 0.0, 0.0]);
        });
        add(&format!("mesh: {name}"), scene, 100);
    }
    for projection in Projection::ALL {
        let scene = with(ball(), &|scene| {
            scene.objects[0].projection = Some(projection);
            look(scene, [0.05, 2.0, 0.0], [0.0, 0.0, 0.0]);
        });
        add(
            &format!("{} projection from above", projection.name()),
            scene,
            300,
        );
    }
    all
}

/// Prepares the scene in `tier`; `None` if the surface bends too much for the
/// accurate tier.
fn prepared(scene: &Scene, tier: Tier) -> Option<PreparedScene> {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        object.tier = tier;
    }
    match prepare(&scene, &|_| ()) {
        Ok(prepared) => Some(prepared),
        Err(relievo::Error::Object { problem, .. }) if tier == Tier::Accurate => {
            assert!(problem.contains("tier = \"fast\""), "{problem}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Checks every pixel; returns the number of hits.
fn check(scene: &PreparedScene, picture: &GeometryWords) -> Result<usize, String> {
    let mut met = 0;
    // Rounding of coordinates, texels: relative to their size before whole
    // repeats are subtracted.
    let corners = scene.objects[0].triangles.iter().flat_map(|t| t.corners);
    let largest = corners.fold(1.0, |largest: f32, corner| {
        largest.max(corner.uv[0].abs()).max(corner.uv[1].abs())
    });
    let side = scene.objects[0].parameters.map_size;
    let rounding = 4e-7 * largest * (side[0] + side[1]);
    for (index, (place, surface)) in picture.place.iter().zip(&picture.surface).enumerate() {
        let class = picture.class(index);
        if class == CLASS_MISS {
            continue;
        }
        met += 1;
        let [t, u, v, depth_fraction] = place.map(f32::from_bits);
        let [_, x, y, z] = surface.map(f32::from_bits);
        let normal = Vec3::new(x, y, z);
        let parameters = &scene.objects[0].parameters;
        let in_range = t.is_finite()
            && t > 0.0
            && (0.0..=1.0).contains(&u)
            && (0.0..=1.0).contains(&v)
            && (0.0..=1.0).contains(&depth_fraction)
            && (normal.length() - 1.0).abs() < 1e-5
            && class <= CLASS_FLOOR
            && picture.steps(index) <= parameters.linear_steps;
        if !in_range {
            return Err(format!(
                "pixel {index}: {place:?} {surface:?} class {class}"
            ));
        }
        // Unless the steps ran out, a side is where the solid begins.
        let is_side = class == CLASS_WALL || class == CLASS_BEVEL;
        if is_side
            && picture.steps(index) < parameters.linear_steps
            && parameters.map_format != FORMAT_PAPER
        {
            let map = ShapeMap::new(parameters);
            let distance = map.distance(scene.objects[0].map.words(), Vec2::new(u, v));
            let radius = Profile::new(parameters).radius(depth_fraction);
            // The accurate tier evaluates its pieces' position, which may be a
            // tolerance away from the ray's.
            let tolerance = if scene.objects[0].has_prisms() {
                2.0 * TOLERANCE
            } else {
                TOLERANCE
            };
            if distance - radius > tolerance + rounding {
                return Err(format!(
                    "pixel {index}: the solid is {} away",
                    distance - radius
                ));
            }
        }
    }
    Ok(met)
}

#[test]
fn gpu_and_cpu_agree_and_every_number_is_in_its_range() {
    let folder = Folder::new();
    let mut adapters = every_adapter();
    adapters.retain(relievo::render::gpu::Adapter::takes_spirv);
    if !is_long() {
        adapters.truncate(1);
    }
    let tiers = [Tier::Planar, Tier::Fast, Tier::Accurate];
    let cases: Vec<(Extreme, Tier)> = extremes(&folder)
        .into_iter()
        .flat_map(|extreme| tiers.map(|tier| (extreme.clone(), tier)))
        .collect();
    let drawn = |((name, scene, least), tier): &(Extreme, Tier)| -> Result<bool, String> {
        let name = format!("{name}, {}", tier.name());
        let Some(scene) = prepared(scene, *tier) else {
            return Ok(false);
        };
        let mut cpu = CpuRenderer::new(&scene);
        let geometry = cpu.geometry(&scene.frame).unwrap();
        let color = cpu.color(&scene.frame).unwrap();
        let met = check(&scene, &geometry).map_err(|problem| format!("{name}: {problem}"))?;
        if met < *least {
            return Err(format!("{name}: met in {met} pixels only"));
        }
        let finite = |words: &[u32; 4]| words[..3].iter().all(|&w| f32::from_bits(w).is_finite());
        if !color.words.iter().all(finite) {
            return Err(format!("{name}: a colour is no number"));
        }
        for adapter in &adapters {
            let choice = Choice::These(Shaders::Exact);
            let mut gpu = match GpuRenderer::new(&scene, adapter, choice) {
                Ok(gpu) => gpu,
                // The largest map exceeds some devices' limits, which they
                // report.
                Err(RenderError::Limit { needed, limit, .. }) if needed > 1 << 27 => {
                    assert!(needed > limit);
                    continue;
                }
                Err(error) => panic!("{name}: {error}"),
            };
            if gpu.geometry(&scene.frame).unwrap() != geometry {
                return Err(format!("{name}: other geometry on {}", adapter.describe()));
            }
            if gpu.color(&scene.frame).unwrap() != color {
                return Err(format!("{name}: other colours on {}", adapter.describe()));
            }
        }
        Ok(true)
    };
    let results: Vec<_> = cases.par_iter().map(drawn).collect();
    let wrong: Vec<&String> = results.iter().filter_map(|r| r.as_ref().err()).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let count = results.iter().filter(|result| **result == Ok(true)).count();
    println!("{count} of {} pictures drawn", cases.len());
    assert!(10 * count > 9 * cases.len(), "{count} of {}", cases.len());
}

/// The check detects each fault.
#[test]
fn wrong_numbers_are_seen() {
    let scene = prepared(&ball(), Tier::Fast).unwrap();
    let right = CpuRenderer::new(&scene).geometry(&scene.frame).unwrap();
    assert!(check(&scene, &right).unwrap() > 300);
    let side = (0..right.place.len())
        .find(|&index| right.class(index) == CLASS_WALL)
        .unwrap();
    for (word, wrong) in [
        (0, f32::NAN),
        (0, -1.0),
        (1, f32::INFINITY),
        (3, 1.1),
        (1, 0.0),
    ] {
        let mut picture = right.clone();
        picture.place[side][word] = wrong.to_bits();
        if word == 1 && wrong == 0.0 {
            // Half a repeat away there is nothing.
            let [u, v] = [1, 2].map(|word| f32::from_bits(right.place[side][word]));
            let away = |x: f32| (x + 0.5).fract().to_bits();
            picture.place[side][1..3].copy_from_slice(&[away(u), away(v)]);
        }
        assert!(check(&scene, &picture).is_err(), "{word} {wrong}");
    }
    let mut picture = right.clone();
    picture.surface[side][1] = 2.0_f32.to_bits();
    assert!(check(&scene, &picture).is_err());
    assert!(asset("meshes/sphere.obj").is_file());
}
