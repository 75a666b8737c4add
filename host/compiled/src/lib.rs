//! Compiles SPIR-V with a Vulkan driver and returns what the driver says of the result:
//! registers, spills, instructions and, if asked, its intermediate forms and assembly
//! (`VK_KHR_pipeline_executable_properties`).
//!
//! Mesa's driver for AMD compiles for a GPU that is not there ([`Generation`]). It reads
//! the generation from environment variables, so each generation needs a process of its
//! own. Nothing is drawn.
//!
//! ```no_run
//! use relievo_compiled::{Driver, Shader, Texts};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let vertex = Shader::read(&std::fs::read("vertex.spv")?)?;
//! let fragment = Shader::read(&std::fs::read("color.spv")?)?;
//! let driver = Driver::open()?;
//! // SAFETY: spirv-val has checked both.
//! for made in unsafe { driver.compile(&[&vertex, &fragment], Texts::None)? } {
//!     println!("{:?}: {:?} registers", made.stage, made.statistic("VGPRs"));
//! }
//! # Ok(())
//! # }
//! ```
//!
//! [`assembly`] finds what is not exact in an assembly.

pub mod assembly;
mod driver;
mod generation;
mod spirv;

pub use assembly::Allowed;
pub use driver::{Driver, Executable, Texts};
pub use generation::{GENERATIONS, Generation, manifest};
pub use spirv::{Binding, Shader, Stage, Target};

/// Why a shader was not compiled.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not SPIR-V that this package can describe to a driver.
    #[error("not a module that can be compiled alone: {0}")]
    Module(String),
    /// There is no Vulkan.
    #[error("no Vulkan loader ({0}); install libvulkan1")]
    Loader(#[from] ash::LoadingError),
    /// A driver refused something.
    #[error("{0}: {1}")]
    Vulkan(&'static str, ash::vk::Result),
    /// There is no driver.
    #[error("no Vulkan device; install mesa-vulkan-drivers")]
    NoDevice,
}
