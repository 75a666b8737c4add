//! The extremes: what a scene may say at its limits, and what a ray may do.
//!
//! ```text
//! functions   any input of the functions' domains, and their borders
//! pictures    scenes at the limits, in every tier, on the CPU and on every GPU
//! scaling     a scene in other units is the same picture, bit for bit
//! continuity  a parameter that changes a little changes the picture a little
//! ```
//!
//! With the environment variable RELIEVO_LONG=1 there are more inputs, and maps
//! as large as they may be.

mod continuity;
mod functions;
mod material;
mod pictures;
mod scaling;
