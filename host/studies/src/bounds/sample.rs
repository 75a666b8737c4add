//! Random inputs, and the result of one.

use fastrand::Rng;
use glam::{DVec3, Vec3};
use relievo_shared::layout::{FORMAT_CODES, Object, TIER_FAST};

/// Result of one input.
pub(super) enum Sample {
    /// Error of f32.
    Error(f64),
    /// f32 gives another class or column.
    Other,
    /// Neither side has a result; the input is not counted.
    Unfit,
}

/// Returns |found − expected| / scale.
pub(super) fn error(found: f32, expected: f64, scale: f64) -> f64 {
    (f64::from(found) - expected).abs() / scale
}

/// Returns the length of found − expected, relative to `scale`.
pub(super) fn vector_error(found: Vec3, expected: DVec3, scale: f64) -> f64 {
    (found.as_dvec3() - expected).length() / scale
}

/// Returns a number in −1…1.
pub(super) fn signed(rng: &mut Rng) -> f64 {
    2.0 * rng.f64() - 1.0
}

/// Returns `x` or −`x`.
pub(super) fn either_sign(rng: &mut Rng, x: f64) -> f64 {
    if rng.bool() { x } else { -x }
}

/// Returns a number in `low`…`high`, uniform in its logarithm.
pub(super) fn magnitude(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.f64())
}

/// Returns a uniformly distributed unit vector.
pub(super) fn unit(rng: &mut Rng) -> DVec3 {
    let z = signed(rng);
    let (y, x) = (std::f64::consts::TAU * rng.f64()).sin_cos();
    let around = (1.0 - z * z).sqrt();
    DVec3::new(x * around, y * around, z)
}

/// Returns a unit vector that descends (−z) with the slope `v_z`.
pub(super) fn descending(rng: &mut Rng, v_z: f64) -> Vec3 {
    let (y, x) = (std::f64::consts::TAU * rng.f64()).sin_cos();
    let around = (1.0 - v_z * v_z).max(0.0).sqrt();
    DVec3::new(x * around, y * around, -v_z).as_vec3()
}

/// Texels along each side of [`disc`].
pub(super) const SIDE: u32 = 32;
/// Texels per code step.
const STEP: f32 = 1.0 / 256.0;
/// Code of distance 0.
const BIAS: u32 = 1 << 15;

/// Returns a disc of radius 9.3 texels in closed form, as 16-bit codes.
pub(super) fn disc() -> Vec<u32> {
    let middle = 0.5 * f64::from(SIDE) - 0.5;
    let code = |i: u32| {
        let (x, y) = (f64::from(i % SIDE) - middle, f64::from(i / SIDE) - middle);
        let steps = ((x.hypot(y) - 9.3) / f64::from(STEP)).floor();
        (steps + f64::from(BIAS)) as u32
    };
    (0..SIDE * SIDE / 2)
        .map(|i| code(2 * i) | code(2 * i + 1) << 16)
        .collect()
}

/// Returns an object carved with [`disc`], `depth` deep.
pub(super) fn disc_object(depth: f32) -> Object {
    Object {
        map_size: [SIDE as f32; 2],
        map_step: STEP,
        map_quantum: STEP,
        map_reach: 2.0,
        depth,
        chamfer: 1.0,
        tier: TIER_FAST,
        linear_steps: 1000,
        binary_steps: 20,
        map_bias: BIAS,
        map_packing: 1,
        map_format: FORMAT_CODES,
        ..Object::default()
    }
    .complete()
}
