//! Sliders and switches for the parameters of a scene. Labels, ranges and units of
//! sliders are those of the table of scene keys.

use super::probe::Collector;
use eframe::egui::{self, Response, Ui};
use relievo::mesh::Projection;
use relievo::prepare::{PreparedObject, PreparedScene};
use relievo::scene::keys::{self, Key, OBJECT};
use relievo::scene::{Color, Lettering, Scene, SceneObject, Search, Shape, Technique, Tier, Tone};
use relievo::shape_map::{DEFAULT_RASTER, Storage};
use relievo_shared::profile;
use std::ops::RangeInclusive;
use std::path::Path;

/// Shows controls in a column, and remembers whether one was changed.
pub struct Controls<'a> {
    ui: &'a mut Ui,
    collector: &'a Collector,
    changed: bool,
}

impl<'a> Controls<'a> {
    /// Creates controls in `ui`; `collector` is told of each.
    pub fn new(ui: &'a mut Ui, collector: &'a Collector) -> Controls<'a> {
        Controls {
            ui,
            collector,
            changed: false,
        }
    }

    /// Returns whether a control was changed since [`Controls::new`].
    pub fn changed(&self) -> bool {
        self.changed
    }

    fn note(&mut self, label: &str, response: &Response, value: impl ToString) -> bool {
        self.collector.add(label, response.rect, value);
        self.changed |= response.changed();
        if response.dragged() {
            // Arrow keys continue from there.
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

    /// Shows the slider of a number.
    pub fn number(
        &mut self,
        label: &str,
        unit: &str,
        value: &mut f64,
        range: RangeInclusive<f64>,
    ) -> bool {
        self.slider(label, unit, value, range, false)
    }

    /// Shows the slider of a scene key that holds a number; returns whether it
    /// was moved. `default` is shown where the field has no value.
    fn key<T>(&mut self, key: &Key<T>, owner: &mut T, default: f64) -> bool {
        let slider = key.slider.expect("keys of sliders have one");
        let mut value = key.number(owner).unwrap_or(default);
        let unit = match key.unit {
            "" | "°" => key.unit.to_string(),
            unit => format!(" {unit}"),
        };
        let (low, high) = slider.range;
        let changed = if key.is_whole() {
            let mut whole = value as u32;
            let range = low as u32..=high as u32;
            let changed = self.slider(
                slider.label,
                &unit,
                &mut whole,
                range,
                slider.is_logarithmic,
            );
            value = f64::from(whole);
            changed
        } else {
            self.slider(
                slider.label,
                &unit,
                &mut value,
                low..=high,
                slider.is_logarithmic,
            )
        };
        if changed {
            key.set_number(owner, value);
        }
        changed
    }

    /// As [`Controls::key`], for the key of an object called `name`.
    fn object_key(&mut self, name: &str, object: &mut SceneObject) -> bool {
        let key = keys::find(OBJECT, name).expect("the name is in the table");
        self.key(key, object, 0.0)
    }

    /// Shows the logarithmic slider of a whole number.
    fn count(&mut self, label: &str, value: &mut u32, range: RangeInclusive<u32>) -> bool {
        self.slider(label, "", value, range, true)
    }

    /// Shows a checkbox.
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
            // Rounded to bytes, which scene files write as #rrggbb.
            *value = Color(rgb.map(|channel| (f64::from(channel) * 255.0).round() / 255.0));
        }
        self.note(label, &response.inner, format!("{:?}", value.0))
    }

    /// Shows a list to choose from.
    pub fn choice<T: Copy + PartialEq, N: AsRef<str>>(
        &mut self,
        label: &str,
        value: &mut T,
        choices: impl IntoIterator<Item = (T, N)>,
    ) -> bool {
        let choices: Vec<_> = choices.into_iter().collect();
        let chosen = choices.iter().find(|(choice, _)| choice == value);
        let name = chosen.map_or("", |(_, name)| name.as_ref());
        let before = *value;
        let shown = egui::ComboBox::from_label(label)
            .selected_text(name)
            .show_ui(self.ui, |ui| {
                for (choice, name) in &choices {
                    let name = name.as_ref();
                    let response = ui.selectable_value(value, *choice, name);
                    self.collector
                        .add(&format!("{label}: {name}"), response.rect, "");
                }
            });
        self.collector.add(label, shown.response.rect, name);
        let changed = before != *value;
        self.changed |= changed;
        changed
    }

    /// Shows a button; returns whether it was pressed.
    pub fn button(&mut self, label: &str) -> bool {
        self.button_if(true, label)
    }

    /// Shows a button that can be pressed if `is_enabled`; returns whether it was.
    pub fn button_if(&mut self, is_enabled: bool, label: &str) -> bool {
        let response = self.ui.add_enabled(is_enabled, egui::Button::new(label));
        let state = if is_enabled { "" } else { "disabled" };
        self.collector.add(label, response.rect, state);
        response.clicked()
    }

    /// Shows controls under a heading that can be folded.
    fn group(&mut self, title: &str, open: bool, add: impl FnOnce(&mut Controls<'_>)) {
        let collector = self.collector;
        let changed = self.folded(title, open, |ui| {
            let mut controls = Controls::new(ui, collector);
            add(&mut controls);
            controls.changed
        });
        self.changed |= changed.unwrap_or(false);
    }

    /// Shows other contents under a heading that can be folded; returns their result
    /// unless they are folded.
    pub fn folded<R>(
        &mut self,
        title: &str,
        open: bool,
        add: impl FnOnce(&mut Ui) -> R,
    ) -> Option<R> {
        let shown = egui::CollapsingHeader::new(title)
            .default_open(open)
            .show(self.ui, add);
        self.collector.add(title, shown.header_response.rect, "");
        shown.body_returned
    }

    /// Shows the parameters of one object. `prepared` gives the depth of an
    /// object that has none in the scene.
    pub fn object(&mut self, object: &mut SceneObject, prepared: Option<&PreparedScene>) {
        let drawn = drawn(object, prepared);
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
            controls.technique(object);
            controls.parts("repeat", ["u", "v"], &mut object.repeat);
            if object.depth.is_some() {
                controls.flag("Rise from the mesh", &mut object.raised);
            }
            controls.flag("Cut out (no floor)", &mut object.cut_out);
            controls.flag("Invert the pattern", &mut object.invert);
            controls.flag("Shadows on itself", &mut object.self_shadow);
        });
        self.group("Accuracy", true, |controls| controls.accuracy(object));
        self.group("Pattern and mesh", false, |controls| {
            controls.letters(&mut object.shape);
            if is_drawn(&object.shape) {
                let key = keys::find(OBJECT, "raster").expect("the name is in the table");
                controls.key(key, object, f64::from(DEFAULT_RASTER));
            }
            controls.object_key("threshold", object);
            let storages = Storage::ALL.iter().filter_map(|&storage| {
                let bits = storage.map_bits()?;
                Some((storage, format!("{bits} bits a texel")))
            });
            controls.choice("Shape map", &mut object.map.storage, storages);
            let reductions = [(1, "every texel"), (2, "1 of 2 × 2"), (4, "1 of 4 × 4")];
            controls.choice("Texels", &mut object.map.reduction, reductions);
            let projections = Projection::ALL
                .into_iter()
                .map(|projection| (Some(projection), projection.name()));
            let own = (None, "the mesh's own");
            let all = std::iter::once(own).chain(projections);
            controls.choice("Texture coordinates", &mut object.projection, all);
            controls.object_key("crease_angle", object);
            controls.object_key("scale", object);
            controls.parts("rotate", ["x", "y", "z"], &mut object.rotate);
        });
        self.group("Material", false, |controls| {
            let (colors, names) = (&mut object.material, &mut object.finish);
            for (label, color, name) in [
                ("Cap", &mut colors.cap, &mut names.cap),
                ("Wall", &mut colors.wall, &mut names.wall),
                ("Bevel", &mut colors.bevel, &mut names.bevel),
                ("Floor", &mut colors.floor, &mut names.floor),
            ] {
                let before = *color;
                controls.color(label, color);
                // A colour takes the place of a material.
                if *color != before {
                    *name = None;
                }
            }
            for key in keys::MATERIAL.iter().filter(|key| key.slider.is_some()) {
                controls.key(key, object, 0.0);
            }
        });
    }

    /// Shows the sliders of the technique's parameters.
    fn technique(&mut self, object: &mut SceneObject) {
        let mut technique = object.technique();
        // Relief mapping draws no layers, and would lose them.
        let is_drawn = |technique: &Technique| {
            object.layers.is_empty() || technique.search() == Search::Extrusion
        };
        let all = Technique::ALL.into_iter().filter(is_drawn);
        let all: Vec<_> = all.map(|technique| (technique, technique.name())).collect();
        if self.choice("Technique", &mut technique, all) {
            object.set_technique(technique);
            object.tidy();
        }
        for key in OBJECT {
            // Straight profiles show all parameters: changing one may change the technique.
            let is_shown = technique.has(key.name)
                || (object.extrusion.profile == profile::STRAIGHT
                    && Technique::Chamfered.has(key.name));
            let is_hidden = key.name == "chamfer"
                && object.extrusion.bevel <= 0.0
                && object.search != Search::Relief;
            if is_shown && !is_hidden {
                self.key(key, object, 0.0);
            }
        }
        let extrusion = &mut object.extrusion;
        let is_upright = extrusion.bevel == 0.0 && extrusion.profile == profile::STRAIGHT;
        if is_upright && object.search != Search::Relief {
            extrusion.chamfer = 1.0;
        }
        if object.tier == Tier::Paper {
            extrusion.extension = extrusion.extension.max(0.0);
        }
    }

    /// Shows a slider for each number of the key called `name`.
    fn parts<const N: usize>(&mut self, name: &str, parts: [&str; N], values: &mut [f64; N]) {
        let key = keys::find(OBJECT, name).expect("the name is in the table");
        let slider = key.slider.expect("keys of sliders have one");
        let (low, high) = slider.range;
        for (part, value) in parts.into_iter().zip(values) {
            self.number(
                &format!("{} {part}", slider.label),
                key.unit,
                value,
                low..=high,
            );
        }
    }

    /// Shows a text that is the pattern.
    fn letters(&mut self, shape: &mut Shape) {
        let mut text = match shape {
            Shape::Text(lettering) => lettering.text.clone(),
            _ => String::new(),
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
                _ => (None, Lettering::DEFAULT_MARGIN),
            };
            *shape = Shape::Text(Lettering { text, font, margin });
        }
    }

    fn accuracy(&mut self, object: &mut SceneObject) {
        let is_ours = object.search == Search::Extrusion;
        let mut has_budget = object.budget.is_some();
        if is_ours && self.flag("Find the cheapest for an error", &mut has_budget) {
            object.budget = has_budget.then_some(0.5);
            object.tier = Tier::Fast;
            object.tidy();
        }
        if object.budget.is_some() {
            self.object_key("error_px", object);
            return;
        }
        if is_ours {
            // So would the paper's tier.
            let tiers = Tier::ALL.into_iter();
            let tiers = tiers.filter(|tier| object.layers.is_empty() || *tier != Tier::Paper);
            let tiers: Vec<_> = tiers.map(|tier| (tier, tier.name())).collect();
            if self.choice("Tier", &mut object.tier, tiers) {
                object.tidy();
            }
        }
        if object.tier == Tier::Accurate {
            self.object_key("tolerance", object);
        }
        if is_ours && object.tier != Tier::Paper {
            self.object_key("slack", object);
        }
        self.object_key("steps", object);
        self.object_key("bisections", object);
    }

    /// Shows the sliders of those of `keys` that have one.
    fn scene_keys(&mut self, keys: &[Key<Scene>], scene: &mut Scene) {
        for key in keys.iter().filter(|key| key.slider.is_some()) {
            self.key(key, scene, 0.0);
        }
    }

    /// Shows the light of a scene that has no others.
    fn light(&mut self, scene: &mut Scene) {
        let light = &mut scene.light;
        for (axis, part) in ["x", "y", "z"].into_iter().zip(&mut light.direction) {
            self.number(&format!("Light along {axis}"), "", part, -1.0..=1.0);
        }
        if light.direction.iter().all(|part| part.abs() < 1e-6) {
            light.direction = [0.0, 1.0, 0.0];
        }
        self.color("Light", &mut light.color);
        self.scene_keys(keys::LIGHT, scene);
        let light = &mut scene.light;
        self.color("Ambient light", &mut light.ambient);
    }

    /// Shows the parameters of picture, light and background.
    pub fn scene(&mut self, scene: &mut Scene) {
        self.group("Light and background", false, |controls| {
            if scene.lights.is_empty() {
                controls.light(scene);
            }
            controls.color("Background", &mut scene.background);
            controls.scene_keys(keys::IMAGE, scene);
            let mut is_agx = scene.development.tone == Tone::Agx;
            if controls.flag("AgX tone curve", &mut is_agx) {
                scene.development.tone = if is_agx { Tone::Agx } else { Tone::Clip };
            }
        });
        self.group("Picture in a file", false, |controls| {
            let [width, height] = &mut scene.size;
            controls.count("Width", width, 16..=4096);
            controls.count("Height", height, 16..=4096);
            controls.scene_keys(keys::CAMERA, scene);
            let mut supersample = scene.supersampling > 1;
            if controls.flag("Four samples a pixel", &mut supersample) {
                scene.supersampling = if supersample { 2 } else { 1 };
            }
            if scene.is_physical() {
                controls.flag("Smooth edges", &mut scene.smooth_edges);
            }
            controls.flag(
                "Transparent background",
                &mut scene.development.is_transparent,
            );
        });
    }
}

/// Returns the prepared object of a scene's object.
pub fn drawn<'a>(
    object: &SceneObject,
    prepared: Option<&'a PreparedScene>,
) -> Option<&'a PreparedObject> {
    let mut objects = prepared?.objects.iter();
    objects.find(|drawn| drawn.name == object.name)
}

/// Returns whether a pattern has no pixels of its own.
fn is_drawn(shape: &Shape) -> bool {
    let ending = |path: &Path| path.extension().unwrap_or_default().to_ascii_lowercase();
    match shape {
        Shape::Text(_) | Shape::Drawing(_) => true,
        Shape::File(path) => ending(path) == "svg",
        Shape::Pattern(_) => false,
    }
}
