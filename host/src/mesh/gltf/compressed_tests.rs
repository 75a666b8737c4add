//! The cylinder of `assets/meshes`, compressed by gltfpack 1.3 and glTF-Transform 4.5.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use super::parse;
use super::tests::{glb, message, options, read};
use crate::Files;
use crate::mesh::MeshError;
use crate::mesh::raw::RawMesh;

const QUANTIZED: &[u8] = include_bytes!("compressed/meshopt-quantized.glb");
const MESHOPT: &[u8] = include_bytes!("compressed/meshopt.glb");
const DRACO: &[u8] = include_bytes!("compressed/draco.glb");

/// Largest error of what is quantized to 12 bits (texture coordinates) or more.
const TOLERANCE: f64 = 2e-4;

/// Position, normal and texture coordinates of each corner, sorted.
fn corners(mesh: &RawMesh) -> Vec<([f64; 3], [f64; 3], [f64; 2])> {
    let mut corners: Vec<_> = mesh
        .triangles
        .iter()
        .flatten()
        .map(|corner| {
            let normal = mesh.normals[corner.normal.unwrap() as usize];
            (
                mesh.positions[corner.position as usize].to_array(),
                normal.normalize().to_array(),
                mesh.uvs[corner.uv.unwrap() as usize].to_array(),
            )
        })
        .collect();
    // By place: quantized numbers that are nearly equal would change their order.
    let key = |numbers: &[f64]| -> Vec<i64> {
        let rounded = numbers.iter().map(|x| (x * 500.0).round() as i64);
        rounded.collect()
    };
    corners.sort_by_cached_key(|(position, _, uv)| (key(position), key(uv)));
    corners
}

