//! The program as a user runs it: files, output and errors.

#[cfg(target_os = "linux")]
use crate::desk::within_memory;
use crate::desk::{Desk, Outcome, RENDER, words};
use crate::{left_out, program};
use exr::prelude::{AttributeValue, FlatSamples, Text, read_first_flat_layer_from_file};
use proptest::prelude::*;
use relievo::scene::{LARGEST_PICTURE_SIDE, Scene};
use relievo_tests::asset;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

const MISS: u32 = 0;
const CAP: u32 = 1;
const WALL: u32 = 2;
const BEVEL: u32 = 3;
const FLOOR: u32 = 4;

impl Desk {
    /// Writes `text` as scene.toml and asserts that rendering fails with code 1
    /// and `parts`.
    #[track_caller]
    fn scene_fails(&self, text: impl AsRef<[u8]>, parts: &str) {
        self.write("scene.toml", text);
        self.fails(&format!("{RENDER} -o new/p.png"), 1, parts);
    }

    /// Renders `text` on the CPU, 64 × 48 pixels, picture and AOVs.
    #[track_caller]
    fn render(&self, text: &str) -> (Picture, Aov) {
        self.write("scene.toml", text);
        self.run(&format!("{RENDER} -o out/p.png --aov out/p.exr"))
            .done();
        let picture = Picture::load(&self.path("out/p.png"));
        let aov = Aov::load(&self.path("out/p.exr"));
        assert_eq!((picture.width, picture.height), (64, 48));
        assert_eq!((aov.width, aov.height), (64, 48));
        aov.check();
        (picture, aov)
    }
}

/// A written PNG.
struct Picture {
    width: u32,
    height: u32,
    /// Three bytes per pixel.
    bytes: Vec<u8>,
    /// International text chunks.
    texts: BTreeMap<String, String>,
}

impl Picture {
    fn load(path: &Path) -> Picture {
        let decoder = png::Decoder::new(BufReader::new(File::open(path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut bytes).unwrap();
        reader.finish().unwrap();
        assert_eq!(frame.color_type, png::ColorType::Rgb);
        assert_eq!(frame.bit_depth, png::BitDepth::Eight);
        Picture {
            width: frame.width,
            height: frame.height,
            bytes,
            texts: reader
                .info()
                .utf8_text
                .iter()
                .map(|chunk| (chunk.keyword.clone(), chunk.get_text().unwrap()))
                .collect(),
        }
    }

    /// Sum of the squared differences of neighbours in a row.
    fn roughness(&self) -> u64 {
        self.bytes
            .chunks_exact(3 * self.width as usize)
            .flat_map(|row| row.iter().zip(&row[3..]))
            .map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2))
            .sum()
    }
}

/// A written OpenEXR file.
struct Aov {
    width: usize,
    height: usize,
    real: BTreeMap<String, Vec<f32>>,
    class: Vec<u32>,
    attributes: BTreeMap<String, AttributeValue>,
    software: String,
}

impl Aov {
    fn load(path: &Path) -> Aov {
        let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
        let (mut real, mut whole) = (BTreeMap::new(), BTreeMap::new());
        for channel in layer.channel_data.list {
            let name = channel.name.to_string();
            match channel.sample_data {
                FlatSamples::F32(samples) => assert!(real.insert(name, samples).is_none()),
                FlatSamples::U32(samples) => assert!(whole.insert(name, samples).is_none()),
                FlatSamples::F16(_) => panic!("{name} has 16 bits"),
            }
        }
        // Frames of sequences have motion vectors.
        let names = real.keys().filter(|name| !name.starts_with("motion."));
        assert_eq!(
            names.map(String::as_str).collect::<Vec<_>>(),
            ["N.x", "N.y", "N.z", "delta", "t", "u", "v"]
        );
        assert_eq!(
            whole.keys().map(String::as_str).collect::<Vec<_>>(),
            ["class", "instance", "object"]
        );
        let class = whole["class"].clone();
        // Each hit is one of an object, and of an instance of it.
        for name in ["instance", "object"] {
            let numbers = whole[name].iter().zip(&class);
            assert!(
                numbers
                    .into_iter()
                    .all(|(&number, &class)| (number == 0) == (class == 0))
            );
        }
        let attributes = layer.attributes;
        Aov {
            width: layer.size.0,
            height: layer.size.1,
            real,
            class,
            attributes: attributes
                .other
                .into_iter()
                .map(|(name, value)| (name.to_string(), value))
                .collect(),
            software: attributes.software_name.unwrap().to_string(),
        }
    }

    /// Checks what holds for every picture.
    fn check(&self) {
        for (i, &class) in self.class.iter().enumerate() {
            let [x, y, z, delta, t, u, v] =
                ["N.x", "N.y", "N.z", "delta", "t", "u", "v"].map(|name| self.real[name][i]);
            assert!(class <= FLOOR);
            assert_eq!(class == MISS, t == 0.0, "class {class}, t {t}");
            if class == MISS {
                assert_eq!([x, y, z, delta, u, v], [0.0; 6]);
            } else {
                assert!(t > 0.0 && t.is_finite(), "{t}");
                assert!((0.0..=1.0).contains(&delta), "{delta}");
                assert!(
                    (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v),
                    "{u} {v}"
                );
                let length = (x * x + y * y + z * z).sqrt();
                assert!((length - 1.0).abs() < 1e-4, "{x} {y} {z}");
            }
        }
    }

    /// Returns the classes that occur, without misses.
    fn classes(&self) -> BTreeSet<u32> {
        self.class
            .iter()
            .copied()
            .filter(|&class| class != MISS)
            .collect()
    }

    /// The pixels of a class.
    fn count(&self, class: u32) -> usize {
        self.class.iter().filter(|&&found| found == class).count()
    }

    /// Returns class and distance at the centre.
    fn middle(&self) -> (u32, f32) {
        let i = self.height / 2 * self.width + self.width / 2;
        (self.class[i], self.real["t"][i])
    }
}

/// An object table with a mesh and a pattern of the assets, and `keys`.
fn object(mesh: &str, shape: &str, keys: &str) -> String {
    let mesh = asset("meshes").join(mesh);
    let shape = asset("patterns").join(shape);
    object_of(
        &mesh.display().to_string(),
        &shape.display().to_string(),
        keys,
    )
}

/// An object table; paths are relative to the scene.
fn object_of(mesh: &str, shape: &str, keys: &str) -> String {
    format!("[[object]]\nmesh = '{mesh}'\nshape = '{shape}'\n{keys}\n")
}

/// A torus with a pattern in the folder.
fn torus_with(shape: &str, keys: &str) -> String {
    let mesh = asset("meshes/torus.obj");
    object_of(&mesh.display().to_string(), shape, keys)
}

fn torus(keys: &str) -> String {
    object(
        "torus.obj",
        "discs.png",
        &format!("repeat = [24, 10]\n{keys}"),
    )
}

fn text_of(path: &Path) -> String {
    path.display().to_string()
}

// ---------------------------------------------------------------- render

#[test]
fn render_makes_the_picture_and_says_who_rendered_it() {
    let desk = Desk::new();
    let text = torus("# ☃");
    desk.write("scene.v2.toml", &text);
    let outcome = desk
        .run("render scene.v2.toml --backend cpu --size 64x48")
        .done();
    let lines: Vec<&str> = outcome.stdout.lines().collect();
    assert!(lines[0].starts_with("CPU ("), "{lines:?}");
    assert!(lines[0].ends_with(": as requested"), "{lines:?}");
    assert_eq!(
        lines[1..],
        ["scene.v2.png"],
        "the scene's name, in this folder"
    );
    assert_eq!(outcome.stderr, "");

    let picture = Picture::load(&desk.path("scene.v2.png"));
    assert_eq!((picture.width, picture.height), (64, 48));
    assert_eq!(picture.texts["relievo-scene"], text);
    assert!(picture.texts["Software"].starts_with("relievo "));
    let colors: BTreeSet<&[u8]> = picture.bytes.chunks_exact(3).collect();
    assert!(colors.len() > 50, "{} colours", colors.len());
    assert_eq!(desk.listing().len(), 2, "{:?}", desk.listing());
}

#[test]
fn the_scene_sets_the_size_where_the_command_line_does_not() {
    let desk = Desk::new();
    desk.write(
        "scene.toml",
        format!("[image]\nsize = [31, 17]\n{}", torus("")),
    );
    desk.run("render scene.toml --backend cpu").done();
    let picture = Picture::load(&desk.path("scene.png"));
    assert_eq!((picture.width, picture.height), (31, 17));
}

