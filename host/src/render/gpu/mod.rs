//! The renderer on a GPU, through wgpu.
//!
//! [`GpuRenderer`] renders to words and waits for the device. [`GpuScene`],
//! [`Pipelines`] and [`Targets`] never wait: a window draws with them.
//!
//! ```no_run
//! use relievo::prepare::prepare;
//! use relievo::render::gpu::{Choice, choose};
//! use relievo::render::{GpuRenderer, Renderer};
//! use relievo::scene::Scene;
//!
//! let scene = Scene::load("assets/scenes/torus.toml".as_ref())?;
//! let prepared = prepare(&scene, &|_| ())?;
//! let mut renderer = GpuRenderer::new(&prepared, &choose(None)?, Choice::Trusted)?;
//! let colors = renderer.color(&prepared.frame)?;
//! # Ok::<(), relievo::Error>(())
//! ```

mod content;
mod error;
mod lit;
mod memory;
mod outlines;
mod pipelines;
mod scene;
mod shaders;
mod shared;
mod targets;
mod timestamps;

pub use crate::shaders::{EntryPoints, Extent, Facets};
pub use content::Content;
pub(crate) use content::Pass;
pub use memory::{Memory, Pictures};
pub use pipelines::Pipelines;
pub use relievo_bitwise::{Adapter, Device, Module, Signature, TIME_LIMIT, adapters, choose};
pub use scene::GpuScene;
pub use shaders::{Choice, Shaders, canaries, signature};
pub use targets::Targets;

use super::Renderer;
use super::error::RenderError;
use super::words::{ColorWords, GeometryWords};
use crate::prepare::PreparedScene;
use relievo_shared::layout::Frame;
use std::time::{Duration, Instant};
pub use timestamps::Timestamps;

/// Renders one scene on a GPU. Buffers and pipelines are made once; a frame
/// writes its camera and draws.
pub struct GpuRenderer {
    description: String,
    device: Device,
    pipelines: Pipelines,
    extent: Extent,
    scene: GpuScene,
    /// Kept while the size of the frames stays the same.
    targets: Option<Targets>,
    /// `None` if the adapter has no timestamps.
    timestamps: Option<Timestamps>,
}

/// Time of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameTime {
    /// From recording the commands to the end of waiting, by the host's clock.
    pub wall: Duration,
    /// The render passes alone, by the device's clock; `None` if it has none.
    pub pass: Option<Duration>,
}

impl GpuRenderer {
    /// Uploads `scene` to the device of `adapter`, with the shaders of `choice`.
    ///
    /// # Errors
    /// [`RenderError::Device`], or [`RenderError::Limit`] if the scene is too large.
    pub fn new(
        scene: &PreparedScene,
        adapter: &Adapter,
        choice: Choice,
    ) -> Result<GpuRenderer, RenderError> {
        GpuRenderer::with_extent(scene, adapter, choice, Extent::Needed)
    }

    /// As [`GpuRenderer::new`], with shaders of this `extent`.
    ///
    /// # Errors
    /// As [`GpuRenderer::new`].
    pub fn with_extent(
        scene: &PreparedScene,
        adapter: &Adapter,
        choice: Choice,
        extent: Extent,
    ) -> Result<GpuRenderer, RenderError> {
        let device = adapter.open()?;
        let shaders = choice.on(&device)?;
        let module = shaders.module()?;
        GpuRenderer::on(scene, device, &module, shaders.describe(), extent)
    }

    /// As [`GpuRenderer::new`], with a custom module that has the same entry points
    /// and bindings; `name` describes it to a person.
    ///
    /// # Errors
    /// As [`GpuRenderer::new`].
    pub fn with_module(
        scene: &PreparedScene,
        adapter: &Adapter,
        module: &Module,
        name: &str,
    ) -> Result<GpuRenderer, RenderError> {
        GpuRenderer::on(scene, adapter.open()?, module, name, Extent::Needed)
    }

    fn on(
        scene: &PreparedScene,
        opened: Device,
        module: &Module,
        name: &str,
        extent: Extent,
    ) -> Result<GpuRenderer, RenderError> {
        let device = opened.clone();
        device.attempt(|| GpuRenderer::put(scene, opened, module, name, extent))
    }

    /// The body of [`GpuRenderer::on`].
    fn put(
        scene: &PreparedScene,
        opened: Device,
        module: &Module,
        name: &str,
        extent: Extent,
    ) -> Result<GpuRenderer, RenderError> {
        let description = format!("{}, {name}", opened.describe());
        let mut pipelines = Pipelines::new(&opened, module);
        let scene = GpuScene::new(scene, &mut pipelines, extent, &description)?;
        let timestamps = Timestamps::of(&opened);
        Ok(GpuRenderer {
            description,
            device: opened,
            pipelines,
            extent,
            scene,
            targets: None,
            timestamps,
        })
    }

