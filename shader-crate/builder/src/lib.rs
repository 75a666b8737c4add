//! Compiles crates of rust-gpu shaders to SPIR-V modules, one for each entry point.
//!
//! The exact variant gives the CPU's words on every device that rounds sums and products
//! as IEEE 754 requires. What is not exact is refused, with the place and with what to
//! write instead.
//!
//! ```text
//! folder        a project → the files of its shader folder
//! shader_crate  a crate and its variants
//! compile       a crate → modules
//!   rust_gpu    calls rust-gpu, and explains its errors
//!   exact       the exact variant: decorates, optimises, checks
//!     allowed   which operations it may contain
//!     panics    finds panics, and removes those that cannot happen
//!     sites     finds the places of what is refused
//!       debug   lines and source texts in a module
//!       packages  which file belongs to which package, and which may divide
//!   refusal     the message
//!     advice    what is wrong with an operation, and what to write instead
//!   arms        removes empty arms of selections
//!   words       SPIR-V as words
//! ```

pub mod advice;
pub mod allowed;
pub mod arms;
pub mod compile;
pub mod debug;
pub mod exact;
pub mod folder;
pub mod loops;
pub mod packages;
pub mod panics;
pub mod refusal;
pub mod rust_gpu;
pub mod shader_crate;
pub mod sites;
pub mod words;
