//! The shaders of a project: which crates they are in, and whether the compiled modules
//! are those of the sources.
//!
//! A project names its shader crates in its `Cargo.toml` ([`Project`]). Compiled shaders are
//! committed, so that users need neither rust-gpu nor its nightly. Beside them lies a
//! manifest ([`Manifest`]), which the builder writes: the toolchain, and SHA-256 digests of
//! the modules and of all that decides them ([`source_digests`]). [`changes`] compares it
//! with the files.
//!
//! ```text
//! project       [package.metadata.relievo] of a project
//! manifest      the manifest's file
//! sources       digests of what decides the modules
//!   packages    the path dependencies of the shader crates
//!   lock        their locked dependencies
//!   inherited   what they inherit from their workspaces
//! changes       the manifest against the files
//! toolchain     the nightly
//! files         reads files
//! error         errors
//! ```

mod changes;
mod error;
mod files;
mod inherited;
mod lock;
mod manifest;
mod packages;
mod project;
mod sources;
mod toolchain;

#[cfg(test)]
mod tests;

pub use changes::{changed_modules, changed_sources, changes, module_files};
pub use error::ManifestError;
pub use manifest::{MANIFEST_FILE, Manifest, Module, Toolchain, digest};
pub use packages::target_folder;
pub use project::{Project, ShaderCrate};
pub use sources::source_digests;
pub use toolchain::{COMPONENTS, INSTALL, NIGHTLY, VERSION};
