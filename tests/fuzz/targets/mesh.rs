//! OBJ files: any text gives a valid mesh or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo::mesh::{Mesh, MeshOptions, Projection};
use std::path::Path;

fuzz_target!(|input: (u8, &str)| {
    let (choice, text) = input;
    let projections = Projection::ALL;
    let options = MeshOptions {
        // The first choice is the file's own coordinates.
        projection: (usize::from(choice) % (projections.len() + 1))
            .checked_sub(1)
            .map(|index| projections[index]),
        triangle_limit: 256,
        ..MeshOptions::default()
    };
    match Mesh::parse(text, Path::new("mesh.obj"), &options) {
        Ok(mesh) => {
            assert!((1..=256).contains(&mesh.triangles.len()));
            for corner in mesh.triangles.iter().flat_map(|triangle| triangle.corners) {
                assert!(corner.position.is_finite() && corner.uv.is_finite());
                assert!((corner.normal.length() - 1.0).abs() < 1e-6);
                assert!((corner.tangent.length() - 1.0).abs() < 1e-6);
                assert!(corner.normal.dot(corner.tangent).abs() < 1e-6);
            }
            // The accurate tier builds its prisms from it.
            assert_eq!(mesh.prisms().len(), mesh.triangles.len());
        }
        Err(error) => assert!(error.to_string().contains("mesh.obj")),
    }
});
