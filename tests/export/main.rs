//! Output of `relievo export`: read back, checked by the tools of each
//! language, and drawn by other programs.

mod bindings;
mod cases;
mod hit;
mod hull;
#[allow(dead_code, reason = "its other users need the rest")]
mod opengl;
mod orthographic;
mod tools;
mod webgpu;

use crate::desk::{Desk, Outcome};
use cases::{file, prepared};
use gltf::Semantic;
use relievo::export::{Options, Target, export};
use relievo::prepare::PreparedScene;
use relievo::scene::Tier;
use relievo::shape_map::{DEFAULT_MAX_PIXELS, ShapeMap, Storage};
use relievo_shared::layout::{
    Frame, Object, PlanarTriangle, PrismData, Triangle, depth_reductions,
};
use relievo_tests::{asset, library_example, plain_wgpu, root};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Every file of a scene with one object, in WGSL only.
fn in_wgsl(scene: &PreparedScene) -> Vec<relievo::export::ExportedFile> {
    let options = Options {
        targets: vec![Target::Wgsl],
        ..Options::default()
    };
    export(scene, &options).unwrap()
}

/// The attributes of the mesh, by name, flat.
fn attributes(glb: &[u8]) -> BTreeMap<String, Vec<f32>> {
    // Read with all checks of the gltf crate.
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(glb).unwrap();
    let blob = blob.unwrap();
    let mesh = document.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    assert_eq!(primitive.mode(), gltf::mesh::Mode::Triangles);
    assert!(primitive.indices().is_none());
    let attribute = |(semantic, accessor): (Semantic, gltf::Accessor<'_>)| {
        assert_eq!(accessor.data_type(), gltf::accessor::DataType::F32);
        let view = accessor.view().unwrap();
        let (stride, start) = (view.stride().unwrap(), view.offset() + accessor.offset());
        let size = accessor.size();
        let values = (0..accessor.count())
            .flat_map(|index| {
                let at = start + index * stride;
                bytemuck::pod_collect_to_vec::<u8, f32>(&blob[at..at + size])
            })
            .collect();
        (semantic.to_string(), values)
    };
    primitive.attributes().map(attribute).collect()
}

#[test]
fn the_mesh_is_read_back_with_all_its_attributes() {
    for file_name in ["torus.toml", "torus_planar.toml", "torus_accurate.toml"] {
        let scene = prepared(file_name, |_| ());
        let object = &scene.objects[0];
        let files = in_wgsl(&scene);
        let found = attributes(file(&files, "mesh.glb"));
        let corners = || {
            object
                .triangles
                .iter()
                .flat_map(|triangle| triangle.corners.map(|corner| (corner, triangle.handedness)))
        };
        let tangents = corners().flat_map(|(corner, w)| {
            let [x, y, z] = corner.tangent;
            [x, y, z, w]
        });
        let wanted: [(&str, Vec<f32>); 8] = [
            ("POSITION", corners().flat_map(|c| c.0.position).collect()),
            ("NORMAL", corners().flat_map(|c| c.0.normal).collect()),
            ("TANGENT", tangents.collect()),
            ("TEXCOORD_0", corners().flat_map(|c| c.0.uv).collect()),
            ("_QUADRIC", corners().flat_map(|c| c.0.quadric).collect()),
            (
                "_GRADIENT_U",
                corners().flat_map(|c| c.0.gradient_u).collect(),
            ),
            (
                "_GRADIENT_V",
                corners().flat_map(|c| c.0.gradient_v).collect(),
            ),
            (
                "_DEPTH_REDUCTION",
                object
                    .triangles
                    .iter()
                    .flat_map(|triangle| depth_reductions(triangle.depth_reductions))
                    .collect(),
            ),
        ];
        assert_eq!(found.len(), wanted.len());
        for (name, values) in wanted {
            assert!(!values.is_empty() && found[name] == values, "{name}");
        }
    }
}