    /// Replaces the scene, and keeps the device and the pipelines: a driver compiles only the shaders
    /// that no earlier scene has needed. The device holds both scenes until the new one is uploaded.
    ///
    /// # Errors
    /// As [`GpuRenderer::new`]; the earlier scene stays.
    pub fn set_scene(&mut self, scene: &PreparedScene) -> Result<(), RenderError> {
        let device = self.device.clone();
        let (pipelines, description) = (&mut self.pipelines, &self.description);
        self.scene =
            device.attempt(|| GpuScene::new(scene, pipelines, self.extent, description))?;
        Ok(())
    }

    /// Returns the device. Once it is lost or destroyed, every later frame is an
    /// error.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the bytes of the scene's buffers and of the last pictures on the
    /// device; [`Memory::of`] predicts them.
    pub fn bytes(&self) -> u64 {
        self.scene.bytes() + self.targets.as_ref().map_or(0, Targets::bytes)
    }

    /// Renders `frame`, waits for the device, and returns the time; nothing is
    /// read back.
    ///
    /// # Errors
    /// As [`Renderer::color`].
    pub fn time_color(&mut self, frame: &Frame) -> Result<FrameTime, RenderError> {
        let start = Instant::now();
        self.draw(frame, Content::Color, false)?;
        let wall = start.elapsed();
        let pass = match &self.timestamps {
            Some(timestamps) => {
                let buffer = timestamps.buffer();
                Some(
                    self.device
                        .read(buffer, buffer.size(), |bytes| timestamps.duration(bytes))?,
                )
            }
            None => None,
        };
        Ok(FrameTime { wall, pass })
    }

    fn draw(
        &mut self,
        frame: &Frame,
        content: Content,
        read_back: bool,
    ) -> Result<(), RenderError> {
        let device = self.device.clone();
        let drawn = device.attempt(|| self.submit(frame, content, read_back));
        if drawn.is_err() {
            // The targets may have exhausted the device's memory.
            self.targets = None;
        }
        drawn
    }

    /// Renders, and waits for the device.
    fn submit(
        &mut self,
        frame: &Frame,
        content: Content,
        read_back: bool,
    ) -> Result<(), RenderError> {
        self.scene.make(&mut self.pipelines, content)?;
        let size = frame.size.map(|side| side as u32);
        let kept = self.targets.take().filter(|kept| kept.size() == size);
        let mut targets = match kept {
            Some(targets) => targets,
            None => Targets::new(&self.device, size)?,
        };
        self.scene
            .make_targets(&self.pipelines, &mut targets, content, read_back);
        self.scene.set_frame(self.device.queue(), frame);
        // Only measurements read nothing back.
        let timestamps = self.timestamps.as_ref().filter(|_| !read_back);
        let mut encoder = self
            .device
            .wgpu()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.scene
            .record(&mut encoder, &self.pipelines, &targets, content, timestamps);
        if read_back {
            targets.record_read_back(&mut encoder, content);
        }
        if let Some(timestamps) = timestamps {
            timestamps.resolve(&mut encoder);
        }
        self.device.queue().submit([encoder.finish()]);
        self.device.wait()?;
        self.targets = Some(targets);
        Ok(())
    }

    /// Returns the words of target `index`.
    fn read(&self, index: usize) -> Result<Vec<[u32; 4]>, RenderError> {
        let nothing = || self.device.failed("nothing was drawn");
        let targets = self.targets.as_ref().ok_or_else(nothing)?;
        let buffer = targets.read_back(index).ok_or_else(nothing)?;
        self.device
            .read(buffer, buffer.size(), |bytes| targets.words(bytes))?
    }
}

impl Renderer for GpuRenderer {
    fn name(&self) -> String {
        self.description.clone()
    }

    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError> {
        self.draw(frame, Content::Color, true)?;
        Ok(ColorWords {
            width: frame.size[0] as u32,
            height: frame.size[1] as u32,
            words: self.read(0)?,
        })
    }

    fn geometry(&mut self, frame: &Frame) -> Result<GeometryWords, RenderError> {
        self.draw(frame, Content::Geometry, true)?;
        Ok(GeometryWords {
            width: frame.size[0] as u32,
            height: frame.size[1] as u32,
            place: self.read(0)?,
            surface: self.read(1)?,
        })
    }
}
