//! Draws scenes on the window's device without blocking.

use super::present::{Look, Present, Screen};
use super::watch::{Wake, Watch};
use relievo::picture::Picture;
use relievo::prepare::PreparedScene;
use relievo::render::gpu::{
    Choice, Content, Device, Extent, GpuScene, Pipelines, Targets, Timestamps,
};
use relievo::render::{ColorWords, RenderError};
use relievo::scene::Development;
use relievo_shared::layout::Frame;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// Pipelines and the one or two scenes shown.
pub struct Stage {
    device: Device,
    description: String,
    pipelines: Pipelines,
    present: Present,
    panes: Vec<Pane>,
    screen: Option<Screen>,
    /// `None` if the device has no timestamps.
    timestamps: Option<Timestamps>,
    running: Option<Running>,
    last: Option<([u32; 2], Duration)>,
    saving: Option<Saving>,
    watch: Watch,
    wake: Wake,
}

struct Pane {
    scene: GpuScene,
    targets: Option<Targets>,
}

/// A submitted frame.
struct Running {
    size: [u32; 2],
    start: Instant,
    /// Completion time, or the error.
    done: Arc<OnceLock<Result<Instant, wgpu::BufferAsyncError>>>,
}

/// A picture being read back.
struct Saving {
    targets: Targets,
    factor: u32,
    development: Development,
    read: Arc<Mutex<Option<Result<(), String>>>>,
}

impl Stage {
    /// Creates a stage on `device` with the shaders that files are rendered
    /// with. `wake` is called when the device has finished something.
    ///
    /// # Errors
    /// [`RenderError`] if the device rejects the shaders.
    pub fn new(device: Device, wake: Wake) -> Result<Stage, RenderError> {
        let shaders = Choice::Trusted.on(&device)?;
        let pipelines = Pipelines::new(&device, &shaders.module()?);
        Ok(Stage {
            description: format!("{}, {}", device.describe(), shaders.describe()),
            present: Present::new(device.wgpu()),
            timestamps: Timestamps::of(&device),
            pipelines,
            watch: Watch::new(&device),
            wake,
            device,
            panes: Vec::new(),
            screen: None,
            running: None,
            last: None,
            saving: None,
        })
    }

    /// Returns the device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the names of device and shaders.
    pub fn describe(&self) -> &str {
        &self.description
    }

    /// Sets the scenes to draw, one or two.
    ///
    /// # Errors
    /// As [`GpuScene::new`].
    pub fn put(&mut self, scenes: &[&PreparedScene]) -> Result<(), RenderError> {
        let device = self.device.clone();
        let mut targets: Vec<_> = self.panes.drain(..).map(|pane| pane.targets).collect();
        targets.resize_with(scenes.len(), || None);
        for (scene, targets) in scenes.iter().zip(targets) {
            let (pipelines, description) = (&mut self.pipelines, &self.description);
            let scene =
                device.attempt(|| GpuScene::new(scene, pipelines, Extent::Needed, description))?;
            self.panes.push(Pane { scene, targets });
        }
        Ok(())
    }

    /// Returns the device memory of scenes and pictures, bytes.
    pub fn bytes(&self) -> u64 {
        let pane =
            |pane: &Pane| pane.scene.bytes() + pane.targets.as_ref().map_or(0, Targets::bytes);
        let screen = self.screen.as_ref().map_or(0, |screen| {
            4 * u64::from(screen.size[0]) * u64::from(screen.size[1])
        });
        self.panes.iter().map(pane).sum::<u64>() + screen
    }

    /// Returns whether the last frame is still being drawn.
    pub fn is_busy(&mut self) -> bool {
        let Some(running) = &self.running else {
            return false;
        };
        let Some(done) = running.done.get() else {
            return true;
        };
        if let Ok(end) = done {
            let clock = self.timestamps.as_ref().and_then(|timestamps| {
                let buffer = timestamps.buffer();
                let bytes = buffer.slice(..).get_mapped_range().ok()?;
                // The query of the last scene.
                Some(timestamps.duration(&bytes) * self.panes.len() as u32)
            });
            let wall = end.duration_since(running.start);
            self.last = Some((running.size, clock.unwrap_or(wall)));
        }
        if let Some(timestamps) = &self.timestamps {
            timestamps.buffer().unmap();
        }
        self.running = None;
        false
    }

    /// Returns size and time of the last finished frame, once. The time is from
    /// timestamps, or from the wall clock without them.
    pub fn finished(&mut self) -> Option<([u32; 2], Duration)> {
        self.last.take()
    }

    /// Submits a frame of each scene, all of one size, to the screen.
    /// [`Stage::is_busy`] reports its completion. Returns a view if the screen
    /// texture is new.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails.
    pub fn draw(
        &mut self,
        frames: &[Frame],
        look: &Look,
    ) -> Result<Option<&wgpu::TextureView>, RenderError> {
        let Some(first) = frames.first() else {
            return Ok(None);
        };
        let size = first.size.map(|side| side as u32);
        let device = self.device.clone();
        let is_new = device.attempt(|| self.submit(frames, size, look))?;
        Ok(self
            .screen
            .as_ref()
            .filter(|_| is_new)
            .map(|screen| &screen.view))
    }

