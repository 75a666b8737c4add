//! Malicious or malformed input: decompression bombs, pipes and devices, paths
//! that leave the folder, full disks. Each gives a message and an exit code,
//! and leaves no partial file.

#[cfg(target_os = "linux")]
use crate::desk::within_memory;
use crate::desk::{Desk, Outcome, RENDER};
use crate::left_out;
#[cfg(unix)]
use crate::program;
use relievo::Limits;
use relievo_tests::{asset, root};
use std::fs;
use std::path::Path;

/// Arguments to render untrusted scenes.
const STRICT: &str = "render scene.toml --backend cpu --size 64x48";

/// Commands that load a scene, given alone.
const LOADING: [&str; 6] = [
    "render",
    "info",
    "explain",
    "verify",
    "bench scene",
    "accuracy",
];

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

fn object(mesh: &str, shape: &str) -> String {
    format!("[[object]]\nmesh = '{mesh}'\nshape = '{shape}'\n")
}

/// A folder with a mesh, a pattern and a scene of both.
fn desk() -> Desk {
    let desk = Desk::new();
    desk.write("mesh.obj", format!("{TRIANGLE}f 1/1 2/2 3/3\n"));
    desk.image("pattern.png", 16, 16, |x, y| {
        if (x / 4 + y / 4) % 2 == 0 { 0 } else { 255 }
    });
    desk.write("scene.toml", object("mesh.obj", "pattern.png"));
    desk
}

impl Desk {
    /// Runs exactly these arguments.
    fn run_strictly(&self, arguments: &str) -> Outcome {
        Outcome::of(self.command().args(arguments.split_whitespace()))
    }

    /// Like [`Desk::fails`], with exactly these arguments.
    #[track_caller]
    fn fails_strictly(&self, arguments: &str, parts: &str) {
        if left_out(arguments).is_some() {
            return self.fails(arguments, 2, "");
        }
        let before = self.listing();
        let Outcome { code, stderr, .. } = self.run_strictly(arguments);
        assert_eq!(code, Some(1), "{arguments}\n{stderr}");
        for part in parts.split('|').map(str::trim) {
            assert!(stderr.contains(part), "{part:?} is missing in\n{stderr}");
        }
        assert_eq!(self.listing(), before, "{stderr}");
    }
}

// ---------------------------------------------------------------- limits

#[test]
fn every_limit_is_told_and_can_be_raised() {
    let desk = desk();
    let text = object("mesh.obj", "pattern.png").repeat(3);
    desk.write("scene.toml", text);
    for (low, high, parts) in [
        (
            "--max-objects 2",
            "--max-objects 3",
            "scene.toml, line 8 | object 3 | limit of 2 | --max-objects",
        ),
        (
            "--max-triangles 2",
            "--max-triangles 3",
            "scene.toml | \"mesh\" | limit of 2 | --max-triangles",
        ),
        (
            "--max-pixels 255",
            "--max-pixels 256",
            "pattern.png | 16 × 16 | limit of 255 | --max-pixels",
        ),
    ] {
        for command in [STRICT, "info scene.toml", "explain scene.toml --size 64x48"] {
            desk.fails_strictly(&format!("{command} {low}"), parts);
        }
        desk.run_strictly(&format!("{STRICT} {high}")).done();
        fs::remove_file(desk.path("scene.png")).unwrap();
    }
    desk.fails_strictly(
        "bake pattern.png -o map.png --max-pixels 255",
        "16 × 16 | --max-pixels",
    );
    desk.run_strictly("bake pattern.png -o map.png --max-pixels 256")
        .done();
    desk.write("scene.toml", object("mesh.obj", "map.png"));
    desk.fails_strictly(
        &format!("{STRICT} --max-pixels 255"),
        "map.png | 16 × 16 | --max-pixels",
    );
    desk.run_strictly(&format!("{STRICT} --max-pixels 256"))
        .done();
}

