//! Generated glTF files: valid, unusual and malformed.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use crate::mesh::{Mesh, MeshOptions};
use crate::prepare::tests::words;
use crate::scene::Scene;
use crate::{Files, Limits};

const LIMIT: usize = 10_000;
const BYTES: u64 = 1 << 20;

pub(super) fn options(byte_limit: u64) -> MeshOptions {
    MeshOptions {
        triangle_limit: LIMIT,
        byte_limit,
        ..MeshOptions::default()
    }
}

/// Builds a JSON description and its buffer.
struct Builder {
    json: Value,
    bytes: Vec<u8>,
}

impl Builder {
    fn new() -> Builder {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"name": "Thing", "primitives": []}],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        });
        Builder {
            json,
            bytes: Vec::new(),
        }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        self.accessor(&bytes, 5126, &format!("VEC{N}"), values.len())
    }

    fn primitive(&mut self, value: Value) {
        let list = &mut self.json["meshes"][0]["primitives"];
        list.as_array_mut().unwrap().push(value);
    }

    fn buffer(&mut self, uri: Option<&str>) {
        let mut buffer = json!({"byteLength": self.bytes.len()});
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        self.json["buffers"] = json!([buffer]);
    }

    fn glb(mut self) -> Vec<u8> {
        self.buffer(None);
        glb(self.json.to_string().as_bytes(), &self.bytes)
    }

    fn text(mut self, uri: &str) -> Vec<u8> {
        self.buffer(Some(uri));
        self.json.to_string().into_bytes()
    }
}

pub(super) fn glb(json: &[u8], bytes: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((28 + json.len() as u32 + bytes.len() as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json);
    file.extend((bytes.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bytes);
    file
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let [a, b, c] = [0, 1, 2].map(|i| u32::from(three.get(i).copied().unwrap_or(0)));
        let bits = a << 16 | b << 8 | c;
        for i in 0..=three.len() {
            text.push(DIGITS[(bits >> (18 - 6 * i) & 63) as usize] as char);
        }
    }
    while !text.len().is_multiple_of(4) {
        text.push('=');
    }
    text
}

pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let (files, path) = (Files::memory([]), Path::new("a/b.glb"));
    // Of any file that is a mesh, or not.
    let _ = materials(&files, bytes, path, BYTES);
    parse(&files, bytes, path, &options(BYTES))
}

pub(super) fn message(bytes: &[u8]) -> String {
    read(bytes).expect_err("the file is wrong").to_string()
}

/// Returns the positions of the corners of all triangles.
fn corners(mesh: &RawMesh) -> Vec<[f64; 3]> {
    let corners = mesh.triangles.iter().flatten();
    corners
        .map(|corner| mesh.positions[corner.position as usize].to_array())
        .collect()
}

const SQUARE: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [1.0, 1.0, 0.0],
];

/// Returns a square of two triangles as a primitive of `mode` with `indices`.
fn square(mode: u32, indices: &[u8]) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&SQUARE);
    let indices = builder.accessor(indices, 5121, "SCALAR", indices.len());
    builder.primitive(
        json!({"attributes": {"POSITION": positions}, "indices": indices, "mode": mode}),
    );
    builder
}

fn plain() -> Builder {
    square(4, &[0, 1, 2, 2, 1, 3])
}

/// Returns the torus in single precision: positions, normals, texture coordinates
/// with v down, indices.
type Vertices = (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<u32>);

fn torus() -> Vertices {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/meshes/torus.obj");
    let text = std::fs::read_to_string(&path).unwrap();
    let mesh = crate::mesh::obj::parse(&text, &path, &options(BYTES)).unwrap();
    let mut known = HashMap::new();
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    let mut indices = Vec::new();
    for corner in mesh.triangles.iter().flatten() {
        let key = (corner.position, corner.normal, corner.uv);
        indices.push(*known.entry(key).or_insert_with(|| {
            let narrow = |v: DVec3| v.as_vec3().to_array();
            positions.push(narrow(mesh.positions[corner.position as usize]));
            normals.push(narrow(mesh.normals[corner.normal.unwrap() as usize]));
            let uv = mesh.uvs[corner.uv.unwrap() as usize];
            uvs.push([uv.x as f32, (1.0 - uv.y) as f32]);
            positions.len() as u32 - 1
        }));
    }
    (positions, normals, uvs, indices)
}

