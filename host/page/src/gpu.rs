//! The whole viewer, with WebGPU.

use crate::browser::Browser;
use crate::default;
use eframe::WebRunner;
use relievo_viewer::Viewer;
use relievo_viewer::web::options;
use std::cell::RefCell;
use std::rc::Rc;
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;
use web_time::Instant;

/// The viewer on a canvas.
#[wasm_bindgen]
pub struct GpuPage {
    runner: WebRunner,
    told: Rc<RefCell<String>>,
}

#[wasm_bindgen]
impl GpuPage {
    /// Creates a viewer that shows nothing yet.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::new_without_default, reason = "JavaScript has no defaults")]
    pub fn new() -> GpuPage {
        console_error_panic_hook::set_once();
        GpuPage {
            runner: WebRunner::new(),
            told: Rc::default(),
        }
    }

    /// Shows the scene of `fragment`, of the page's address, on `canvas`. Returns a
    /// message if it shows the default scene in place of it.
    ///
    /// # Errors
    /// The message, as a string.
    pub async fn start(
        &self,
        canvas: HtmlCanvasElement,
        fragment: String,
    ) -> Result<Option<String>, JsValue> {
        let started = Instant::now();
        let (scene, problem) = default::scene_of(&fragment).map_err(|error| error.to_string())?;
        let browser = Browser {
            told: self.told.clone(),
        };
        let create: eframe::AppCreator<'static> = Box::new(move |context| {
            let viewer = Viewer::new(context, scene, Box::new(browser), started)?;
            Ok(Box::new(viewer))
        });
        self.runner.start(canvas, options(), create).await?;
        Ok(problem)
    }

    /// Returns the state of the page as JSON.
    pub fn probe(&self) -> String {
        self.told.borrow().clone()
    }
}