/// For any memory limit, the whole picture is written or nothing is.
#[test]
fn memory_is_limited_step_by_step() {
    let desk = desk();
    let mut refused = Vec::new();
    let mut kilobytes = 52;
    let enough = loop {
        let arguments = format!("{STRICT} --max-memory {kilobytes}K");
        let outcome = desk.run_strictly(&arguments);
        if outcome.code == Some(0) {
            break kilobytes;
        }
        desk.fails_strictly(&arguments, "error: | limit of | --max-memory");
        refused.push(outcome.stderr);
        kilobytes += 1;
    };
    assert!((60..100).contains(&enough), "{enough}");
    // Counted in turn: picture, mesh, triangles, pattern.
    for part in ["picture of 64 × 48 pixels", "mesh.obj", "pattern.png"] {
        assert!(
            refused.iter().any(|message| message.contains(part)),
            "{part}: {refused:?}"
        );
    }
    let more = format!("{STRICT} --max-memory {}K", enough + 1);
    desk.run_strictly(&more).done();
}

#[test]
fn wrong_limits_are_wrong_usage() {
    let desk = desk();
    for wrong in [
        "--max-memory much",
        "--max-memory 1.5G",
        "--max-pixels 0",
        "--max-pixels 1073741825",
        "--max-objects=-1",
        "--max-triangles 1e9",
    ] {
        let flag = wrong.split([' ', '=']).next().unwrap();
        desk.fails(&format!("{STRICT} {wrong}"), 2, flag);
    }
}

#[test]
fn the_page_on_limits_has_the_limits() {
    let page = fs::read_to_string(root().join("docs/limits.md")).unwrap();
    let Limits {
        objects,
        triangles,
        pixels,
        memory,
        outside,
    } = Limits::default();
    assert!(!outside);
    for row in [
        format!("| `--max-objects` | {objects} |"),
        format!("| `--max-triangles` | {triangles} |"),
        format!("| `--max-pixels` | {pixels} |"),
        format!("| `--max-memory` | {}G |", memory >> 30),
    ] {
        assert!(page.contains(&row), "{row} is missing");
    }
}

/// Four samples of each of 2²⁸ pixels exceed the limit on any machine.
#[test]
fn a_large_picture_is_refused_before_it_is_begun() {
    let desk = desk();
    let text = format!(
        "[image]\nsize = [16384, 16384]\nsupersample = true\n{}",
        object("mesh.obj", "pattern.png")
    );
    desk.write("scene.toml", text);
    desk.fails_strictly(
        "render scene.toml --backend cpu",
        "scene.toml | 16384 × 16384 pixels, 4 sample(s) | --max-memory",
    );
}

/// A file without contents that claims to have 100 GB.
#[cfg(target_os = "linux")]
#[test]
fn a_huge_mesh_file_is_not_read() {
    let desk = desk();
    let file = fs::File::create(desk.path("mesh.obj")).unwrap();
    file.set_len(100 << 30).unwrap();
    let outcome = within_memory(&desk, 1 << 30, STRICT);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    for part in ["mesh.obj", "larger than the limit", "--max-memory"] {
        assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    }
    let file = fs::File::create(desk.path("scene.toml")).unwrap();
    file.set_len(100 << 30).unwrap();
    let outcome = within_memory(&desk, 1 << 30, STRICT);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("at most 16777216"),
        "{}",
        outcome.stderr
    );
}

/// The picture fits, but not its AOVs.
#[test]
fn large_aovs_are_refused_before_anything_is_drawn() {
    let desk = desk();
    let render = "render scene.toml --backend cpu --size 640x480 --max-memory 20M -o p.png";
    desk.fails_strictly(
        &format!("{render} --aov p.exr"),
        "scene.toml | --aov would take 35635200 bytes | --max-memory",
    );
    desk.run_strictly(render).done();
}

// ---------------------------------------------------------------- decompression