#[test]
fn missing_folders_are_made_and_old_pictures_replaced() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    let arguments = format!("{RENDER} -o a/b/p.png --aov c/d/p.exr");
    desk.run(&arguments).done();
    let first = fs::read(desk.path("a/b/p.png")).unwrap();
    desk.write("a/b/p.png", "old");
    desk.run(&arguments).done();
    assert_eq!(
        fs::read(desk.path("a/b/p.png")).unwrap(),
        first,
        "and the same again"
    );
    assert_eq!(desk.listing().len(), 7, "{:?}", desk.listing());
}

#[test]
fn the_asset_scene_renders() {
    let desk = Desk::new();
    let mut command = desk.command();
    command.arg("render").arg(asset("scenes/torus.toml"));
    let outcome = Outcome::of(command.args(["--backend", "cpu", "--size", "64x48"])).done();
    assert_eq!(outcome.stdout.lines().last(), Some("torus.png"));
    Picture::load(&desk.path("torus.png"));
}

#[test]
fn auto_says_which_renderer_and_why_and_gpu_needs_an_adapter() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    let adapters = desk.run("info").done().stdout;
    let auto = desk.run("render scene.toml --size 16x12").done();
    let line = auto.stdout.lines().next().unwrap();
    let reasons = [
        "this machine's GPU",
        "is a software driver",
        "this machine has no GPU adapter",
        "the GPU cannot render this",
    ];
    assert_eq!(
        reasons
            .iter()
            .filter(|reason| line.contains(**reason))
            .count(),
        1,
        "{line}"
    );
    fs::remove_file(desk.path("scene.png")).unwrap();

    let gpu = "render scene.toml --size 16x12 --backend gpu";
    if adapters.contains("adapters: none") {
        assert!(line.contains("this machine has no GPU adapter"), "{line}");
        desk.fails(gpu, 3, "no GPU adapter | --backend cpu");
    } else {
        assert!(adapters.starts_with("adapter: "), "{adapters}");
        let outcome = desk.run(gpu).done();
        assert!(
            outcome
                .stdout
                .lines()
                .next()
                .unwrap()
                .ends_with(": as requested")
        );
        let picture = Picture::load(&desk.path("scene.png"));
        assert_eq!((picture.width, picture.height), (16, 12));
    }
}

#[test]
fn an_adapter_that_is_not_there_is_the_machines_fault() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    let adapters = desk.run("info").done().stdout;
    // The list of adapters.
    let first = adapters.lines().next().unwrap();
    let there = match first.strip_prefix("adapter: ") {
        Some(found) => found.split(" (").next().unwrap(),
        None => "this machine has none",
    };
    for command in [
        "render",
        "render --backend gpu",
        "verify",
        "bench scene --frames 1",
    ] {
        desk.fails(
            &format!("{command} scene.toml --size 16x12 --adapter no-such-adapter"),
            3,
            &format!("no-such-adapter | --backend cpu | {there}"),
        );
    }
    // Invalid, and no reason to ignore half of the arguments.
    desk.fails(
        &format!("{RENDER} --adapter none"),
        2,
        "--adapter names a GPU",
    );
}

#[test]
fn gpu_verify_reports_functions_and_pictures_of_every_adapter() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    let arguments = "verify scene.toml --size 32x24 --inputs 640 --all-adapters";
    let json = desk.run(&format!("{arguments} --json")).done().stdout;
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let adapters = report["adapters"].as_array().unwrap();
    assert!(!adapters.is_empty());
    for adapter in adapters {
        assert!(!adapter["driver"].as_str().unwrap().is_empty());
        for module in adapter["modules"].as_array().unwrap() {
            if module["promises"] == true {
                assert_eq!(module["different"], 0, "{module}");
                assert!(adapter["canaries"].as_array().unwrap().len() > 5);
            }
            let kernels = module["kernels"].as_array().unwrap();
            let divide = kernels.iter().find(|kernel| kernel["name"] == "divide");
            assert_eq!(divide.unwrap()["words"], 640);
            let picture = &module["pictures"][0];
            assert_eq!(picture["size"], serde_json::json!([32, 24]));
            assert_eq!(picture["color"]["words"], 32 * 24 * 4);
            assert_eq!(picture["geometry"]["words"], 32 * 24 * 8);
        }
    }
    // The same as text.
    let text = desk.run(arguments).done().stdout;
    for part in [
        "canaries",
        "divide: ",
        "scene.toml, 32 × 24: ",
        "geometry: ",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    desk.fails("verify --inputs 0", 1, "nothing to compare | --inputs");
}

#[test]
fn aovs_hold_what_was_hit_and_where_it_came_from() {
    let desk = Desk::new();
    let camera = "[camera]\neye = [0.0, 2.3, 3.4]\ntarget = [0.0, -0.08, 0.0]\nfov = 38.0\n";
    let keys = "depth = 0.1\ntechnique = \"chamfered\"\nbevel = 0.1\nchamfer = 0.5";
    let text = format!("{camera}{}", torus(keys));
    let (_, aov) = desk.render(&text);
    assert_eq!(aov.classes(), BTreeSet::from([CAP, WALL, BEVEL, FLOOR]));
    assert!(aov.count(MISS) > 0);
    for (class, &delta) in aov.class.iter().zip(&aov.real["delta"]) {
        match *class {
            CAP => assert!(delta < 0.01, "{delta}"),
            FLOOR => assert!(delta > 0.99, "{delta}"),
            BEVEL => assert!(delta <= 0.5, "{delta}"),
            _ => {}
        }
    }
    assert!(aov.software.starts_with("relievo "), "{}", aov.software);
    let vector = |x, y, z| AttributeValue::FloatVec3((x, y, z));
    assert_eq!(aov.attributes["relievo.camera.eye"], vector(0.0, 2.3, 3.4));
    assert_eq!(
        aov.attributes["relievo.camera.target"],
        vector(0.0, -0.08, 0.0)
    );
    assert_eq!(aov.attributes["relievo.camera.up"], vector(0.0, 1.0, 0.0));
    assert_eq!(
        aov.attributes["relievo.camera.fov"],
        AttributeValue::F32(38.0)
    );
    let scene = AttributeValue::Text(Text::from(text.as_str()));
    assert_eq!(aov.attributes["relievo.scene"], scene);
}

#[test]
fn scenes_in_any_script_reach_the_metadata() {
    let desk = Desk::new();
    for (name, written) in [
        ("Ärger", "Ärger"),
        ("Блок 🗿", r"\u{411}\u{43b}\u{43e}\u{43a} \u{1f5ff}"),
    ] {
        let text = torus(&format!("name = \"{name}\""));
        let (picture, aov) = desk.render(&text);
        assert_eq!(picture.texts["relievo-scene"], text);
        let scene = AttributeValue::Text(Text::from(text.replace(name, written).as_str()));
        assert_eq!(aov.attributes["relievo.scene"], scene);
    }
}

#[test]
fn supersampling_smooths_the_same_picture() {
    let desk = Desk::new();
    let (plain, plain_aov) = desk.render(&torus(""));
    let (fine, fine_aov) = desk.render(&format!("[image]\nsupersample = true\n{}", torus("")));
    assert_ne!(plain.bytes, fine.bytes);
    assert!(
        10 * fine.roughness() < 9 * plain.roughness(),
        "{} {}",
        fine.roughness(),
        plain.roughness()
    );
    assert_eq!(plain_aov.class, fine_aov.class, "AOVs are not averaged");
    let difference: u64 = plain
        .bytes
        .iter()
        .zip(&fine.bytes)
        .map(|(a, b)| u64::from(a.abs_diff(*b)))
        .sum();
    assert!(
        difference < 30 * plain.bytes.len() as u64,
        "the same thing is seen: {difference}"
    );
}

