//! The picture of the viewer: drawing, pointer, keys, overlays and the bar
//! between two tiers.

use super::bench::Order;
use super::orbit;
use super::probe::Collector;
use super::{Drawn, PATIENCE, REST, Viewer};
use eframe::egui::emath::GuiRounding as _;
use eframe::egui::{self, Key, Modifiers, Rect, Sense, Ui, Vec2, vec2};
use relievo::scene::Tier;
use web_time::Instant;

/// Longest side of a picture on the screen, pixels.
const LARGEST_SCREEN: f32 = 4096.0;
/// Rotation by an arrow key, radians, and motion by one, picture heights.
const KEY_TURN: f64 = 0.1;

impl Viewer {
    /// Returns whether the last frame is still being drawn; records its time
    /// once it is finished.
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

    /// Draws the picture with `full` pixels, unless it is on the screen
    /// already.
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

    /// Returns whether the screen is up to date.
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
        // Before the shorter shortcut, which would match as well.
        if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::P) {
            self.save_shown();
        }
        if pressed(Modifiers::COMMAND, Key::P) {
            self.save_picture();
        }
        if pressed(Modifiers::NONE, Key::F5) {
            self.thumbnails.forget();
            self.order(true);
        }
        if pressed(Modifiers::COMMAND, Key::O) {
            self.open();
        }
        // A text field has its own.
        if !ui.ctx().text_edit_focused() {
            if pressed(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z)
                || pressed(Modifiers::COMMAND, Key::Y)
            {
                self.redo();
            }
            if pressed(Modifiers::COMMAND, Key::Z) {
                self.undo();
            }
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

    /// Applies the pointer's rotation, motion and zoom.
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

    /// Shows the picture as large as fits into `ui` with the scene's aspect
    /// ratio.
    pub(super) fn picture(&mut self, ui: &mut Ui, collector: &Collector) {
        let space = ui.available_rect_before_wrap();
        let [width, height] = self.scene.size.map(|side| side as f32);
        let scale = (space.width() / width)
            .min(space.height() / height)
            .max(0.0);
        // Whole pixels, so that pixels are not resampled.
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
            // Arrow keys move the camera, not the focus.
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
        // Read once: it may change meanwhile.
        let is_moving = self.is_moving();
        self.draw(full, is_moving);
        self.analyse(full, is_moving);
        let painter = ui.painter_at(rectangle);
        let whole = Rect::from_min_size(egui::Pos2::ZERO, Vec2::splat(1.0));
        let analysed = self.analysed.as_ref().map(egui::TextureHandle::id);
        let texture = analysed.or(self.screen);
        if let Some(texture) = texture {
            painter.image(texture, rectangle, whole, egui::Color32::WHITE);
        }
        if self.has_wireframe {
            self.paint_wireframe(&painter, rectangle);
        }
        if self.compared.is_some() && self.analysis.is_none() {
            self.split_bar(ui, &painter, rectangle, collector);
        }
        if response.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            ui.painter()
                .rect_stroke(rectangle, 0.0, stroke, egui::StrokeKind::Outside);
        }
        self.probe.settled = self.is_settled(full, is_moving) && !self.is_busy();
        let is_complete = self.probe.settled && self.analysis.is_some() == self.analysed.is_some();
        self.take_shot(ui.ctx(), rectangle, is_complete);
        if !self.probe.settled {
            // The workshop and the device request a repaint when they finish.
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

    /// Shows the bar between two tiers, which can be moved by pointer and keys.
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
            // The picture was drawn before the bar moved.
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

    /// Drops the analysis that is shown, and the one in progress.
    pub(super) fn forget_analysis(&mut self) {
        self.analysed = None;
        self.analyses += 1;
    }

    /// Orders the analysis of the picture once it stands still.
    fn analyse(&mut self, full: [u32; 2], is_moving: bool) {
        let Some(analysis) = self.analysis.filter(|_| !is_moving) else {
            return self.forget_analysis();
        };
        let (Some(camera), Some(first)) = (self.camera, self.prepared.first()) else {
            return;
        };
        if self.analysed.is_some() || self.analysing.is_some() || !self.is_settled(full, is_moving)
        {
            return;
        }
        let size = analysis.size(self.scene.size);
        self.analyses += 1;
        self.analysing = Some(self.analyses);
        self.workshop.order(Order::Analyse {
            analysis,
            number: self.analyses,
            camera,
            frame: Box::new(first.frame_from(&self.scene, &camera, size)),
        });
        self.say(format!("Analysis: {} …", analysis.name()));
    }
}