/// A chunk of a PNG.
#[cfg(target_os = "linux")]
fn chunk(kind: &[u8; 4], contents: &[u8]) -> Vec<u8> {
    let mut bytes = (contents.len() as u32).to_be_bytes().to_vec();
    bytes.extend(kind);
    bytes.extend(contents);
    let checksum = bytes[4..].iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 }
        })
    });
    bytes.extend((!checksum).to_be_bytes());
    bytes
}

/// A zlib stream of `megabytes` of zeros, about a thousandth as long: deflate
/// with fixed codes, a zero and then copies of it, 258 bytes at a time.
#[cfg(target_os = "linux")]
fn zeros(megabytes: usize) -> Vec<u8> {
    let mut bits = Bits(vec![0x78, 0x01], 0);
    // The last block, with fixed codes; the literal 0.
    bits.put(0b011, 3);
    bits.put_reversed(0b0011_0000, 8);
    for _ in 0..(megabytes << 20) / 258 {
        // Length 258 is code 285, distance 1 is code 0.
        bits.put_reversed(0b1100_0101, 8);
        bits.put_reversed(0, 5);
    }
    bits.put_reversed(0, 7);
    bits.0
}

/// Bits of a deflate stream, lowest bit of each byte first.
#[cfg(target_os = "linux")]
struct Bits(Vec<u8>, u32);

#[cfg(target_os = "linux")]
impl Bits {
    fn put(&mut self, bits: u32, count: u32) {
        for index in 0..count {
            if self.1 == 0 {
                self.0.push(0);
            }
            let last = self.0.last_mut().unwrap();
            *last |= (((bits >> index) & 1) as u8) << self.1;
            self.1 = (self.1 + 1) % 8;
        }
    }

    fn put_reversed(&mut self, bits: u32, count: u32) {
        self.put(bits.reverse_bits() >> (32 - count), count);
    }
}

/// A PNG with `extra` before its pixels, and `pixels` as their zlib stream.
#[cfg(target_os = "linux")]
fn png(side: u32, extra: &[u8], pixels: &[u8]) -> Vec<u8> {
    let mut header = side.to_be_bytes().to_vec();
    header.extend(side.to_be_bytes());
    // 8 bits, gray.
    header.extend([8, 0, 0, 0, 0]);
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    bytes.extend(chunk(b"IHDR", &header));
    bytes.extend(extra);
    bytes.extend(chunk(b"IDAT", pixels));
    bytes.extend(chunk(b"IEND", b""));
    bytes
}

/// Small files that inflate to 2 GB with a limit of 1 GB: a profile, a text,
/// pixels, and more pixels than the header says.
#[cfg(target_os = "linux")]
#[test]
fn images_that_inflate() {
    let desk = desk();
    let bomb = zeros(2048);
    assert!(bomb.len() < 16 << 20);
    let named = |kind: &[u8; 4]| chunk(kind, &[b"name\0\0", &bomb[..]].concat());
    let description =
        r#"{"version":1,"storage":"r8","bias":0,"step":1,"scale":1,"saturated":false}"#;
    let described = chunk(
        b"tEXt",
        format!("relievo-shape-map\0{description}").as_bytes(),
    );
    // 8 rows of 9 bytes.
    let pixels = {
        let mut bits = Bits(vec![0x78, 0x01], 0);
        bits.put(0b011, 3);
        for _ in 0..72 {
            bits.put_reversed(0b0011_0000, 8);
        }
        bits.put_reversed(0, 7);
        bits.0.extend([0, 72, 0, 1]);
        bits.0
    };
    let plain = png(8, &[], &pixels);
    desk.write("pattern.png", &plain);
    desk.run_strictly(STRICT).done();
    for (name, bytes, code) in [
        ("a profile", png(8, &named(b"iCCP"), &pixels), 0),
        ("a text", png(8, &named(b"zTXt"), &pixels), 0),
        ("too many pixels", png(8, &[], &bomb), 0),
        ("a large picture", png(46_000, &[], &bomb), 1),
        (
            "a map with a profile",
            png(8, &[named(b"iCCP"), described.clone()].concat(), &pixels),
            0,
        ),
        (
            "a map with a text",
            png(8, &[named(b"zTXt"), described.clone()].concat(), &pixels),
            0,
        ),
        ("a map of too many pixels", png(8, &described, &bomb), 0),
        ("a large map", png(46_000, &described, &bomb), 1),
    ] {
        desk.write("pattern.png", bytes);
        let outcome = within_memory(&desk, 1 << 30, STRICT);
        assert_eq!(outcome.code, Some(code), "{name}: {}", outcome.stderr);
        if code == 1 {
            assert!(
                outcome.stderr.contains("pattern.png"),
                "{name}: {}",
                outcome.stderr
            );
        }
    }
}

