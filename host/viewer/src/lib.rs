//! Interactive viewer: a scene to orbit, with a slider for every parameter.
//!
//! ```text
//! picture    pointer, keys      → camera; draws the picture
//! panel      widgets            → scene
//! controls   sliders for the parameters of a scene
//! orbit      camera motion
//! workshop   scene              → prepared scene, in the background
//! away       the same in a worker of a browser, by bytes
//! bench      the work itself
//! stage      prepared, camera   → words → screen, on the window's device
//! watch      finished work      → repaint
//! governor   frame times        → resolution in motion
//! present    words              → screen, on the GPU
//! display    words              → colours, also on the CPU
//! analysis   prepared, camera   → errors against the oracle, local depth
//! dropped    files that arrive  → scene
//! browse     files of the disk to open
//! history    scenes             → undo and redo
//! patterns   patterns to choose from
//! thumbnails patterns           → small pictures
//! presets    preset             → object
//! link       scene              ↔ fragment of an address
//! saving     scene, screen      → files
//! platform   desktop or browser
//! probe      state of the window as data
//! ```
//!
//! ```no_run
//! use relievo::scene::Scene;
//! use relievo_viewer::native::{Options, run};
//! use std::path::Path;
//!
//! # fn main() -> Result<(), relievo::Error> {
//! let options = Options {
//!     folder: "out".into(),
//!     adapter: None,
//!     size: [1200.0, 760.0],
//!     probe: None,
//! };
//! run(Scene::load(Path::new("torus.toml"))?, &options)
//! # }
//! ```

mod analysis;
#[cfg(feature = "worker")]
pub mod away;
mod bench;
#[cfg(not(target_arch = "wasm32"))]
mod browse;
mod controls;
pub mod display;
pub mod dropped;
mod governor;
mod history;
pub mod link;
#[cfg(not(target_arch = "wasm32"))]
pub mod native;
pub mod orbit;
mod panel;
mod patterns;
mod picture;
pub mod platform;
pub mod present;
mod presets;
pub mod probe;
mod saving;
pub mod stage;
mod thumbnails;
pub mod watch;
#[cfg(target_arch = "wasm32")]
pub mod web;
mod wireframe;
mod workshop;

use analysis::{Analysed, Analysis};
use bench::{Delivery, Order, Ready};
use display::{Scale, Show};
use dropped::Arrived;
use eframe::egui::{self, FontData, FontDefinitions, Ui};
use eframe::egui_wgpu;
use epaint_default_fonts::UBUNTU_LIGHT;
use governor::Governor;
use history::History;
use platform::Platform;
use present::Look;
use probe::{Collector, Probe};
use relievo::prepare::PreparedScene;
use relievo::scene::{Camera, Scene, Tier};
use relievo_bitwise::Device;
use relievo_shared::layout::Frame;
use saving::{Caption, Shot};
use stage::Stage;
use std::sync::Arc;
use std::time::Duration;
use thumbnails::Thumbnails;
use watch::Wake;
use web_time::Instant;
use wireframe::Wireframe;
use workshop::Workshop;

/// Time after the last change until the picture is drawn at full resolution.
const REST: Duration = Duration::from_millis(150);
/// Time after which to poll for an event that should have been reported.
const PATIENCE: Duration = Duration::from_millis(250);

/// A scene in a window.
pub struct Viewer {
    platform: Box<dyn Platform>,
    scene: Scene,
    selected: usize,
    /// Name of saved files, without an extension.
    name: String,
    camera: Option<Camera>,
    /// Tier shown beside the scene's own.
    compared: Option<Tier>,
    split: f32,
    show: Show,
    has_wireframe: bool,
    /// Shown in place of the picture once it rests.
    analysis: Option<Analysis>,

    workshop: Workshop,
    ordered: u64,
    shown: u64,
    prepared: Vec<Arc<PreparedScene>>,
    wireframe: Option<Wireframe>,

    stage: Stage,
    egui_renderer: Arc<egui::mutex::RwLock<egui_wgpu::Renderer>>,
    screen: Option<egui::TextureId>,
    governor: Governor,
    drawn: Option<Drawn>,
    moved: Instant,
    analysed: Option<egui::TextureHandle>,
    /// Number of the analysis in progress.
    analysing: Option<u64>,
    /// Number of the last analysis.
    analyses: u64,