fn torus_as_obj((positions, normals, uvs, indices): &Vertices) -> String {
    let mut text = String::new();
    for [x, y, z] in positions {
        let [x, y, z] = [x, y, z].map(|&x| f64::from(x));
        text += &format!("v {x} {y} {z}\n");
    }
    for [x, y, z] in normals {
        let [x, y, z] = [x, y, z].map(|&x| f64::from(x));
        text += &format!("vn {x} {y} {z}\n");
    }
    for &[u, v] in uvs {
        text += &format!("vt {} {}\n", f64::from(u), 1.0 - f64::from(v));
    }
    for three in indices.chunks(3) {
        let corners = three.iter().map(|i| format!(" {0}/{0}/{0}", i + 1));
        text += &format!("f{}\n", corners.collect::<String>());
    }
    text
}

fn torus_as_gltf((positions, normals, uvs, indices): &Vertices) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(positions);
    let normals = builder.floats(normals);
    let uvs = builder.floats(uvs);
    let bytes: Vec<u8> = indices
        .iter()
        .flat_map(|&index| (index as u16).to_le_bytes())
        .collect();
    let indices = builder.accessor(&bytes, 5123, "SCALAR", indices.len());
    builder.primitive(json!({
        "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs},
        "indices": indices,
    }));
    builder
}

/// Renders `mesh` with letters, whose orientation is visible.
fn picture(mesh: &str, more: &[(&str, Vec<u8>)]) -> Vec<[u32; 4]> {
    let letters = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/patterns/letters.png");
    let mut files = vec![("letters.png", std::fs::read(letters).unwrap())];
    files.extend_from_slice(more);
    let files = files
        .into_iter()
        .map(|(name, bytes)| (PathBuf::from(name), Arc::from(bytes)));
    let text = format!(
        "[camera]\neye = [0.0, 1.5, 2.5]\nfov = 38.0\n[[object]]\nmesh = {mesh:?}\nshape = 'letters.png'\nrepeat = [12, 6]\ndepth = 0.08\n"
    );
    let files = Files::memory(files);
    let scene = Scene::parse_with(&text, Path::new("x.toml"), &Limits::default(), files);
    words(scene.unwrap())
}

#[test]
fn the_torus_written_both_ways_is_the_same_picture() {
    let torus = torus();
    let obj = torus_as_obj(&torus).into_bytes();
    let wanted = picture("torus.obj", &[("torus.obj", obj)]);
    assert!(wanted.iter().any(|word| word[3] == 1));
    let as_gltf = || torus_as_gltf(&torus);
    let bytes = as_gltf().bytes;
    let uri = format!("data:application/octet-stream;base64,{}", base64(&bytes));
    for (name, files) in [
        ("torus.glb", vec![("torus.glb", as_gltf().glb())]),
        // Detected from the content.
        ("torus.bin", vec![("torus.bin", as_gltf().glb())]),
        ("torus.gltf", vec![("torus.gltf", as_gltf().text(&uri))]),
        (
            "m/torus.gltf",
            vec![
                ("m/torus.gltf", as_gltf().text("a%20b.bin")),
                ("m/a b.bin", bytes),
            ],
        ),
    ] {
        assert!(picture(name, &files) == wanted, "{name}");
    }
}