/// The largest allowed number of pixels, from 300 kB: the memory is checked
/// before decoding.
#[cfg(target_os = "linux")]
#[test]
fn a_pattern_must_fit_into_the_memory_that_is_allowed() {
    let desk = desk();
    desk.write("pattern.png", png(16_000, &[], &zeros(256)));
    let arguments = format!("{STRICT} --max-memory 500M");
    let outcome = within_memory(&desk, 1 << 30, &arguments);
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    for part in ["pattern.png", "16000 × 16000", "--max-memory"] {
        assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    }
}

/// Some decoders read the whole file before they report an error.
#[cfg(target_os = "linux")]
#[test]
fn a_huge_image_file_is_not_read() {
    let desk = desk();
    for (name, start) in [
        ("pattern.jpg", &b"\xff\xd8\xff\xe0"[..]),
        ("pattern.webp", b"RIFF\xff\xff\xff\xffWEBPVP8 "),
        ("pattern.tga", b""),
        ("pattern.png", b"\x89PNG\r\n\x1a\n"),
    ] {
        let path = desk.write(name, start);
        let file = fs::File::options().write(true).open(path).unwrap();
        file.set_len(100 << 30).unwrap();
        desk.write("scene.toml", object("mesh.obj", name));
        for arguments in [STRICT, &format!("bake {name} -o map.png")] {
            let outcome = within_memory(&desk, 1 << 30, arguments);
            assert_eq!(outcome.code, Some(1), "{name}: {}", outcome.stderr);
            for part in [name, "107374182400 bytes", "--max-pixels"] {
                assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
            }
        }
    }
}

// ---------------------------------------------------------------- meshes

#[test]
fn faces_that_name_what_is_not_there() {
    let desk = desk();
    for (face, parts) in [
        ("f 1 2 4294967297", "line 7 | vertex 4294967297 | has 3"),
        ("f 1 2 4294967299", "line 7 | vertex 4294967299 | has 3"),
        (
            "f 1/1 2/2 3/4294967298",
            "line 7 | texture coordinate 4294967298",
        ),
        ("f 1 2 -4", "line 7 | vertex -4 | only 3"),
        ("f 1 2 -4294967295", "line 7 | vertex -4294967295"),
        (
            "f 1 2 -9223372036854775808",
            "line 7 | vertex -9223372036854775808",
        ),
        ("f -1/-1 -2/-2 -3/-9", "line 7 | texture coordinate -9"),
        ("f 1 2 -0", "line 7 | vertex 0"),
    ] {
        desk.write("mesh.obj", format!("{TRIANGLE}{face}\n"));
        desk.fails_strictly(STRICT, &format!("mesh.obj | {parts}"));
    }
    // Negative indices are fine if they exist.
    desk.write("mesh.obj", format!("{TRIANGLE}f -3/-3 -2/-2 -1/-1\n"));
    desk.run_strictly(STRICT).done();
}

// ---------------------------------------------------------------- paths

