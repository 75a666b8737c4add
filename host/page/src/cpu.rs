//! CPU rendering in a worker, for pages without WebGPU.

use crate::default;
use relievo::budget::plan_with;
use relievo::prepare::{Assets, PreparedScene};
use relievo::render::gpu::Content;
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Camera, Lettering, Scene, Shape, Tier};
use relievo_viewer::display::{self, Scale, Show};
use relievo_viewer::dropped::adopt;
use relievo_viewer::link::encode;
use relievo_viewer::orbit;
use std::path::Path;
use wasm_bindgen::prelude::*;

/// A scene in a worker.
#[wasm_bindgen]
pub struct CpuPage {
    scene: Scene,
    assets: Assets,
    prepared: Option<PreparedScene>,
    camera: Option<Camera>,
    show: Show,
    problem: Option<String>,
}

#[wasm_bindgen]
impl CpuPage {
    /// Reads the scene of the fragment of the page's address, or the default scene.
    ///
    /// # Errors
    /// The message, as a string.
    #[wasm_bindgen(constructor)]
    pub fn new(fragment: &str) -> Result<CpuPage, JsValue> {
        console_error_panic_hook::set_once();
        let (scene, problem) = default::scene_of(fragment).map_err(|error| error.to_string())?;
        Ok(CpuPage {
            camera: scene.own_camera(),
            scene,
            assets: Assets::default(),
            prepared: None,
            show: Show::default(),
            problem,
        })
    }

    /// Returns why it shows the default scene in place of the fragment's.
    pub fn problem(&self) -> Option<String> {
        self.problem.clone()
    }

    /// Returns the fragment that shows the scene.
    ///
    /// # Errors
    /// The message, as a string.
    pub fn link(&self) -> Result<String, JsValue> {
        let scene = self.scene.seen_from(self.camera);
        Ok(encode(&scene, &default::files())?)
    }

    /// Sets a parameter of the first object.
    ///
    /// # Errors
    /// A message that there is no such parameter.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), JsValue> {
        let object = &mut self.scene.objects[0];
        match name {
            "depth" => object.depth = Some(value),
            "extension" => object.extrusion.extension = value,
            "bevel" => object.extrusion.bevel = value,
            "chamfer" => object.extrusion.chamfer = value,
            "cut-out" => object.cut_out = value > 0.0,
            "invert" => object.invert = value > 0.0,
            "shadows" => object.self_shadow = value > 0.0,
            "repeat-u" => object.repeat[0] = value,
            "repeat-v" => object.repeat[1] = value,
            "accurate" => {
                object.tier = if value > 0.0 {
                    Tier::Accurate
                } else {
                    Tier::Fast
                };
                object.tidy();
            }
            _ => return Err(format!("there is no parameter {name:?}").into()),
        }
        self.prepared = None;
        Ok(())
    }

    /// Returns the parameters that [`CpuPage::set`] sets, as JSON: pairs of name and value.
    pub fn values(&self) -> String {
        let object = &self.scene.objects[0];
        let flag = |flag: bool| f64::from(u8::from(flag));
        let depth = object.depth.map(|depth| ("depth", depth));
        let others = [
            ("extension", object.extrusion.extension),
            ("bevel", object.extrusion.bevel),
            ("chamfer", object.extrusion.chamfer),
            ("cut-out", flag(object.cut_out)),
            ("invert", flag(object.invert)),
            ("shadows", flag(object.self_shadow)),
            ("repeat-u", object.repeat[0]),
            ("repeat-v", object.repeat[1]),
            ("accurate", flag(object.tier == Tier::Accurate)),
        ];
        let all: Vec<(&str, f64)> = depth.into_iter().chain(others).collect();
        // Strings and numbers always serialize.
        serde_json::to_string(&all).unwrap_or_default()
    }

    /// Turns (radians), moves (picture heights) and zooms (factor) the camera.
    pub fn turn(&mut self, yaw: f64, pitch: f64, right: f64, up: f64, factor: f64) {
        if let Some(camera) = self.camera {
            let turned = orbit::orbit(&camera, yaw, pitch);
            let moved = orbit::pan(&turned, right, up, self.scene.field_of_view);
            self.camera = Some(orbit::zoom(&moved, factor));
        }
    }

    /// Selects the viewer's display of this name.
    ///
    /// # Errors
    /// A message that there is no such display.
    pub fn show(&mut self, name: &str) -> Result<(), JsValue> {
        let found = Show::ALL.into_iter().find(|show| show.name() == name);
        self.show = found.ok_or_else(|| format!("there is no view {name:?}"))?;
        Ok(())
    }

    /// Sets letters as the pattern.
    pub fn letter(&mut self, text: &str) {
        self.scene.objects[0].shape = Shape::Text(Lettering {
            text: text.to_string(),
            font: None,
            margin: Lettering::DEFAULT_MARGIN,
        });
        self.prepared = None;
    }

    /// Sets a file as the mesh or the pattern, by its ending.
    pub fn adopt(&mut self, name: &str, bytes: Vec<u8>) {
        if adopt(&mut self.scene, 0, Path::new(name), bytes) {
            self.camera = None;
        }
        self.prepared = None;
    }

    /// Renders RGBA of a picture of this size.
    ///
    /// # Errors
    /// The message, as a string.
    pub fn render(&mut self, width: u32, height: u32) -> Result<Vec<u8>, JsValue> {
        let prepared = match &mut self.prepared {
            Some(prepared) => prepared,
            none => {
                let made = plan_with(&self.scene.without_tracks(), &mut self.assets, &|_| ())
                    .map_err(|error| error.to_string())?;
                none.insert(made.scene)
            }
        };
        let camera = *self.camera.get_or_insert(prepared.camera);
        let frame = prepared.frame_from(&self.scene, &camera, [width, height]);
        let mut renderer = CpuRenderer::new(prepared);
        let pixels = match self.show.content() {
            Content::Color => renderer
                .color(&frame)
                .map(|words| display::color_bytes(&words, &self.scene.development)),
            Content::Geometry => renderer.geometry(&frame).map(|words| {
                display::geometry_bytes(self.show, &words, &Scale::of(prepared, &camera))
            }),
        };
        Ok(pixels.map_err(|error| error.to_string())?)
    }

    /// Returns the scene file.
    pub fn scene(&self) -> String {
        self.scene.seen_from(self.camera).to_toml(Path::new(""))
    }
}
