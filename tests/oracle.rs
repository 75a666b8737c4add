//! The torus against its oracle.

use glam::DVec3;
use relievo::oracle::{Accuracy, TorusOracle};
use relievo::prepare::prepare;
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::Scene;
use relievo_tests::asset;

fn accuracy(tier: &str) -> Accuracy {
    let text = format!(
        "[image]\nsize = [480, 360]\n[camera]\neye = [0.0, 2.3, 3.4]\nfov = 38.0\n[[object]]\nmesh = \"../meshes/torus.obj\"\nshape = \"../patterns/discs.png\"\nrepeat = [24, 10]\ndepth = 0.08\ntier = \"{tier}\"\n"
    );
    let scene = Scene::parse(&text, &asset("scenes/test.toml")).unwrap();
    let prepared = prepare(&scene, &|_| ()).unwrap();
    let words = CpuRenderer::new(&prepared)
        .geometry(&prepared.frame)
        .unwrap();
    let oracle = TorusOracle {
        map: &prepared.objects[0].map,
        repeat: [24.0, 10.0],
        depth: 0.08,
        extrusion: scene.objects[0].extrusion,
    };
    let eye = DVec3::from(prepared.camera.eye);
    oracle.truth(eye, &prepared.frame).judge(&words)
}

/// The bounds lie just under what is measured: IoU .9847 and 95 interior holes
/// for the fast tier, .9645 for the planar one. A better tier is another issue.
#[test]
fn the_fast_tier_has_the_silhouette_of_the_torus() {
    let fast = accuracy("fast");
    let planar = accuracy("planar");
    println!("fast {fast:?}\nplanar {planar:?}");
    assert!(fast.silhouette_iou >= 0.984, "{fast:?}");
    assert!(fast.interior_holes <= 100, "{fast:?}");
    assert!(fast.class_errors <= 0.05, "{fast:?}");
    assert!(planar.silhouette_iou <= 0.97, "{planar:?}");
    assert!(planar.extra > 3 * fast.extra, "{planar:?}");
}
