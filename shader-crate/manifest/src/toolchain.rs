//! The compiler that rust-gpu is a backend of.

/// The nightly that rust-gpu 0.11.0 is a backend of; as in the builder's
/// `rust-toolchain.toml`.
pub const NIGHTLY: &str = "nightly-2026-08-15";

/// What the builder needs of the nightly beside the compiler.
pub const COMPONENTS: [&str; 3] = ["rust-src", "rustc-dev", "llvm-tools"];

/// The command that installs the nightly.
pub const INSTALL: &str = "rustup toolchain install nightly-2026-08-15 --profile minimal -c rust-src -c rustc-dev -c llvm-tools";

/// The version of Relievo, whose builder makes the modules.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