#[test]
fn all_ways_to_make_triangles() {
    let wanted = corners(&read(&plain().glb()).unwrap());
    assert_eq!(wanted.len(), 6);
    // A strip reverses every second triangle.
    let strip = read(&square(5, &[0, 1, 2, 3]).glb()).unwrap();
    let [a, b, c, d] = SQUARE.map(|corner| corner.map(f64::from));
    assert_eq!(corners(&strip), [a, b, c, b, d, c]);
    let fan = read(&square(6, &[0, 1, 3, 2]).glb()).unwrap();
    assert_eq!(corners(&fan), [a, b, d, a, d, c]);
    // Points and lines are ignored.
    let mut builder = plain();
    builder.primitive(json!({"attributes": {"POSITION": 0}, "mode": 1}));
    assert_eq!(corners(&read(&builder.glb()).unwrap()), wanted);
    // Indices of every width, and none.
    for (component, width) in [(5121, 1), (5123, 2), (5125, 4)] {
        let bytes = [0_u32, 1, 2, 2, 1, 3].map(|index| index.to_le_bytes());
        let bytes: Vec<u8> = bytes
            .iter()
            .flat_map(|index| &index[..width])
            .copied()
            .collect();
        let mut builder = Builder::new();
        let positions = builder.floats(&SQUARE);
        let indices = builder.accessor(&bytes, component, "SCALAR", 6);
        builder.primitive(json!({"attributes": {"POSITION": positions}, "indices": indices}));
        assert_eq!(corners(&read(&builder.glb()).unwrap()), wanted);
    }
    let mut builder = Builder::new();
    let positions = builder.floats(&[0, 1, 2, 2, 1, 3].map(|i: usize| SQUARE[i]));
    builder.primitive(json!({"attributes": {"POSITION": positions}}));
    assert_eq!(corners(&read(&builder.glb()).unwrap()), wanted);
}

#[test]
fn nodes_place_and_mirror() {
    let mut builder = plain();
    let normals = builder.floats(&[[0.0, 0.6, 0.8]; 4]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals.into();
    builder.json["nodes"] = json!([
        {"children": [1, 2], "translation": [10.0, 0.0, 0.0], "scale": [2.0, 2.0, 2.0]},
        {"mesh": 0, "scale": [-1.0, 1.0, 1.0]},
        // A quarter turn about z.
        {"mesh": 0, "matrix": [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 5.0, 1.0]},
        // Not in the scene.
        {"mesh": 0},
    ]);
    let mesh = read(&builder.glb()).unwrap();
    let corners = corners(&mesh);
    assert_eq!(corners.len(), 12);
    // The winding of the mirrored triangle matches its normal.
    let (origin, x, y) = ([10.0, 0.0, 0.0], [8.0, 0.0, 0.0], [10.0, 2.0, 0.0]);
    assert_eq!(corners[..3], [origin, y, x]);
    assert_eq!(
        corners[6..9],
        [[10.0, 0.0, 10.0], [10.0, 2.0, 10.0], [8.0, 0.0, 10.0]]
    );
    let normal =
        |triangle: usize| mesh.normals[mesh.triangles[triangle][0].normal.unwrap() as usize];
    assert!(normal(0).distance(DVec3::new(0.0, 0.6, 0.8)) < 1e-7);
    assert!(normal(2).distance(DVec3::new(-0.6, 0.0, 0.8)) < 1e-7);
}

#[test]
fn numbers_of_every_form() {
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.2], [1.0, 1.0]];
    for (component, largest, width) in [(5121, 255.0, 1), (5123, 65_535.0, 2)] {
        let mut builder = plain();
        let numbers = uvs.iter().flatten();
        let numbers = numbers.map(|x| ((x * largest) as u32).to_le_bytes());
        let bytes: Vec<u8> = numbers.flat_map(|x| x[..width].to_vec()).collect();
        let accessor = builder.accessor(&bytes, component, "VEC2", 4);
        builder.json["accessors"][accessor]["normalized"] = true.into();
        builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = accessor.into();
        let mesh = read(&builder.glb()).unwrap();
        assert_eq!(mesh.face_without_uvs, None);
        for (corner, [u, v]) in mesh.triangles[0].iter().zip(uvs) {
            let uv = mesh.uvs[corner.uv.unwrap() as usize];
            assert_eq!(uv, DVec2::new(u, 1.0 - v));
        }
    }
    // A corner moved by a sparse accessor, with and without a base.
    for has_base in [true, false] {
        let mut builder = plain();
        let indices = builder.view(&[1, 3]);
        let values = builder.floats(&[[5.0, 0.0, 0.0], [5.0, 5.0, 0.0]]);
        let values = builder.json["accessors"][values]["bufferView"].clone();
        let accessor = &mut builder.json["accessors"][0];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": 5121},
            "values": {"bufferView": values},
        });
        if !has_base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        let corners = corners(&read(&builder.glb()).unwrap());
        let third = if has_base { [0.0, 1.0, 0.0] } else { [0.0; 3] };
        assert_eq!(corners[..3], [[0.0; 3], [5.0, 0.0, 0.0], third]);
        assert_eq!(corners[5], [5.0, 5.0, 0.0]);
    }
}