#[test]
fn a_scene_reads_no_files_elsewhere_unless_it_may() {
    let desk = desk();
    fs::create_dir_all(desk.path("inner/scenes")).unwrap();
    fs::create_dir_all(desk.path("inner/meshes")).unwrap();
    fs::copy(desk.path("mesh.obj"), desk.path("inner/mesh.obj")).unwrap();
    fs::copy(desk.path("mesh.obj"), desk.path("inner/meshes/mesh.obj")).unwrap();
    fs::copy(desk.path("pattern.png"), desk.path("inner/pattern.png")).unwrap();
    let absolute = desk.path("pattern.png").display().to_string();
    for (mesh, shape, key, named) in [
        (
            "../mesh.obj",
            "pattern.png",
            "line 2 | object 1: mesh",
            "mesh.obj",
        ),
        (
            "mesh.obj",
            "../pattern.png",
            "line 3 | object 1: shape",
            "pattern.png",
        ),
        (
            "mesh.obj",
            &absolute,
            "line 3 | object 1: shape",
            "pattern.png",
        ),
        // Its existence is not revealed either.
        (
            "../none.obj",
            "pattern.png",
            "line 2 | object 1: mesh",
            "none.obj",
        ),
        (
            "meshes/../../mesh.obj",
            "pattern.png",
            "line 2 | object 1: mesh",
            "mesh.obj",
        ),
        (
            "/dev/zero",
            "pattern.png",
            "line 2 | object 1: mesh",
            "/dev/zero",
        ),
    ] {
        desk.write("inner/scene.toml", object(mesh, shape));
        for command in LOADING {
            desk.fails_strictly(
                &format!("{command} inner/scene.toml"),
                &format!("inner/scene.toml | {key} | {named} | outside of | --allow-outside"),
            );
        }
        desk.fails_strictly("tradeoff inner/scene.toml -o out", "--allow-outside");
    }
    desk.write("inner/scene.toml", object("../mesh.obj", &absolute));
    desk.run_strictly("render inner/scene.toml --backend cpu --size 16x12 --allow-outside")
        .done();
    // Meshes and patterns may lie beside a folder called scenes.
    desk.write(
        "inner/scenes/s.toml",
        object("../meshes/mesh.obj", "../pattern.png"),
    );
    desk.run_strictly("render inner/scenes/s.toml --backend cpu --size 16x12")
        .done();
    desk.write(
        "inner/scenes/t.toml",
        object("../../mesh.obj", "../pattern.png"),
    );
    desk.fails_strictly(
        "render inner/scenes/t.toml",
        "line 2 | object 1: mesh | --allow-outside",
    );
}

#[test]
fn the_buffers_of_a_mesh_and_fonts_lie_in_the_folder_as_well() {
    let desk = desk();
    fs::create_dir(desk.path("inner")).unwrap();
    fs::copy(desk.path("pattern.png"), desk.path("inner/pattern.png")).unwrap();
    fs::copy(desk.path("mesh.obj"), desk.path("inner/mesh.obj")).unwrap();
    desk.write("secret.bin", [0; 60]);
    let gltf = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"../secret.bin"}]}"#;
    desk.write("inner/mesh.gltf", gltf);
    desk.write("inner/scene.toml", object("mesh.gltf", "pattern.png"));
    desk.fails_strictly(
        "render inner/scene.toml",
        "mesh.gltf | secret.bin | outside of | --allow-outside",
    );
    // Now it may be read, and holds no triangle.
    desk.fails_strictly("render inner/scene.toml --allow-outside", "mesh.gltf");
    desk.write(
        "inner/scene.toml",
        "[[object]]\nmesh = 'mesh.obj'\nshape = { text = 'A', font = '../secret.bin' }\n",
    );
    desk.fails_strictly(
        "render inner/scene.toml",
        "line 3 | object 1: shape.font | secret.bin | --allow-outside",
    );
    desk.fails_strictly("render inner/scene.toml --allow-outside", "not a font");
}