    fn submit(
        &mut self,
        frames: &[Frame],
        size: [u32; 2],
        look: &Look,
    ) -> Result<bool, RenderError> {
        let content = look.show.content();
        let (device, queue) = (self.device.wgpu(), self.device.queue());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let count = self.panes.len();
        let clock = self.timestamps.as_ref();
        for (number, (pane, frame)) in self.panes.iter_mut().zip(frames).enumerate() {
            pane.scene.make(&mut self.pipelines, content)?;
            let kept = pane.targets.take().filter(|kept| kept.size() == size);
            let targets = pane.targets.insert(match kept {
                Some(targets) => targets,
                None => Targets::new(&self.device, size)?,
            });
            pane.scene
                .make_targets(&self.pipelines, targets, content, false);
            pane.scene.set_frame(queue, frame);
            pane.scene.record(
                &mut encoder,
                &self.pipelines,
                targets,
                content,
                clock.filter(|_| number + 1 == count),
            );
        }
        let is_new = self
            .screen
            .as_ref()
            .is_none_or(|screen| screen.size != size);
        if is_new {
            self.screen = Some(Screen::new(device, size));
        }
        let views: Vec<_> = self
            .panes
            .iter()
            .filter_map(|pane| pane.targets.as_ref())
            .map(|targets| [targets.view(0), targets.view(1)])
            .collect();
        if let (Some(screen), Some(left)) = (&self.screen, views.first()) {
            let right = views.last().unwrap_or(left);
            let split = if views.len() == 1 { 1.0 } else { look.split };
            let split = (split * size[0] as f32).round() as u32;
            self.present.record(
                device,
                queue,
                &mut encoder,
                &screen.view,
                [left, right],
                look,
                split,
            );
        }
        if let Some(timestamps) = clock {
            timestamps.resolve(&mut encoder);
        }
        let done = Arc::new(OnceLock::new());
        self.running = Some(Running {
            size,
            start: Instant::now(),
            done: done.clone(),
        });
        queue.submit([encoder.finish()]);
        let wake = self.wake.clone();
        let finish = move |result: Result<(), wgpu::BufferAsyncError>| {
            // Reported once only.
            let _ = done.set(result.map(|()| Instant::now()));
            wake();
        };
        match clock {
            Some(timestamps) => timestamps
                .buffer()
                .slice(..)
                .map_async(wgpu::MapMode::Read, finish),
            None => queue.on_submitted_work_done(move || finish(Ok(()))),
        }
        self.watch.begin();
        Ok(is_new)
    }

    /// Starts rendering the first scene for a file, with `factor`² samples per
    /// pixel. [`Stage::saved`] returns it.
    ///
    /// # Errors
    /// [`RenderError`] if the device fails.
    pub fn save(
        &mut self,
        frame: &Frame,
        factor: u32,
        development: Development,
    ) -> Result<(), RenderError> {
        let size = frame.size.map(|side| side as u32);
        let device = self.device.clone();
        let mut targets = Targets::new(&device, size)?;
        let Some(pane) = self.panes.first_mut() else {
            return Ok(());
        };
        let read = Arc::new(Mutex::new(None));
        let done = read.clone();
        let wake = self.wake.clone();
        device.attempt(|| {
            pane.scene
                .make_targets(&self.pipelines, &mut targets, Content::Color, true);
            pane.scene.set_frame(device.queue(), frame);
            let mut encoder = device
                .wgpu()
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            pane.scene.record(
                &mut encoder,
                &self.pipelines,
                &targets,
                Content::Color,
                None,
            );
            targets.record_read_back(&mut encoder, Content::Color);
            device.queue().submit([encoder.finish()]);
            if let Some(buffer) = targets.read_back(0) {
                buffer
                    .slice(..)
                    .map_async(wgpu::MapMode::Read, move |result| {
                        *done.lock().unwrap_or_else(PoisonError::into_inner) =
                            Some(result.map_err(|error| error.to_string()));
                        wake();
                    });
            }
            Ok::<_, RenderError>(())
        })?;
        self.saving = Some(Saving {
            targets,
            factor,
            development,
            read,
        });
        self.watch.begin();
        Ok(())
    }

    /// Returns the picture started by [`Stage::save`] once it is finished.
    pub fn saved(&mut self) -> Option<Result<Picture, RenderError>> {
        let saving = self.saving.take()?;
        let read = saving
            .read
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        match read {
            None => {
                self.saving = Some(saving);
                None
            }
            Some(Err(message)) => Some(Err(self.device.failed(message).into())),
            Some(Ok(())) => Some(self.develop(&saving)),
        }
    }

