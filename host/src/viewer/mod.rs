//! The viewer: a scene that can be turned, and every parameter under a slider.
//!
//! ```text
//! controls   sliders            → the scene
//! orbit      pointer and keys   → the camera
//! workshop   the scene          → prepared, beside the window
//! stage      prepared, camera   → words → the screen, by the window's own device
//! watch      the device is done → the window looks again
//! governor   how long that took → how large the next picture in motion is
//! present    words → the screen
//! display    what of the words that is, also on the CPU
//! judge      prepared, camera   → how wrong it is
//! dropped    files of a person  → the scene
//! saving     scene, screen      → files
//! platform   desktop or browser: where files go
//! probe      what is on the window, as data
//! ```

mod controls;
pub mod display;
pub mod dropped;
mod governor;
mod judge;
#[cfg(not(target_arch = "wasm32"))]
pub mod native;
pub mod orbit;
pub mod platform;
pub mod present;
pub mod probe;
mod saving;
pub mod stage;
pub mod watch;
#[cfg(target_arch = "wasm32")]
pub mod web;
mod wireframe;
mod workshop;

use crate::prepare::PreparedScene;
use crate::scene::{Camera, Scene, Tier};
use controls::Controls;
use display::{Scale, Show};
use dropped::Arrived;
use eframe::egui::emath::GuiRounding as _;
use eframe::egui::{self, Key, Modifiers, Rect, Sense, ThemePreference, Ui, Vec2, vec2};
use eframe::egui_wgpu;
use governor::Governor;
use judge::Judgement;
use platform::Platform;
use present::Look;
use probe::{Collector, Probe};
use relievo_bitwise::Device;
use relievo_shared::layout::Frame;
use saving::{Caption, Shot};
use stage::Stage;
use std::sync::Arc;
use std::time::Duration;
use watch::Wake;
use web_time::Instant;
use wireframe::Wireframe;
use workshop::{Delivery, Order, Workshop};

/// How long after the last change the picture is drawn at full resolution.
const REST: Duration = Duration::from_millis(150);
/// When to ask for what should have been told.
const PATIENCE: Duration = Duration::from_millis(250);
/// The longest side of a picture on the screen, pixels.
const LARGEST_SCREEN: f32 = 4096.0;
/// Radians that an arrow key turns the camera by, and shares of the picture
/// that it moves it by.
const KEY_TURN: f64 = 0.1;

/// A scene in a window.
pub struct Viewer {
    platform: Box<dyn Platform>,
    scene: Scene,
    selected: usize,
    /// The name of saved files, without an ending.
    name: String,
    camera: Option<Camera>,
    /// The tier that is shown beside the scene's own.
    compared: Option<Tier>,
    split: f32,
    show: Show,
    has_wireframe: bool,
    is_judged: bool,

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
    judgement: Option<egui::TextureHandle>,
    /// The number of the picture that is being judged.
    judging: Option<u64>,
    judged: u64,

    message: String,
    is_wrong: bool,
    /// A picture for a file is being drawn.
    saving: Option<Caption>,
    shot: Shot,
    dropped: Arrived,
    started: Instant,
    probe: Probe,
    told: Probe,
}

/// All that a picture on the screen follows from.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    number: u64,
    camera: Camera,
    look: Look,
    size: [u32; 2],
}