#[test]
fn small_files_do_not_claim_large_meshes_and_patterns() {
    let desk = desk();
    let gltf = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"componentType":5126,"type":"VEC3","count":3000000000}],"bufferViews":[],"buffers":[]}"#;
    desk.write("mesh.gltf", gltf);
    desk.write("scene.toml", object("mesh.gltf", "pattern.png"));
    desk.fails_strictly(STRICT, "mesh.gltf | --max-triangles");
    desk.write(
        "pattern.svg",
        "<svg xmlns='http://www.w3.org/2000/svg' width='1e9' height='1e9'/>",
    );
    let text = object("mesh.obj", "pattern.svg") + "raster = 32768\n";
    desk.write("scene.toml", text);
    desk.fails_strictly(STRICT, "pattern.svg | 32768 × 32768 | --max-pixels");
}

#[cfg(unix)]
#[test]
fn links_lead_nowhere_else() {
    let desk = desk();
    fs::create_dir(desk.path("inner")).unwrap();
    fs::copy(desk.path("pattern.png"), desk.path("inner/pattern.png")).unwrap();
    std::os::unix::fs::symlink("../mesh.obj", desk.path("inner/mesh.obj")).unwrap();
    desk.write("inner/scene.toml", object("mesh.obj", "pattern.png"));
    desk.fails_strictly(
        "render inner/scene.toml",
        "object 1: mesh | outside of | --allow-outside",
    );
    // The scene itself is named by the user.
    std::os::unix::fs::symlink("inner", desk.path("link")).unwrap();
    fs::remove_file(desk.path("inner/mesh.obj")).unwrap();
    fs::copy(desk.path("mesh.obj"), desk.path("inner/mesh.obj")).unwrap();
    desk.run_strictly("render link/scene.toml --backend cpu --size 16x12")
        .done();
}

/// The README's first command, and every other scene beside it.
#[test]
fn the_scenes_of_the_assets_need_no_flag() {
    let desk = Desk::new();
    let arguments = ["render", "--backend", "cpu", "--size", "16x12"];
    let torus = asset("scenes/torus.toml");
    Outcome::of(desk.command().args(arguments).arg(torus)).done();
    assert!(desk.path("torus.png").exists());
    // Which reads as many files.
    for scene in relievo_tests::scenes() {
        Outcome::of(desk.command().arg("info").arg(scene)).done();
    }
    let scene = asset("../docs/gallery/scenes/figure-06-basic-fast.toml");
    let outcome = Outcome::of(desk.command().arg("info").arg(&scene));
    assert_eq!(outcome.code, Some(1));
    assert!(
        outcome.stderr.contains("--allow-outside"),
        "{}",
        outcome.stderr
    );
    Outcome::of(desk.command().args(["info", "--allow-outside"]).arg(&scene)).done();
}

/// A scene cannot choose the output: one picture is written, where the user
/// said.
#[test]
fn a_scene_cannot_name_what_is_written() {
    let desk = desk();
    let before = desk.listing();
    for key in ["output", "aov", "file", "path", "out"] {
        for table in ["[image]\n", "[camera]\n", "[light]\n", "", "[[object]]\n"] {
            desk.write("scene.toml", format!("{table}{key} = 'written'\n"));
            desk.fails_strictly(STRICT, &format!("scene.toml | {key}"));
        }
    }
    let named = format!(
        "{}name = '../../written'\n",
        object("mesh.obj", "pattern.png")
    );
    desk.write("scene.toml", named);
    desk.run_strictly(&format!("{STRICT} -o p.png --aov p.exr"))
        .done();
    let mut after = desk.listing();
    assert!(after.remove(&desk.path("p.png")) && after.remove(&desk.path("p.exr")));
    assert_eq!(after, before);
}

// ---------------------------------------------------------------- pipes and devices

/// Creates a pipe without reader or writer.
#[cfg(unix)]
fn pipe(path: &Path) {
    let made = std::process::Command::new("mkfifo").arg(path).status();
    assert!(made.unwrap().success());
}

