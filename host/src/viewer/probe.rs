//! What is on the window, as data: for tests and for other programs.

use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// A control as it was shown last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// What stands on it.
    pub label: String,
    /// Left, top, right and bottom, in points of the window.
    pub rectangle: [f32; 4],
    /// Its value, as text.
    pub value: String,
}

/// The state of the viewer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// Controls, in the order of the keyboard.
    pub controls: Vec<Control>,
    /// Frames that were drawn since the start.
    pub frames: u64,
    /// Milliseconds that the last one took on the device; 0 before the first.
    pub frame_ms: f64,
    /// Its size, pixels.
    pub frame_size: [u32; 2],
    /// Whether the picture shows all that the controls say, at full resolution.
    pub settled: bool,
    /// What renders.
    pub renderer: String,
    /// What was said last.
    pub message: String,
    /// The scene as it would be saved.
    pub scene: String,
    /// Milliseconds from the start to the first picture.
    pub first_picture_ms: Option<f64>,
}

/// Collects controls while they are shown.
#[derive(Default)]
pub struct Collector(RefCell<Vec<Control>>);

impl Collector {
    /// A control is there.
    pub fn add(&self, label: &str, rectangle: eframe::egui::Rect, value: impl ToString) {
        self.0.borrow_mut().push(Control {
            label: label.to_string(),
            rectangle: [
                rectangle.min.x,
                rectangle.min.y,
                rectangle.max.x,
                rectangle.max.y,
            ],
            value: value.to_string(),
        });
    }

    /// All of them, in order.
    pub fn into_controls(self) -> Vec<Control> {
        self.0.into_inner()
    }
}