#[test]
fn pictures_are_exposed_toned_and_cut_free() {
    let desk = Desk::new();
    let render = |keys: &str| {
        desk.render(&format!("[image]\n{keys}\n{}", torus("")))
            .0
            .bytes
    };
    let brightness = |bytes: &[u8]| bytes.iter().map(|byte| u64::from(*byte)).sum::<u64>();
    let plain = render("");
    assert_eq!(render("exposure = 0.0\ntone = 'clip'"), plain);
    let (dark, agx) = (
        render("exposure = -2.0"),
        render("exposure = 2.0\ntone = 'agx'"),
    );
    assert!(brightness(&dark) < brightness(&plain));
    assert!(agx != plain && agx != render("exposure = 2.0"));
    // The background is not developed.
    assert!(
        [&dark, &agx]
            .iter()
            .all(|picture| picture[..3] == plain[..3])
    );

    desk.write(
        "scene.toml",
        format!("[image]\ntransparent = true\n{}", torus("")),
    );
    desk.run(&format!("{RENDER} -o cut.png")).done();
    let file = BufReader::new(File::open(desk.path("cut.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut cut = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut cut).unwrap();
    assert_eq!(frame.color_type, png::ColorType::Rgba);
    let (_, aov) = desk.render(&torus(""));
    for ((pixel, opaque), class) in cut.chunks(4).zip(plain.chunks(3)).zip(&aov.class) {
        match *class {
            MISS => assert_eq!(pixel, [0; 4]),
            _ => assert!(pixel[..3] == *opaque && pixel[3] == 255),
        }
    }
}

// ------------------------------------------------------- render --frames

/// A scene with a camera, a named torus of some depth, and `tracks`.
fn animated(orbit: f64, depth: f64, tracks: &str) -> String {
    let camera = format!("[camera]\neye = [0.0, 2.3, 3.4]\nfov = 38.0\norbit = {orbit:?}\n");
    let object = torus(&format!("name = \"ring\"\ndepth = {depth:?}"));
    format!("[image]\nframe_rate = 4\n{camera}{object}{tracks}")
}

const ORBIT: &str = "[[animate]]\nkey = 'camera.orbit'\ntimes = [0, 1]\nvalues = [0, 40]\n";
const DEEPER: &str =
    "[[animate]]\nkey = 'object.ring.depth'\ntimes = [0, 1]\nvalues = [0.0625, 0.125]\n";

#[test]
fn each_frame_is_the_picture_of_its_scene() {
    let desk = Desk::new();
    // One preparation for all frames, and one for each.
    for (tracks, depths) in [(ORBIT, [0.1; 3]), (DEEPER, [0.078125, 0.09375, 0.109375])] {
        desk.write("scene.toml", animated(0.0, 0.1, tracks));
        let frames = "--frames 1..=3 -o out/%02d.png --aov out/%02d.exr";
        let outcome = desk.run(&format!("{RENDER} {frames}")).done();
        let lines: Vec<&str> = outcome.stdout.lines().skip(1).collect();
        let names = [1, 2, 3].map(|n| [format!("out/0{n}.exr"), format!("out/0{n}.png")]);
        assert_eq!(lines, names.as_flattened());
        for (frame, depth) in (1..=3).zip(depths) {
            let orbit = if tracks == ORBIT {
                10.0 * f64::from(frame)
            } else {
                0.0
            };
            let (alone, alone_aov) = desk.render(&animated(orbit, depth, ""));
            let picture = Picture::load(&desk.path(&format!("out/0{frame}.png")));
            assert!(picture.bytes == alone.bytes, "{tracks} {frame}");
            assert_eq!(picture.texts["relievo-frame"], frame.to_string());
            let aov = Aov::load(&desk.path(&format!("out/0{frame}.exr")));
            let motion = ["motion.x", "motion.y"].map(|name| &aov.real[name]);
            assert_eq!(alone_aov.real.len() + 2, aov.real.len());
            for (name, samples) in &alone_aov.real {
                assert!(aov.real[name] == *samples, "{name}");
            }
            // Points of the front move to the left by some pixels; a depth moves none.
            let furthest = motion[0].iter().fold(0.0f32, |most, x| most.max(x.abs()));
            let expected = if tracks == ORBIT {
                1.0..10.0
            } else {
                0.0..0.01
            };
            assert!(expected.contains(&furthest), "{furthest}");
        }
    }
}

#[test]
fn a_sequence_may_be_one_animated_picture() {
    let desk = Desk::new();
    desk.write("scene.toml", animated(0.0, 0.1, ORBIT));
    desk.run(&format!("{RENDER} --frames 0..4 -o turn.apng"))
        .done();
    let file = BufReader::new(File::open(desk.path("turn.apng")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    for frame in 0..4 {
        reader.next_frame(&mut bytes).unwrap();
        let (alone, _) = desk.render(&animated(10.0 * f64::from(frame), 0.1, ""));
        assert!(bytes == alone.bytes, "{frame}");
        let delay = reader.info().frame_control().unwrap();
        assert_eq!(u32::from(delay.delay_den), 4 * u32::from(delay.delay_num));
    }
}

#[test]
fn wrong_frames_are_told() {
    let desk = Desk::new();
    desk.write("scene.toml", animated(0.0, 0.1, ORBIT));
    for (options, code, parts) in [
        ("--frames 3", 2, "FIRST..END"),
        ("--frames 4..4", 2, "there is no frame in 4..4"),
        (
            "--frames 0..2 -o a.png",
            1,
            "a.png has no place for the number of the frame | %04d",
        ),
        ("--frames 0..2 -o %d.APNG", 1, "%d.APNG holds all frames"),
        (
            "--frames 0..12 -o out/%d.exr --aov out/1%d.exr",
            1,
            "two of the outputs would be out/1",
        ),
        ("--frames 0..2 --aov a.exr", 1, "--aov a.exr has no place"),
    ] {
        desk.fails(&format!("{RENDER} {options}"), code, parts);
    }
    assert_eq!(desk.listing().len(), 1, "{:?}", desk.listing());
    // The eye passes through its target at frame 2: what was drawn before stays.
    let through =
        "[[animate]]\nkey = 'camera.eye'\ntimes = [0, 1]\nvalues = [[0, 0, 3], [0, 0, -3]]\n";
    desk.write("scene.toml", animated(0.0, 0.1, through));
    let outcome = desk.run(&format!("{RENDER} --frames 0..4 -o out/%d.png"));
    let part = "camera.eye is the same point as camera.target; move one of them, at 0.5 s";
    assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    assert_eq!(outcome.code, Some(1));
    assert!(desk.path("out/1.png").exists() && !desk.path("out/2.png").exists());
}

// ---------------------------------------------------------------- bake

/// A diamond of 1/4 of the width.
fn diamond(x: u32, y: u32) -> u8 {
    if x.abs_diff(20) + y.abs_diff(16) < 10 {
        0
    } else {
        255
    }
}

#[test]
fn a_baked_map_draws_the_same_picture_as_its_pattern() {
    let desk = Desk::new();
    desk.image("pattern.png", 40, 32, diamond);
    let keys = "repeat = [12, 5]\nextension = 0.05";
    let (wanted, aov) = desk.render(&torus_with("pattern.png", keys));
    assert!(aov.count(CAP) > 100 && aov.count(FLOOR) > 100);
    for bits in ["16", "8"] {
        let outcome = desk
            .run(&format!("bake pattern.png -o map.png --format r{bits}"))
            .done();
        for part in ["map.png", "40 × 32", &format!("{bits} bits")] {
            assert!(outcome.stdout.contains(part), "{}", outcome.stdout);
        }
        let decoder = png::Decoder::new(BufReader::new(File::open(desk.path("map.png")).unwrap()));
        let reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().color_type, png::ColorType::Grayscale);
        assert_eq!((reader.info().bit_depth as u8).to_string(), bits);
        assert_eq!((reader.info().width, reader.info().height), (40, 32));

        let (picture, baked) = desk.render(&torus_with("map.png", keys));
        if bits == "16" {
            assert!(picture.bytes == wanted.bytes);
        } else {
            let other = baked
                .class
                .iter()
                .zip(&aov.class)
                .filter(|(a, b)| a != b)
                .count();
            assert!(other < 64 * 48 / 50, "{other} pixels of another class");
        }
    }
    desk.run("bake pattern.png -o default.png").done();
    desk.run("bake pattern.png -o map.png --format r16").done();
    let read = |name| fs::read(desk.path(name)).unwrap();
    assert!(
        read("default.png") == read("map.png"),
        "16 bits are the default"
    );
}

#[test]
fn drawings_and_letters_are_baked() {
    let desk = Desk::new();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='20' height='16'><path d='M10 3L17 8 10 13 3 8z'/></svg>";
    desk.write("drawing.svg", svg);
    let bake = |arguments: &str| {
        let command = format!("bake -o map.png {arguments}");
        let outcome = desk.run(&command).done();
        (fs::read(desk.path("map.png")).unwrap(), outcome.stdout)
    };
    let (default, said) = bake("drawing.svg");
    assert!(said.contains("512 × 410"), "{said}");
    let (small, said) = bake("drawing.svg --raster 40");
    assert!(small != default && said.contains("40 × 32"), "{said}");
    // The map that a scene makes from it.
    let keys = "repeat = [12, 5]";
    let (wanted, aov) = desk.render(&torus_with("map.png", keys));
    let counts = [aov.count(CAP), aov.count(FLOOR)];
    assert!(counts[0] > 50 && counts[1] > 50, "{counts:?}");
    let keys = format!("{keys}\nraster = 40");
    let (found, _) = desk.render(&torus_with("drawing.svg", &keys));
    assert!(found.bytes == wanted.bytes);

    let (wide, said) = bake("--text RELIEVO --raster 64");
    assert!(said.contains("64 × "), "{said}");
    assert!(bake("--text RELIEVO --raster 64 --margin 1").0 != wide);
    desk.image("p.png", 8, 8, diamond);
    for (arguments, code, parts) in [
        ("--text 字", 1, "字 | built-in font | name a font"),
        ("--text A --font p.png", 1, "p.png | not a font"),
        ("--text A --font none.ttf", 1, "none.ttf"),
        ("p.png --raster 64", 1, "p.png | --raster"),
        ("p.png --text A", 2, "cannot be used with"),
        ("p.png --font f.ttf", 2, "cannot be used with"),
        ("--text A --margin 11", 2, "--margin"),
        ("--text A --raster 7", 2, "--raster"),
        ("", 2, "PATTERN"),
    ] {
        desk.fails(&format!("bake -o other.png {arguments}"), code, parts);
    }
}

#[test]
fn bake_inverts_and_thresholds() {
    let desk = Desk::new();
    desk.image("ramp.png", 16, 4, |x, _| 16 * x as u8);
    desk.image("dark.png", 16, 4, |x, _| if 16 * x < 100 { 0 } else { 255 });
    desk.image(
        "light.png",
        16,
        4,
        |x, _| if 16 * x < 100 { 255 } else { 0 },
    );
    let bake = |arguments: &str| {
        desk.run(&format!("bake -o map.png {arguments}")).done();
        fs::read(desk.path("map.png")).unwrap()
    };
    let dark = bake("dark.png");
    let light = bake("light.png");
    assert!(dark != light);
    assert!(bake("ramp.png --threshold 100") == dark);
    assert!(bake("ramp.png --threshold 100 --invert") == light);
    assert!(bake("dark.png --invert") == light);
    assert!(bake("ramp.png") != dark);
    // The scene's own keys do the same.
    let (wanted, _) = desk.render(&torus_with("light.png", "repeat = [12, 5]"));
    let keys = "repeat = [12, 5]\nthreshold = 100\ninvert = true";
    let (found, _) = desk.render(&torus_with("ramp.png", keys));
    assert!(found.bytes == wanted.bytes);
}

#[test]
fn bake_says_what_is_wrong() {
    let desk = Desk::new();
    desk.image("pattern.png", 8, 8, diamond);
    desk.write("text.png", "no image");
    fs::create_dir(desk.path("folder")).unwrap();
    for (arguments, parts) in [
        (
            "none.png -o map.png",
            "none.png | check that the file exists",
        ),
        ("folder -o map.png", "folder | give an image file"),
        ("text.png -o map.png", "text.png | give an undamaged PNG"),
        ("pattern.png -o folder", "folder | .png"),
        (
            "pattern.png -o text.png/m.png",
            "cannot write text.png/m.png",
        ),
    ] {
        desk.fails(&format!("bake {arguments}"), 1, parts);
    }
    for wrong in ["--format r9", "--threshold 0", "--threshold 256"] {
        let parts = wrong.replace(' ', "|");
        desk.fails(&format!("bake pattern.png -o map.png {wrong}"), 2, &parts);
    }
    desk.fails("bake pattern.png", 2, "--output");
}

// ---------------------------------------------------------------- info

/// Prisms as deep as the torus's tube would fold.
#[test]
fn a_depth_that_the_surface_cannot_have_is_reduced_and_told() {
    let desk = Desk::new();
    let told = |keys: &str| {
        desk.write("scene.toml", torus(keys));
        desk.run("render scene.toml -o a.png").done().stderr
    };
    let deep = "depth = 0.5\ntier = \"accurate\"";
    let text = told(deep);
    let told_once = text.matches("the depth 0.500000 is reduced over").count();
    assert_eq!(told_once, 1, "{text}");
    assert!(text.contains("too thin or too curved"), "{text}");
    // A budget plans several ways to draw it, and says it once too.
    let planned = told("depth = 0.5\nerror_px = 2");
    assert_eq!(planned.matches("is reduced over").count(), 1, "{planned}");
    let (_, reduced) = desk.render(&torus(deep));
    reduced.check();
    assert_eq!(reduced.classes(), BTreeSet::from([CAP, WALL, FLOOR]));
    // A possible depth is unchanged.
    let possible = "depth = 0.05\ntier = \"accurate\"";
    assert!(!told(possible).contains("is reduced over"));
    let (_, shallow) = desk.render(&torus(possible));
    assert!(shallow.count(WALL) < reduced.count(WALL));
    // As a map: coloured where it is less.
    let map = |keys: &str| {
        desk.write("scene.toml", torus(keys));
        desk.run("render scene.toml -o picture.png --backend cpu")
            .done();
        let info = desk
            .run("info scene.toml --local-depth map.png")
            .done()
            .stdout;
        let [picture, map] = ["picture.png", "map.png"].map(|name| {
            let picture = image::open(desk.path(name)).unwrap().into_rgb8();
            picture.into_raw()
        });
        (info, picture != map)
    };
    let (info, is_coloured) = map(deep);
    assert!(
        info.contains("local depth: 0.500000, reduced over"),
        "{info}"
    );
    assert!(is_coloured);
    let (info, is_coloured) = map(possible);
    assert!(!info.contains("local depth") && !is_coloured, "{info}");
    desk.fails("info --local-depth map.png", 2, "SCENE");
    let scene_itself = "info scene.toml --local-depth scene.toml";
    desk.fails(scene_itself, 1, "scene.toml is a file that the scene reads");
    desk.scene_fails(
        torus("depth = 1e-5\ntier = \"accurate\""),
        "too little|tier = \"fast\"",
    );
}

#[test]
fn info_shows_what_a_scene_loads() {
    let desk = Desk::new();
    let outcome = Outcome::of(desk.command().arg("info").arg(asset("scenes/torus.toml"))).done();
    let text = &outcome.stdout;
    for part in [
        "torus.toml",
        "800 × 600",
        "2028 triangles",
        "512 × 512 texels",
        "16 bits",
        "\nadapter",
    ] {
        assert!(text.contains(part), "{part:?} is missing in\n{text}");
    }
    // A torus of radii 1 and 0.4: from −1/(1 − 0.4) on its inside to 1/0.4 around the tube.
    let line = text
        .lines()
        .find(|line| line.contains("principal curvatures"))
        .unwrap();
    let numbers: Vec<f64> = line
        .split(' ')
        .filter_map(|word| word.parse().ok())
        .collect();
    let [smallest, largest] = numbers[..] else {
        panic!("{line}");
    };
    assert!((smallest + 1.0 / 0.6).abs() < 0.1, "{line}");
    assert!((largest - 2.5).abs() < 0.1, "{line}");
    assert!(desk.listing().is_empty(), "info writes nothing");
}

#[test]
fn explain_says_what_is_in_and_what_is_out() {
    let desk = Desk::new();
    let outcome = Outcome::of(
        desk.command()
            .arg("explain")
            .arg(asset("scenes/torus_planar.toml")),
    )
    .done();
    let text = &outcome.stdout;
    for part in [
        "out rays bent along quadrics: tier = \"planar\"",
        "in  floor",
        "exact shader color_planar: ",
        "    RDNA3: ",
        " registers (vector + scalar), none spilled; ",
        "with everything, color_extrusion: ",
        "prisms: 0 (688128)",
        "together: ",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_budget_takes_the_place_of_tier_and_steps() {
    let desk = Desk::new();
    let scene = asset("scenes/sphere.toml");
    let scene = text_of(&scene);
    let drawn = |budget: &str| {
        desk.run(&format!(
            "render {scene} --size 40x30 --backend cpu --budget {budget} -o out.png"
        ))
        .done()
        .stdout
    };
    let [coarse, fine] = ["4px", "0.02"].map(drawn);
    assert!(coarse.contains("4 px: tier planar"), "{coarse}");
    assert!(fine.contains("0.02 px: tier accurate"), "{fine}");
    assert!(desk.path("out.png").exists());

    let text = desk
        .run(&format!("explain {scene} --size 40x30 --budget 1px"))
        .done()
        .stdout;
    for part in [
        "budget 1 px: tier ",
        "model: the planar tier is likely wrong by ",
        "tried tier ",
        " rays, after at most ",
        "without pictures: ",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    for wrong in ["0", "-1px", "1mm", "1000px"] {
        desk.fails(
            &format!("render {scene} --budget={wrong}"),
            2,
            "--budget | from 0.01 to 100",
        );
    }
}

/// Lines of a measurement file.
#[cfg(feature = "studies")]
fn measured(desk: &Desk, file: &str) -> Vec<serde_json::Value> {
    let text = fs::read_to_string(desk.path(file)).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    lines.collect()
}

#[cfg(feature = "studies")]
#[test]
fn tradeoff_goes_on_where_it_was_stopped() {
    let desk = Desk::new();
    let scene = asset("scenes/torus.toml");
    let scene = text_of(&scene);
    let sweep = format!("tradeoff {scene} --quick --size 64x48 --backend cpu --frames 1 -o out");
    let first = desk.run(&sweep).done();
    for name in ["tradeoff.csv", "pareto.svg", "pareto.png", "tradeoff.md"] {
        assert!(first.stdout.contains(name), "{}", first.stdout);
    }
    let larger = sweep.replace("64x48", "65x48");
    desk.fails(&larger, 1, "size is [64,48] there and [65,48] here");

    // As if it had been interrupted while writing the last line.
    let file = desk.path("out/measurements-1-of-1.jsonl");
    let whole = fs::read(&file).unwrap();
    fs::write(&file, &whole[..whole.len() - 20]).unwrap();
    let again = desk.run(&sweep).done();
    assert!(
        again.stdout.contains("measured: 1, kept from before: 13"),
        "{}",
        again.stdout
    );
    let before = fs::read(&file).unwrap();
    let again = desk.run(&sweep).done();
    assert!(
        again.stdout.contains("measured: 0, kept from before: 14"),
        "{}",
        again.stdout
    );
    assert_eq!(fs::read(&file).unwrap(), before);

    let csv = fs::read_to_string(desk.path("out/tradeoff.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 14, "{csv}");
    let page = fs::read_to_string(desk.path("out/tradeoff.md")).unwrap();
    let chart = fs::read_to_string(desk.path("out/pareto.svg")).unwrap();
    // The accurate tier is nearest to the truth, which uses prisms as well.
    let best = "accurate-0.1px/96+8/slack-0px/r16/1:1/1x/no-shadow/cpu";
    assert!(page.contains(best) && chart.contains(best), "{page}");
    let picture = image::open(desk.path("out/pareto.png"))
        .unwrap()
        .into_rgb8();
    assert!(picture.pixels().any(|pixel| pixel.0 != [255; 3]));

    let lines = measured(&desk, "out/measurements-1-of-1.jsonl");
    let errors = |key: &str| {
        let line = lines.iter().find(|line| line["key"] == key).unwrap();
        line["measured"]["errors"]["misplaced"].as_f64().unwrap()
    };
    let fast = errors("fast/96+8/slack-0px/r16/1:1/1x/no-shadow/cpu");
    let planar = errors("planar/96+8/slack-0px/r16/1:1/1x/no-shadow/cpu");
    assert!(errors(best) < fast && fast < planar);
}

#[cfg(feature = "studies")]
#[test]
fn tradeoff_leaves_out_what_a_scene_cannot_have() {
    let desk = Desk::new();
    // Less deep than the accurate tier can follow rays.
    desk.write("scene.toml", torus("depth = 1e-5"));
    let quick = "tradeoff scene.toml --quick --size 32x24 --backend cpu --frames 1 -o";
    desk.run(&format!("{quick} deep")).done();
    let page = fs::read_to_string(desk.path("deep/tradeoff.md")).unwrap();
    assert!(
        page.contains("14 variants at 32 × 24 pixels, of which 12 were measured"),
        "{page}"
    );
    assert!(page.contains("2 variants `accurate-0.1px/*/"), "{page}");
    assert!(
        page.contains("too little") && page.contains("The FLIP difference"),
        "{page}"
    );

    desk.write("scene.toml", torus("technique = 'relief'"));
    desk.run(&format!("{quick} relief")).done();
    let page = fs::read_to_string(desk.path("relief/tradeoff.md")).unwrap();
    assert!(page.contains("The tiers paper and accurate"), "{page}");

    let pattern = text_of(&asset("patterns/discs.png"));
    desk.run(&format!("bake {pattern} -o discs.png")).done();
    desk.write(
        "scene.toml",
        torus_with("discs.png", "repeat = [24, 10]\nerror_px = 1"),
    );
    desk.run(&format!("{quick} baked")).done();
    let page = fs::read_to_string(desk.path("baked/tradeoff.md")).unwrap();
    assert!(page.contains("Storage and size of the maps"), "{page}");
    assert!(page.contains("/baked/1:1/"), "{page}");
}

#[test]
fn info_tells_what_was_done_to_a_mesh() {
    let desk = Desk::new();
    // No texture coordinates, no normals, one triangle without area.
    desk.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n");
    desk.image("p.png", 8, 8, diamond);
    desk.write(
        "scene.toml",
        object_of("m.obj", "p.png", "projection = 'planar-z'"),
    );
    let outcome = desk.run("info scene.toml").done();
    for part in [
        "1 triangles without area left out",
        "normals computed",
        "coordinates projected",
    ] {
        assert!(outcome.stdout.contains(part), "{}", outcome.stdout);
    }
}

// ---------------------------------------------------------------- bad input

#[test]
fn wrong_usage_ends_with_code_2() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    for (arguments, parts) in [
        ("render scene.toml --size 0x5", "--size | 800x600"),
        ("render scene.toml --size 5", "--size | 800x600"),
        ("render scene.toml --size 99999x5", "--size | 16384"),
        ("render scene.toml --size=-1x5", "--size | 800x600"),
        ("render scene.toml --backend abacus", "abacus | cpu"),
        (
            "render scene.toml --no-such-flag",
            "--no-such-flag | --help",
        ),
        ("render", "<SCENE> | Usage"),
        ("paint", "paint | --help"),
        (
            "verify scene.toml --adapter a --all-adapters",
            "--adapter | --all-adapters",
        ),
        ("verify scene.toml --shaders best", "--shaders | portable"),
        ("bench scene scene.toml --frames 0", "--frames"),
        ("tradeoff scene.toml", "--output"),
        ("render scene.toml --plan job.json", "--plan | --frames"),
        (
            "render scene.toml --frames 0..2 --piece-seconds 3",
            "--plan",
        ),
        ("job job.json --piece 1 --merge", "--piece | --merge"),
        ("submit job.json", "--slurm"),
    ] {
        desk.fails(arguments, 2, parts);
    }
    // Requested, so no error.
    for arguments in ["--help", "--version", "render --help"] {
        let outcome = desk.run(arguments).done();
        assert!(outcome.stdout.contains("relievo"), "{}", outcome.stdout);
    }
    // Without a command, the help is the message.
    let outcome = desk.run("");
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("Usage"), "{}", outcome.stderr);
}

#[test]
fn a_command_that_is_left_out_says_how_to_get_it() {
    let desk = Desk::new();
    for command in [
        "view s.toml",
        "bench scene s.toml",
        "bounds",
        "gallery -o out --size 8x6",
    ] {
        let Some(feature) = left_out(command) else {
            continue;
        };
        let name = words(command)[0];
        for command in [command, &format!("{name} --help")] {
            let outcome = desk.run(command);
            let line = format!("cargo run --release --features {feature} -- {command}");
            assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
            assert!(outcome.stderr.contains(&line), "{}", outcome.stderr);
        }
    }
}

#[test]
fn scene_files_that_cannot_be_read() {
    let desk = Desk::new();
    fs::create_dir(desk.path("folder")).unwrap();
    for command in ["render", "info", "bench scene"] {
        desk.fails(
            &format!("{command} none.toml"),
            1,
            "none.toml | check the path",
        );
        desk.fails(&format!("{command} folder"), 1, "folder | name a TOML file");
    }
    desk.scene_fails(b"\n# caf\xe9\n", "scene.toml | line 2 | save it as UTF-8");
    desk.scene_fails("", "scene.toml | add a table [[object]]");
}

#[test]
fn scene_files_with_mistakes() {
    let desk = Desk::new();
    for (key, parts) in [
        ("depht = 0.1", "line 4 | depht | depth"),
        ("depth = nan", "line 4 | depth | goes from"),
        ("depth = \"deep\"", "line 4 | deep | expected"),
        ("depth = ", "line 4 | expected"),
        ("repeat = [1, inf]", "line 4 | repeat | go from"),
        ("translate = [0, nan, 0]", "line 4 | translate | finite"),
        ("translate = [0, 0]", "line 4 | 3"),
        ("tier = 'best'", "line 4 | best | fast"),
        (
            "[image]\nsize = [0, 600]",
            "line 5 | image.size | from 1 to 16384",
        ),
        ("[image]\nbackground = '#12'", "line 5 | #12 | #rrggbb"),
        ("[image]\nbackground = [nan, 0, 0]", "line 5 | from 0 to 1"),
        ("[camera]\nfov = nan", "line 5 | camera.fov | goes from"),
        (
            "[camera]\neye = [nan, 0, 1]",
            "line 5 | camera.eye | finite",
        ),
        ("[[object]", "line 4 | expected"),
    ] {
        let text = object_of("m.obj", "p.png", key);
        desk.scene_fails(text, &format!("scene.toml | {parts}"));
    }
}

/// Scenes are parsed recursively: the depth must not depend on the input.
#[test]
fn scene_files_nested_without_end() {
    let desk = Desk::new();
    let n = 200_000;
    for text in [
        format!("a = {}", "[".repeat(n)),
        format!("a = {}{}", "[".repeat(n), "]".repeat(n)),
        format!("a = {}", "{a=".repeat(n)),
        format!("a{} = 1", ".a".repeat(n)),
        format!("[a{}]", ".a".repeat(n)),
        format!("[[object]]\nmaterial{} = 1", ".a".repeat(n)),
    ] {
        desk.scene_fails(&text, "scene.toml");
    }
}

#[test]
fn scenes_from_other_editors() {
    let desk = Desk::new();
    let text = torus("depth = 0.1");
    let (wanted, _) = desk.render(&text);
    for other in [format!("\u{feff}{text}"), text.replace('\n', "\r\n")] {
        let (found, _) = desk.render(&other);
        assert!(found.bytes == wanted.bytes);
    }
    let wrong = text.replace("0.1", "-1");
    for other in [format!("\u{feff}{wrong}"), wrong.replace('\n', "\r\n")] {
        desk.scene_fails(other, "line 5, column 9 | depth");
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

#[test]
fn meshes_that_cannot_be_used() {
    let desk = Desk::new();
    desk.image("p.png", 8, 8, diamond);
    fs::create_dir(desk.path("folder")).unwrap();
    desk.scene_fails(
        object_of("none.obj", "p.png", ""),
        "none.obj | check the path",
    );
    desk.scene_fails(
        object_of("folder", "p.png", ""),
        "folder | name an OBJ or glTF file",
    );
    let scene = object_of("m.obj", "p.png", "");
    for (statements, parts) in [
        ("this is no mesh", "no faces | export it with"),
        ("f 1/1 2/2 9/3", "line 7 | 9"),
        ("f 1/1 2/2 x/3", "line 7 | x"),
        ("v 1 2", "line 7"),
        ("v 0 nan 0\nf 1/1 2/2 3/3", "line 7 | nan | finite"),
        ("v 0 1e999 0\nf 1/1 2/2 3/3", "line 7 | 1e999 | finite"),
        ("vt nan 0\nf 1/4 2/2 3/3", "line 7 | nan | finite"),
        ("# no face", "no faces | export it with"),
        ("f 1/1 2/2 2/2", "no area | check the exporter"),
        ("f 1 2 3", "line 7 | projection = \"spherical\""),
    ] {
        desk.write("m.obj", format!("{TRIANGLE}{statements}\n"));
        desk.scene_fails(&scene, &format!("m.obj | {parts}"));
    }
    desk.write("m.obj", "");
    desk.scene_fails(&scene, "m.obj | no faces");
    // A comment in Latin-1 is text, a zero byte is none.
    desk.write("m.obj", b"# caf\xe9\n");
    desk.scene_fails(&scene, "m.obj | no faces");
    desk.write("m.obj", b"v 0 0\0 0\n");
    desk.scene_fails(&scene, "m.obj | not text | OBJ");
}

#[test]
fn a_projection_makes_a_mesh_without_texture_coordinates_usable() {
    let desk = Desk::new();
    desk.image("p.png", 40, 32, diamond);
    desk.write("m.obj", format!("{TRIANGLE}f 1 2 3\n"));
    for projection in [
        "planar-x",
        "planar-y",
        "planar-z",
        "cylindrical",
        "spherical",
    ] {
        let keys = format!("projection = '{projection}'");
        let (_, aov) = desk.render(&object_of("m.obj", "p.png", &keys));
        assert!(aov.count(MISS) < 64 * 48, "{projection}");
    }
}

#[test]
fn shapes_that_cannot_be_used() {
    let desk = Desk::new();
    fs::create_dir(desk.path("folder")).unwrap();
    desk.write("text.png", "no image");
    desk.write("nothing.png", "");
    desk.image("whole.png", 40, 32, |x, y| (x * y) as u8);
    let whole = fs::read(desk.path("whole.png")).unwrap();
    desk.write("cut.png", &whole[..whole.len() / 2]);
    desk.run("bake whole.png -o map.png").done();
    let map = fs::read(desk.path("map.png")).unwrap();
    desk.write("cut_map.png", &map[..map.len() / 2]);
    for (shape, part) in [
        ("none.png", "check that the file exists"),
        ("folder", "give an image file"),
        ("text.png", "give an undamaged PNG"),
        ("nothing.png", "give an undamaged PNG"),
        ("cut.png", "give an undamaged PNG"),
        ("cut_map.png", "bake it again"),
    ] {
        let parts = format!("{shape} | {part}");
        desk.scene_fails(torus_with(shape, ""), &parts);
        desk.fails("info scene.toml", 1, &parts);
    }
}

/// Signature and header of a gray PNG, and no pixels.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    drop(encoder.write_header().unwrap());
    bytes
}

#[test]
fn a_huge_shape_is_refused_by_its_header() {
    let desk = Desk::new();
    desk.write("huge.png", png_header(60_000, 60_000));
    desk.write("scene.toml", torus_with("huge.png", ""));
    for arguments in [RENDER, "bake huge.png -o map.png"] {
        let parts = "huge.png | 60000 × 60000 | scale the image down";
        desk.fails(arguments, 1, parts);
        #[cfg(target_os = "linux")]
        {
            // The pixels would take 3.6 GB.
            let outcome = within_memory(&desk, 1 << 30, arguments);
            assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
            assert!(
                outcome.stderr.contains("60000 × 60000"),
                "{}",
                outcome.stderr
            );
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_does_not_fit_is_the_machines_fault() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    let side = LARGEST_PICTURE_SIDE;
    let arguments = format!("render scene.toml --backend cpu --size {side}x{side}");
    let outcome = within_memory(&desk, 1 << 30, &arguments);
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("memory"), "{}", outcome.stderr);
    assert_eq!(desk.listing().len(), 1);
}

#[test]
fn outputs_that_cannot_be_written() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    fs::create_dir(desk.path("folder")).unwrap();
    for (output, way_out) in [("folder", "name a file in it"), ("scene.toml/p.png", "")] {
        let parts = format!("cannot write {output} | {way_out}");
        desk.fails(&format!("{RENDER} -o {output}"), 1, &parts);

        // The picture is finished by then, and remains.
        let outcome = desk.run(&format!("{RENDER} -o p.png --aov {output}"));
        assert_eq!(outcome.code, Some(1));
        assert!(
            outcome.stderr.contains(&format!("cannot write {output}")),
            "{}",
            outcome.stderr
        );
        Picture::load(&desk.path("p.png"));
        fs::remove_file(desk.path("p.png")).unwrap();
        assert_eq!(desk.listing().len(), 2, "{:?}", desk.listing());
    }
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_to() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    let folder = desk.path("locked");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    if File::create(folder.join("probe")).is_ok() {
        eprintln!("skipped: this user may write anywhere");
        return;
    }
    desk.fails(
        &format!("{RENDER} -o locked/p.png"),
        1,
        "cannot write locked/p.png | denied",
    );
}

/// Not even the administrator can write there.
#[cfg(target_os = "linux")]
#[test]
fn a_place_where_nobody_may_write() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    desk.fails(
        &format!("{RENDER} -o /proc/new/p.png"),
        1,
        "cannot write /proc/new/p.png",
    );
}

/// `relievo info | head -1`
#[test]
fn a_reader_that_goes_away_is_no_panic() {
    let desk = Desk::new();
    desk.write("scene.toml", torus(""));
    for arguments in ["info scene.toml", RENDER] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = std::process::Command::new(program())
            .args(words(arguments))
            .current_dir(desk.0.path())
            .stdout(writer)
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(!stderr.contains("panicked"), "{stderr}");
    }
    // The requested file exists.
    Picture::load(&desk.path("scene.png"));
}

// ---------------------------------------------------------------- patterns at the edge

#[test]
fn full_and_empty_patterns() {
    let desk = Desk::new();
    for (width, height) in [(16, 16), (1, 1), (1, 7), (7, 1)] {
        desk.image("black.png", width, height, |_, _| 0);
        desk.image("white.png", width, height, |_, _| 255);
        for keys in [
            "",
            "tier = 'planar'",
            "extension = 0.1",
            "technique = 'chamfered'",
        ] {
            let keys = &format!("depth = 0.05\n{keys}");
            let (_, full) = desk.render(&torus_with("black.png", keys));
            assert_eq!(
                full.classes(),
                BTreeSet::from([CAP]),
                "{width} × {height}, {keys}"
            );
            let (_, empty) = desk.render(&torus_with("white.png", keys));
            assert_eq!(
                empty.classes(),
                BTreeSet::from([FLOOR]),
                "{width} × {height}, {keys}"
            );
            // The floor is lower, so that slightly less is visible.
            let seen = empty.count(FLOOR) as f64 / full.count(CAP) as f64;
            assert!(
                (0.75..=1.0).contains(&seen),
                "{width} × {height}, {keys}: {seen}"
            );
        }
        let (_, nothing) = desk.render(&torus_with("white.png", "cut_out = true"));
        assert_eq!(nothing.count(MISS), 64 * 48);
    }
}

/// Extension and bevel grow the pattern; an empty pattern does not grow.
#[test]
fn nothing_grows_on_an_empty_pattern() {
    let desk = Desk::new();
    desk.image("white.png", 16, 16, |_, _| 255);
    let (_, aov) = desk.render(&torus_with("white.png", "extension = 2.0"));
    assert_eq!(aov.classes(), BTreeSet::from([FLOOR]));
}

#[test]
fn patterns_one_pixel_wide() {
    let desk = Desk::new();
    for (width, height) in [(1, 16), (16, 1)] {
        desk.image(
            "p.png",
            width,
            height,
            |x, y| if (x + y) < 8 { 0 } else { 255 },
        );
        let plane = object_of(
            &text_of(&asset("meshes/plane.obj")),
            "p.png",
            "repeat = [2, 2]\ndepth = 0.02",
        );
        let camera = "[camera]\neye = [0, 3, 0]\nup = [0, 0, -1]\n";
        let (_, aov) = desk.render(&format!("{camera}{plane}"));
        // Seen from above, half is pattern.
        let (cap, hit) = (aov.count(CAP) as f64, 64.0 * 48.0 - aov.count(MISS) as f64);
        assert!((0.4..0.6).contains(&(cap / hit)), "{cap} of {hit}");
        assert!(aov.count(FLOOR) > 0);
    }
}

/// One black pixel in the corner: distances grow to half the diagonal.
fn dot(x: u32, y: u32) -> u8 {
    if x + y == 0 { 0 } else { 255 }
}

#[test]
fn a_pattern_cannot_grow_beyond_what_its_map_holds() {
    let desk = Desk::new();
    desk.image("dot.png", 400, 400, dot);
    let outcome = desk.run("bake dot.png -o map.png --format r8").done();
    assert!(outcome.stdout.contains("saturate"), "{}", outcome.stdout);
    // 127.5 texels of 400 fit.
    desk.scene_fails(
        torus_with("map.png", "extension = 0.4"),
        "scene.toml | torus | e + b·c = 0.4 | map.png | --format r16",
    );
    desk.scene_fails(
        torus_with("map.png", "extension = 0.1\nbevel = 0.5\nchamfer = 0.5"),
        "e + b·c = 0.35 | map.png | --format r16",
    );
    desk.render(&torus_with("map.png", "extension = 0.3"));
    // The suggested remedy works.
    desk.run("bake dot.png -o map.png --format r16").done();
    desk.render(&torus_with("map.png", "extension = 0.4"));
}

/// As above, where 16 bits are not enough: they must not be the advice.
#[test]
fn the_way_out_of_a_full_16_bit_map_is_not_16_bits() {
    let desk = Desk::new();
    desk.image("dot.png", 6000, 1, dot);
    desk.write("scene.toml", torus_with("dot.png", "extension = 0.45"));
    let outcome = desk.run("info scene.toml");
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("dot.png"), "{}", outcome.stderr);
    assert!(!outcome.stderr.contains("r16"), "{}", outcome.stderr);
}

/// The inside of a pattern saturates too, and an inset reaches into it.
#[test]
fn a_pattern_cannot_shrink_beyond_what_its_map_holds() {
    let desk = Desk::new();
    desk.image("hole.png", 400, 400, |x, y| 255 - dot(x, y));
    let text = |shape: &str| torus_with(shape, "technique = 'outward'\nextension = -0.25");
    let (_, wanted) = desk.render(&text("hole.png"));
    assert!(wanted.count(CAP) > 100);
    desk.run("bake hole.png -o map.png --format r8").done();
    desk.write("scene.toml", text("map.png"));
    let outcome = desk.run(&format!("{RENDER} -o new.png --aov new.exr"));
    if outcome.code == Some(0) {
        let found = Aov::load(&desk.path("new.exr"));
        let other = found
            .class
            .iter()
            .zip(&wanted.class)
            .filter(|(a, b)| a != b)
            .count();
        assert!(other < 64 * 48 / 50, "{other} pixels of another class");
    } else {
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("map.png"), "{}", outcome.stderr);
    }
}

// ---------------------------------------------------------------- scenes at the edge

#[test]
fn eyes_and_depths_at_the_edge() {
    let desk = Desk::new();
    for tier in ["planar", "fast"] {
        for (camera, keys) in [
            ("", "depth = 50"),
            ("", "depth = 1e9"),
            ("", "depth = 1e-9"),
            ("", "depth = 50\ncut_out = true"),
            // In the tube, on it, at a vertex, in the hole, under the floor.
            ("[camera]\neye = [1, 0, 0]", ""),
            ("[camera]\neye = [1.4, 0, 0]", ""),
            ("[camera]\neye = [1, 0.4, 0]\ntarget = [1, 0.4, 5]", ""),
            (
                "[camera]\neye = [0, 0, 0]\ntarget = [0, -1, 0]\nup = [1, 0, 0]",
                "",
            ),
            ("[camera]\neye = [1, 0.1, 0]", "depth = 0.5"),
            ("[camera]\neye = [0, 1e8, 1e7]", ""),
            ("[camera]\neye = [0, 0, 3]\nfov = 179", ""),
            ("[camera]\neye = [0, 0, 3]\nfov = 0.01", ""),
        ] {
            let (_, aov) = desk.render(&format!("{camera}\n{}tier = '{tier}'\n", torus(keys)));
            if camera.is_empty() && keys == "depth = 1e-9" {
                assert!(aov.count(CAP) > 100 && aov.count(FLOOR) > 100, "{tier}");
                assert_eq!(aov.count(WALL), 0, "{tier}");
            }
        }
    }
}

#[test]
fn one_triangle() {
    let desk = Desk::new();
    desk.image("black.png", 4, 4, |_, _| 0);
    desk.write("m.obj", format!("{TRIANGLE}f 1/1 2/2 3/3\n"));
    let camera = "[camera]\neye = [0.3, 0.3, 2]\ntarget = [0.3, 0.3, 0]\n";
    let scene = format!("{camera}{}", object_of("m.obj", "black.png", ""));
    let (_, aov) = desk.render(&scene);
    let (class, t) = aov.middle();
    assert_eq!(class, CAP);
    assert!((t - 2.0).abs() < 0.01, "{t}");
    // Half a square unit, 2 units away, 45° high: (48 / (4 tan 22.5°))² / 2 pixels.
    let wanted = (48.0 / (4.0 * (22.5f64).to_radians().tan())).powi(2) / 2.0;
    let found = aov.count(CAP) as f64;
    assert!(
        (found / wanted - 1.0).abs() < 0.1,
        "{found} pixels, not {wanted}"
    );
}

/// A square of side 2 at height `y`, black, seen from 3 units above.
fn square(y: f64, keys: &str) -> String {
    let mesh = text_of(&asset("meshes/plane.obj"));
    object_of(
        &mesh,
        "black.png",
        &format!("translate = [0, {y}, 0]\n{keys}"),
    )
}

const FROM_ABOVE: &str = "[camera]\neye = [0, 3, 0]\nup = [0, 0, -1]\n";

#[test]
fn the_nearer_object_is_seen_whatever_the_order() {
    let desk = Desk::new();
    desk.image("black.png", 4, 4, |_, _| 0);
    let near = square(1.0, "");
    let far = square(-1.0, "scale = 3\n[object.material]\ncap = '#ff0000'\n");
    let (alone, _) = desk.render(&format!("{FROM_ABOVE}{near}"));
    let (first, aov) = desk.render(&format!("{FROM_ABOVE}{near}{far}"));
    let (second, other) = desk.render(&format!("{FROM_ABOVE}{far}{near}"));
    assert!(first.bytes == second.bytes && aov.real == other.real);
    let middle = 3 * (24 * 64 + 32);
    assert_eq!(first.bytes[middle..][..3], alone.bytes[middle..][..3]);
    assert!((aov.middle().1 - 2.0).abs() < 1e-3, "{:?}", aov.middle());
    // The far square is visible beside the near one.
    let farthest = aov.real["t"].iter().copied().fold(0.0, f32::max);
    assert!(farthest > 4.0, "{farthest}");
}

#[test]
fn a_cut_out_object_is_seen_through() {
    let desk = Desk::new();
    desk.image("black.png", 4, 4, |_, _| 0);
    desk.image("half.png", 16, 16, |x, _| if x < 8 { 0 } else { 255 });
    let mesh = text_of(&asset("meshes/plane.obj"));
    let screen = object_of(
        &mesh,
        "half.png",
        "repeat = [4, 4]\ndepth = 0.05\ncut_out = true",
    );
    let (_, holes) = desk.render(&format!("{FROM_ABOVE}{screen}"));
    assert_eq!(holes.count(FLOOR), 0);
    assert!(holes.count(CAP) > 200);
    let behind = square(-1.0, "scale = 3");
    let (_, filled) = desk.render(&format!("{FROM_ABOVE}{screen}{behind}"));
    assert_eq!(filled.count(MISS), 0);
    let through = holes
        .class
        .iter()
        .zip(&filled.real["t"])
        .filter(|(class, t)| **class == MISS && **t > 3.5)
        .count();
    assert_eq!(through, holes.count(MISS));
}

#[test]
fn intersecting_objects() {
    let desk = Desk::new();
    let upright = torus("name = 'upright'\nrotate = [90, 0, 0]\nbevel = 0.05");
    let ball = object(
        "sphere.obj",
        "bricks.png",
        "repeat = [6, 3]\ntier = 'planar'\nscale = 0.8",
    );
    let flat = torus("name = 'flat'\ncut_out = true");
    let camera = "[camera]\neye = [1, 2, 4]\n";
    let (picture, aov) = desk.render(&format!("{camera}{flat}{upright}{ball}"));
    let (other_picture, other) = desk.render(&format!("{camera}{ball}{upright}{flat}"));
    assert!(picture.bytes == other_picture.bytes);
    assert!(aov.real == other.real && aov.class == other.class);
    // Each pixel shows the nearest of the objects' separate pictures.
    let alone = [&flat, &upright, &ball].map(|object| desk.render(&format!("{camera}{object}")).1);
    let mut other = 0;
    for (i, &t) in aov.real["t"].iter().enumerate() {
        let nearest = alone
            .iter()
            .map(|aov| aov.real["t"][i])
            .filter(|&t| t > 0.0)
            .reduce(f32::min)
            .unwrap_or(0.0);
        // The origin moves with the objects, so the last digits differ.
        other += usize::from((t - nearest).abs() > 1e-3);
    }
    assert!(other < 64 * 48 / 100, "{other} pixels");
}

// ---------------------------------------------------------------- scene text

/// Every key, once.
const EVERY_KEY: &str = r##"# Комментарий
[image]
size = [64, 48]
supersample = true
background = "#e9edf2"

[camera]
eye = [0.0, 2.3, 3.4]
target = [0.0, -0.08, 0.0]
up = [0.0, 1.0, 0.0]
fov = 38.0

[light]
direction = [0.5, 0.8, 0.6]
color = [1.0, 0.9, 0.8]
intensity = 1.5
ambient = "#5a6470"

[[object]]
name = "тор"
mesh = "torus.obj"
shape = "discs.png"
repeat = [24, 10]
depth = 0.1
technique = "chamfered"
extension = 0.05
bevel = 0.1
chamfer = 0.5
tier = "fast"
steps = 96
bisections = 8
cut_out = false
projection = "spherical"
threshold = 128
invert = true
scale = 1.0
rotate = [0, 90, 0]
translate = [1, 2, 3]

[object.material]
cap = "#d8b45c"
wall = "#b0502e"
bevel = "#e8cf94"
floor = "#3d5a73"
specular = 0.25
shininess = 40
"##;

/// Fragments that are hard to parse.
const PIECES: [&str; 32] = [
    "nan",
    "-inf",
    "-0",
    "-0.0",
    "1e999",
    "1e-999",
    "9223372036854775808",
    "-9223372036854775808",
    "0x7fffffffffffffff",
    "1979-05-27T07:32:00Z",
    "true",
    "\"",
    "'",
    "\"\"\"",
    "\\u0000",
    "\\ud800",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "=",
    ".",
    ",",
    "\n",
    "\r",
    "\0",
    "#",
    "é",
    "🗿",
    "[[object]]\n",
];

/// A change to the bytes of a text.
#[derive(Clone, Debug)]
enum Mutation {
    Delete(usize, usize),
    Duplicate(usize, usize, usize),
    Replace(usize, u8),
    Insert(usize, &'static str),
    ReplaceWord(usize, &'static str),
}

impl Mutation {
    fn any() -> impl Strategy<Value = Mutation> {
        let place = 0..EVERY_KEY.len();
        let length = prop_oneof![1..4usize, 1..200usize];
        let piece = || prop::sample::select(&PIECES[..]);
        prop_oneof![
            (place.clone(), length.clone()).prop_map(|(a, n)| Mutation::Delete(a, n)),
            (place.clone(), length, place.clone())
                .prop_map(|(a, n, b)| Mutation::Duplicate(a, n, b)),
            (place.clone(), any::<u8>()).prop_map(|(a, byte)| Mutation::Replace(a, byte)),
            (place.clone(), piece()).prop_map(|(a, piece)| Mutation::Insert(a, piece)),
            (place, piece()).prop_map(|(a, piece)| Mutation::ReplaceWord(a, piece)),
        ]
    }

    fn apply(&self, text: &mut Vec<u8>) {
        let clip = |a: usize, n: usize, text: &Vec<u8>| a.min(text.len())..(a + n).min(text.len());
        match *self {
            Mutation::Delete(a, n) => drop(text.drain(clip(a, n, text))),
            Mutation::Duplicate(a, n, b) => {
                let copy = text[clip(a, n, text)].to_vec();
                let at = b.min(text.len());
                text.splice(at..at, copy);
            }
            Mutation::Replace(a, byte) => {
                if let Some(old) = text.get_mut(a) {
                    *old = byte;
                }
            }
            Mutation::Insert(a, piece) => {
                let at = a.min(text.len());
                text.splice(at..at, piece.bytes());
            }
            Mutation::ReplaceWord(a, piece) => {
                let ends = |byte: &u8| b" ,[]\n".contains(byte);
                let start = a.min(text.len());
                let start = text[..start].iter().rposition(ends).map_or(0, |i| i + 1);
                let length = text[start..].iter().position(ends).unwrap_or(0);
                text.splice(start..start + length, piece.bytes());
            }
        }
    }
}

/// Checks the invariants of [`Scene`]: every number is finite and in its range.
fn check_scene(scene: &Scene) {
    let finite = |numbers: &[f64]| assert!(numbers.iter().all(|x| x.is_finite()), "{numbers:?}");
    assert!(
        scene
            .size
            .iter()
            .all(|side| (1..=LARGEST_PICTURE_SIDE).contains(side))
    );
    assert!((0.01..=179.0).contains(&scene.field_of_view));
    if let Some(camera) = scene.camera {
        finite(&[camera.eye, camera.target, camera.up].concat());
        assert_ne!(camera.eye, camera.target);
    }
    finite(&scene.light.direction);
    assert_ne!(scene.light.direction, [0.0; 3]);
    let light = [scene.light.color, scene.light.ambient, scene.background];
    let mut colors = light.to_vec();
    assert!(!scene.objects.is_empty());
    for object in &scene.objects {
        finite(&[object.rotate, object.translate].concat());
        assert!(
            object
                .repeat
                .iter()
                .all(|&repeat| repeat > 0.0 && repeat.is_finite())
        );
        assert!(
            object
                .depth
                .is_none_or(|depth| depth > 0.0 && depth.is_finite())
        );
        assert!(object.scale > 0.0 && object.scale.is_finite());
        let extrusion = object.extrusion;
        finite(&[extrusion.extension, extrusion.bevel]);
        assert!((0.0..=1.0).contains(&extrusion.chamfer));
        assert!(object.steps > 0 && object.bisections <= 64 && object.threshold > 0);
        let material = object.material;
        assert!((0.0..=1.0).contains(&material.specular));
        assert!((1..=127).contains(&material.shininess));
        colors.extend([material.cap, material.wall, material.bevel, material.floor]);
    }
    for channel in colors.iter().flat_map(|color| color.0) {
        assert!((0.0..=1.0).contains(&channel), "{channel}");
    }
}

#[test]
fn the_text_that_is_mutated_is_a_scene() {
    check_scene(&Scene::parse(EVERY_KEY, Path::new("some.toml")).unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn any_text_is_a_scene_or_an_error(mutations in prop::collection::vec(Mutation::any(), 1..6)) {
        let mut text = EVERY_KEY.as_bytes().to_vec();
        for mutation in &mutations {
            mutation.apply(&mut text);
        }
        let text = String::from_utf8_lossy(&text);
        match Scene::parse(&text, Path::new("some.toml")) {
            Ok(scene) => check_scene(&scene),
            Err(error) => prop_assert!(error.to_string().contains("some.toml"), "{}", error),
        }
    }
}