#[test]
fn texture_coordinates_are_asked_for() {
    let options = MeshOptions::default();
    let path = Path::new("square.glb");
    let load =
        |options: &MeshOptions| Mesh::from_bytes(&Files::memory([]), &plain().glb(), path, options);
    let error = load(&options).unwrap_err().to_string();
    for part in ["square.glb", "mesh 0 \"Thing\", primitive 0", "planar-z"] {
        assert!(error.contains(part), "{error}");
    }
    let options = MeshOptions {
        projection: Some(crate::mesh::Projection::PlanarZ),
        ..options
    };
    assert_eq!(load(&options).unwrap().triangles.len(), 2);
}

#[test]
fn mistakes_are_told() {
    type Change<'a> = (&'a str, &'a dyn Fn(&mut Builder));
    let cases: [Change<'_>; 19] = [
        ("\"ABC_new\"", &|b| {
            b.json["extensionsRequired"] = json!(["ABC_new"])
        }),
        ("accessor", &|b| b.json["accessors"] = json!([])),
        ("position 9", &|b| b.bytes[48 + 5] = 9),
        ("position 0 is [NaN", &|b| {
            b.bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes())
        }),
        ("at most 1e12", &|b| {
            b.bytes[..4].copy_from_slice(&1e13_f32.to_le_bytes())
        }),
        ("buffer view 0", &|b| {
            b.json["bufferViews"][0]["byteLength"] = 1000.into()
        }),
        ("buffer view 0", &|b| {
            b.json["bufferViews"][0]["byteOffset"] = u64::MAX.into()
        }),
        ("12 bytes do not fit", &|b| {
            b.json["bufferViews"][0]["byteStride"] = 8.into()
        }),
        ("do not fit", &|b| {
            b.json["accessors"][0]["byteOffset"] = 4.into()
        }),
        ("do not fit", &|b| {
            b.json["accessors"][1]["count"] = 3000.into()
        }),
        ("more than the limit", &|b| {
            b.json["accessors"][1]["count"] = 30_003.into()
        }),
        ("more than the limit", &|b| {
            b.json["accessors"][1] =
                json!({"componentType": 5125, "type": "SCALAR", "count": 3_u64 << 60});
        }),
        ("not a multiple of 3", &|b| {
            b.json["accessors"][1]["count"] = 5.into()
        }),
        ("the type Vec2", &|b| {
            b.json["accessors"][0]["type"] = "VEC2".into()
        }),
        ("not integers", &|b| {
            b.json["accessors"][1]["componentType"] = 5120.into()
        }),
        ("two parents", &|b| {
            b.json["nodes"][0]["children"] = json!([0])
        }),
        ("\"POSITION\"", &|b| {
            b.json["meshes"][0]["primitives"][0]["attributes"] = json!({});
        }),
        ("has no faces", &|b| {
            b.json["meshes"][0]["primitives"][0]["mode"] = 0.into()
        }),
        ("has no faces", &|b| {
            b.json["scenes"][0]["nodes"] = json!([])
        }),
    ];
    for (index, (part, change)) in cases.iter().enumerate() {
        let mut builder = plain();
        change(&mut builder);
        let message = message(&builder.glb());
        assert!(message.contains(part), "{index}: {message}");
        assert!(message.contains("a/b.glb"), "{message}");
    }
    // Half of the vertices have normals.
    let mut builder = plain();
    let normals = builder.floats(&[[0.0, 0.0, 1.0]; 2]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals.into();
    assert!(message(&builder.glb()).contains("2 normals for 4 positions"));
}

