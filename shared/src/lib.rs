//! The mathematics of relievo, written once for shaders and CPU.
//!
//! The same files are compiled three times: to SPIR-V by `shader-crate`, to
//! the CPU in f32 as this package, and to the CPU in f64 as
//! `relievo-shared-f64`, the reference for the f32 arithmetic. "Section N" is
//! section N of `docs/algorithm.md`. Equation and algorithm numbers are those of
//! the paper (Chahdi, Ragragui, Halli, Satori: "Per-pixel extrusion mapping with
//! correct silhouettes", 2021).
//!
//! # Where to start
//!
//! A fragment shader calls, in this order, [`camera::pixel_ray`],
//! [`Model::meet`](model::Model::meet), [`Model::enter`](model::Model::enter),
//! [`trace::trace`] and [`trace::color`]; the CPU renderer calls the same. What
//! the vertex shader draws is the result of [`outline`].
//!
//! ```text
//! camera        pixel → ray
//! outline       triangle or prism → the pixels that may see it
//! trace         one pixel of one facet, from the ray to the colour
//! model         what a tier knows about the surface: one file a tier
//!   facet         ray + triangle → barycentrics, distance
//!   surface       barycentrics → normal, tangent frame, quadric, uv
//!   path          the ray in uv and depth, by the distance s
//!   prism         triangle → curved prism (accurate tier)
//! march         path × profile × shape map → hit, by safe steps
//!   walk          from prism to prism, a march in each (accurate tier)
//!   profile       r(δ): the radius of the pattern by depth — one file a profile
//!   shape_map     uv → distance to the pattern
//!   stack         several patterns in one march
//! normals       hit → surface class and normal
//! layers        the same in a stack
//! shadow        hit → lit or not
//! light         normal → colour
//! tangent       hit → tangent frame
//! intersection  ray of an engine → hit; hit → the surface there
//! gbuffer       hit → words, for materials and lights
//! far           pixels that show nothing but the mean of a pattern
//! openness      hit → how much of the sky it sees
//! shading       words → colour: what a scene with materials or lights needs
//!   material      class, coordinates → base colour, roughness, …
//!   image         coordinates → filtered value
//!   brdf          metallic-roughness
//!   lights        directional, point and spot lights
//!   shadow_map    position → how much of a light arrives
//!   environment   light from all directions
//! shaders       list of searches, tiers and shader entry points
//! techniques    list of techniques, with their profiles and parameters
//! facts         what specialised shaders know of an object
//! layout        structs that the host writes and both renderers read
//! kernels       list of functions whose results on GPU and CPU are compared
//! ```
//!
//! # Rules for this code
//!
//! Code that runs on both sides must give the same bits on every device, and
//! must pass through rust-gpu, spirv-opt and naga.
//!
//! **Arithmetic.** + − ×, comparisons, casts and the functions of [`arithmetic`] and
//! `relievo-exact`, and nothing else: no `/`, `%`, `sqrt`, `mul_add`, `powf`,
//! trigonometry, glam's `normalize` or `length`, whose results differ between
//! devices. A quotient of literals is a `const`: elsewhere the device computes it.
//! `clippy.toml` lists the banned methods, and `tests/sources.rs` scans the sources for
//! the operators.
//!
//! **Loops.** `while` with a counter or a flag; no `for`, `loop`, `break` or
//! `continue`, and no `return` from within a loop. A `for` is an iterator of
//! `Option`s in rust-gpu, enums that cost registers and instructions. A second exit
//! from the body makes rust-gpu's structurizer duplicate the rest of the body or
//! guard it by flags of its own, and gives the loop a `continuing` block, which
//! naga writes wrongly in GLSL, HLSL and MSL (gfx-rs/wgpu#4558): the portable
//! shaders rewrite such loops, and refuse a `continue` within a switch
//! (`host/bitwise/src/portable.rs`). Code that is needed twice in a loop is
//! written once and executed in separate iterations: what is inlined twice is in
//! the shader twice.
//!
//! **Functions.** `#[inline]`, small, generic over types known at compile time;
//! no recursion, no trait objects, no allocation, no panics but checks of debug
//! builds ([`contract`]). No `Option` or enum with data: results are structs or
//! tuples with a flag.
//!
//! **Data.** Layouts are structs of scalars and arrays, without padding. A value
//! that is stored or passed from stage to stage keeps the value [`contract`].
//!
//! **Macros.** None in expressions: `relievo-shared-variant` rewrites every
//! operation of these files and does not see into macros.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod arithmetic;
pub mod camera;
pub mod contract;
#[cfg(feature = "double")]
mod double;
#[cfg(not(feature = "double"))]
pub mod edge;
pub mod exit;
pub mod facet;
pub mod facts;
#[cfg(not(feature = "double"))]
pub mod far;
#[cfg(not(feature = "double"))]
pub mod gbuffer;
#[cfg(not(feature = "double"))]
pub mod intersection;
#[cfg(not(feature = "double"))]
pub mod kernels;
pub mod layers;
pub mod layout;
pub mod light;
pub mod march;
pub mod model;
pub mod normals;
#[cfg(not(feature = "double"))]
pub mod openness;
pub mod outline;
pub mod path;
pub mod prism;
pub mod profile;
mod quotients;
pub mod shaders;
#[cfg(not(feature = "double"))]
pub mod shading;
pub mod shadow;
pub mod shape_map;
pub mod stack;
pub mod surface;
#[cfg(not(feature = "double"))]
pub mod tangent;
pub mod techniques;
pub mod trace;
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
