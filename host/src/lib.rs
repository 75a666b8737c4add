//! Relievo: per-pixel extrusion mapping with correct silhouettes.
//!
//! A binary pattern is wrapped around a mesh and appears as carved geometry,
//! outline included, without one extra triangle. How data flows, each step a
//! module that can be used alone:
//!
//! ```text
//! scene      a TOML file → what is to be drawn, checked
//! limits     what a scene may take: memory, files
//! files      where it is read from: the disk, or memory
//! mesh       OBJ or glTF → triangles with tangent frames and curvature
//! prism      a mesh's curved prisms → plain data for the accurate tier
//! shape_map  image, drawing or text → signed distance to the pattern
//! prepare    all of these → plain data for a renderer
//! budget     scene with an error budget → the cheapest data that keeps it
//! render     data → words of a picture, on the CPU or on a GPU, by the same code
//! picture    words → PNG        aov  words → OpenEXR
//! shaders    the compiled shaders that draw an object
//! export     data → shaders in other languages, and what they read
//! overlay    the polygon mesh over a picture
//! oracle     reference hits in f64 → errors of a picture
//! verify     GPU words against CPU words
//! ```
//!
//! The mathematics stands in `relievo-shared`, and only there.

pub mod aov;
pub mod budget;
pub mod error;
#[cfg(feature = "gpu")]
pub mod explain;
#[cfg(feature = "export")]
pub mod export;
pub mod file;
pub mod files;
mod hierarchy;
pub mod limits;
pub mod mesh;
pub mod motion;
pub mod oracle;
pub mod overlay;
pub mod picture;
pub mod prepare;
pub mod prism;
pub mod render;
pub mod scene;
#[cfg(feature = "export")]
pub mod shaders;
pub mod shape_map;
mod srgb;
pub mod tone;
#[cfg(feature = "gpu")]
pub mod verify;

pub use error::Error;
pub use files::Files;
pub use limits::Limits;
