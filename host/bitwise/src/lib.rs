//! Runs the same functions on GPU and CPU and counts the words that differ.
//!
//! For rust-gpu projects whose functions must give the same bits in a shader
//! and on the CPU. Arguments are generated from their domains ([`generate`]) and
//! passed as u32 words in storage buffers, where nothing rounds or filters them
//! ([`runner`]); pictures are drawn by vertex and fragment shaders ([`picture`]). Results are compared word by word, without a tolerance
//! ([`compare`]).
//!
//! Projects use it through `relievo-test`, in `cargo test`, and build their shaders with
//! `cargo relievo` (docs/testing.md). A program that compares by itself, as
//! `relievo verify` does:
//!
//! ```no_run
//! use relievo_bitwise::{Module, Plan, Recorded, Runner, adapters, compare_kernel};
//! use relievo_kernel::{Kernel, domain::NUMBER, table};
//!
//! const KERNELS: &[Kernel] = table! {
//!     square(f32: NUMBER) -> f32 = |x: f32| x * x;
//! };
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Untouched, since naga (`Module::portable`) drops NoContraction.
//! // SAFETY: spirv-val has checked it, and its accesses are within its buffers.
//! let module = unsafe { Module::untouched(&[&std::fs::read("kernels.spv")?])? };
//! let plan = Plan { inputs: 1 << 20, seed: 1, recorded: &Recorded::new() };
//! let all = adapters();
//! assert!(!all.is_empty(), "no adapter: nothing would be compared");
//! for adapter in all.iter().filter(|adapter| adapter.takes_spirv()) {
//!     let mut runner = Runner::new(&adapter.open()?, &module)?;
//!     for kernel in KERNELS {
//!         let tally = compare_kernel(&mut runner, kernel, &plan, &|_| ())?;
//!         assert!(tally.is_exact(), "{} on {}: {:?}", kernel.name, adapter.name(), tally.first);
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! At start-up, a program may compare a few kernels to find out whether a device is
//! exact ([`Signature`]).

pub mod adapter;
mod attempt;
pub mod canary;
pub mod check;
pub mod compare;
mod device;
mod error;
pub mod generate;
mod interface;
#[cfg(test)]
mod loops;
pub mod module;
pub mod picture;
pub mod runner;
mod shrink;
#[cfg(test)]
mod testing;

pub use adapter::{Adapter, adapters, choose, descriptor};
pub use attempt::attempt;
pub use canary::{Canary, Signature, Told};
pub use check::{Plan, compare_kernel, evaluate};
pub use compare::{Batch, Difference, Histogram, Tally, ulp_distance};
pub use device::Device;
pub use error::{DeviceError, TIME_LIMIT};
pub use generate::{Distribution, DomainError, Generator, Recorded, contains};
pub use module::{EntryPoint, Module, Route};
pub use picture::{Picture, Pixels};
pub use runner::{Pending, Runner};
pub use shrink::{kinds, shrink};
pub use wgpu;
