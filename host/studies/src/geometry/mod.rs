//! The carving as plain triangles, which is what one would draw without Relievo: made,
//! drawn and measured beside the extrusions.
//!
//! The pattern's outlines are traced and simplified, each prism of the mesh is
//! triangulated with them, and cap, floor and walls are put where the accurate tier and its
//! oracle have them.

mod carve;
mod contour;
mod measure;
mod raster;
mod report;
mod trace;

pub use carve::{Carving, Vertex, contours};
pub use contour::Contours;
pub use measure::{Cell, ERROR_PX, GeometryError, Method, Row, Setting, check, measure, settings};
pub use raster::Raster;
pub use report::Comparison;
pub use trace::Tracer;
