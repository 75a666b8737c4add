//! Scenes that cover every shader.

use relievo::export::{ExportedFile, Options, Output, Target, export};
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::ColorWords;
use relievo::render::gpu::{EntryPoints, Extent, Shaders};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Layer, Scene, SceneObject, Search, Technique, Tier};
use relievo::shape_map::Storage;
use relievo_tests::asset;
use std::collections::BTreeSet;

/// A scene to export.
pub struct Case {
    pub name: String,
    pub scene: PreparedScene,
}

type Change = fn(&mut SceneObject);

/// A scene for each fragment shader without shadows.
const SEARCHES: [(&str, &str, Change); 12] = [
    ("planar", "torus_planar.toml", |object| {
        object.extrusion.bevel = 0.0;
    }),
    ("planar_growing", "torus_planar.toml", |object| {
        object.extrusion.bevel = 0.06;
    }),
    ("curved", "torus.toml", |_| ()),
    ("curved_growing", "torus.toml", |object| {
        object.extrusion.bevel = 0.06;
    }),
    ("straight", "torus.toml", |object| {
        object.map.storage = Storage::R32F;
    }),
    ("extrusion", "torus.toml", |object| {
        object.set_technique(Technique::Rounded);
    }),
    ("relief", "torus.toml", |object| {
        object.search = Search::Relief;
    }),
    ("paper", "torus.toml", |object| {
        object.tier = Tier::Paper;
        (object.steps, object.bisections) = Tier::Paper.default_effort();
    }),
    ("layers", "torus.toml", add_layer),
    ("prisms_layers", "torus_accurate.toml", add_layer),
    ("prisms_straight", "torus_accurate.toml", |_| ()),
    ("prisms", "torus_accurate.toml", |object| {
        object.set_technique(Technique::Stepped);
    }),
];

/// Fills what the pattern leaves out, below.
fn add_layer(object: &mut SceneObject) {
    object.layers.push(Layer {
        invert: !object.invert,
        top: 0.5,
        bottom: 0.75,
        ..Layer::new(object.shape.clone()).with_technique(Technique::Chamfered)
    });
}

/// A modified, small scene of `assets/scenes`.
pub fn prepared(file: &str, change: impl Fn(&mut SceneObject)) -> PreparedScene {
    let mut scene = Scene::load(&asset("scenes").join(file)).unwrap();
    scene.size = [160, 120];
    scene.objects.iter_mut().for_each(change);
    prepare(&scene, &|_| ()).unwrap()
}

/// One scene for each fragment shader, and whole scenes.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (shader, file, change) in SEARCHES {
        for self_shadow in [false, true] {
            let scene = prepared(file, |object| {
                change(object);
                object.self_shadow = self_shadow;
            });
            let shadow = if self_shadow { "_shadow" } else { "" };
            let name = format!("color_{shader}{shadow}");
            let entry_points = EntryPoints::of(&scene.objects[0].parameters, Extent::Needed);
            assert_eq!(entry_points.color, name);
            cases.push(Case { name, scene });
        }
    }
    for file in ["lattice.toml", "together.toml", "sphere.toml"] {
        let name = file.to_string();
        let scene = prepared(file, |_| ());
        cases.push(Case { name, scene });
    }
    cases
}

#[test]
fn every_shader_is_in_a_case() {
    let module = Shaders::Fast.module().unwrap();
    let there: BTreeSet<String> = module
        .entry_points()
        .map(|entry_point| entry_point.name.clone())
        .filter(|name| name.starts_with("color_"))
        .collect();
    let known =
        SEARCHES.map(|(name, ..)| [format!("color_{name}"), format!("color_{name}_shadow")]);
    assert_eq!(there, known.into_iter().flatten().collect());
}

/// Exports each object of a scene in one language.
pub fn exported(scene: &PreparedScene, target: Target, output: Output) -> Vec<Vec<ExportedFile>> {
    let options = Options {
        targets: vec![target],
        output,
        ..Options::default()
    };
    let files = export(scene, &options).unwrap();
    if scene.objects.len() == 1 {
        return vec![files];
    }
    let folder = |file: &ExportedFile| {
        file.name
            .split_once('/')
            .map(|(folder, _)| folder.to_string())
    };
    let folders: BTreeSet<String> = files.iter().filter_map(folder).collect();
    assert_eq!(folders.len(), scene.objects.len());
    let of = |folder: &String| {
        let mine = files.iter().filter_map(|file| {
            let name = file.name.strip_prefix(folder)?.strip_prefix('/')?;
            Some(ExportedFile {
                name: name.to_string(),
                bytes: file.bytes.clone(),
            })
        });
        mine.collect()
    };
    folders.iter().map(of).collect()
}

/// The bytes of a file.
#[track_caller]
pub fn file<'a>(files: &'a [ExportedFile], name: &str) -> &'a [u8] {
    let found = files.iter().find(|file| file.name == name);
    &found
        .unwrap_or_else(|| panic!("{name} is not exported"))
        .bytes
}

/// Differences from our pictures.
#[derive(Debug, Default)]
pub struct Difference {
    /// Pixels with another class.
    pub classes: usize,
    /// Pixels of the same class with another colour.
    pub colors: usize,
    /// Largest difference of a channel in those, linear.
    pub largest: f32,
}

/// Largest measured difference of a channel, rounded up, on Mesa's software
/// drivers (docs/export.md).
const LARGEST: f32 = 2.6e-6;
/// The same for the paper's algorithms, whose quotients magnify rounding errors.
const LARGEST_OF_PAPER: f32 = 1.6e-5;
/// Bound for GPUs, which have not been measured yet.
const LARGEST_ON_A_GPU: f32 = 1e-3;
const CLASSES_ON_A_GPU: usize = 20;

impl Difference {
    /// Prints the differences, and fails if they are too large.
    pub fn check(&self, case: &Case, is_software: bool) {
        eprintln!("{}: {self:?}", case.name);
        let (classes, largest) = if is_software {
            let is_paper = case.name.starts_with("color_paper");
            (0, if is_paper { LARGEST_OF_PAPER } else { LARGEST })
        } else {
            (CLASSES_ON_A_GPU, LARGEST_ON_A_GPU)
        };
        let is_small = self.classes <= classes && self.largest <= largest;
        assert!(is_small, "{}: {self:?}", case.name);
    }

    /// Compares a picture of colours (r, g, b, 1) with one of words.
    pub fn of(scene: &PreparedScene, colors: &[[u32; 4]], words: &[[u32; 4]]) -> Difference {
        let ours: ColorWords = CpuRenderer::new(scene).color(&scene.frame).unwrap();
        assert_eq!(ours.words.len(), colors.len());
        assert_eq!(ours.words.len(), words.len());
        let covered = ours.words.iter().filter(|word| word[3] != 0).count();
        assert!(covered > 1000, "there is something to see");
        let mut difference = Difference::default();
        for ((ours, color), words) in ours.words.iter().zip(colors).zip(words) {
            assert_eq!(f32::from_bits(color[3]), 1.0);
            if ours[3] != words[3] {
                difference.classes += 1;
                continue;
            }
            let channel = |i: usize| (f32::from_bits(ours[i]) - f32::from_bits(color[i])).abs();
            let largest = channel(0).max(channel(1)).max(channel(2));
            assert!(largest.is_finite());
            difference.colors += usize::from(largest > 0.0);
            difference.largest = difference.largest.max(largest);
        }
        difference
    }
}