#[test]
fn damaged_files_are_told() {
    let whole = plain().glb();
    for length in [4, 11, 12, 19, 30, whole.len() - 1] {
        let message = message(&whole[..length]);
        assert!(message.contains("export it again"), "{length}: {message}");
    }
    let mut old = whole.clone();
    old[4] = 1;
    assert!(message(&old).contains("glTF 1"));
    for text in ["{", "{}", "[]", "{\"asset\": 7}"] {
        assert!(message(text.as_bytes()).contains("not a glTF 2.0 file"));
    }
    // Many objects take far more memory than their text.
    let mut many = b"{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{}".to_vec();
    many.extend(b",{}".repeat(100_000));
    many.extend(b"]}");
    assert!(message(&many).contains("--max-memory"));
}

#[test]
fn buffers_are_files_beside_it() {
    let bytes = plain().bytes;
    let read = |uri: &str, limit: u64| {
        let text = plain().text(uri);
        let name = |name: &str| (PathBuf::from(name), Arc::from(bytes.as_slice()));
        let files = Files::memory([name("a/x.bin"), name("y.bin")]);
        let limit = text.len() as u64 + limit;
        parse(&files, &text, Path::new("a/b.gltf"), &options(limit))
            .map_err(|error| error.to_string())
    };
    let length = bytes.len() as u64;
    for uri in ["x.bin", "./x.bin", "../y.bin", "%78.bin"] {
        assert_eq!(read(uri, length).unwrap().triangles.len(), 2, "{uri}");
    }
    let data = format!("data:;base64,{}", base64(&bytes));
    assert!(read(&data, length).is_ok());
    for (uri, part) in [
        ("none.bin", "a/none.bin, which is not among"),
        ("https://example.org/x.bin", "is not a file name"),
        ("file:///etc/passwd", "is not a file name"),
        ("", "is not a file name"),
        ("%ff.bin", "is not a file name"),
        ("data:;base64,A", "damaged base64"),
        ("data:;base64,AAAA", "should have"),
    ] {
        let message = read(uri, length).unwrap_err();
        assert!(
            message.contains(part) && message.contains("a/b.gltf"),
            "{message}"
        );
    }
    for uri in ["x.bin", data.as_str()] {
        assert!(
            read(uri, length - 1).unwrap_err().contains("--max-memory"),
            "{uri}"
        );
    }

    // On the disk, files must be in the scene's folder.
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("mine");
    std::fs::create_dir(&scenes).unwrap();
    std::fs::write(folder.path().join("out.bin"), &bytes).unwrap();
    std::fs::write(scenes.join("in.bin"), &bytes).unwrap();
    let files = Files::of_scene(&scenes).unwrap();
    let read = |files: &Files, uri: &str| {
        let path = scenes.join("b.gltf");
        parse(files, &plain().text(uri), &path, &options(BYTES)).map_err(|error| error.to_string())
    };
    assert!(read(&files, "in.bin").is_ok());
    assert!(
        read(&files, "../out.bin")
            .unwrap_err()
            .contains("--allow-outside")
    );
    assert!(read(&Files::Disk, "../out.bin").is_ok());
    assert!(read(&files, "gone.bin").unwrap_err().contains(".glb"));
}

proptest! {
    #[test]
    fn no_bytes_panic(changes in prop::collection::vec((any::<usize>(), any::<u8>()), 1..8)) {
        let mut file = plain().glb();
        for (place, byte) in changes {
            let place = place % file.len();
            file[place] = byte;
        }
        let _ = read(&file);
    }

    /// Changes numbers in the description.
    #[test]
    fn no_number_panics(
        changes in prop::collection::vec(
            (any::<usize>(), prop::sample::select(vec!["0", "1", "7", "-1", "0.5", "4294967295", "18446744073709551615", "9007199254740993", "1e300"])),
            1..4,
        ),
    ) {
        let mut builder = everything();
        builder.buffer(None);
        let mut text = builder.json.to_string();
        for (place, number) in changes {
            let digits: Vec<usize> = (1..text.len())
                .filter(|&at| {
                    text.as_bytes()[at].is_ascii_digit() && b":[,".contains(&text.as_bytes()[at - 1])
                })
                .collect();
            let start = digits[place % digits.len()];
            let length = text[start..].find(|c: char| !c.is_ascii_digit()).unwrap_or(1);
            text.replace_range(start..start + length, number);
        }
        let _ = read(&glb(text.as_bytes(), &builder.bytes));
    }
}

