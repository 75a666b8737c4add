//! Renders a prepared scene, on the CPU or on a GPU: two renderers behind one
//! interface that run the same shared code and give the same words.
//!
//! A picture is kept as words, the bits of its f32, so that two pictures can be
//! compared exactly. [`GeometryWords`] decodes them per pixel, and [`Hits`]
//! adds what follows from scene and camera: position and object.
//!
//! ```
//! use relievo::prepare::prepare;
//! use relievo::render::{CpuRenderer, Hits, Renderer};
//! use relievo::scene::Scene;
//! use relievo::{Files, Limits};
//! use std::path::Path;
//!
//! let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let files = Files::memory([("quad.obj".into(), quad.as_bytes().into())]);
//! let text = r#"
//! image.size = [40, 30]
//! [[object]]
//! mesh = "quad.obj"
//! shape = { text = "A" }
//! projection = "planar-z"
//! "#;
//! let scene = Scene::parse_with(text, Path::new(""), &Limits::default(), files)?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let words = CpuRenderer::new(&prepared).geometry(&prepared.frame)?;
//! let hits = Hits::new(&prepared, &prepared.frame, &words);
//! let hit = hits.at(20, 15).expect("the quad is in the middle of the picture");
//! assert_eq!(hit.object(), Some(0));
//! // In the relief, between the surface at z = 0 and the floor below it.
//! assert!(hit.position().z < 1e-3 && hit.delta() <= 1.0);
//! # Ok::<(), relievo::Error>(())
//! ```

pub mod cpu;
mod error;
#[cfg(feature = "gpu")]
pub mod fallback;
mod found;
#[cfg(feature = "gpu")]
pub mod gpu;
mod hit;
mod placed;
mod shading;
mod space;
mod tile;
mod words;

pub use cpu::{CpuRenderer, RayStatistics};
pub use error::RenderError;
pub(crate) use error::allocate;
#[cfg(feature = "gpu")]
pub use fallback::FallbackRenderer;
#[cfg(feature = "gpu")]
pub use gpu::GpuRenderer;
pub use hit::{Class, Hit, Hits};
pub use words::{ColorWords, GeometryWords};

use crate::prepare::PreparedScene;
use relievo_shared::layout::Frame;
use relievo_shared::normals::CLASS_MISS;

/// Renders pictures of one prepared scene.
pub trait Renderer {
    /// Returns the renderer's name for a person: "CPU (2 threads)",
    /// "llvmpipe (Vulkan)".
    fn name(&self) -> String;

    /// Renders the colours of the scene in `frame`.
    ///
    /// # Errors
    /// [`RenderError`] if the machine fails.
    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError>;

    /// Renders what each pixel of `frame` hits.
    ///
    /// # Errors
    /// [`RenderError`] if the machine fails.
    fn geometry(&mut self, frame: &Frame) -> Result<GeometryWords, RenderError>;
}

/// Returns the background of `scene` as a pixel of [`ColorWords`].
fn background_words(scene: &PreparedScene) -> [u32; 4] {
    let [r, g, b] = scene.background.map(f32::to_bits);
    [r, g, b, CLASS_MISS]
}
