//! What is written is read back.

use crate::Files;
use crate::mesh::{MeshSource, Projection};
use crate::prepare::Assets;
use crate::prepare::tests::words_with;
use crate::scene::{
    Camera, Color, Extrusion, Finish, Layer, Lettering, Light, MapOptions, Material, Scene,
    SceneObject, Search, Shape, Technique, Tier,
};
use crate::shape_map::Storage;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// Everything that a scene file says is the same.
fn assert_same(a: &Scene, b: &Scene) {
    assert_eq!(
        (a.size, a.supersampling, a.background, a.camera),
        (b.size, b.supersampling, b.background, b.camera)
    );
    assert_eq!((a.field_of_view, a.light), (b.field_of_view, b.light));
    assert_eq!(a.objects, b.objects);
}

fn again(scene: &Scene, folder: &str) -> Scene {
    let folder = Path::new(folder);
    let text = scene.to_toml(folder);
    Scene::parse(&text, &folder.join("again.toml"))
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        low..=high,
        Just(low),
        Just(high),
        (low..=high).prop_map(move |x| x.round().clamp(low, high))
    ]
}

fn vector(limit: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(number(-limit, limit))
}

fn color() -> impl Strategy<Value = Color> {
    prop_oneof![
        (0..0x100_0000_u32).prop_map(Color::from_hex),
        prop::array::uniform3(number(0.0, 1.0)).prop_map(Color)
    ]
}

fn camera() -> impl Strategy<Value = Camera> {
    (vector(1e9), vector(1e9), vector(10.0))
        .prop_map(|(eye, target, up)| Camera { eye, target, up })
        .prop_filter("a camera looks somewhere", |camera| {
            let [eye, target, up] = [camera.eye, camera.target, camera.up].map(glam::DVec3::from);
            let forward = (target - eye).normalize_or_zero();
            forward.cross(up.normalize_or_zero()).length() > 1e-5
        })
}

/// A path below the folder of the scene, or above it.
fn path() -> impl Strategy<Value = PathBuf> {
    "(\\.\\./){0,2}[a-zé \"'#\\]\\[=]{1,8}(/[a-z]{1,3}){0,2}\\.[a-z]{3}"
        .prop_map(|path: String| Path::new("some/scenes").join(path))
}

fn shape() -> impl Strategy<Value = Shape> {
    let text = any::<String>().prop_filter("letters", |text| {
        text.chars().any(|c| !c.is_whitespace()) && text.chars().count() < 4000
    });
    prop_oneof![
        path().prop_map(Shape::File),
        any::<String>().prop_map(|document| Shape::svg(&document)),
        (text, prop::option::of(path()), number(0.0, 10.0))
            .prop_map(|(text, font, margin)| Shape::Text(Lettering { text, font, margin }))
    ]
}

/// A part of the pieces of a pattern, or all.
fn pieces() -> impl Strategy<Value = Option<[u32; 2]>> {
    prop::option::of(
        (1..=64_u32).prop_flat_map(|parts| (1..=parts).prop_map(move |number| [number, parts])),
    )
}

/// A layer, but for its gloss.
fn layer() -> impl Strategy<Value = Layer> {
    let pattern = (shape(), 1..=255_u8, any::<bool>(), pieces());
    let part = prop::sample::subsequence(vec![0.0, 0.1, 0.5, 1.0], 2);
    let technique = prop::sample::select(&Technique::ALL[..Technique::ALL.len() - 1]);
    let growth = (technique, number(-1.0, 2.0), number(0.0, 1.0), 1..=64_u32);
    let colors = prop::array::uniform4(color());
    let of_mesh = any::<bool>();
    (pattern, part, growth, colors, of_mesh).prop_map(|(pattern, part, growth, colors, of_mesh)| {
        let (shape, threshold, invert, pieces) = pattern;
        let (technique, extension, chamfer, parts) = growth;
        let mut layer = Layer {
            threshold,
            invert,
            pieces,
            ..Layer::new(shape).with_technique(technique)
        };
        (layer.top, layer.bottom) = (part[0], part[1]);
        let extrusion = &mut layer.extrusion;
        for (name, value, field) in [
            ("extension", extension, &mut extrusion.extension),
            ("chamfer", chamfer, &mut extrusion.chamfer),
        ] {
            if technique.has(name) {
                *field = value;
            }
        }
        if technique.has("terraces") {
            extrusion.parts = parts;
        }
        let [cap, wall, bevel, _] = colors;
        layer.material = Material {
            cap,
            wall,
            bevel,
            ..layer.material
        };
        if of_mesh {
            layer.finish = Finish {
                wall: Some(Finish::OF_MESH.to_string()),
                ..Finish::default()
            };
        }
        layer
    })
}

