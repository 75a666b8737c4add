//! Translates rust-gpu's SPIR-V with naga: for backends that do not take it, and to other
//! shading languages.
//!
//! [`portable`] reads SPIR-V and rewrites the loops that naga translates wrongly;
//! [`constants`] sets specialization constants; [`memory_model`] replaces the memory model;
//! `translate` (feature `export`) writes WGSL, GLSL, HLSL, Metal and SPIR-V.

pub mod constants;
pub mod memory_model;
pub mod portable;
pub mod spirv;
#[cfg(feature = "export")]
mod translate;

#[cfg(feature = "export")]
pub use translate::*;
