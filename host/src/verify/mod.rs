//! GPU words against CPU words: the same code must give the same.
//!
//! ```text
//! kernels    functions of the shared mathematics, one by one
//! agreement  two pictures of one frame
//! matrix     a scene in every tier with every technique
//! report     what was compared, on which device, and what differs
//! ```

pub mod agreement;
pub mod kernels;
pub mod matrix;
pub mod report;

pub use agreement::{Agreement, compare};
pub use report::{AdapterReport, ModuleReport, PictureReport, Report};