/// How the object is searched: all that depends on each other.
fn searched() -> impl Strategy<Value = SceneObject> {
    let text = "[[object]]\nmesh = 'a'\nshape = 'a'\n";
    let plain = Scene::parse(text, Path::new("")).unwrap().objects.remove(0);
    let parameters = (
        0..5_usize,
        number(-1.0, 2.0),
        number(0.0, 10.0),
        number(0.0, 1.0),
    );
    let effort = (
        1..=65_536_u32,
        0..=64_u32,
        number(1e-4, 16.0),
        number(0.0, 16.0),
    );
    let rest = (
        prop::sample::select(&Tier::ALL[..]),
        prop::option::of(number(0.01, 100.0)),
        any::<bool>(),
        prop::sample::select(vec![Storage::R8, Storage::R16, Storage::R32F]),
        0..=12_u32,
    );
    (parameters, effort, rest).prop_map(move |(parameters, effort, rest)| {
        let (technique, extension, bevel, chamfer) = parameters;
        let (steps, bisections, tolerance, slack) = effort;
        let (tier, budget, uses_default, storage, reduction) = rest;
        let is_relief = technique == 4;
        let mut object = plain.clone();
        object.search = if is_relief {
            Search::Relief
        } else {
            Search::Extrusion
        };
        object.extrusion = Extrusion {
            extension: if technique > 0 { extension } else { 0.0 },
            bevel: if technique > 1 { bevel } else { 0.0 },
            chamfer: if technique > 2 { chamfer } else { 1.0 },
            ..Extrusion::UPRIGHT
        };
        if is_relief {
            (object.steps, object.bisections) = Tier::Paper.default_effort();
        } else if budget.is_some() {
            object.budget = budget;
            return object;
        }
        object.tier = if is_relief && tier == Tier::Accurate {
            Tier::Fast
        } else {
            tier
        };
        if object.tier == Tier::Paper {
            object.extrusion.extension = object.extrusion.extension.abs();
        }
        if object.tier == Tier::Accurate {
            object.tolerance = tolerance;
        }
        if object.tier != Tier::Paper && !is_relief {
            object.slack = slack;
            (object.steps, object.bisections) = object.tier.default_effort();
        } else {
            (object.steps, object.bisections) = Tier::Paper.default_effort();
        }
        if !uses_default {
            (object.steps, object.bisections) = (steps, bisections);
        }
        object.map = MapOptions {
            storage,
            reduction: 1 << reduction,
        };
        object
    })
}

fn object() -> impl Strategy<Value = SceneObject> {
    let names = (prop::option::of(any::<String>()), path(), shape());
    let placed = (
        prop::array::uniform2(number(1e-3, 1e5)),
        prop::option::of(number(1e-9, 1e9)),
        number(1e-9, 1e9),
        vector(1e9),
        vector(1e9),
    );
    let pattern = (
        prop::option::of(8..=32_768_u32),
        prop::option::of(prop::sample::select(&Projection::ALL[..])),
        number(0.0, 180.0),
        1..=255_u8,
        any::<[bool; 4]>(),
        pieces(),
    );
    let material = (
        prop::array::uniform4(color()),
        number(0.0, 1.0),
        1..=127_u32,
    );
    let layers = prop::collection::vec(layer(), 0..3);
    (searched(), names, placed, pattern, material, layers).prop_map(
        |(searched, (name, mesh, shape), placed, pattern, material, mut layers)| {
            let (repeat, depth, scale, rotate, translate) = placed;
            let (
                raster,
                projection,
                crease_angle,
                threshold,
                [cut_out, self_shadow, invert, raised],
                pieces,
            ) = pattern;
            let ([cap, wall, bevel, floor], specular, shininess) = material;
            let mesh = MeshSource::File(mesh);
            if searched.search == Search::Relief || searched.tier == Tier::Paper {
                layers.clear();
            }
            for layer in &mut layers {
                // Floor and gloss are the object's. A colour is not written where a name takes its place.
                (layer.material.specular, layer.material.shininess) = (specular, shininess);
                layer.material.floor = floor;
                if layer.finish.wall.is_some() {
                    layer.material.wall = wall;
                }
            }
            SceneObject {
                name: name.unwrap_or_else(|| mesh.label()),
                mesh,
                shape,
                raster,
                repeat,
                depth,
                raised: raised && depth.is_some(),
                cut_out,
                self_shadow,
                projection,
                crease_angle,
                threshold,
                invert,
                pieces,
                scale,
                rotate,
                translate,
                material: Material {
                    cap,
                    wall,
                    bevel,
                    floor,
                    specular,
                    shininess,
                },
                layers,
                ..searched
            }
        },
    )
}

