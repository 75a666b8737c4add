//! Compares the words of GPU and CPU, which must be equal for the exact shaders.
//!
//! ```text
//! kernels    functions of the shared mathematics, one by one
//! agreement  two renderings of a frame
//! matrix     a scene in every tier with every technique
//! report     results per device
//! tested     comparisons on one adapter
//! ```
//!
//! ```
//! use relievo::verify::{AdapterReport, ModuleReport, Report};
//! use relievo::render::gpu::{Shaders, adapters};
//!
//! let mut report = Report::default();
//! for adapter in adapters() {
//!     let mut of_adapter = AdapterReport::new(&adapter, None);
//!     of_adapter.modules.push(ModuleReport::new(Shaders::Exact));
//!     report.adapters.push(of_adapter);
//! }
//! assert!(report.broken().is_empty());
//! ```

pub mod agreement;
pub mod kernels;
pub mod matrix;
pub mod report;
pub mod tested;

pub use agreement::{Agreement, color_difference, compare};
pub use report::{AdapterReport, ModuleReport, PictureReport, Report};
pub use tested::Tested;
