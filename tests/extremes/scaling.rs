//! A scene in other units: scaled by a power of two, every colour is the same
//! bit for bit, and every distance is that power of two larger.

use super::material::{ball, over, scale};
use relievo::prepare::prepare;
use relievo::render::{CpuRenderer, GeometryWords, Renderer};
use relievo::scene::{Scene, Tier};

/// Exponents: object units from 2⁻²⁴ to 2²⁴ of those of the scenes, whose objects
/// are two units in size. Squares of a small triangle's area leave the value
/// contract from 2⁻²⁵ on, and those of curvatures at 2²⁶.
const EXPONENTS: [i32; 8] = [-24, -20, -10, -1, 1, 10, 20, 24];

fn pictures(scene: &Scene, exponent: i32) -> (Vec<[u32; 4]>, GeometryWords) {
    let mut scene = scene.clone();
    scale(&mut scene, f64::from(exponent).exp2());
    let scene = prepare(&scene, &|_| ()).unwrap();
    let mut cpu = CpuRenderer::new(&scene);
    let color = cpu.color(&scene.frame).unwrap();
    (color.words, cpu.geometry(&scene.frame).unwrap())
}

#[test]
fn powers_of_two_change_no_bit() {
    let mut wrong = Vec::new();
    for mesh in ["sphere.obj", "torus.obj", "saddle.obj", "plane.obj"] {
        for tier in [Tier::Planar, Tier::Fast, Tier::Accurate] {
            let mut scene = if mesh == "sphere.obj" {
                ball()
            } else {
                over(mesh)
            };
            scene.objects[0].tier = tier;
            scene.objects[0].self_shadow = true;
            let (color, geometry) = pictures(&scene, 0);
            assert!(geometry.coverage().0 > 100);
            for exponent in EXPONENTS {
                let (scaled_color, scaled) = pictures(&scene, exponent);
                let factor = (exponent as f32).exp2();
                let same = |index: usize| {
                    let [t, rest @ ..] = geometry.place[index];
                    let [scaled_t, scaled_rest @ ..] = scaled.place[index];
                    f32::from_bits(t) * factor == f32::from_bits(scaled_t)
                        && rest == scaled_rest
                        && geometry.surface[index] == scaled.surface[index]
                        && color[index] == scaled_color[index]
                };
                let different = (0..color.len()).filter(|&index| !same(index)).count();
                if different > 0 {
                    wrong.push(format!(
                        "{mesh}, {}, 2^{exponent}: {different} pixels",
                        tier.name()
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