    fn develop(&self, saving: &Saving) -> Result<Picture, RenderError> {
        let Saving {
            targets,
            factor,
            development,
            ..
        } = saving;
        let nothing = || self.device.failed("nothing was drawn");
        let buffer = targets.read_back(0).ok_or_else(nothing)?;
        let words = {
            let bytes = buffer
                .slice(..)
                .get_mapped_range()
                .map_err(|error| self.device.failed(error))?;
            targets.words(&bytes)?
        };
        let [width, height] = targets.size();
        let words = ColorWords {
            width,
            height,
            words,
        };
        Picture::develop(&words, *factor, development)
    }
}

#[cfg(test)]
mod tests {
    use super::super::display::{self, Scale, Show};
    use super::*;
    use relievo::prepare::prepare;
    use relievo::render::gpu::adapters;
    use relievo::render::{CpuRenderer, Renderer};
    use relievo::scene::{Environment, Scene, Tier, Tone};
    use std::path::Path;

    /// Returns a torus in the fast tier, and one in the planar tier with smooth edges.
    fn tori() -> [PreparedScene; 2] {
        [torus(Tier::Fast, false), torus(Tier::Planar, true)]
    }

    fn torus(tier: Tier, has_smooth_edges: bool) -> PreparedScene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/torus.toml");
        let mut scene = Scene::load(&path).unwrap();
        // Not a multiple of the row alignment of buffers.
        scene.size = [97, 64];
        scene.objects[0].tier = tier;
        if has_smooth_edges {
            scene.environment = Some(Environment::default());
            scene.smooth_edges = true;
        }
        prepare(&scene, &|_| ()).unwrap()
    }

    /// Returns RGBA of each pixel of the screen.
    fn pixels(stage: &Stage) -> Vec<u8> {
        let screen = stage.screen.as_ref().unwrap();
        let [width, height] = screen.size;
        let stride = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let device = stage.device.wgpu();
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(stride * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            screen.view.texture().as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: None,
                },
            },
            screen.view.texture().size(),
        );
        stage.device.queue().submit([encoder.finish()]);
        let rows = |bytes: &[u8]| {
            let rows = bytes.chunks(stride as usize);
            rows.flat_map(|row| row[..4 * width as usize].to_vec())
                .collect()
        };
        stage.device.read(&buffer, buffer.size(), rows).unwrap()
    }

    fn expected(scene: &PreparedScene, look: &Look) -> Vec<u8> {
        let mut renderer = CpuRenderer::new(scene);
        match look.show.content() {
            Content::Color => {
                display::color_bytes(&renderer.color(&scene.frame).unwrap(), &look.development)
            }
            Content::Geometry => {
                let words = renderer.geometry(&scene.frame).unwrap();
                display::geometry_bytes(look.show, &words, &look.scale)
            }
        }
    }

    /// The device's `pow` may round differently.
    fn same(a: &[u8], b: &[u8], what: &str) {
        assert_eq!(a.len(), b.len());
        let far = a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 1);
        assert_eq!(far.count(), 0, "{what}");
    }

    #[test]
    fn gpu_the_screen_shows_what_display_says() {
        let scenes = tori();
        let all = adapters();
        assert!(!all.is_empty(), "no adapter on this machine");
        for adapter in all {
            let mut stage = Stage::new(adapter.open().unwrap(), Arc::new(|| ())).unwrap();
            if !stage.describe().contains("exact") {
                continue;
            }
            for split in [1.0, 0.25] {
                let shown = if split == 1.0 { 1 } else { 2 };
                let shown: Vec<_> = scenes.iter().take(shown).collect();
                stage.put(&shown).unwrap();
                let agx = Development {
                    exposure: 1.5,
                    tone: Tone::Agx,
                    is_transparent: false,
                };
                let plain = Show::ALL.map(|show| (show, Development::default()));
                for (show, development) in plain.into_iter().chain([(Show::Color, agx)]) {
                    let scale = Scale {
                        distances: [2.0, 6.0],
                        steps: 32.0,
                    };
                    let look = Look {
                        show,
                        split,
                        scale,
                        development,
                    };
                    stage.draw(&[scenes[0].frame; 2], &look).unwrap();
                    while stage.is_busy() {}
                    let (size, took) = stage.finished().unwrap();
                    assert!(size == [97, 64] && took > Duration::ZERO);
                    let seen = pixels(&stage);
                    let mut wanted = expected(&scenes[0], &look);
                    if split < 1.0 {
                        let right = expected(&scenes[1], &look);
                        for (row, other) in wanted.chunks_mut(4 * 97).zip(right.chunks(4 * 97)) {
                            row[4 * 24..].copy_from_slice(&other[4 * 24..]);
                        }
                    }
                    same(
                        &seen,
                        &wanted,
                        &format!("{show:?}, {split}, {development:?}, {}", stage.describe()),
                    );
                }
            }
        }
    }
}
