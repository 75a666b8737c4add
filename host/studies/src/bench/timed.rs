//! Renderers that time frames.

use relievo::prepare::PreparedScene;
use relievo::render::gpu::{Adapter, Choice, Shaders};
use relievo::render::{CpuRenderer, GpuRenderer, RenderError, Renderer};
use relievo_shared::layout::Frame;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Selects a renderer.
#[derive(Clone, Copy)]
pub enum Backend<'a> {
    /// The CPU.
    Cpu,
    /// A GPU, with one of the shader modules.
    Gpu(&'a Adapter, Shaders),
}

/// Returns a renderer, or `None` where there is none or its buffers are too large.
///
/// # Errors
/// [`RenderError`] if the device fails otherwise.
pub(crate) fn fitting<T>(made: Option<Result<T, RenderError>>) -> Result<Option<T>, RenderError> {
    match made {
        None | Some(Err(RenderError::Limit { .. })) => Ok(None),
        Some(made) => made.map(Some),
    }
}

/// Source of frame times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// Device timestamps around the render pass.
    Device,
    /// Wall clock; on a GPU around recording, submitting and waiting.
    Wall,
}

impl Clock {
    /// Returns a description for tables.
    pub fn describe(self) -> &'static str {
        match self {
            Clock::Device => "the device's timestamps around the render pass",
            Clock::Wall => "wall clock around the whole frame",
        }
    }
}

/// Renderer that times frames.
pub enum Timed<'a> {
    /// The CPU.
    Cpu(Box<CpuRenderer<'a>>),
    /// A GPU.
    Gpu(Box<GpuRenderer>),
}

impl<'a> Timed<'a> {
    /// Creates a renderer of `scene`.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails or the scene does not fit.
    pub fn new(scene: &'a PreparedScene, backend: &Backend<'_>) -> Result<Timed<'a>, RenderError> {
        Ok(match backend {
            Backend::Cpu => Timed::Cpu(Box::new(CpuRenderer::new(scene))),
            Backend::Gpu(found, shaders) => Timed::Gpu(Box::new(GpuRenderer::new(
                scene,
                found,
                Choice::These(*shaders),
            )?)),
        })
    }

    /// Returns the renderer.
    pub fn renderer(&mut self) -> &mut dyn Renderer {
        match self {
            Timed::Cpu(renderer) => renderer.as_mut(),
            Timed::Gpu(renderer) => renderer.as_mut(),
        }
    }

    /// Draws the colours of `frame`; returns milliseconds and their source.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails.
    pub fn time(&mut self, frame: &Frame) -> Result<(f64, Clock), RenderError> {
        let (time, clock) = match self {
            Timed::Cpu(renderer) => {
                let start = Instant::now();
                renderer.color(frame)?;
                (start.elapsed(), Clock::Wall)
            }
            Timed::Gpu(renderer) => {
                let time = renderer.time_color(frame)?;
                match time.pass {
                    Some(pass) => (pass, Clock::Device),
                    None => (time.wall, Clock::Wall),
                }
            }
        };
        Ok((1e3 * time.as_secs_f64(), clock))
    }
}
