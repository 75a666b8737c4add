//! The worker that prepares and analyses scenes: both of its ends.

use js_sys::{Array, Reflect, Uint8Array};
use relievo_viewer::away;
use relievo_viewer::platform::{News, Worker};
use relievo_viewer::watch::Wake;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use wasm_bindgen::prelude::*;
use web_sys::{ErrorEvent, MessageEvent, WorkerOptions, WorkerType};

/// The program of the worker, beside the page.
const PROGRAM: &str = "workshop.js";

/// The end in the worker.
#[wasm_bindgen]
#[derive(Default)]
pub struct Station(away::Station);

#[wasm_bindgen]
impl Station {
    /// Creates a station without files and scenes.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Station {
        console_error_panic_hook::set_once();
        Station::default()
    }

    /// Executes an order, and returns the delivery.
    ///
    /// # Errors
    /// The message, as a string.
    pub fn work(&mut self, order: &[u8]) -> Result<Vec<u8>, JsValue> {
        Ok(self.0.work(order)?)
    }
}

/// The end in the page.
struct Remote {
    worker: web_sys::Worker,
    news: Rc<RefCell<VecDeque<News>>>,
    // Called by the worker as long as it runs.
    _on_message: Closure<dyn Fn(MessageEvent)>,
    _on_error: Closure<dyn Fn(ErrorEvent)>,
}

/// Starts a worker, which calls `wake` when there are news.
///
/// # Errors
/// Why the browser has none.
pub fn start(wake: Wake) -> Result<Box<dyn Worker>, String> {
    let started = Remote::start(wake).map_err(|error| format!("{error:?}"))?;
    Ok(Box::new(started))
}

impl Remote {
    fn start(wake: Wake) -> Result<Remote, JsValue> {
        let options = WorkerOptions::new();
        options.set_type(WorkerType::Module);
        let worker = web_sys::Worker::new_with_options(PROGRAM, &options)?;
        let news: Rc<RefCell<VecDeque<News>>> = Rc::default();
        let tell = {
            let news = news.clone();
            move |new: News| {
                news.borrow_mut().push_back(new);
                wake();
            }
        };
        let on_message = {
            let tell = tell.clone();
            Closure::new(move |event: MessageEvent| tell(read(&event.data())))
        };
        let on_error = Closure::new(move |event: ErrorEvent| {
            // An event without a message: its program cannot be loaded.
            let message = Reflect::get(&event, &"message".into());
            let message = message.ok().and_then(|message| message.as_string());
            let missing = || format!("{PROGRAM} cannot be loaded");
            tell(News::Stopped(message.unwrap_or_else(missing)));
        });
        worker.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
        worker.set_onerror(Some(on_error.as_ref().unchecked_ref()));
        worker.post_message(&wasm_bindgen::module())?;
        Ok(Remote {
            worker,
            news,
            _on_message: on_message,
            _on_error: on_error,
        })
    }
}

/// Reads a message of `workshop.js`.
fn read(data: &JsValue) -> News {
    if let Some(bytes) = data.dyn_ref::<Uint8Array>() {
        return News::Reply(bytes.to_vec());
    }
    match Reflect::get(data, &"error".into()) {
        Ok(error) if !error.is_undefined() => {
            News::Stopped(error.as_string().unwrap_or_else(|| format!("{error:?}")))
        }
        _ => News::Ready,
    }
}

impl Worker for Remote {
    fn send(&mut self, order: Vec<u8>) {
        let order = Uint8Array::from(order.as_slice());
        let moved = Array::of1(&order.buffer());
        if let Err(error) = self.worker.post_message_with_transfer(&order, &moved) {
            let mut news = self.news.borrow_mut();
            news.push_back(News::Stopped(format!("{error:?}")));
        }
    }

    fn news(&mut self) -> Option<News> {
        self.news.borrow_mut().pop_front()
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        self.worker.terminate();
    }
}
