//! Scenes and rays at the limits of their ranges.
//!
//! ```text
//! functions   any input of the functions' domains, and their borders
//! pictures    scenes at the limits, in every tier, on the CPU and on every GPU
//! scaling     a scene in other units is the same picture, bit for bit
//! continuity  a parameter that changes a little changes the picture a little
//! ```
//!
//! With the environment variable RELIEVO_LONG=1 there are more inputs, and maps
//! of the largest size.

mod continuity;
mod functions;
mod material;
mod pictures;
mod scaling;