/// Returns a square that uses every feature that is read.
fn everything() -> Builder {
    let mut builder = plain();
    let normals = builder.floats(&[[0.0, 0.0, 1.0]; 4]);
    let uvs = builder.floats(&[[0.0, 0.0]; 4]);
    let indices = builder.view(&[1, 3]);
    let values = builder.view(&[0; 24]);
    builder.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5121, "byteOffset": 0},
        "values": {"bufferView": values, "byteOffset": 0},
    });
    builder.json["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": 0, "NORMAL": normals, "TEXCOORD_0": uvs});
    builder.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"mesh": 0}]);
    let picture = builder.view(b"picture");
    builder.json["images"] = json!([
        {"bufferView": picture, "mimeType": "image/png"},
        {"uri": format!("data:image/png;base64,{}", base64(b"inline"))},
        {"uri": "my%20wood.png"},
    ]);
    builder.json["textures"] = json!([{"source": 0}, {"source": 1}, {"source": 2}, {}]);
    builder.json["materials"] = json!([
        {},
        {
            "name": "oak",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 0.125, 1.0],
                "metallicFactor": 0.75,
                "roughnessFactor": 0.5,
                "baseColorTexture": {
                    "index": 2,
                    "extensions": {"KHR_texture_transform": {"scale": [2.0, 2.5], "offset": [0.5, 0.0]}},
                },
                "metallicRoughnessTexture": {
                    "index": 1,
                    "extensions": {"KHR_texture_transform": {"scale": [2.0, 2.5], "offset": [0.5, 0.0]}},
                },
            },
            "normalTexture": {
                "index": 0,
                "scale": 0.5,
                "extensions": {"KHR_texture_transform": {"scale": [2.0, 2.5], "rotation": 1.0}},
            },
            "emissiveFactor": [1.0, 0.5, 0.0],
            "emissiveTexture": {"index": 0},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
        },
        {
            "name": "glass",
            "alphaMode": "BLEND",
            "occlusionTexture": {"index": 0},
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}},
            "emissiveTexture": {"index": 3},
            "emissiveFactor": [1.0, 1.0, 1.0],
            "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}},
        },
        {
            "name": "old",
            "extensions": {"KHR_materials_pbrSpecularGlossiness": {
                "diffuseFactor": [0.5, 0.5, 0.5, 1.0],
                "glossinessFactor": 0.75,
                "diffuseTexture": {"index": 0},
            }},
        },
    ]);
    builder.json["meshes"][0]["primitives"][0]["material"] = 1.into();
    builder
}

/// Returns a square of each material of [`everything`], and one without.
fn materialized() -> Builder {
    let mut builder = everything();
    builder.json["nodes"] = json!([{"mesh": 0}]);
    let first = builder.json["meshes"][0]["primitives"][0].clone();
    for material in [Some(3), None, Some(1), Some(2), Some(0)] {
        let mut primitive = first.clone();
        match material {
            Some(material) => primitive["material"] = material.into(),
            None => {
                primitive.as_object_mut().unwrap().remove("material");
            }
        }
        builder.primitive(primitive);
    }
    builder
}

#[test]
fn triangles_have_the_materials_of_their_primitives() {
    let mesh = read(&materialized().glb()).unwrap();
    assert_eq!(mesh.materials, ["oak", "old", "", "glass", "material 0"]);
    let of_squares: Vec<u32> = mesh.material_of.chunks(2).map(|pair| pair[0]).collect();
    assert_eq!(of_squares, [0, 1, 2, 0, 3, 4]);
    assert_eq!(mesh.material_of.len(), mesh.triangles.len());
    let mesh = read(&plain().glb()).unwrap();
    assert!(mesh.materials.is_empty() && mesh.material_of.is_empty());
}

