//! glTF files, text or binary: any bytes give a valid mesh or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::Files;
use relievo::mesh::{Mesh, MeshOptions, Projection};
use std::path::Path;
use std::sync::Arc;

fuzz_target!(|input: (bool, &[u8])| {
    let (is_projected, bytes) = input;
    let options = MeshOptions {
        projection: is_projected.then_some(Projection::Spherical),
        triangle_limit: 256,
        byte_limit: 1 << 20,
        ..MeshOptions::default()
    };
    let files = Files::memory([("a.bin".into(), Arc::from([0_u8; 64].as_slice()))]);
    match Mesh::from_bytes(&files, bytes, Path::new("mesh.glb"), &options) {
        Ok(mesh) => {
            assert!((1..=256).contains(&mesh.triangles.len()));
            for corner in mesh.triangles.iter().flat_map(|triangle| triangle.corners) {
                assert!(corner.position.is_finite() && corner.uv.is_finite());
                assert!((corner.normal.length() - 1.0).abs() < 1e-6);
                assert!((corner.tangent.length() - 1.0).abs() < 1e-6);
            }
        }
        Err(error) => assert!(error.to_string().contains("mesh.glb")),
    }
});