#[cfg(unix)]
#[test]
fn pipes_are_not_waited_for() {
    let desk = desk();
    pipe(&desk.path("pipe"));
    let pipe_is = |desk: &Desk| {
        use std::os::unix::fs::FileTypeExt;
        fs::metadata(desk.path("pipe"))
            .unwrap()
            .file_type()
            .is_fifo()
    };
    for command in LOADING {
        desk.fails_strictly(&format!("{command} pipe"), "pipe | name a TOML file");
    }
    desk.fails_strictly("tradeoff pipe -o out", "pipe | name a TOML file");
    for (mesh, shape) in [("pipe", "pattern.png"), ("mesh.obj", "pipe")] {
        desk.write("scene.toml", object(mesh, shape));
        for command in [
            STRICT,
            "info scene.toml",
            "tradeoff scene.toml --quick -o out",
        ] {
            desk.fails_strictly(command, "pipe | a pipe or a device | regular file");
        }
    }
    desk.fails_strictly("bake pipe -o map.png", "pipe | regular file");
    // Nor replaced.
    desk.write("scene.toml", object("mesh.obj", "pattern.png"));
    desk.fails_strictly(
        &format!("{STRICT} -o pipe"),
        "cannot write pipe | regular file",
    );
    let outcome = desk.run_strictly(&format!("{STRICT} -o p.png --aov pipe"));
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("cannot write pipe"),
        "{}",
        outcome.stderr
    );
    fs::rename(desk.path("pipe"), desk.path("pipe.png")).unwrap();
    desk.fails_strictly(
        "bake pattern.png -o pipe.png",
        "cannot write pipe.png | regular file",
    );
    fs::rename(desk.path("pipe.png"), desk.path("pipe")).unwrap();
    assert!(pipe_is(&desk));
    fs::create_dir(desk.path("out")).unwrap();
    pipe(&desk.path("out/measurements-1-of-1.jsonl"));
    desk.fails_strictly(
        "tradeoff scene.toml --quick --backend cpu -o out",
        "cannot write out/measurements-1-of-1.jsonl | pipe",
    );
}

/// An administrator could replace these.
#[cfg(target_os = "linux")]
#[test]
fn devices_are_neither_read_nor_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let desk = desk();
    for device in ["/dev/full", "/dev/null"] {
        desk.fails_strictly(
            &format!("{STRICT} -o {device}"),
            &format!("cannot write {device} | device | regular file"),
        );
        let kind = fs::metadata(device).unwrap().file_type();
        assert!(kind.is_char_device(), "{device} was replaced");
    }
    for (mesh, shape) in [("/dev/zero", "pattern.png"), ("mesh.obj", "/dev/zero")] {
        desk.write("scene.toml", object(mesh, shape));
        desk.fails(RENDER, 1, "/dev/zero | regular file");
    }
}

// ---------------------------------------------------------------- what gives way

/// An incompressible pattern.
#[cfg(unix)]
fn noise(desk: &Desk, side: u32) {
    desk.image("noise.png", side, side, |x, y| {
        let mixed = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
        mixed.wrapping_mul(0xc2b2_ae35).to_be_bytes()[0]
    });
}

/// Runs the program with a file size limit of 1 kB.
#[cfg(unix)]
fn in_small_files(desk: &Desk, arguments: &str) -> Outcome {
    let mut command = assert_cmd::Command::new("bash");
    command
        .args(["-c", "ulimit -f 1; exec \"$0\" \"$@\""])
        .arg(program())
        .args(arguments.split_whitespace())
        .current_dir(desk.0.path());
    Outcome::of(&mut command)
}

#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_is_not_left_half() {
    let desk = desk();
    desk.write("p.png", "old");
    noise(&desk, 64);
    // The picture contains the scene's text.
    let text = object("mesh.obj", "pattern.png");
    desk.write("scene.toml", format!("{text}# {}\n", "-".repeat(2000)));
    let before = desk.listing();
    for arguments in [
        format!("{STRICT} -o p.png").as_str(),
        "bake noise.png -o map.png",
        "bake noise.png --format r32f -o map.exr",
    ] {
        let outcome = in_small_files(&desk, arguments);
        assert_eq!(outcome.code, Some(3), "{arguments}\n{}", outcome.stderr);
        assert!(
            outcome.stderr.contains("cannot write"),
            "{}",
            outcome.stderr
        );
        assert_eq!(desk.listing(), before, "{}", outcome.stderr);
        assert_eq!(fs::read(desk.path("p.png")).unwrap(), b"old");
    }
}

