//! A GPU as long as it works, and the CPU from then on.

use super::{ColorWords, CpuRenderer, GeometryWords, GpuRenderer, RenderError, Renderer};
use crate::prepare::PreparedScene;
use relievo_shared::layout::Frame;

/// Draws on a GPU. Once that fails (it is lost, hangs, has not the memory), the
/// frame is drawn again on the CPU, with a warning, and so is each later one.
pub struct FallbackRenderer<'a> {
    scene: &'a PreparedScene,
    renderer: Current<'a>,
}

enum Current<'a> {
    Gpu(Box<GpuRenderer>),
    Cpu(CpuRenderer<'a>),
}

impl<'a> FallbackRenderer<'a> {
    /// Begins with `gpu`, which was made for `scene`.
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
            Current::Cpu(cpu) => return draw(cpu),
            Current::Gpu(gpu) => gpu,
        };
        let error = match draw(gpu.as_mut()) {
            Ok(words) => return Ok(words),
            Err(error) => error,
        };
        let mut cpu = CpuRenderer::new(self.scene);
        tracing::warn!(
            "the GPU failed, and the {} draws instead: {error}",
            cpu.name()
        );
        let words = draw(&mut cpu);
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
