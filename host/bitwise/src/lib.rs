//! Runs the same functions on GPU and CPU and counts the words that differ.
//!
//! For rust-gpu projects whose functions must give the same bits in a shader
//! and on the CPU. Arguments are generated from their domains ([`generate`]) and
//! passed as u32 words in storage buffers, where nothing rounds or filters them
//! ([`runner`]). Results are compared word by word, without a tolerance
//! ([`compare`]).
//!
//! # Four steps
//!
//! **1. List the functions** once, in the crate that GPU and CPU share: name, type
//! and [`Domain`](relievo_kernel::Domain) of each argument, result, path.
//!
//! ```ignore
//! use relievo_kernel::{Domain, Kind};
//! pub const LENGTH: Domain = Domain::new("length", Kind::Magnitude { low: 1e-9, high: 1e9 });
//! pub const NORMAL: Domain = Domain::new("normal", Kind::UnitVector);
//!
//! #[macro_export]
//! macro_rules! for_each_kernel {
//!     ($with:ident) => {
//!         $with! {
//!             square(f32: $crate::LENGTH) -> f32 = $crate::square;
//!             reflect(Vec3: $crate::NORMAL, Vec3: $crate::NORMAL) -> Vec3 = $crate::reflect;
//!         }
//!     };
//! }
//! ```
//!
//! **2. Make a compute shader of each**, in the crate that rust-gpu compiles; it depends on
//! `spirv-std`, and on `relievo-kernel` with the feature `spirv`:
//!
//! ```ignore
//! #![cfg_attr(target_arch = "spirv", no_std)]
//! use my_shared::for_each_kernel;
//! use relievo_kernel::entry_points;
//!
//! for_each_kernel!(entry_points);
//! ```
//!
//! Decorate every float operation of the module with NoContraction, since drivers
//! fuse a·b + c otherwise, and check the module with spirv-val. For division, roots,
//! powers, exponential and trigonometric functions call those of `relievo-exact`, with
//! its feature `corrected` in the exact module: devices round their own differently.
//!
//! **3. Compare** in a test, on every adapter. Use `Module::untouched`, since naga
//! ([`Module::portable`]) drops NoContraction.
//!
//! ```no_run
//! use relievo_bitwise::{Module, Plan, Recorded, Runner, adapters, compare_kernel};
//! use relievo_kernel::{Domain, Kernel, Kind, table};
//! # const LENGTH: Domain = Domain::new("length", Kind::Magnitude { low: 1e-9, high: 1e9 });
//! # macro_rules! for_each_kernel {
//! #     ($with:ident) => { $with! { square(f32: LENGTH) -> f32 = |x: f32| x * x; } };
//! # }
//! const KERNELS: &[Kernel] = for_each_kernel!(table);
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
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
//! **4. See it fail.** Run the same comparison with a function that is wrong (a
//! constant changed by 1 ULP, `mul_add` in place of a·b + c) and require
//! differences.
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
mod memory_model;
pub mod module;
pub mod picture;
pub mod portable;
pub mod runner;
mod shrink;
mod spirv;
#[cfg(test)]
mod testing;
#[cfg(feature = "export")]
pub mod translate;

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
pub use shrink::shrink;
pub use wgpu;
