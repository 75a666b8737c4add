//! The mathematics of relievo, written once.
//!
//! The same files are compiled three times: to SPIR-V by `shader-crate`, to
//! the CPU in f32 as this package, and to the CPU in f64 as
//! `relievo-shared-f64`, the judge of the f32 arithmetic. Section numbers in
//! these docs are those of the project's algorithm page; equation and
//! algorithm numbers are those of the paper (Chahdi, Ragragui, Halli, Satori:
//! "Per-pixel extrusion mapping with correct silhouettes", 2021).
//!
//! How data flows, one module a step:
//!
//! ```text
//! camera        pixel → ray
//! outline       triangle or prism → the pixels that may see it
//! facet         ray + triangle → weights, distance
//! surface       weights → normal, tangent frame, quadric, uv
//! path          surface + ray → where the ray is at s, in uv and depth (the tier)
//! prism         triangle → curved shell (the accurate tier)
//! profile       depth → radius by which the pattern is grown (the technique)
//! shape_map     uv → distance to the pattern
//! march         path × profile × shape map → hit; relief, paper: baselines
//! walk          prisms × profile × shape map → hit (the accurate tier)
//! normals       hit → normal and surface class
//! shadow        hit → lit or not
//! light         normal → colour
//! fragment      all of the above for one pixel and one triangle
//! shell         all of the above for one pixel and one prism (the accurate tier)
//! ```
//!
//! `kernels` lists the functions whose results on GPU and CPU are compared.
//!
//! # What may be called here
//!
//! Code that runs on both sides uses + − ×, comparisons, casts and the
//! functions of [`arithmetic`], and nothing else: no `/`, `%`, `sqrt`,
//! `mul_add`, `powf`, trigonometry, glam's `normalize` or `length`. Their
//! results are not the same on every device. `clippy.toml` lists the banned
//! methods, and a test of the workspace scans the sources for the operators.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod arithmetic;
pub mod camera;
pub mod contract;
pub mod facet;
pub mod facts;
pub mod fragment;
#[cfg(not(feature = "double"))]
pub mod kernels;
pub mod layout;
pub mod light;
pub mod march;
mod native;
pub mod normals;
pub mod outline;
pub mod paper;
pub mod path;
pub mod prism;
pub mod profile;
pub mod relief;
#[cfg(not(feature = "double"))]
pub mod rounding;
pub mod shadow;
pub mod shape_map;
pub mod shell;
pub mod surface;
pub mod walk;

/// The floating-point type of this build: f32, or f64 in `relievo-shared-f64`.
#[cfg(not(feature = "double"))]
pub type Real = f32;
/// The floating-point type of this build: f32, or f64 in `relievo-shared-f64`.
#[cfg(feature = "double")]
pub type Real = f64;

/// Two [`Real`]s: texture coordinates, texel coordinates, gradients of them.
#[cfg(not(feature = "double"))]
pub type Vec2 = glam::Vec2;
/// Two [`Real`]s: texture coordinates, texel coordinates, gradients of them.
#[cfg(feature = "double")]
pub type Vec2 = glam::DVec2;

/// Three [`Real`]s: positions and directions in object units, linear colours.
#[cfg(not(feature = "double"))]
pub type Vec3 = glam::Vec3;
/// Three [`Real`]s: positions and directions in object units, linear colours.
#[cfg(feature = "double")]
pub type Vec3 = glam::DVec3;

/// "Never", as a ray parameter: large, but not an infinity (section 4).
pub const FAR: Real = 1e30;
