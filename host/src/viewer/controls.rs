//! Sliders and switches: every parameter of a scene, with its unit.

use super::probe::Collector;
use crate::mesh::Projection;
use crate::prepare::PreparedScene;
use crate::scene::{
    Color, LARGEST_BUDGET, LARGEST_STEPS, LEAST_BUDGET, Lettering, Scene, SceneObject, Search,
    Shape, Tier,
};
use crate::shape_map::{DEFAULT_RASTER, SMALLEST_RASTER, Storage};
use eframe::egui::{self, Response, Ui};
use std::ops::RangeInclusive;
use std::path::Path;

/// Shows controls one below the other, and remembers whether one was changed.
pub struct Controls<'a> {
    ui: &'a mut Ui,
    collector: &'a Collector,
    changed: bool,
}

impl<'a> Controls<'a> {
    /// In `ui`; `collector` is told of each.
    pub fn new(ui: &'a mut Ui, collector: &'a Collector) -> Controls<'a> {
        Controls {
            ui,
            collector,
            changed: false,
        }
    }

    /// Whether a control was changed since this was made.
    pub fn changed(&self) -> bool {
        self.changed
    }

    fn note(&mut self, label: &str, response: &Response, value: impl ToString) -> bool {
        self.collector.add(label, response.rect, value);
        self.changed |= response.changed();
        if response.dragged() {
            // Arrow keys go on from there.
            response.request_focus();
        }
        response.changed()
    }

    fn slider<N: egui::emath::Numeric + ToString>(
        &mut self,
        label: &str,
        unit: &str,
        value: &mut N,
        range: RangeInclusive<N>,
        is_logarithmic: bool,
    ) -> bool {
        let slider = egui::Slider::new(value, range)
            .text(label)
            .suffix(unit)
            .logarithmic(is_logarithmic)
            .clamping(egui::SliderClamping::Edits);
        let response = self.ui.add(slider);
        self.note(label, &response, *value)
    }

    /// A number with its unit.
    pub fn number(
        &mut self,
        label: &str,
        unit: &str,
        value: &mut f64,
        range: RangeInclusive<f64>,
    ) -> bool {
        self.slider(label, unit, value, range, false)
    }

    /// A positive number over many orders of magnitude.
    fn magnitude(
        &mut self,
        label: &str,
        unit: &str,
        value: &mut f64,
        range: RangeInclusive<f64>,
    ) -> bool {
        self.slider(label, unit, value, range, true)
    }

    /// A whole number over many orders of magnitude.
    fn count(&mut self, label: &str, value: &mut u32, range: RangeInclusive<u32>) -> bool {
        self.slider(label, "", value, range, true)
    }

    /// Yes or no.
    pub fn flag(&mut self, label: &str, value: &mut bool) -> bool {
        let response = self.ui.checkbox(value, label);
        self.note(label, &response, *value)
    }

    fn color(&mut self, label: &str, value: &mut Color) -> bool {
        let mut rgb = value.0.map(|channel| channel as f32);
        let response = self.ui.horizontal(|ui| {
            let response = ui.color_edit_button_rgb(&mut rgb);
            let name = ui.label(label);
            response.labelled_by(name.id)
        });
        if response.inner.changed() {
            // As bytes: a scene file then says it as #rrggbb.
            *value = Color(rgb.map(|channel| (f64::from(channel) * 255.0).round() / 255.0));
        }
        self.note(label, &response.inner, format!("{:?}", value.0))
    }

    /// One of several.
    pub fn choice<T: Copy + PartialEq>(
        &mut self,
        label: &str,
        value: &mut T,
        choices: impl IntoIterator<Item = (T, &'static str)>,
    ) -> bool {
        let choices: Vec<_> = choices.into_iter().collect();
        let chosen = choices.iter().find(|(choice, _)| choice == value);
        let name = chosen.map_or("", |(_, name)| *name);
        let before = *value;
        let shown = egui::ComboBox::from_label(label)
            .selected_text(name)
            .show_ui(self.ui, |ui| {
                for (choice, name) in choices {
                    let response = ui.selectable_value(value, choice, name);
                    self.collector
                        .add(&format!("{label}: {name}"), response.rect, "");
                }
            });
        self.collector.add(label, shown.response.rect, name);
        let changed = before != *value;
        self.changed |= changed;
        changed
    }

    /// What can be pressed.
    pub fn button(&mut self, label: &str) -> bool {
        let response = self.ui.button(label);
        self.collector.add(label, response.rect, "");
        response.clicked()
    }

    /// Controls under a heading that folds them away.
    fn group(&mut self, title: &str, open: bool, add: impl FnOnce(&mut Controls<'_>)) {
        let collector = self.collector;
        let shown = egui::CollapsingHeader::new(title)
            .default_open(open)
            .show(self.ui, |ui| {
                let mut controls = Controls::new(ui, collector);
                add(&mut controls);
                controls.changed
            });
        self.collector.add(title, shown.header_response.rect, "");
        self.changed |= shown.body_returned.unwrap_or(false);
    }

    /// The parameters of one object; `prepared` knows the depth that it has
    /// where the scene gives none.
    pub fn object(&mut self, object: &mut SceneObject, prepared: Option<&PreparedScene>) {
        let drawn = prepared.and_then(|scene| {
            let mut objects = scene.objects.iter();
            objects.find(|drawn| drawn.name == object.name)
        });
        self.group("Extrusion", true, |controls| {
            let size = drawn.map_or(1.0, |drawn| drawn.mesh.bounds.diagonal());
            let current = drawn.map_or(0.04, |drawn| f64::from(drawn.parameters.depth));
            let mut depth = object.depth.unwrap_or(current);
            let largest = (0.2 * size).max(depth);
            if controls.number(
                "Depth",
                " world units",
                &mut depth,
                1e-3 * largest..=largest,
            ) {
                object.depth = Some(depth);
            }
            let least = if object.tier == Tier::Paper {
                0.0
            } else {
                -0.2
            };
            let extrusion = &mut object.extrusion;
            controls.number(
                "Extension e",
                " widths",
                &mut extrusion.extension,
                least..=0.3,
            );
            if controls.number("Bevel b", " widths/depth", &mut extrusion.bevel, 0.0..=0.5)
                && extrusion.bevel == 0.0
            {
                extrusion.chamfer = 1.0;
            }
            if extrusion.bevel > 0.0 || object.search == Search::Relief {
                controls.number("Chamfer c", " of depth", &mut extrusion.chamfer, 0.0..=1.0);
            }
            controls.number("Repeats along u", "", &mut object.repeat[0], 1.0..=64.0);
            controls.number("Repeats along v", "", &mut object.repeat[1], 1.0..=64.0);
            controls.flag("Cut out (no floor)", &mut object.cut_out);
            controls.flag("Invert the pattern", &mut object.invert);
            controls.flag("Shadows on itself", &mut object.self_shadow);
        });
        self.group("Accuracy", true, |controls| controls.accuracy(object));
        self.group("Pattern and mesh", false, |controls| {
            controls.letters(&mut object.shape);
            if is_drawn(&object.shape) {
                let mut raster = object.raster.unwrap_or(DEFAULT_RASTER);
                if controls.count(
                    "Pixels of the longer side",
                    &mut raster,
                    SMALLEST_RASTER..=4096,
                ) {
                    object.raster = Some(raster);
                }
            }
            let mut threshold = u32::from(object.threshold);
            if controls.count("Threshold", &mut threshold, 1..=255) {
                object.threshold = threshold as u8;
            }
            let storages = [
                (Storage::R8, "8 bits a texel"),
                (Storage::R16, "16 bits a texel"),
                (Storage::R32F, "32 bits a texel"),
            ];
            controls.choice("Shape map", &mut object.map.storage, storages);
            let reductions = [(1, "every texel"), (2, "1 of 2 × 2"), (4, "1 of 4 × 4")];
            controls.choice("Texels", &mut object.map.reduction, reductions);
            let projections = Projection::ALL
                .into_iter()
                .map(|projection| (Some(projection), projection.name()));
            let own = (None, "the mesh's own");
            let all = std::iter::once(own).chain(projections);
            controls.choice("Texture coordinates", &mut object.projection, all);
            controls.magnitude("Scale", " times", &mut object.scale, 0.01..=100.0);
            for (axis, angle) in ["x", "y", "z"].into_iter().zip(&mut object.rotate) {
                controls.number(
                    &format!("Rotation about {axis}"),
                    "°",
                    angle,
                    -180.0..=180.0,
                );
            }
        });
        self.group("Material", false, |controls| {
            let material = &mut object.material;
            controls.color("Cap", &mut material.cap);
            controls.color("Wall", &mut material.wall);
            controls.color("Bevel", &mut material.bevel);
            controls.color("Floor", &mut material.floor);
            controls.number("Highlight", "", &mut material.specular, 0.0..=1.0);
            controls.count("Shininess", &mut material.shininess, 1..=127);
        });
    }

    /// Letters in place of the pattern.
    fn letters(&mut self, shape: &mut Shape) {
        let mut text = match shape {
            Shape::Text(lettering) => lettering.text.clone(),
            Shape::File(_) => String::new(),
        };
        let label = "Letters as pattern";
        let response = self.ui.horizontal(|ui| {
            let field = egui::TextEdit::singleline(&mut text).desired_width(120.0);
            let field = ui.add(field);
            let name = ui.label(label);
            field.labelled_by(name.id)
        });
        if self.note(label, &response.inner, &text) && !text.trim().is_empty() {
            let (font, margin) = match shape {
                Shape::Text(before) => (before.font.clone(), before.margin),
                Shape::File(_) => (None, Lettering::DEFAULT_MARGIN),
            };
            *shape = Shape::Text(Lettering { text, font, margin });
        }
    }

    fn accuracy(&mut self, object: &mut SceneObject) {
        let searches = [
            (Search::Extrusion, "extrusion"),
            (Search::Relief, "relief mapping"),
        ];
        if self.choice("Search", &mut object.search, searches) {
            object.tidy();
        }
        let is_ours = object.search == Search::Extrusion;
        let mut has_budget = object.budget.is_some();
        if is_ours && self.flag("Find the cheapest for an error", &mut has_budget) {
            object.budget = has_budget.then_some(0.5);
            object.tier = Tier::Fast;
            object.tidy();
        }
        if let Some(budget) = &mut object.budget {
            self.magnitude("Error", " px", budget, LEAST_BUDGET..=LARGEST_BUDGET);
            return;
        }
        if is_ours {
            let tiers = Tier::ALL.into_iter().map(|tier| (tier, tier.name()));
            if self.choice("Tier", &mut object.tier, tiers) {
                object.tidy();
            }
        }
        if object.tier == Tier::Accurate {
            self.magnitude("Tolerance", " px", &mut object.tolerance, 1e-4..=16.0);
            self.flag("Less depth where it bends", &mut object.clamp_depth);
        }
        if is_ours && object.tier != Tier::Paper {
            self.number("Slack", " px", &mut object.slack, 0.0..=4.0);
        }
        self.count("Steps", &mut object.steps, 1..=LARGEST_STEPS.min(4096));
        self.count("Bisections", &mut object.bisections, 0..=24);
    }

    /// Picture, light and background.
    pub fn scene(&mut self, scene: &mut Scene) {
        self.group("Light and background", false, |controls| {
            let light = &mut scene.light;
            for (axis, part) in ["x", "y", "z"].into_iter().zip(&mut light.direction) {
                controls.number(&format!("Light along {axis}"), "", part, -1.0..=1.0);
            }
            if light.direction.iter().all(|part| part.abs() < 1e-6) {
                light.direction = [0.0, 1.0, 0.0];
            }
            controls.color("Light", &mut light.color);
            controls.number("Intensity", "", &mut light.intensity, 0.0..=4.0);
            controls.color("Ambient light", &mut light.ambient);
            controls.color("Background", &mut scene.background);
        });
        self.group("Picture in a file", false, |controls| {
            let [width, height] = &mut scene.size;
            controls.count("Width", width, 16..=4096);
            controls.count("Height", height, 16..=4096);
            controls.number("Field of view", "°", &mut scene.field_of_view, 5.0..=120.0);
            let mut supersample = scene.supersampling > 1;
            if controls.flag("Four samples a pixel", &mut supersample) {
                scene.supersampling = if supersample { 2 } else { 1 };
            }
        });
    }
}

/// Whether a pattern has no pixels of its own.
fn is_drawn(shape: &Shape) -> bool {
    let ending = |path: &Path| path.extension().unwrap_or_default().to_ascii_lowercase();
    match shape {
        Shape::Text(_) => true,
        Shape::File(path) => ending(path) == "svg",
    }
}