#[test]
fn the_shape_map_is_read_back_in_every_form() {
    for (storage, name) in [
        (Storage::R8, "shape_map.png"),
        (Storage::R16, "shape_map.png"),
        (Storage::R32F, "shape_map.exr"),
        (Storage::Rgba8, "shape_map.png"),
    ] {
        let scene = prepared("torus.toml", |object| object.map.storage = storage);
        let files = in_wgsl(&scene);
        let bytes = file(&files, name);
        let map = ShapeMap::from_bytes(bytes, Path::new(name), DEFAULT_MAX_PIXELS).unwrap();
        assert!(map == *scene.objects[0].map, "{storage}");
        let words: &[u8] = bytemuck::cast_slice(map.words());
        assert!(words == file(&files, "map.bin"), "{storage}");
    }
}

/// `layout.json` describes the bytes and names every file.
#[test]
fn the_layout_describes_the_files() {
    type Change = fn(&mut relievo::scene::SceneObject);
    let kinds: [(&str, Change, &str, usize); 3] = [
        ("torus.toml", |_| (), "Triangle", size_of::<Triangle>()),
        (
            "torus_planar.toml",
            |_| (),
            "PlanarTriangle",
            size_of::<PlanarTriangle>(),
        ),
        (
            "torus.toml",
            |object| object.tier = Tier::Accurate,
            "PrismData",
            size_of::<PrismData>(),
        ),
    ];
    for (scene_file, change, facet, facet_bytes) in kinds {
        let scene = prepared(scene_file, change);
        let object = &scene.objects[0];
        let files = export(&scene, &Options::default()).unwrap();
        let text = std::str::from_utf8(file(&files, "layout.json")).unwrap();
        let layout: Value = serde_json::from_str(text).unwrap();
        assert_eq!(layout["format"], 1);
        let entries = layout["bind_groups"][0]["entries"].as_array().unwrap();
        let sizes = [size_of::<Frame>(), size_of::<Object>(), facet_bytes, 4];
        let names = ["Frame", "Object", facet, "u32"];
        for (index, entry) in entries.iter().enumerate() {
            assert_eq!(entry["binding"], index);
            assert_eq!(entry["element"], names[index]);
            assert_eq!(entry["element_bytes"], sizes[index]);
            let bytes = file(&files, entry["file"].as_str().unwrap()).len();
            assert!(bytes.is_multiple_of(sizes[index]) && bytes > 0);
            if entry["is_array"] == false {
                assert_eq!(bytes, sizes[index]);
            }
        }
        assert_eq!(file(&files, "frame.bin"), bytemuck::bytes_of(&scene.frame));
        assert_eq!(
            file(&files, "object.bin"),
            bytemuck::bytes_of(&object.parameters)
        );
        let facets = file(&files, "facets.bin").len() / facet_bytes;
        assert_eq!(facets, object.triangles.len());
        let vertices = 3 * facets as u32;
        assert_eq!(layout["draw"]["vertices"], vertices);
        let draw: [u32; 4] = bytemuck::pod_read_unaligned(file(&files, "draw.bin"));
        assert_eq!(draw, [vertices, 1, 0, 0]);

        let shaders = layout["shaders"].as_array().unwrap();
        assert_eq!(shaders.len(), 2 * Target::ALL.len());
        for shader in shaders {
            let bytes = file(&files, shader["file"].as_str().unwrap());
            let name = shader["entry_point"].as_str().unwrap();
            let text = String::from_utf8_lossy(bytes);
            assert!(text.contains(name), "{shader}");
        }
        // Every file is listed.
        let readme = std::str::from_utf8(file(&files, "README.md")).unwrap();
        for file in files.iter().filter(|file| file.name != "README.md") {
            assert!(
                readme.contains(&format!("`{}`", file.name)),
                "{}",
                file.name
            );
        }
        // The Rust file has the structs of the JSON, and parses.
        let rust = std::str::from_utf8(file(&files, "bindings.rs")).unwrap();
        let rust = syn::parse_file(rust).unwrap();
        let in_rust: BTreeMap<String, usize> = rust
            .items
            .iter()
            .filter_map(|item| match item {
                syn::Item::Struct(item) => Some((item.ident.to_string(), item.fields.len())),
                _ => None,
            })
            .collect();
        let in_json = layout["structs"]
            .as_array()
            .unwrap()
            .iter()
            .map(|described| {
                let fields = described["fields"].as_array().unwrap().len();
                (described["name"].as_str().unwrap().to_string(), fields)
            });
        assert_eq!(in_rust, in_json.collect());
    }
}

