//! Random scenes: one mesh of this project, carved with one of its patterns,
//! seen from anywhere. The planner is fitted to some, and held to others.

use crate::prepare::rotation;
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

/// The text of random scene number `number` of the series `series`, to be
/// parsed as if it lay in `assets/scenes`; a picture of `size` pixels.
///
/// Distances go from close-ups to far away, fields of view from a telephoto
/// lens to a wide one, and depths from a scratch to a deep relief.
pub fn random_scene(series: u64, number: u64, size: [u32; 2]) -> String {
    // Mixed by the generator itself, so that numbers beside each other differ.
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
    // In the mesh's own frame: what is open is seen from its front, since what
    // a ray meets that comes from below the floor is nobody's definition.
    let (y, angle) = (signed(), std::f64::consts::PI * signed());
    let y = match mesh {
        "plane" => 0.54 + 0.46 * y,
        "saddle" => 0.92 + 0.08 * y,
        "cylinder" => 1.4 * y / distance,
        _ => y,
    };
    let around = (1.0 - y * y).sqrt();
    let eye = distance * DVec3::new(around * angle.cos(), y, around * angle.sin());
    // Past the middle: also outlines are looked at closely.
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
