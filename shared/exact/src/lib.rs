//! Mathematical functions with the same bits on every GPU and every CPU.
//!
//! For shader code in Rust (rust-gpu) that must give the same results on every device:
//! tests of shader logic on the CPU, simulations that players share, procedural worlds.
//! GPUs may round a division by up to 2.5 ULP, and `sin` is any function that looks like
//! one. The functions of this crate use + − ×, comparisons, conversions and whole numbers,
//! which devices with IEEE 754 rounding compute alike, and correct the device's own
//! division and root.
//!
//! ```
//! use relievo_exact::{atan2, pow, sin};
//!
//! assert_eq!(sin(1e6), (1e6_f64).sin() as f32);
//! assert_eq!(pow(2.0, 0.5), 2.0_f32.sqrt());
//! assert_eq!(atan2(1.0, -1.0), 2.356_194_5);
//! ```
//!
//! | functions | error, ULP |
//! |---|---|
//! | [`div`], [`sqrt`], [`trunc`], [`floor`], [`ceil`], [`round`], [`fract`] | ½: rounded correctly |
//! | [`recip_sqrt`], [`exp`], [`exp2`], [`log`], [`log2`], [`sin`], [`cos`], [`tan`], [`asin`], [`acos`], [`atan`] | at most 1 |
//! | [`atan2`], [`pow`] | at most 2 |
//!
//! `docs/exact.md` has the measured errors, and what was compared.
//!
//! # Numbers
//!
//! Denormal numbers count as 0. Results are 0 or normal numbers: what is too large is
//! ±`f32::MAX`. The result for an infinity or NaN is the same everywhere, but means
//! nothing. The sign of zero has no meaning.
//!
//! # What a device must do
//!
//! Sums and products must be rounded to nearest, and not be fused: every float operation
//! of the shader is decorated NoContraction. The feature `corrected` makes division and
//! root exact on a GPU; without it they are the device's own.
//!
//! Beside this crate, use + − × of f32 and of glam's vectors and matrices, `dot` and
//! `cross`. Not `/`, `%`, `mul_add`, nor glam's `length`, `normalize` and `lerp`.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
// Powers of two are written in full.
#![allow(clippy::excessive_precision)]

mod basic;
mod bits;
mod exponential;
#[cfg(any(all(feature = "fused", target_arch = "spirv"), test))]
mod fused;
mod inverse;
pub mod moderate;
mod native;
mod pair;
pub mod rounding;
mod trigonometry;
mod vector;

// How the results of a device are corrected.
#[cfg(all(feature = "fused", target_arch = "spirv"))]
use fused as correction;
#[cfg(all(
    feature = "corrected",
    not(all(feature = "fused", target_arch = "spirv"))
))]
use rounding as correction;

pub use basic::{abs, ceil, clamp, div, floor, fract, max, min, recip_sqrt, round, sqrt, trunc};
pub use bits::finite;
pub use exponential::{exp, exp2, log, log2, pow};
pub use inverse::{acos, asin, atan, atan2};
pub use trigonometry::{cos, sin, tan};
pub use vector::{Vector, distance, length, normalize_or};