/// A PNG's RGB, from its RGB or RGBA.
fn rgb(path: &Path) -> image::RgbImage {
    image::open(path).unwrap().to_rgb8()
}

#[test]
fn gpu_a_plain_wgpu_program_draws_the_export() {
    let example = root().join("host/examples/plain-wgpu");
    let source = fs::read_to_string(example.join("src/main.rs")).unwrap();
    let lines = source.lines().count();
    assert!(lines <= 200, "{lines} lines");
    let manifest = fs::read_to_string(example.join("Cargo.toml")).unwrap();
    assert!(!manifest.contains("relievo"), "it needs nothing of ours");

    let desk = Desk::new();
    let program = plain_wgpu();
    let scenes = ["torus.toml", "torus_planar.toml", "torus_accurate.toml"];
    for scene in scenes {
        let text = fs::read_to_string(asset("scenes").join(scene)).unwrap();
        let text = text
            .replace("../", &format!("{}/", asset("").display()))
            .replace("[image]", "[image]\nbackground = \"#ffffff\"")
            .replace("supersample = true", "supersample = false");
        desk.write("scene.toml", text);
        desk.run("export scene.toml -o out --target wgsl --size 160x120")
            .done();
        let bindings = fs::read_to_string(desk.path("out/bindings.rs")).unwrap();
        if scene == "torus.toml" {
            let built_in = fs::read_to_string(example.join("src/bindings.rs")).unwrap();
            assert!(
                bindings == built_in,
                "export torus.toml, and copy its bindings.rs there"
            );
        }
        let mut run = assert_cmd::Command::new(&program);
        Outcome::of(run.current_dir(desk.0.path()).args(["out", "plain.png"])).done();
        desk.run("render scene.toml -o ours.png --backend cpu --size 160x120")
            .done();
        let [plain, ours] = ["plain.png", "ours.png"].map(|name| rgb(&desk.path(name)));
        assert_eq!(plain.dimensions(), (160, 120));
        assert_eq!(ours.dimensions(), (160, 120));
        let channels = || plain.as_raw().iter().zip(ours.as_raw());
        let differ = channels().filter(|(a, b)| a != b).count();
        let largest = channels().map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        eprintln!("{scene}: {differ} of 57600 bytes differ, by at most {largest}");
        // Bytes are rounded by the device here, and by us there.
        assert!(
            largest <= 1,
            "{scene}: {differ} differ, by at most {largest}"
        );
    }
}

#[test]
fn gpu_the_library_example_draws_with_both_renderers() {
    let desk = Desk::new();
    let program = library_example();
    let scene = asset("scenes/torus.toml");
    for (output, cpu) in [("any.png", None), ("cpu.png", Some("cpu"))] {
        let mut run = assert_cmd::Command::new(&program);
        let run = run.current_dir(desk.0.path()).arg(&scene).arg(output);
        let said = Outcome::of(run.args(cpu)).done().stdout;
        assert!(
            said.contains(output) && said.contains("CPU") == cpu.is_some(),
            "{said}"
        );
        assert_eq!(rgb(&desk.path(output)).dimensions(), (320, 240));
    }
    let [any, cpu] = ["any.png", "cpu.png"].map(|name| rgb(&desk.path(name)));
    let colors: BTreeSet<[u8; 3]> = any.pixels().map(|pixel| pixel.0).collect();
    assert!(colors.len() > 500, "there is something to see");
    let differ = any.as_raw().iter().zip(cpu.as_raw());
    assert!(differ.map(|(a, b)| a.abs_diff(*b)).max().unwrap() <= 1);
}

