//! Random scenes of one mesh and one pattern of this project, to fit and to test
//! the planner.

use crate::scene::rotation;
use glam::DVec3;
use std::fmt::Write;

const MESHES: [&str; 7] = [
    "torus",
    "blob",
    "sphere",
    "cylinder",
    "ellipsoid",
    "saddle",
    "plane",
];
const PATTERNS: [&str; 6] = [
    "discs", "letters", "bricks", "windows", "hexagons", "lattice",
];

/// Returns the text of random scene `number` of `series`, to be parsed as a file
/// of `assets/scenes`, for a picture of `size` pixels.
///
/// Distances go from close-ups to far away, fields of view from a telephoto
/// lens to a wide one, and depths from a scratch to a deep relief.
pub fn random_scene(series: u64, number: u64, size: [u32; 2]) -> String {
    // The generator mixes the seed, so that consecutive numbers differ.
    let mut random = fastrand::Rng::with_seed(
        fastrand::Rng::with_seed(series)
            .u64(..)
            .wrapping_add(number.wrapping_mul(0x9e37_79b9_7f4a_7c15)),
    );
    let mut magnitude = |low: f64, high: f64| (low.ln() + (high / low).ln() * random.f64()).exp();
    let repeat_u = magnitude(2.0, 32.0).round();
    let repeat_v = (repeat_u * magnitude(0.3, 1.0)).round().max(1.0);
    let depth = magnitude(0.004, 0.15);
    let distance = magnitude(1.6, 14.0);
    let field_of_view = magnitude(4.0, 60.0);
    let mesh = MESHES[random.usize(..MESHES.len())];
    let pattern = PATTERNS[random.usize(..PATTERNS.len())];
    let mut signed = || 2.0 * random.f64() - 1.0;
    // In the mesh's own frame. Open meshes are seen from their front: a hit from
    // below the floor is not defined.
    let (y, angle) = (signed(), std::f64::consts::PI * signed());
    let y = match mesh {
        "plane" => 0.54 + 0.46 * y,
        "saddle" => 0.92 + 0.08 * y,
        "cylinder" => 1.4 * y / distance,
        _ => y,
    };
    let around = (1.0 - y * y).sqrt();
    let eye = distance * DVec3::new(around * angle.cos(), y, around * angle.sin());
    // Off centre, so that some scenes show outlines closely.
    let target = 0.5 * DVec3::new(signed(), signed(), signed());
    let rotate = [signed(), signed(), signed()].map(|x| 180.0 * x);
    let turned = rotation(rotate);
    let [eye, target, up] =
        [eye, target, eye.any_orthogonal_vector()].map(|v| (turned * v).to_array());
    let technique = ["basic", "outward", "beveled", "chamfered"][random.usize(..4)];
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "[image]\nsize = {size:?}\n[camera]\neye = {eye:?}\ntarget = {target:?}\nup = {up:?}\nfov = {field_of_view:?}\n[[object]]\nmesh = \"../meshes/{mesh}.obj\"\nshape = \"../patterns/{pattern}.png\"\nrepeat = [{repeat_u:?}, {repeat_v:?}]\ndepth = {depth:?}\nrotate = {rotate:?}\ntechnique = \"{technique}\"\n"
    );
    text
}
