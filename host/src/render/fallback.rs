//! A renderer that falls back from a GPU to the CPU.
//!
//! ```no_run
//! use relievo::prepare::prepare;
//! use relievo::render::gpu::{Choice, choose};
//! use relievo::render::{FallbackRenderer, GpuRenderer, Renderer};
//! use relievo::scene::Scene;
//!
//! let scene = Scene::load("assets/scenes/torus.toml".as_ref())?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let gpu = GpuRenderer::new(&prepared, &choose(None)?, Choice::Trusted)?;
//! let mut renderer = FallbackRenderer::new(&prepared, gpu);
//! let colors = renderer.color(&prepared.frame)?;
//! # Ok::<(), relievo::Error>(())
//! ```

use super::Renderer;
use super::cpu::CpuRenderer;
use super::error::RenderError;
use super::gpu::GpuRenderer;
use super::words::{ColorWords, GeometryWords};
use crate::prepare::PreparedScene;
use relievo_shared::layout::Frame;

/// Renders on a GPU. Once the GPU fails (lost, hanging, out of memory), renders
/// that frame and all later ones on the CPU, and logs a warning.
pub struct FallbackRenderer<'a> {
    scene: &'a PreparedScene,
    renderer: Current<'a>,
}

enum Current<'a> {
    Gpu(Box<GpuRenderer>),
    Cpu(Box<CpuRenderer<'a>>),
}

impl<'a> FallbackRenderer<'a> {
    /// Starts with `gpu`, which was made for `scene`.
    pub fn new(scene: &'a PreparedScene, gpu: GpuRenderer) -> FallbackRenderer<'a> {
        FallbackRenderer {
            scene,
            renderer: Current::Gpu(Box::new(gpu)),
        }
    }

    fn draw<T>(
        &mut self,
        draw: impl Fn(&mut dyn Renderer) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let gpu = match &mut self.renderer {
            Current::Cpu(cpu) => return draw(cpu.as_mut()),
            Current::Gpu(gpu) => gpu,
        };
        let error = match draw(gpu.as_mut()) {
            Ok(words) => return Ok(words),
            Err(error) => error,
        };
        let mut cpu = Box::new(CpuRenderer::new(self.scene));
        log::warn!(
            "the GPU failed, and the {} draws instead: {error}",
            cpu.name()
        );
        let words = draw(cpu.as_mut());
        self.renderer = Current::Cpu(cpu);
        words
    }
}

impl Renderer for FallbackRenderer<'_> {
    fn name(&self) -> String {
        match &self.renderer {
            Current::Gpu(gpu) => gpu.name(),
            Current::Cpu(cpu) => cpu.name(),
        }
    }

    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError> {
        self.draw(|renderer| renderer.color(frame))
    }

    fn geometry(&mut self, frame: &Frame) -> Result<GeometryWords, RenderError> {
        self.draw(|renderer| renderer.geometry(frame))
    }
}