/// A desk with a scene of two objects, one with a name that is not a valid file
/// name.
fn desk() -> Desk {
    let desk = Desk::new();
    fs::copy(asset("meshes/torus.obj"), desk.path("ring.obj")).unwrap();
    desk.image("dots.png", 16, 16, |x, y| {
        if (x / 4 + y / 4) % 2 == 0 { 0 } else { 255 }
    });
    let object = |name: &str, x: i32| {
        format!(
            "[[object]]\nname = '{name}'\nmesh = 'ring.obj'\nshape = 'dots.png'\nrepeat = [8, 4]\ntranslate = [{x}, 0, 0]\n"
        )
    };
    desk.write("two.toml", object("one", 0) + &object("../ü|x/", 3));
    desk.write("one.toml", object("one", 0));
    desk
}

/// The files of a folder and below, with `/` between the parts.
fn files_of(desk: &Desk, folder: &str) -> BTreeSet<String> {
    let start = desk.path(folder);
    let files = desk.listing().into_iter().filter(|path| path.is_file());
    files
        .filter_map(|path| {
            let parts = path.strip_prefix(&start).ok()?.iter();
            let parts: Vec<_> = parts.map(|part| part.to_string_lossy()).collect();
            Some(parts.join("/"))
        })
        .collect()
}

#[test]
fn objects_get_folders_of_their_own() {
    let desk = desk();
    let said = desk.run("export one.toml -o a/new/folder").done().stdout;
    assert!(said.contains("20 files"), "{said}");
    let all = files_of(&desk, "a/new/folder");
    for name in [
        "vertex.spv",
        "fragment.metal",
        "layout.json",
        "mesh.glb",
        "shape_map.png",
    ] {
        assert!(all.contains(name), "{name}");
    }
    desk.run("export two.toml -o both --target wgsl,glsl")
        .done();
    let both = files_of(&desk, "both");
    assert_eq!(both.len(), 1 + 2 * 14, "{both:?}");
    for name in ["README.md", "1-one/fragment.frag", "2-x/vertex.wgsl"] {
        assert!(both.contains(name), "{name}: {both:?}");
    }
    desk.run("export two.toml -o second --object ../ü|x/ --target hlsl")
        .done();
    let second = files_of(&desk, "second");
    assert!(
        second.contains("vertex.hlsl") && second.len() == 12,
        "{second:?}"
    );
    // Existing files remain unless they are overwritten.
    desk.write("second/notes.txt", "mine");
    desk.write("second/frame.bin", "old");
    desk.run("export two.toml -o second --object one --target spirv --write words")
        .done();
    let again = files_of(&desk, "second");
    assert_eq!(again.len(), 12 + 3, "{again:?}");
    assert_eq!(
        fs::read(desk.path("second/frame.bin")).unwrap().len(),
        size_of::<Frame>()
    );
    assert_eq!(fs::read(desk.path("second/notes.txt")).unwrap(), b"mine");
}

/// With `--write words` the SPIR-V is that of the renderer, where that asks for no exits.
#[test]
fn words_in_spirv_are_our_own_shaders() {
    let desk = desk();
    let one = fs::read_to_string(desk.path("one.toml")).unwrap();
    desk.write("planar.toml", one + "tier = 'planar'\n");
    desk.run("export planar.toml -o out --target spirv --write words")
        .done();
    let module = relievo::render::gpu::Shaders::Fast.module().unwrap();
    let layout = fs::read_to_string(desk.path("out/layout.json")).unwrap();
    let layout: Value = serde_json::from_str(&layout).unwrap();
    for stage in ["vertex", "fragment"] {
        let ours = layout[format!("{stage}_shader")].as_str().unwrap();
        let bytes = fs::read(desk.path(&format!("out/{stage}.spv"))).unwrap();
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
        assert!(module.spirv(ours).unwrap() == words, "{ours}");
    }
}