#[test]
fn compressed_files_have_the_mesh_that_was_compressed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/meshes/cylinder.obj");
    let text = std::fs::read_to_string(&path).unwrap();
    let original = crate::mesh::obj::parse(&text, &path, &options(1 << 20)).unwrap();
    for (name, file, of_normals) in [
        ("quantized", QUANTIZED, 0.01),
        ("meshopt", MESHOPT, 1e-6),
        ("draco", DRACO, 0.005),
    ] {
        let mesh = read(file).unwrap();
        let [found, wanted] = [&mesh, &original].map(corners);
        assert_eq!(found.len(), wanted.len(), "{name}");
        for (found, wanted) in found.iter().zip(&wanted) {
            let off = |a: &[f64], b: &[f64]| {
                let pairs = a.iter().zip(b);
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            assert!(
                off(&found.0, &wanted.0) < TOLERANCE,
                "{name} {found:?} {wanted:?}"
            );
            assert!(
                off(&found.1, &wanted.1) < of_normals,
                "{name} {found:?} {wanted:?}"
            );
            assert!(
                off(&found.2, &wanted.2) < TOLERANCE,
                "{name} {found:?} {wanted:?}"
            );
        }
        // Triangles face as before.
        let volume = |mesh: &RawMesh| -> f64 {
            let at = |index: u32| mesh.positions[index as usize];
            let triangles = mesh
                .triangles
                .iter()
                .map(|corners| corners.map(|c| at(c.position)));
            triangles
                .map(|[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0)
                .sum()
        };
        let off = volume(&mesh) / volume(&original) - 1.0;
        assert!(off.abs() < 1e-3, "{name} {off}");
    }
}

/// Pictures of a file whose texture coordinates are quantized lie as they did.
#[test]
fn texture_transforms_restore_coordinates_and_leave_pictures() {
    let (files, path) = (Files::memory([]), Path::new("a.glb"));
    let materials = super::materials(&files, QUANTIZED, path, 1 << 20).unwrap();
    let [material] = &materials.materials[..] else {
        panic!("one material");
    };
    assert!(material.base_color_picture.is_some());
    assert_eq!((material.tiles, material.offset), ([1.0; 2], [0.0, 1.0]));
}

/// Returns `file` with another description.
fn changed(file: &[u8], change: impl Fn(&mut Value)) -> Vec<u8> {
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let (json, rest) = file[20..].split_at(length);
    let mut json = serde_json::from_slice(json).unwrap();
    change(&mut json);
    glb(json.to_string().as_bytes(), &rest[8..])
}

/// A mesh that many nodes show is decoded once: the limit would not do for many.
#[test]
fn nodes_share_what_is_decoded() {
    let file = changed(DRACO, |json| {
        json["nodes"] = (0..4)
            .map(|i| json!({"mesh": 0, "translation": [3 * i, 0, 0]}))
            .collect();
        json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    });
    let (files, path) = (Files::memory([]), Path::new("a.glb"));
    let mesh = parse(&files, &file, path, &options(20_000)).unwrap();
    assert_eq!(mesh.triangles.len(), 4 * 384);
    let right = mesh.positions.iter().map(|at| at.x).fold(0.0, f64::max);
    assert!((right - 10.0).abs() < 1e-3, "{right}");
}

/// Without KHR_mesh_quantization, the transform is one of the pictures alone.
#[test]
fn only_quantized_files_are_restored() {
    let highest = |file: &[u8]| {
        let mesh = read(file).unwrap();
        mesh.uvs.iter().map(|uv| uv.x).fold(0.0, f64::max)
    };
    assert!((highest(QUANTIZED) - 1.0).abs() < TOLERANCE);
    // Numbers of 16 bits that are normalized are plain glTF, too.
    let plain = changed(QUANTIZED, |json| {
        json["extensionsUsed"] = json!(["EXT_meshopt_compression", "KHR_texture_transform"]);
        json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    });
    assert!((highest(&plain) * 16.003664 - 1.0).abs() < TOLERANCE);
}

/// Returns `file` with `from` in its description replaced by `to`, which is as long.
fn with(file: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut file = file.to_vec();
    let at = file
        .windows(from.len())
        .position(|part| part == from.as_bytes());
    let at = at.expect("it is there");
    file[at..at + to.len()].copy_from_slice(to.as_bytes());
    file
}

#[test]
fn mistakes_are_told() {
    for (file, from, to, wanted) in [
        (
            MESHOPT,
            "\"TRIANGLES\"",
            "\"TRIANGLED\"",
            "compressed buffer view 3",
        ),
        (MESHOPT, "\"buffer\":0,", "\"buffer\":7,", "has no buffer 7"),
        (
            MESHOPT,
            "\"byteLength\":1453",
            "\"byteLength\":9453",
            "beyond its buffer",
        ),
        (
            MESHOPT,
            "\"byteLength\":1453",
            "\"byteLength\":1253",
            "cannot be decompressed",
        ),
        (
            MESHOPT,
            "\"count\":245}}",
            "\"count\":-45}}",
            "count is -45, no whole number",
        ),
        (DRACO, "\"mode\":4", "\"mode\":5", "a strip or a fan"),
        (
            DRACO,
            "\"bufferView\":0,\"at",
            "\"bufferView\":5,\"at",
            "no such buffer view",
        ),
        (
            DRACO,
            "\"POSITION\":0,",
            "\"POSITION\":9,",
            "attribute 9 is missing",
        ),
        (
            DRACO,
            "\"count\":1152",
            "\"count\":1149",
            "cannot be decompressed",
        ),
    ] {
        let message = message(&with(file, from, to));
        assert!(message.contains(wanted), "{to}: {message}");
    }
    let path = Path::new("a.glb");
    // Less than what is decoded.
    for (file, limit) in [(MESHOPT, 12_000), (DRACO, 6_000)] {
        let result = parse(&Files::memory([]), file, path, &options(limit));
        assert!(matches!(result, Err(MeshError::TooLarge { .. })), "{limit}");
    }
}

/// A change of any byte is an error or another mesh.
#[test]
fn damaged_content_is_no_panic() {
    for file in [QUANTIZED, MESHOPT, DRACO] {
        let content = file.windows(4).position(|part| part == b"BIN\0").unwrap() + 4;
        let step = 1 + (file.len() - content) / 300;
        for at in (content..file.len()).step_by(step) {
            for change in [0x01, 0x80, 0xff] {
                let mut file = file.to_vec();
                file[at] ^= change;
                let _ = read(&file);
            }
            let mut cut = file[..at].to_vec();
            cut.resize(file.len(), 0);
            let _ = read(&cut);
        }
    }
}