fn scene() -> impl Strategy<Value = Scene> {
    let text = "[[object]]\nmesh = 'a'\nshape = 'a'\n";
    let plain = Scene::parse(text, Path::new("some/scenes/a.toml")).unwrap();
    let picture = (prop::array::uniform2(1..=16_384_u32), 1..=2_u32, color());
    let view = (prop::option::of(camera()), number(0.01, 179.0));
    let light = (
        vector(1e9).prop_filter("light has a direction", |v| *v != [0.0; 3]),
        color(),
        number(0.0, 1000.0),
        color(),
    );
    let objects = prop::collection::vec(object(), 1..3);
    (picture, view, light, objects).prop_map(move |(picture, view, light, objects)| {
        let (size, supersampling, background) = picture;
        let (camera, field_of_view) = view;
        let (direction, color, intensity, ambient) = light;
        Scene {
            size,
            supersampling,
            background,
            camera,
            field_of_view,
            light: Light {
                direction,
                color,
                intensity,
                ambient,
            },
            objects,
            ..plain.clone()
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn any_scene_is_read_back(scene in scene()) {
        assert_same(&again(&scene, "some/scenes"), &scene);
    }
}

#[test]
fn three_lines_stay_short() {
    let text = "[[object]]\nmesh = \"a.obj\"\nshape = \"b.png\"\n";
    let scene = Scene::parse(text, Path::new("scene.toml")).unwrap();
    let size = "[image]\nsize = [800, 600]\n\n";
    assert_eq!(scene.to_toml(Path::new("")), format!("{size}{text}"));
}

#[test]
fn files_are_named_from_the_new_folder() {
    let text = "[[object]]\nmesh = '../meshes/a.obj'\nshape = { text = 'A', font = '/c/d.ttf' }\n";
    let scene = Scene::parse(text, Path::new("/a/scenes/x.toml")).unwrap();
    for (folder, mesh, font) in [
        ("/a/scenes", "../meshes/a.obj", "../../c/d.ttf"),
        ("/a", "scenes/../meshes/a.obj", "../c/d.ttf"),
        ("/a/b/c", "../../meshes/a.obj", "../../../c/d.ttf"),
        ("/", "a/scenes/../meshes/a.obj", "c/d.ttf"),
    ] {
        let text = scene.to_toml(Path::new(folder));
        for name in [mesh, font] {
            assert!(text.contains(&format!("\"{name}\"")), "{name}: {text}");
        }
    }
    // A relative path is seen from where the program runs.
    let scene = Scene::parse("[[object]]\nmesh = 'a'\nshape = 'b/c'\n", Path::new("x/y")).unwrap();
    let here = std::env::current_dir().unwrap();
    for folder in [PathBuf::from("z"), here.join("z")] {
        let text = scene.to_toml(&folder);
        assert!(
            text.contains("\"../x/a\"") && text.contains("\"../x/b/c\""),
            "{text}"
        );
    }
}

#[test]
fn a_budget_that_is_set_is_written() {
    let text = "[[object]]\nmesh = 'a'\nshape = 'b'\ntier = 'accurate'\ntolerance = 1.0\n";
    let mut scene = Scene::parse(text, Path::new("some/a.toml")).unwrap();
    scene.set_budget(Some(0.5));
    assert_same(&again(&scene, "some"), &scene);
}

/// The scenes of this project, and their pictures.
#[test]
fn every_scene_is_read_back() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let scene = Scene::load(&path).unwrap();
        let text = scene.to_toml(&folder);
        let again = Scene::parse_with(&text, &path, &scene.limits, Files::Disk).unwrap();
        assert_same(&again, &scene);
        let mut assets = Assets::default();
        let [again, words] = [again, scene].map(|scene| words_with(scene, &mut assets));
        assert!(again == words, "{}", path.display());
    }
}
