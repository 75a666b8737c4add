//! Measurements of Relievo itself.
//!
//! ```text
//! bench      frame times, and the paper's Table 1
//! bounds     errors of each f32 function against the same source in f64
//! gallery    the paper's figures as a page
//! tradeoff   cost and error of every variant of a scene, as a chart and a page
//! ```

pub mod bench;
pub mod bounds;
pub mod gallery;
pub mod tradeoff;
