//! The browser as the viewer's platform.

use crate::archive::pack;
use crate::{default, station};
use js_sys::{Array, Uint8Array};
use relievo::export::ExportedFile;
use relievo::scene::Scene;
use relievo_viewer::dropped::Arrived;
use relievo_viewer::link::encode;
use relievo_viewer::platform::{Platform, StartWorker};
use relievo_viewer::probe::Probe;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use wasm_bindgen::closure::Closure;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;

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

    fn choose(&mut self, arrived: &Arrived) -> bool {
        if let Err(error) = choose(arrived.clone()) {
            let name = PathBuf::from("a file");
            arrived.add(
                name,
                Err(format!("the browser cannot ask for it: {error:?}")),
            );
        }
        true
    }

    fn workers(&self) -> Option<StartWorker> {
        Some(Box::new(station::start))
    }

    fn has_links(&self) -> bool {
        true
    }

    fn link(&mut self, scene: &Scene) -> Result<String, String> {
        let fragment = encode(scene, &default::files())?;
        address(&fragment).map_err(|error| format!("the page has no address: {error:?}"))
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

/// Puts the fragment into the page's address, and returns the address.
fn address(fragment: &str) -> Result<String, JsValue> {
    let window = web_sys::window().ok_or("there is no window")?;
    // Without a new entry in the history.
    let fragment = format!("#{fragment}");
    window
        .history()?
        .replace_state_with_url(&JsValue::NULL, "", Some(&fragment))?;
    window.location().href()
}

/// Asks the user for a file.
fn choose(arrived: Arrived) -> Result<(), JsValue> {
    let window = web_sys::window().ok_or("there is no window")?;
    let document = window.document().ok_or("there is no page")?;
    let input: web_sys::HtmlInputElement = document.create_element("input")?.dyn_into()?;
    input.set_type("file");
    input.set_accept(".obj,.gltf,.glb,.toml,.svg,image/*");
    let chosen = input.clone();
    let read = Closure::once_into_js(move || {
        let Some(file) = chosen.files().and_then(|files| files.get(0)) else {
            return;
        };
        wasm_bindgen_futures::spawn_local(async move {
            let bytes = JsFuture::from(file.array_buffer()).await;
            let bytes = bytes.map(|buffer| Uint8Array::new(&buffer).to_vec());
            let bytes = bytes.map_err(|error| format!("{error:?}"));
            arrived.add(PathBuf::from(file.name()), bytes);
        });
    });
    input.set_onchange(Some(read.unchecked_ref()));
    input.click();
    Ok(())
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
