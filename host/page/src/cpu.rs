//! Pictures by the CPU, for a worker of a page without WebGPU.

use crate::default;
use relievo::prepare::{Assets, PreparedScene, prepare_with};
use relievo::render::gpu::Content;
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Camera, Lettering, Scene, Shape, Tier};
use relievo::viewer::display::{self, Scale, Show};
use relievo::viewer::dropped::adopt;
use relievo::viewer::orbit;
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
    files: u64,
}

#[wasm_bindgen]
impl CpuPage {
    /// The default scene.
    ///
    /// # Errors
    /// What stands against it, as a text.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Result<CpuPage, JsValue> {
        console_error_panic_hook::set_once();
        let scene = default::scene().map_err(|error| error.to_string())?;
        Ok(CpuPage {
            camera: scene.camera,
            scene,
            assets: Assets::default(),
            prepared: None,
            show: Show::default(),
            files: 0,
        })
    }

    /// Gives a parameter of the first object another value.
    ///
    /// # Errors
    /// That there is no such parameter, as a text.
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

    /// Turns (radians), moves (shares of the height) and zooms (a factor).
    pub fn turn(&mut self, yaw: f64, pitch: f64, right: f64, up: f64, factor: f64) {
        if let Some(camera) = self.camera {
            let turned = orbit::orbit(&camera, yaw, pitch);
            let moved = orbit::pan(&turned, right, up, self.scene.field_of_view);
            self.camera = Some(orbit::zoom(&moved, factor));
        }
    }

    /// Shows pixels as the viewer does under this name.
    ///
    /// # Errors
    /// That there is no such view, as a text.
    pub fn show(&mut self, name: &str) -> Result<(), JsValue> {
        let found = Show::ALL.into_iter().find(|show| show.name() == name);
        self.show = found.ok_or_else(|| format!("there is no view {name:?}"))?;
        Ok(())
    }

    /// Makes letters the pattern.
    pub fn letter(&mut self, text: &str) {
        self.scene.objects[0].shape = Shape::Text(Lettering {
            text: text.to_string(),
            font: None,
            margin: Lettering::DEFAULT_MARGIN,
        });
        self.prepared = None;
    }

    /// Makes a file the mesh or the pattern, by its ending.
    pub fn adopt(&mut self, name: &str, bytes: Vec<u8>) {
        self.files += 1;
        if adopt(&mut self.scene, 0, Path::new(name), bytes, self.files) {
            self.camera = None;
        }
        self.prepared = None;
    }

    /// Red, green, blue and alpha of a picture of this size.
    ///
    /// # Errors
    /// What stands against it, as a text.
    pub fn render(&mut self, width: u32, height: u32) -> Result<Vec<u8>, JsValue> {
        let prepared = match &mut self.prepared {
            Some(prepared) => prepared,
            none => {
                let made = prepare_with(&self.scene, &mut self.assets, &|_| ())
                    .map_err(|error| error.to_string())?;
                none.insert(made)
            }
        };
        let camera = *self.camera.get_or_insert(prepared.camera);
        let frame = prepared.frame_from(&self.scene, &camera, [width, height]);
        let mut renderer = CpuRenderer::new(prepared);
        let pixels = match self.show.content() {
            Content::Color => renderer
                .color(&frame)
                .map(|words| display::color_bytes(&words)),
            Content::Geometry => renderer.geometry(&frame).map(|words| {
                display::geometry_bytes(self.show, &words, &Scale::of(prepared, &camera))
            }),
        };
        Ok(pixels.map_err(|error| error.to_string())?)
    }

    /// The scene as a file.
    pub fn scene(&self) -> String {
        let scene = Scene {
            camera: self.camera,
            ..self.scene.clone()
        };
        scene.to_toml(Path::new(""))
    }
}