impl Viewer {
    /// Shows `scene` with the device of `context`.
    ///
    /// # Errors
    /// Where there is no such device, or it fails.
    pub fn new(
        context: &eframe::CreationContext<'_>,
        scene: Scene,
        platform: Box<dyn Platform>,
        started: Instant,
    ) -> Result<Viewer, crate::Error> {
        let state = context.wgpu_render_state.as_ref().ok_or_else(|| {
            crate::render::RenderError::NoAdapter {
                wanted: "for the window".to_string(),
                found: "it is drawn without one".to_string(),
            }
        })?;
        let device = Device::shared(&state.adapter, state.device.clone(), state.queue.clone())
            .map_err(crate::render::RenderError::from)?;
        let egui = context.egui_ctx.clone();
        let wake: Wake = Arc::new(move || egui.request_repaint());
        let stage = Stage::new(device, wake.clone())?;
        let stem = scene.path.file_stem().unwrap_or_default().to_string_lossy();
        let mut viewer = Viewer {
            name: format!("{stem}-view"),
            camera: scene.camera,
            platform,
            scene,
            selected: 0,
            compared: None,
            split: 0.5,
            show: Show::Color,
            has_wireframe: false,
            is_judged: false,
            workshop: Workshop::new(wake),
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
            judgement: None,
            judging: None,
            judged: 0,
            message: "Preparing the scene …".to_string(),
            is_wrong: false,
            saving: None,
            shot: Shot::default(),
            dropped: Arrived::default(),
            started,
            probe: Probe::default(),
            told: Probe::default(),
        };
        viewer.order(false);
        Ok(viewer)
    }

