//! Small operations with known results: together a device's signature.
//!
//! Exact modules rely on some of them. Vulkan leaves the others to the device; they
//! tell devices apart.

use crate::{Domain, Kind};
use glam::{Vec2, Vec3};

/// Meaning of a difference between the words of device and CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// Name of the canary.
    pub name: &'static str,
    /// Whether a device must pass it to be exact.
    pub required: bool,
    /// Behaviour of a device that differs.
    pub tells: &'static str,
}

const fn meaning(name: &'static str, required: bool, tells: &'static str) -> Meaning {
    Meaning {
        name,
        required,
        tells,
    }
}

/// The meaning of each canary, in the order of the list.
pub const MEANINGS: [Meaning; 12] = [
    meaning("multiply_add", true, "a b + c is fused"),
    meaning("dot3", true, "a dot product is fused or reordered"),
    meaning("factoring", true, "a b + a c becomes a (b + c)"),
    meaning("cancelling", true, "(a + b) - a becomes b"),
    meaning("whole_number", true, "i32 to f32 is wrong"),
    meaning("truncation", true, "f32 to i32 is wrong"),
    meaning("fused", false, "a fused a b + c is rounded twice"),
    meaning("third", false, "x / 3 is not rounded to nearest"),
    meaning("native_division", false, "a / b is not rounded to nearest"),
    meaning(
        "native_root",
        false,
        "a square root is not rounded to nearest",
    ),
    meaning("denormal", false, "denormal numbers are flushed to zero"),
    meaning("negative_zero", false, "zero loses its sign"),
];

/// Numbers of similar size, so that sums round.
pub const NUMBER: Domain = Domain::new(
    "canary number",
    Kind::NonZero {
        low: 0.0625,
        high: 16.0,
    },
);
/// Whole numbers that f32 holds.
pub const WHOLE: Domain = Domain::new(
    "canary whole number",
    Kind::Integer {
        low: 0,
        high: 0x0100_0000,
    },
);
/// Numbers to truncate.
pub const TRUNCATED: Domain = Domain::new(
    "canary truncated number",
    Kind::Range {
        low: -16_777_216.0,
        high: 16_777_216.0,
    },
);
/// Numbers whose half is denormal.
pub const TINY: Domain = Domain::new(
    "canary tiny number",
    Kind::NonZero {
        low: f32::MIN_POSITIVE,
        high: 1.9 * f32::MIN_POSITIVE,
    },
);

/// a b + c.
pub fn multiply_add(a: f32, b: f32, c: f32) -> f32 {
    a * b + c
}

/// a · b, summed from x to z.
pub fn dot3(a: Vec3, b: Vec3) -> f32 {
    a.dot(b)
}

/// a b + a c.
pub fn factoring(a: f32, b: f32, c: f32) -> f32 {
    a * b + a * c
}

/// (a + b) − a.
pub fn cancelling(a: f32, b: f32) -> f32 {
    (a + b) - a
}

/// x, converted by way of i32.
pub fn whole_number(x: u32) -> f32 {
    x as i32 as f32
}

/// x without its fraction.
pub fn truncation(x: f32) -> i32 {
    x as i32
}

/// a b + c by the device's fused sum, and a b less its own rounding, which is exact.
pub fn fused(a: f32, b: f32, c: f32) -> Vec2 {
    Vec2::new(libm::fmaf(a, b, c), libm::fmaf(a, b, -(a * b)))
}

/// x / 3 by the device's division.
pub fn third(x: f32) -> f32 {
    x / 3.0
}

/// a / b by the device's division.
pub fn native_division(a: f32, b: f32) -> f32 {
    a / b
}

/// √|x| by the device's root.
pub fn native_root(x: f32) -> f32 {
    libm::sqrtf(if x < 0.0 { -x } else { x })
}

/// x / 2, denormal.
pub fn denormal(x: f32) -> f32 {
    x * 0.5
}

/// The bits of x · 0.
pub fn negative_zero(x: f32) -> u32 {
    (x * 0.0).to_bits()
}
