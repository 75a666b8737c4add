//! `bindings.rs` of every kind of surface, compiled as exported and used to
//! read the buffers. Run with `RELIEVO_UPDATE_GOLDEN=1` to accept the current
//! exports.

use super::cases::{file, prepared};
use super::in_wgsl;
use relievo::scene::Tier;
use relievo_shared::layout;
use relievo_tests::root;
use std::fs;

#[path = "../../host/examples/plain-wgpu/src/bindings.rs"]
mod curved;
#[path = "bindings/planar.rs"]
mod planar;
#[path = "bindings/prisms.rs"]
mod prisms;

/// Asserts that a struct of `bindings.rs` has the bytes of ours.
fn same<Theirs: bytemuck::Pod, Ours: bytemuck::Pod>() {
    assert_eq!(
        (size_of::<Theirs>(), align_of::<Theirs>()),
        (size_of::<Ours>(), align_of::<Ours>()),
        "{}",
        std::any::type_name::<Theirs>()
    );
}

#[test]
fn bindings_of_every_kind_compile_and_read_the_buffers() {
    same::<curved::Triangle, layout::Triangle>();
    same::<planar::PlanarTriangle, layout::PlanarTriangle>();
    same::<prisms::PrismData, layout::PrismData>();
    for (tier, path) in [
        (Tier::Fast, "host/examples/plain-wgpu/src/bindings.rs"),
        (Tier::Planar, "tests/export/bindings/planar.rs"),
        (Tier::Accurate, "tests/export/bindings/prisms.rs"),
    ] {
        let scene = prepared("torus.toml", |object| object.tier = tier);
        let object = &scene.objects[0];
        let files = in_wgsl(&scene);
        let path = root().join(path);
        let exported = file(&files, "bindings.rs");
        if std::env::var_os("RELIEVO_UPDATE_GOLDEN").is_some() {
            fs::write(&path, exported).unwrap();
        }
        assert!(
            fs::read(&path).unwrap() == exported,
            "{} is not what is exported",
            path.display()
        );
        let facets = file(&files, "facets.bin");
        // The first corner of each facet.
        let places: Vec<[f32; 3]> = match tier {
            Tier::Fast => bytemuck::pod_collect_to_vec::<u8, curved::Triangle>(facets)
                .iter()
                .map(|triangle| triangle.corners[0].position)
                .collect(),
            Tier::Planar => bytemuck::pod_collect_to_vec::<u8, planar::PlanarTriangle>(facets)
                .iter()
                .map(|triangle| triangle.corners[0].position)
                .collect(),
            _ => bytemuck::pod_collect_to_vec::<u8, prisms::PrismData>(facets)
                .iter()
                .map(|prism| prism.anchor)
                .collect(),
        };
        let ours = object.triangles.iter();
        let ours: Vec<_> = ours.map(|triangle| triangle.corners[0].position).collect();
        assert_eq!(places, ours);
    }
}
