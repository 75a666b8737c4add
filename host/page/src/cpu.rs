//! Pictures by the CPU, for a worker of a page without WebGPU.

use crate::default;
use relievo::Files;
use relievo::prepare::{Assets, PreparedScene, prepare_with};
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::{Camera, Scene, Shape, Tier};
use relievo::viewer::{display, orbit};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// A scene in a worker.
#[wasm_bindgen]
pub struct CpuPage {
    scene: Scene,
    assets: Assets,
    prepared: Option<PreparedScene>,
    camera: Option<Camera>,
    files: u32,
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
            "bevel" => {
                object.extrusion.bevel = value;
                object.extrusion.chamfer = 1.0;
            }
            "repeat-u" => object.repeat[0] = value,
            "repeat-v" => object.repeat[1] = value,
            "accurate" => {
                object.tier = if value > 0.0 {
                    Tier::Accurate
                } else {
                    Tier::Fast
                };
                (object.steps, object.bisections) = object.tier.default_effort();
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

    /// Makes a file the mesh or the pattern, by its ending.
    pub fn adopt(&mut self, name: &str, bytes: Vec<u8>) {
        self.files += 1;
        let path = PathBuf::from(format!("dropped-{}/{name}", self.files));
        let object = &mut self.scene.objects[0];
        if let Files::Memory(files) = &mut self.scene.files {
            Arc::make_mut(files).insert(path.clone(), bytes.into());
        }
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        if ["obj", "gltf", "glb"].contains(&ending.to_lowercase().as_str()) {
            object.mesh = path;
            object.depth = None;
            (self.scene.camera, self.camera) = (None, None);
        } else {
            (object.shape, object.raster) = (Shape::File(path), None);
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
        let words = CpuRenderer::new(prepared)
            .color(&frame)
            .map_err(|error| error.to_string())?;
        Ok(display::color_bytes(&words))
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