    message: String,
    is_wrong: bool,
    /// Caption of a picture being rendered for a file.
    saving: Option<Caption>,
    shot: Shot,
    history: History,
    thumbnails: Thumbnails,
    dropped: Arrived,
    #[cfg(not(target_arch = "wasm32"))]
    browse: Option<browse::Browse>,
    started: Instant,
    probe: Probe,
    told: Probe,
}

/// Inputs that determine the picture on the screen.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    number: u64,
    camera: Camera,
    look: Look,
    size: [u32; 2],
}

/// Returns one font for all text.
fn fonts() -> FontDefinitions {
    const NAME: &str = "Ubuntu-Light";
    let mut fonts = FontDefinitions::empty();
    let data = FontData::from_static(UBUNTU_LIGHT);
    fonts.font_data.insert(NAME.to_string(), Arc::new(data));
    for family in fonts.families.values_mut() {
        family.push(NAME.to_string());
    }
    fonts
}

impl Viewer {
    /// Creates a viewer of `scene` on the device of `context`.
    ///
    /// # Errors
    /// There is no such device, or it fails.
    pub fn new(
        context: &eframe::CreationContext<'_>,
        scene: Scene,
        platform: Box<dyn Platform>,
        started: Instant,
    ) -> Result<Viewer, relievo::Error> {
        let state = context.wgpu_render_state.as_ref().ok_or_else(|| {
            relievo::render::RenderError::NoAdapter {
                wanted: "for the window".to_string(),
                found: "it is drawn without one".to_string(),
            }
        })?;
        let device = Device::shared(&state.adapter, state.device.clone(), state.queue.clone())
            .map_err(relievo::render::RenderError::from)?;
        let egui = context.egui_ctx.clone();
        egui.set_fonts(fonts());
        // A slow device draws for longer than egui lets a click take, 0.8 s.
        egui.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
        let wake: Wake = Arc::new(move || egui.request_repaint());
        let stage = Stage::new(device, wake.clone())?;
        let arrived = Arrived::new(wake.clone());
        let workers = platform.workers();
        let mut viewer = Viewer {
            name: saving::name(&scene.path),
            camera: scene.own_camera(),
            platform,
            scene,
            selected: 0,
            compared: None,
            split: 0.5,
            show: Show::Color,
            has_wireframe: false,
            analysis: None,
            thumbnails: Thumbnails::new(wake.clone()),
            workshop: Workshop::new(workers, wake),
            ordered: 0,
            shown: 0,
            prepared: Vec::new(),
            wireframe: None,
            stage,
            egui_renderer: state.renderer.clone(),
            screen: None,
            governor: Governor::default(),
            drawn: None,
            moved: started,
            analysed: None,
            analysing: None,
            analyses: 0,
            message: "Preparing the scene …".to_string(),
            is_wrong: false,
            saving: None,
            shot: Shot::default(),
            history: History::default(),
            dropped: arrived,
            #[cfg(not(target_arch = "wasm32"))]
            browse: None,
            started,
            probe: Probe::default(),
            told: Probe::default(),
        };
        viewer.order(false);
        Ok(viewer)
    }

    /// Orders the preparation of the current scene.
    fn order(&mut self, anew: bool) {
        self.ordered += 1;
        self.moved = Instant::now();
        // The workshop drops an earlier check.
        self.analysing = None;
        // It shows no time: tracks are kept for the file only.
        let mut scenes = vec![self.scene.without_tracks()];
        if let Some(tier) = self.compared {
            let mut other = scenes[0].clone();
            for object in &mut other.objects {
                object.budget = None;
                object.tier = tier;
                object.tidy();
            }
            scenes.push(other);
        }
        self.workshop.order(Order::Prepare {
            number: self.ordered,
            scenes,
            anew,
        });
    }

    /// Receives finished deliveries.
    fn receive(&mut self, context: &egui::Context) {
        while let Some(delivery) = self.workshop.delivery() {
            match delivery {
                Delivery::Prepared(number, Ok(scenes)) => self.show_scenes(number, scenes),
                Delivery::Prepared(number, Err(problem)) => {
                    // Keep what is shown; the next change may be better.
                    self.complain(problem);
                    self.shown = number;
                }
                Delivery::Analysed(number, analysed) => {
                    self.analysing = self.analysing.filter(|analysing| *analysing != number);
                    match analysed {
                        Ok(analysed) => self.show_analysed(context, number, &analysed),
                        Err(problem) => self.complain(problem),
                    }
                }
            }
        }
    }