    /// Has the scene prepared as it is now.
    fn order(&mut self, anew: bool) {
        self.ordered += 1;
        self.moved = Instant::now();
        // The workshop forgets what was to be judged before this.
        self.judging = None;
        let mut scenes = vec![self.scene.clone()];
        if let Some(tier) = self.compared {
            let mut other = self.scene.clone();
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

    /// Takes what the workshop has made.
    fn receive(&mut self, context: &egui::Context) {
        while let Some(delivery) = self.workshop.delivery() {
            match delivery {
                Delivery::Prepared(number, Ok(scenes)) => self.show_scenes(number, scenes),
                Delivery::Prepared(number, Err(problem)) => {
                    // What is shown stays; the next change may be better.
                    self.complain(problem);
                    self.shown = number;
                }
                Delivery::Judged(number, judged) => {
                    self.judging = self.judging.filter(|judging| *judging != number);
                    match judged {
                        Ok(judgement) => self.show_judgement(context, number, &judgement),
                        Err(problem) => self.complain(problem),
                    }
                }
            }
        }
    }

    fn show_scenes(&mut self, number: u64, scenes: Vec<Arc<PreparedScene>>) {
        let all: Vec<&PreparedScene> = scenes.iter().map(Arc::as_ref).collect();
        self.shown = number;
        self.drawn = None;
        if let Err(error) = self.stage.put(&all) {
            self.prepared.clear();
            return self.complain(error.to_string());
        }
        if let Some(first) = scenes.first() {
            self.camera.get_or_insert(first.camera);
            self.wireframe = Wireframe::of(first);
            let plans = first
                .objects
                .iter()
                .filter_map(|object| object.plan.as_ref());
            let plans: Vec<String> = plans.map(|plan| format!("; {plan}")).collect();
            self.say(format!(
                "{} triangles, prepared in {:.0} ms{}",
                first.triangle_count(),
                first.preparation.as_secs_f64() * 1e3,
                plans.concat()
            ));
        }
        self.prepared = scenes;
    }

    fn show_judgement(&mut self, context: &egui::Context, number: u64, judgement: &Judgement) {
        if number != self.judged {
            return;
        }
        let picture = &judgement.picture;
        let size = [picture.width as usize, picture.height as usize];
        let image = egui::ColorImage::from_rgb(size, &picture.bytes);
        let nearest = egui::TextureOptions::NEAREST;
        self.judgement = Some(context.load_texture("error", image, nearest));
        self.say(judgement.text.clone());
    }

    fn say(&mut self, message: String) {
        (self.message, self.is_wrong) = (message, false);
    }

    fn complain(&mut self, message: String) {
        tracing::warn!("{message}");
        (self.message, self.is_wrong) = (message, true);
    }

    /// Whether something has changed a moment ago.
    fn is_moving(&self) -> bool {
        self.moved.elapsed() < REST || self.ordered != self.shown
    }

    fn set_camera(&mut self, camera: Camera) {
        if self.camera != Some(camera) {
            self.camera = Some(camera);
            self.moved = Instant::now();
        }
    }

    /// The picture's frame from the camera, with `size` pixels.
    fn frames(&self, camera: &Camera, size: [u32; 2]) -> Vec<Frame> {
        let prepared = self.prepared.iter();
        prepared
            .map(|scene| scene.frame_from(&self.scene, camera, size))
            .collect()
    }

    /// How pictures from `camera` are shown.
    fn look(&self, camera: &Camera) -> Look {
        let first = self.prepared.first();
        Look {
            show: self.show,
            split: self.split,
            scale: first.map_or_else(Scale::default, |scene| Scale::of(scene, camera)),
        }
    }

    /// Whether the last frame is not done yet; learns from it when it is.
    fn is_busy(&mut self) -> bool {
        let is_busy = self.stage.is_busy();
        if let Err(error) = self.stage.device().alive()
            && !self.is_wrong
        {
            self.complain(error.to_string());
        }
        if let Some((size, took)) = self.stage.finished() {
            self.probe.frame_ms = took.as_secs_f64() * 1e3;
            self.probe.frame_size = size;
            self.governor.learn(size, took);
            let since = self.started.elapsed();
            let first = &mut self.probe.first_picture_ms;
            first.get_or_insert(since.as_secs_f64() * 1e3);
        }
        is_busy
    }

    /// Draws what is to be seen in a picture of `full` pixels, if it is not on
    /// the screen.
    fn draw(&mut self, full: [u32; 2], is_moving: bool) {
        let is_busy = self.is_busy();
        let Some(camera) = self.camera else { return };
        if self.prepared.is_empty() || is_busy {
            return;
        }
        let size = if is_moving {
            self.governor.size(full)
        } else {
            full
        };
        let wanted = Drawn {
            number: self.shown,
            camera,
            look: self.look(&camera),
            size,
        };
        if self.drawn.as_ref() == Some(&wanted) {
            return;
        }
        let frames = self.frames(&camera, size);
        let device = self.stage.device().clone();
        match self.stage.draw(&frames, &wanted.look) {
            Ok(Some(view)) => {
                let mut renderer = self.egui_renderer.write();
                let filter = wgpu::FilterMode::Linear;
                let device = device.wgpu();
                match self.screen {
                    Some(id) => {
                        renderer.update_egui_texture_from_wgpu_texture(device, view, filter, id);
                    }
                    None => {
                        self.screen = Some(renderer.register_native_texture(device, view, filter));
                    }
                }
            }
            Ok(None) => {}
            Err(error) => return self.complain(error.to_string()),
        }
        self.probe.frames += 1;
        self.drawn = Some(wanted);
    }

    /// Whether the screen shows all that was asked for.
    fn is_settled(&self, full: [u32; 2], is_moving: bool) -> bool {
        !is_moving
            && self.saving.is_none()
            && self.drawn.as_ref().is_some_and(|drawn| {
                drawn.size == full
                    && Some(drawn.camera) == self.camera
                    && drawn.number == self.shown
                    && drawn.look == self.look(&drawn.camera)
            })
    }

    fn keys(&mut self, ui: &Ui, on_picture: bool) {
        let pressed = |modifiers, key| ui.input_mut(|input| input.consume_key(modifiers, key));
        if pressed(Modifiers::COMMAND, Key::S) {
            self.save_scene();
        }
        // Before the shorter one, which takes it as well.
        if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::P) {
            self.save_shown();
        }
        if pressed(Modifiers::COMMAND, Key::P) {
            self.save_picture();
        }
        if pressed(Modifiers::NONE, Key::F5) {
            self.order(true);
        }
        let Some(camera) = self.camera.filter(|_| on_picture) else {
            return;
        };
        let field_of_view = self.scene.field_of_view;
        let mut camera = camera;
        ui.input(|input| {
            let count = |key| input.num_presses(key) as f64;
            let right = count(Key::ArrowRight) - count(Key::ArrowLeft);
            let up = count(Key::ArrowUp) - count(Key::ArrowDown);
            if right != 0.0 || up != 0.0 {
                camera = if input.modifiers.shift {
                    orbit::pan(&camera, KEY_TURN * right, KEY_TURN * up, field_of_view)
                } else {
                    orbit::orbit(&camera, KEY_TURN * right, KEY_TURN * up)
                };
            }
            let nearer = count(Key::Plus) + count(Key::Equals) - count(Key::Minus);
            if nearer != 0.0 {
                camera = orbit::zoom(&camera, 1.1f64.powf(nearer));
            }
            if input.key_pressed(Key::Home)
                && let Some(first) = self.prepared.first()
            {
                camera = first.camera;
            }
        });
        self.set_camera(camera);
    }

    /// Turns, moves and zooms by what the pointer did on the picture.
    fn point(&mut self, ui: &Ui, response: &egui::Response, height: f32) {
        let Some(camera) = self.camera else { return };
        let field_of_view = self.scene.field_of_view;
        let drag = response.drag_delta();
        let share = |points: f32| f64::from(points / height.max(1.0));
        let mut next = camera;
        let pans = response.dragged_by(egui::PointerButton::Secondary)
            || response.dragged_by(egui::PointerButton::Middle)
            || (response.dragged() && ui.input(|input| input.modifiers.shift));
        if pans {
            next = orbit::pan(&next, -share(drag.x), share(drag.y), field_of_view);
        } else if response.dragged() {
            let turn = std::f64::consts::PI;
            next = orbit::orbit(&next, -turn * share(drag.x), turn * share(drag.y));
        }
        if response.hovered() {
            let (scroll, pinch) =
                ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (f64::from(scroll) * 0.004).exp() * f64::from(pinch);
            if factor != 1.0 {
                next = orbit::zoom(&next, factor);
            }
        }
        if response.double_clicked()
            && let Some(first) = self.prepared.first()
        {
            next = first.camera;
        }
        self.set_camera(next);
    }

    /// The picture, as large as it fits into `ui` with the scene's proportions.
    fn picture(&mut self, ui: &mut Ui, collector: &Collector) {
        let space = ui.available_rect_before_wrap();
        let [width, height] = self.scene.size.map(|side| side as f32);
        let scale = (space.width() / width)
            .min(space.height() / height)
            .max(0.0);
        // Whole pixels: what is drawn is shown as it is.
        let pixels_per_point = ui.ctx().pixels_per_point();
        let rectangle = Rect::from_center_size(space.center(), scale * vec2(width, height))
            .intersect(space)
            .round_to_pixels(pixels_per_point);
        let response = ui.interact(
            rectangle,
            ui.scope_id().with("picture"),
            Sense::click_and_drag(),
        );
        response.widget_info(|| {
            egui::WidgetInfo::labeled(
                egui::Role::Image,
                true,
                "The picture: arrow keys turn, with shift move, plus and minus zoom, Home resets",
            )
        });
        collector.add("Picture", rectangle, self.show.name());
        if response.clicked() || response.dragged() {
            response.request_focus();
        }
        if response.has_focus() {
            // The arrow keys belong to the camera, not to the focus.
            ui.memory_mut(|memory| {
                memory.set_focus_lock_filter(
                    response.id,
                    egui::EventFilter {
                        horizontal_arrows: true,
                        vertical_arrows: true,
                        ..Default::default()
                    },
                );
            });
        }
        self.point(ui, &response, rectangle.height());
        self.keys(ui, response.has_focus());

        let points = rectangle.size() * pixels_per_point;
        let full = [points.x, points.y].map(|side| side.round().clamp(1.0, LARGEST_SCREEN) as u32);
        // Asked once: it may end meanwhile.
        let is_moving = self.is_moving();
        self.draw(full, is_moving);
        self.judge(full, is_moving);
        let painter = ui.painter_at(rectangle);
        let whole = Rect::from_min_size(egui::Pos2::ZERO, Vec2::splat(1.0));
        let judged = self.judgement.as_ref().map(egui::TextureHandle::id);
        let texture = judged.or(self.screen);
        if let Some(texture) = texture {
            painter.image(texture, rectangle, whole, egui::Color32::WHITE);
        }
        if self.has_wireframe {
            self.paint_wireframe(&painter, rectangle);
        }
        if self.compared.is_some() && !self.is_judged {
            self.split_bar(ui, &painter, rectangle, collector);
        }
        if response.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            ui.painter()
                .rect_stroke(rectangle, 0.0, stroke, egui::StrokeKind::Outside);
        }
        self.probe.settled = self.is_settled(full, is_moving) && !self.is_busy();
        let is_complete = self.probe.settled && self.is_judged == self.judgement.is_some();
        self.take_shot(ui.ctx(), rectangle, is_complete);
        if !self.probe.settled {
            // The workshop and the device tell when they are done.
            let rest = REST.saturating_sub(self.moved.elapsed());
            let next = if rest.is_zero() { PATIENCE } else { rest };
            ui.ctx().request_repaint_after(next);
        }
    }

