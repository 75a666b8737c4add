//! A shader crate and its two variants.

use std::path::PathBuf;

/// The two ways to compile a shader crate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Variant {
    /// Optimised freely; refuses nothing.
    Fast,
    /// Gives the CPU's words.
    Exact,
}

impl Variant {
    /// Returns the name, as in folders.
    pub fn name(self) -> &'static str {
        match self {
            Variant::Fast => "fast",
            Variant::Exact => "exact",
        }
    }

    /// Describes how it is made.
    pub fn describe(self) -> &'static str {
        match self {
            // For any backend, through naga too.
            Variant::Fast => "optimised freely by spirv-opt",
            // Gives the CPU's words; passed to the driver untouched.
            Variant::Exact => {
                "division and square root corrected, every float operation NoContraction, then optimised; opcodes from an allow-list"
            }
        }
    }
}

/// A crate of shaders to compile.
#[derive(Clone, Debug)]
pub struct ShaderCrate {
    /// The folder of its `Cargo.toml`.
    pub folder: PathBuf,
    /// The features of both variants. The exact one has `corrected` besides.
    pub features: Vec<String>,
    /// The folder for what cargo builds.
    pub target_folder: PathBuf,
}
