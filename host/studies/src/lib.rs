//! Measurements of Relievo itself.
//!
//! ```text
//! bench      frame times, and the paper's Table 1
//! bounds     errors of each f32 function against the same source in f64
//! distance   flicker, error and cost of a scene, from near to far away
//! edges      error and cost of smooth edges
//! geometry   the carving as plain triangles, beside the extrusions
//! gallery    the paper's figures as a page
//! lines      charts of lines on logarithmic axes
//! perceptual FLIP, the perceptual difference of two pictures
//! report     what a device does with the shaders: words, times, registers
//! tradeoff   cost and error of every variant of a scene, as a chart and a page
//! ```

pub mod bench;
pub mod bounds;
pub mod distance;
pub mod edges;
pub mod gallery;
pub mod geometry;
pub mod lines;
pub mod perceptual;
pub mod report;
pub mod tradeoff;
