//! The row of tools, the panel of controls and the status line.

use super::Viewer;
use super::analysis::Analysis;
#[cfg(not(target_arch = "wasm32"))]
use super::browse::Browse;
use super::controls::{Controls, drawn};
use super::display::Show;
use super::presets::{apply, presets};
use super::probe::Collector;
use eframe::egui::{self, ThemePreference, Ui};
use relievo::scene::Tier;
use std::sync::Arc;

impl Viewer {
    /// Shows what changes the scene as a whole, and presets.
    pub(super) fn tools(&mut self, ui: &mut Ui, collector: &Collector) {
        ui.horizontal_wrapped(|ui| {
            let mut controls = Controls::new(ui, collector);
            if controls.button_if(self.can_undo(), "Undo (Ctrl Z)") {
                self.undo();
            }
            if controls.button_if(self.can_redo(), "Redo (Ctrl Shift Z)") {
                self.redo();
            }
            if controls.button("Open…") {
                self.open();
            }
            if self.platform.has_links() && controls.button("Copy link") {
                self.copy_link(ui.ctx());
            }
            ui.separator();
            ui.label("Preset");
            let mut controls = Controls::new(ui, collector);
            for preset in presets() {
                if controls.button(&preset.name)
                    && let Some(object) = self.scene.objects.get_mut(self.selected)
                {
                    let drawn = drawn(object, self.prepared.first().map(Arc::as_ref));
                    apply(preset, object, drawn.map(|drawn| drawn.mesh.as_ref()));
                    self.order(false);
                }
            }
        });
    }

    /// Lets the user open a file.
    pub(super) fn open(&mut self) {
        if !self.platform.choose(&self.dropped) {
            #[cfg(not(target_arch = "wasm32"))]
            {
                let folder = self.scene.path.parent();
                self.browse = folder.map(Browse::new);
            }
        }
    }

    /// Shows the list of files to open, if it is wanted.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn list_files(&mut self, context: &egui::Context, collector: &Collector) {
        if let Some(browse) = &mut self.browse
            && !browse.show(context, collector, &self.dropped)
        {
            self.browse = None;
        }
    }

    pub(super) fn panel(&mut self, ui: &mut Ui, collector: &Collector) {
        let mut controls = Controls::new(ui, collector);
        let shows = Show::ALL.into_iter().map(|show| (show, show.name()));
        controls.choice("Show", &mut self.show, shows);
        controls.flag("Wireframe", &mut self.has_wireframe);
        let analyses = Analysis::ALL.map(|analysis| (Some(analysis), analysis.name()));
        let nothing = std::iter::once((None, "nothing"));
        if controls.choice("Analysis", &mut self.analysis, nothing.chain(analyses)) {
            self.forget_analysis();
        }
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
        let (thumbnails, scene) = (&mut self.thumbnails, &self.scene);
        if let Some(object) = scene.objects.get(self.selected) {
            thumbnails.visit(&object.shape);
        }
        let chosen = controls.folded("Patterns", false, |ui| {
            thumbnails.show(ui, collector, scene, self.selected)
        });
        if let Some(object) = self.scene.objects.get_mut(self.selected) {
            if let Some(Some(shape)) = chosen {
                (object.shape, object.raster) = (shape, None);
                is_changed = true;
            }
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

    pub(super) fn status(&mut self, ui: &mut Ui, collector: &Collector) {
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
}