    fn paint_wireframe(&self, painter: &egui::Painter, rectangle: Rect) {
        let (Some(camera), Some(wireframe)) = (self.camera, &self.wireframe) else {
            return;
        };
        let frames = self.frames(&camera, self.scene.size);
        let Some(frame) = frames.first() else { return };
        let stroke = egui::Stroke::new(1.0, egui::Color32::from_black_alpha(150));
        let at = |[x, y]: [f32; 2]| rectangle.min + vec2(x, y) * rectangle.size();
        painter.extend(
            wireframe
                .seen(frame)
                .map(|ends| egui::Shape::line_segment(ends.map(at), stroke)),
        );
    }

    /// The bar between two tiers, which can be dragged and moved by keys.
    fn split_bar(
        &mut self,
        ui: &mut Ui,
        painter: &egui::Painter,
        rectangle: Rect,
        collector: &Collector,
    ) {
        let x = rectangle.left() + self.split * rectangle.width();
        let bar = Rect::from_center_size(
            egui::pos2(x, rectangle.center().y),
            vec2(12.0, rectangle.height()),
        );
        let response = ui
            .interact(bar, ui.scope_id().with("split"), Sense::click_and_drag())
            .on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
        collector.add("Split", bar, self.split);
        response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(self.split), "Split"));
        let mut split = self.split + response.drag_delta().x / rectangle.width().max(1.0);
        if response.dragged() {
            response.request_focus();
        }
        if response.has_focus() {
            let keys = ui.input(|input| {
                input.num_presses(Key::ArrowRight) as f32 - input.num_presses(Key::ArrowLeft) as f32
            });
            split += 0.02 * keys;
        }
        let split = split.clamp(0.0, 1.0);
        if split != self.split {
            self.split = split;
            self.moved = Instant::now();
            // The picture was drawn before the bar.
            ui.ctx().request_repaint();
        }
        let color = ui.style().interact(&response).fg_stroke.color;
        painter.vline(
            x,
            rectangle.y_range(),
            egui::Stroke::new(3.0, egui::Color32::BLACK),
        );
        painter.vline(x, rectangle.y_range(), egui::Stroke::new(1.5, color));
        let own = self.scene.objects.get(self.selected);
        let left = own.map_or("", |object| object.tier.name());
        let right = self.compared.map_or("", Tier::name);
        let font = egui::FontId::proportional(14.0);
        for (align, offset, name) in [
            (egui::Align2::RIGHT_TOP, -8.0, left),
            (egui::Align2::LEFT_TOP, 8.0, right),
        ] {
            let place = egui::pos2(x + offset, rectangle.top() + 6.0);
            let shadow = place + vec2(1.0, 1.0);
            painter.text(shadow, align, name, font.clone(), egui::Color32::BLACK);
            painter.text(place, align, name, font.clone(), egui::Color32::WHITE);
        }
    }

    /// Has the picture judged against the oracle once it stands still.
    fn judge(&mut self, full: [u32; 2], is_moving: bool) {
        if !self.is_judged || is_moving {
            self.judgement = None;
            // One that is under way is of another picture.
            self.judged += 1;
            return;
        }
        let (Some(camera), Some(first)) = (self.camera, self.prepared.first()) else {
            return;
        };
        if self.judgement.is_some() || self.judging.is_some() || !self.is_settled(full, is_moving) {
            return;
        }
        let size = judge::size(self.scene.size);
        self.judged += 1;
        self.judging = Some(self.judged);
        self.workshop.order(Order::Judge {
            number: self.judged,
            scene: first.clone(),
            camera,
            frame: Box::new(first.frame_from(&self.scene, &camera, size)),
        });
        self.say("Judging the picture …".to_string());
    }

    fn panel(&mut self, ui: &mut Ui, collector: &Collector) {
        let mut controls = Controls::new(ui, collector);
        let shows = Show::ALL.into_iter().map(|show| (show, show.name()));
        controls.choice("Show", &mut self.show, shows);
        controls.flag("Wireframe", &mut self.has_wireframe);
        controls.flag("Error against the oracle", &mut self.is_judged);
        let tiers = Tier::ALL.into_iter().map(|tier| (Some(tier), tier.name()));
        let none = std::iter::once((None, "nothing"));
        let mut is_changed = controls.choice("Compare with", &mut self.compared, none.chain(tiers));

        ui.separator();
        if self.scene.objects.len() > 1 {
            let selected = &mut self.selected;
            egui::ComboBox::from_label("Object")
                .selected_text(&self.scene.objects[*selected].name)
                .show_ui(ui, |ui| {
                    for (number, object) in self.scene.objects.iter().enumerate() {
                        ui.selectable_value(selected, number, &object.name);
                    }
                });
        }
        let mut controls = Controls::new(ui, collector);
        if let Some(object) = self.scene.objects.get_mut(self.selected) {
            controls.object(object, self.prepared.first().map(Arc::as_ref));
        }
        controls.scene(&mut self.scene);
        is_changed |= controls.changed();
        if is_changed {
            self.order(false);
        }

        ui.separator();
        let label = ui.label("Name of saved files");
        let field = ui
            .text_edit_singleline(&mut self.name)
            .labelled_by(label.id);
        collector.add("Name of saved files", field.rect, &self.name);
        let mut controls = Controls::new(ui, collector);
        if controls.button("Save picture (Ctrl P)") {
            self.save_picture();
        }
        if controls.button("Save what is shown (Ctrl Shift P)") {
            self.save_shown();
        }
        if controls.button("Save scene (Ctrl S)") {
            self.save_scene();
        }
        if controls.button("Export shaders") {
            self.export();
        }
        ui.separator();
        ui.small("Drop a mesh or a pattern on the window. Drag turns, shift or the right button moves, the wheel zooms, a double click resets.");
    }

    fn status(&mut self, ui: &mut Ui, collector: &Collector) {
        ui.horizontal_wrapped(|ui| {
            let mut theme = ui.memory(|memory| memory.options.theme_preference);
            let themes = [
                (ThemePreference::System, "as the system"),
                (ThemePreference::Light, "light"),
                (ThemePreference::Dark, "dark"),
            ];
            if Controls::new(ui, collector).choice("Theme", &mut theme, themes) {
                ui.ctx().set_theme(theme);
            }
            ui.separator();
            let [width, height] = self.probe.frame_size;
            let memory = self.stage.bytes() as f64 / f64::from(1 << 20);
            ui.label(format!(
                "{width} × {height}: {:.1} ms, {memory:.1} MiB",
                self.probe.frame_ms
            ));
            ui.separator();
            let color = if self.is_wrong {
                ui.visuals().error_fg_color
            } else {
                ui.visuals().text_color()
            };
            ui.colored_label(color, &self.message);
        });
        ui.small(self.stage.describe());
    }

    /// Tells the platform what has changed since it was told last.
    fn tell(&mut self, collector: Collector) {
        if !self.platform.listens() {
            return;
        }
        self.probe.controls = collector.into_controls();
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
        self.read_dropped(&context);
        self.use_dropped();
        self.receive(&context);
        self.finish_picture();
        self.finish_shot(&context);
        egui::Panel::bottom("status").show(ui, |ui| self.status(ui, &collector));
        egui::Panel::right("controls")
            .default_size(340.0)
            .show(ui, |ui| {
                egui::ScrollArea::vertical().show(ui, |ui| self.panel(ui, &collector));
            });
        egui::CentralPanel::default().show(ui, |ui| self.picture(ui, &collector));
        self.tell(collector);
    }
}
