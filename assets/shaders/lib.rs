//! The compiled shaders of relievo: a SPIR-V module for each entry point.
//!
//! `cargo relievo build` writes the modules; `manifest.toml` has their digests and
//! those of their sources. `registers.csv` has what a compiler for GPUs made of them
//! ([`Compiled`]).
//!
//! ```
//! const VERTEX: &[u8] = relievo_shaders::module("relievo_fast/vertex");
//! assert_eq!(VERTEX[..4], 0x0723_0203_u32.to_le_bytes());
//! ```
#![no_std]

mod compiled;

pub use compiled::{Compiled, REGISTERS};

/// Modules by folder and entry point.
const MODULES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/modules.rs"));

/// Returns the module `"folder/entry_point"` as the bytes of its `.spv` file. In a
/// constant, so that programs contain only the modules that they use.
///
/// # Panics
/// If there is no such module.
#[inline]
pub const fn module(name: &str) -> &'static [u8] {
    let mut index = 0;
    while index < MODULES.len() {
        let (known, bytes) = MODULES[index];
        if equal(known.as_bytes(), name.as_bytes()) {
            return bytes;
        }
        index += 1;
    }
    panic!("there is no such module");
}

/// Compares bytes in a constant, where `==` does not work.
const fn equal(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut index = 0;
    while index < a.len() {
        if a[index] != b[index] {
            return false;
        }
        index += 1;
    }
    true
}
