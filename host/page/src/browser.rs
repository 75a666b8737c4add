//! The browser as the viewer's platform.

use crate::archive::pack;
use js_sys::{Array, Uint8Array};
use relievo::export::ExportedFile;
use relievo_viewer::platform::Platform;
use relievo_viewer::probe::Probe;
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use wasm_bindgen::closure::Closure;
use wasm_bindgen::{JsCast, JsValue};

/// Saves files as downloads.
pub struct Browser {
    /// Last state of the viewer, as JSON.
    pub told: Rc<RefCell<String>>,
}

impl Platform for Browser {
    fn save_file(&mut self, name: &str, bytes: &[u8]) -> Result<String, String> {
        download(name, bytes)
            .map_err(|error| format!("the browser cannot download {name}: {error:?}"))?;
        Ok(name.to_string())
    }

    fn save_folder(&mut self, name: &str, files: &[ExportedFile]) -> Result<String, String> {
        self.save_file(&format!("{name}.zip"), &pack(name, files)?)
    }

    fn folder(&self) -> &Path {
        Path::new("")
    }

    fn listens(&self) -> bool {
        true
    }

    fn tell(&mut self, probe: &Probe) {
        // Strings and numbers always serialize.
        *self.told.borrow_mut() = serde_json::to_string(probe).unwrap_or_default();
    }
}

/// Starts the download of a file.
fn download(name: &str, bytes: &[u8]) -> Result<(), JsValue> {
    let parts = Array::of1(&Uint8Array::from(bytes));
    let blob = web_sys::Blob::new_with_u8_array_sequence(&parts)?;
    let url = web_sys::Url::create_object_url_with_blob(&blob)?;
    let window = web_sys::window().ok_or("there is no window")?;
    let document = window.document().ok_or("there is no page")?;
    let anchor: web_sys::HtmlAnchorElement = document.create_element("a")?.dyn_into()?;
    anchor.set_href(&url);
    anchor.set_download(name);
    anchor.click();
    // The browser may start reading a moment later.
    let forget = Closure::once_into_js(move || web_sys::Url::revoke_object_url(&url));
    window.set_timeout_with_callback_and_timeout_and_arguments_0(forget.unchecked_ref(), 60_000)?;
    Ok(())
}