    fn show_scenes(&mut self, number: u64, scenes: Vec<Ready>) {
        let all: Vec<&PreparedScene> = scenes.iter().map(|ready| &*ready.scene).collect();
        self.shown = number;
        self.drawn = None;
        if let Err(error) = self.stage.put(&all) {
            self.prepared.clear();
            return self.complain(error.to_string());
        }
        if let Some(Ready {
            scene: first,
            plans,
        }) = scenes.first()
        {
            self.camera.get_or_insert(first.camera);
            self.wireframe = Wireframe::of(first);
            let notes = plans.iter().map(String::as_str).chain(self.workshop.note());
            let notes: Vec<String> = notes.map(|note| format!("; {note}")).collect();
            self.say(format!(
                "{} triangles, prepared in {:.0} ms{}",
                first.triangle_count(),
                first.preparation.as_secs_f64() * 1e3,
                notes.concat()
            ));
        }
        self.prepared = scenes.into_iter().map(|ready| ready.scene).collect();
    }

    fn show_analysed(&mut self, context: &egui::Context, number: u64, analysed: &Analysed) {
        if number != self.analyses {
            return;
        }
        let picture = &analysed.picture;
        let size = [picture.width as usize, picture.height as usize];
        let image = egui::ColorImage::from_rgb(size, &picture.bytes);
        let nearest = egui::TextureOptions::NEAREST;
        self.analysed = Some(context.load_texture("analysis", image, nearest));
        self.say(analysed.text.clone());
    }

    fn say(&mut self, message: String) {
        (self.message, self.is_wrong) = (message, false);
    }

    fn complain(&mut self, message: String) {
        log::warn!("{message}");
        (self.message, self.is_wrong) = (message, true);
    }

    /// Returns whether something changed a moment ago.
    fn is_moving(&self) -> bool {
        self.moved.elapsed() < REST || self.ordered != self.shown
    }

    fn set_camera(&mut self, camera: Camera) {
        if self.camera != Some(camera) {
            self.camera = Some(camera);
            self.moved = Instant::now();
        }
    }

    /// Returns a frame of each scene from the camera, of `size` pixels.
    fn frames(&self, camera: &Camera, size: [u32; 2]) -> Vec<Frame> {
        let prepared = self.prepared.iter();
        prepared
            .map(|scene| scene.frame_from(&self.scene, camera, size))
            .collect()
    }

    /// Returns the display settings of pictures from `camera`.
    fn look(&self, camera: &Camera) -> Look {
        let first = self.prepared.first();
        Look {
            show: self.show,
            split: self.split,
            scale: first.map_or_else(Scale::default, |scene| Scale::of(scene, camera)),
            development: self.scene.development,
        }
    }

    /// Reports changes of state to the platform.
    fn tell(&mut self, context: &egui::Context, collector: Collector) {
        if !self.platform.listens() {
            return;
        }
        (self.probe.pointer, self.probe.is_pressed) = context.input(|input| {
            let place = input.pointer.latest_pos();
            (place.map(Into::into), input.pointer.any_down())
        });
        self.probe.controls = collector.into_controls();
        self.probe.is_preparing = self.ordered != self.shown;
        self.probe.message.clone_from(&self.message);
        self.probe.renderer = self.stage.describe().to_string();
        self.probe.scene = self.saved_scene().to_toml(self.platform.folder());
        if self.probe != self.told {
            self.platform.tell(&self.probe);
            self.told.clone_from(&self.probe);
        }
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        let collector = Collector::default();
        context.input(|input| self.history.record(&self.scene, input));
        self.read_dropped(&context);
        self.use_dropped();
        self.receive(&context);
        self.finish_picture();
        self.finish_shot(&context);
        egui::Panel::top("tools").show(ui, |ui| self.tools(ui, &collector));
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui, &collector));
        egui::Panel::right("controls")
            .default_size(340.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| self.panel(ui, &collector));
            });
        egui::CentralPanel::default().show(ui, |ui| self.picture(ui, &collector));
        #[cfg(not(target_arch = "wasm32"))]
        self.list_files(&context, &collector);
        self.tell(&context, collector);
    }
}