#[test]
fn what_cannot_be_exported_is_refused_and_nothing_is_written() {
    let desk = desk();
    desk.write("file", "mine");
    fs::create_dir_all(desk.path("taken/mesh.glb")).unwrap();
    for (arguments, code, parts) in [
        (
            "export two.toml -o out --object none",
            1,
            "none|\"one\"|--object",
        ),
        ("export one.toml -o file", 1, "file|no folder|another name"),
        (
            "export one.toml -o taken",
            1,
            "mesh.glb|is a folder|another folder",
        ),
        (
            "export one.toml -o out --target wgsl,pascal",
            2,
            "pascal|wgsl",
        ),
        ("export one.toml -o out --write sums", 2, "sums|words"),
        ("export one.toml", 2, "--output"),
        ("export none.toml -o out", 1, "none.toml"),
        (
            "export one.toml -o out --max-triangles 3",
            1,
            "--max-triangles",
        ),
    ] {
        desk.fails(arguments, code, parts);
    }
    // Inputs are not overwritten either.
    fs::create_dir(desk.path("scenes")).unwrap();
    let text = fs::read_to_string(desk.path("one.toml")).unwrap();
    fs::copy(desk.path("dots.png"), desk.path("scenes/shape_map.png")).unwrap();
    let text = text
        .replace("dots.png", "shape_map.png")
        .replace("ring.obj", "../ring.obj");
    desk.write("scenes/one.toml", text);
    desk.fails(
        "export scenes/one.toml -o scenes",
        1,
        "shape_map.png|reads|another folder",
    );
}

/// The smallest and the longest scenes are exported like any other.
#[test]
fn one_triangle_with_one_texel_or_a_hundred_thousand_is_exported() {
    let desk = Desk::new();
    desk.write(
        "mesh.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n",
    );
    for (width, height) in [(1, 1), (100_000, 1), (1, 100_000)] {
        desk.image("pattern.png", width, height, |x, y| {
            if (x + y) % 7 == 0 { 0 } else { 255 }
        });
        desk.write(
            "scene.toml",
            "[[object]]\nmesh = 'mesh.obj'\nshape = 'pattern.png'\ndepth = 0.1\n",
        );
        desk.run("export scene.toml -o out --size 1x1").done();
        let glb = fs::read(desk.path("out/mesh.glb")).unwrap();
        let all = attributes(&glb);
        assert_eq!(all["POSITION"].len(), 9);
        assert!(all.values().flatten().all(|value| value.is_finite()));
        let map = fs::read(desk.path("out/shape_map.png")).unwrap();
        let map = ShapeMap::from_bytes(&map, Path::new("shape_map.png"), DEFAULT_MAX_PIXELS);
        let map = map.unwrap();
        assert_eq!([map.width(), map.height()], [width, height]);
    }
}

/// A file that cannot be written is named, and nothing is left.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_behind() {
    let desk = desk();
    // Files are limited to a kilobyte.
    let limited = |arguments: &str| {
        let program = crate::program();
        let shell = format!(
            "ulimit -f 1; trap '' XFSZ; exec {} {arguments}",
            program.display()
        );
        let mut run = assert_cmd::Command::new("bash");
        Outcome::of(run.current_dir(desk.0.path()).args(["-c", &shell]))
    };
    let before = desk.listing();
    let outcome = limited("export one.toml -o out --target wgsl");
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("out/"), "{}", outcome.stderr);
    assert_eq!(desk.listing(), before, "{}", outcome.stderr);
}
