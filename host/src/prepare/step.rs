//! Progress of the preparation.

use crate::scene::Shape;
use std::path::PathBuf;

/// A step of the work, for a progress bar.
#[derive(Clone, Debug)]
pub enum Step {
    /// Loads a mesh and fits its curvature.
    Mesh(PathBuf),
    /// Loads a pattern and computes its distance field; fraction done, 0…1.
    ShapeMap(Shape, f64),
    /// Plans how to draw the object of this name.
    Plan(String),
}