#[test]
fn parts_are_read_alone() {
    let mut builder = materialized();
    // Texture coordinates that the other parts lack do not matter.
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut();
    for primitive in primitives.unwrap().iter_mut().skip(1) {
        let attributes = primitive["attributes"].as_object_mut().unwrap();
        attributes.remove("TEXCOORD_0");
    }
    let file = builder.glb();
    let parts = |names: &[&str]| {
        let options = MeshOptions {
            parts: names.iter().map(|name| name.to_string()).collect(),
            ..options(BYTES)
        };
        parse(&Files::memory([]), &file, Path::new("a.glb"), &options)
    };
    let all = parts(&[]).unwrap();
    assert_eq!(
        (all.triangles.len(), all.face_without_uvs.is_some()),
        (12, true)
    );
    let some = parts(&["glass", ""]).unwrap();
    assert_eq!(
        (some.triangles.len(), &some.material_of[..]),
        (4, &[2, 2, 3, 3][..])
    );
    assert_eq!(parts(&["old"]).unwrap().triangles.len(), 2);
    let message = parts(&["oak", "tin"]).unwrap_err().to_string();
    let told = r#"has no part "tin"; its parts are "oak", "old", "", "glass", "material 0""#;
    assert!(message.contains(told), "{message}");
}

#[test]
fn materials_are_read_with_their_pictures() {
    let files = Files::memory([("a/my wood.png".into(), b"wood".as_slice().into())]);
    let file = materialized().glb();
    let found = materials(&files, &file, Path::new("a/b.glb"), BYTES).unwrap();
    let [oak, old, none, glass, plain] = &found.materials[..] else {
        panic!("{found:?}");
    };
    assert_eq!(
        (oak.base_color, oak.metallic, oak.roughness),
        ([0.5, 0.25, 0.125], 0.75, 0.5)
    );
    assert_eq!(
        (oak.emission, oak.normal_scale, oak.tiles, oak.offset),
        ([4.0, 2.0, 0.0], 0.5, [2.0, 2.5], [0.5, 2.5])
    );
    let content = |picture: Option<usize>| &found.pictures[picture.unwrap()].1[..];
    assert_eq!(content(oak.base_color_picture), b"wood");
    assert_eq!(content(oak.metallic_roughness_picture), b"inline");
    assert_eq!(content(oak.normal_picture), b"picture");
    assert_eq!(oak.emission_picture, oak.normal_picture);
    assert_eq!(
        (old.base_color, old.metallic, old.roughness),
        ([0.5; 3], 0.0, 0.25)
    );
    assert_eq!(content(old.base_color_picture), b"picture");
    // The default of glTF.
    assert_eq!((none.metallic, none.roughness), (1.0, 1.0));
    assert_eq!((plain.metallic, plain.roughness), (1.0, 1.0));
    assert_eq!(
        (glass.base_color_picture, glass.emission_picture),
        (None, None)
    );
    let unused = found.unused.iter();
    let unused: Vec<_> = unused
        .flat_map(|(what, materials)| materials.iter().map(|material| (&**material, &**what)))
        .collect();
    // Not where its picture is missing.
    assert_eq!(glass.emission, [0.0; 3]);
    for left in [
        ("oak", "turns of pictures"),
        ("oak", "scales and offsets of further pictures"),
        ("old", "specular colours and pictures of glossiness"),
        ("glass", "pictures with a second set of texture coordinates"),
        ("glass", "pictures in formats of extensions"),
        ("glass", "pictures of occlusion"),
        ("glass", "transparency"),
        ("glass", "KHR_materials_clearcoat"),
    ] {
        assert!(unused.contains(&left), "{left:?}: {unused:?}");
    }
    assert_eq!(unused.len(), 8, "{unused:?}");
    assert!(found.problems.is_empty());

    // A picture that is missing is told; all others are there.
    let found = materials(&Files::memory([]), &file, Path::new("a/b.glb"), BYTES).unwrap();
    assert_eq!((found.pictures.len(), found.problems.len()), (2, 1));
    assert!(
        found.problems[0].contains("my wood.png"),
        "{:?}",
        found.problems
    );
    let small = materials(&files, &file, Path::new("a/b.glb"), file.len() as u64 + 3);
    assert!(matches!(small, Err(MeshError::TooLarge { .. })));
}
