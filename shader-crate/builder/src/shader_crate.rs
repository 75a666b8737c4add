//! A shader crate and its variants.

use std::path::PathBuf;

/// The feature of crates that are compiled as [`Variant::Fused`], too.
pub const FUSED: &str = "fused";

/// The ways to compile a shader crate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Variant {
    /// Optimised freely; refuses nothing.
    Fast,
    /// Gives the CPU's words.
    Exact,
    /// The same on devices that fuse sums, with fewer instructions: for crates with a
    /// feature `fused`.
    Fused,
}

impl Variant {
    /// Returns the name, as in folders.
    pub fn name(self) -> &'static str {
        match self {
            Variant::Fast => "fast",
            Variant::Exact => "exact",
            Variant::Fused => "fused",
        }
    }

    /// Returns the features of its own.
    pub fn features(self) -> &'static [&'static str] {
        match self {
            Variant::Fast => &[],
            Variant::Exact => &["corrected"],
            Variant::Fused => &["corrected", FUSED],
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
            Variant::Fused => {
                "as the exact modules, with division and square root corrected by fused sums, for devices that have them"
            }
        }
    }
}

/// A crate of shaders to compile.
#[derive(Clone, Debug)]
pub struct ShaderCrate {
    /// The folder of its `Cargo.toml`.
    pub folder: PathBuf,
    /// The features of all variants. The exact ones have `corrected` besides, and `fused`.
    pub features: Vec<String>,
    /// The folder for what cargo builds.
    pub target_folder: PathBuf,
}