/// On a file system of 16 kB, if one can be created.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_the_machines_fault() {
    let desk = desk();
    fs::create_dir(desk.path("small")).unwrap();
    noise(&desk, 200);
    // In its own namespace, which ends with the shell.
    let script = "mount -t tmpfs -o size=16k none small || exit 77; echo old > small/map.exr; \
                  \"$0\" bake noise.png --format r32f -o small/map.exr; \
                  code=$?; ls -A small >&2; head -c 4 small/map.exr >&2; exit $code";
    let mut command = assert_cmd::Command::new("unshare");
    command
        .args(["--mount", "--map-root-user", "bash", "-c", script])
        .arg(program())
        .current_dir(desk.0.path());
    let outcome = Outcome::of(&mut command);
    if outcome.code == Some(77) || outcome.stderr.contains("unshare") {
        eprintln!(
            "skipped: no file system can be mounted here: {}",
            outcome.stderr
        );
        return;
    }
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("cannot write small/map.exr"),
        "{}",
        outcome.stderr
    );
    assert!(
        outcome.stderr.ends_with("map.exr\nold\n"),
        "{}",
        outcome.stderr
    );
    assert!(!outcome.stderr.contains(".part"), "{}", outcome.stderr);
}

/// Starts the program, waits until `is_time`, and interrupts it.
#[cfg(unix)]
fn interrupted(
    desk: &Desk,
    arguments: &str,
    signal: &str,
    is_time: &dyn Fn() -> bool,
) -> Option<i32> {
    use std::os::unix::process::ExitStatusExt;
    use std::time::{Duration, Instant};
    let mut child = std::process::Command::new(program())
        .args(arguments.split_whitespace())
        .current_dir(desk.0.path())
        .stdout(fs::File::create(desk.path("stdout")).unwrap())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !is_time() {
        assert!(start.elapsed() < Duration::from_secs(200), "it never began");
        let ended = child.try_wait().unwrap();
        assert!(ended.is_none(), "it was done too soon: {ended:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
    let sent = std::process::Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    child.wait().unwrap().signal()
}

#[cfg(unix)]
#[test]
fn ctrl_c_in_the_middle_of_a_picture_leaves_nothing() {
    let desk = desk();
    desk.write("stdout", "");
    desk.write("p.png", "old");
    let before = desk.listing();
    for (signal, number) in [("-INT", 2), ("-TERM", 15)] {
        let is_drawing = || {
            let said = fs::read_to_string(desk.path("stdout")).unwrap();
            said.contains("as requested")
        };
        // Slow enough to be interrupted: 100 million samples.
        let render = "render scene.toml --backend cpu --size 10000x10000 -o p.png";
        let ended = interrupted(&desk, render, signal, &is_drawing);
        assert_eq!(ended, Some(number));
        assert_eq!(desk.listing(), before);
        assert_eq!(fs::read(desk.path("p.png")).unwrap(), b"old");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_in_the_middle_of_writing_leaves_nothing() {
    let desk = desk();
    desk.write("stdout", "");
    desk.write("map.exr", "old");
    noise(&desk, 3000);
    let before = desk.listing();
    let is_writing = || {
        desk.listing()
            .iter()
            .any(|path| path.to_string_lossy().ends_with(".part"))
    };
    let bake = "bake noise.png --format r32f -o map.exr";
    let ended = interrupted(&desk, bake, "-INT", &is_writing);
    assert_eq!(ended, Some(2));
    assert_eq!(desk.listing(), before);
    assert_eq!(fs::read(desk.path("map.exr")).unwrap(), b"old");
}
