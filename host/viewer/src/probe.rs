//! State of the window as data, for tests and other programs.

use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// A control as last shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Control {
    /// Its label.
    pub label: String,
    /// Left, top, right and bottom, points from the window's upper left corner.
    pub rectangle: [f32; 4],
    /// Its value, as text.
    pub value: String,
}

/// State of the viewer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    /// Controls, in keyboard order.
    pub controls: Vec<Control>,
    /// Place of the pointer in the window, points; none while it is elsewhere.
    pub pointer: Option<[f32; 2]>,
    /// Whether a button of the pointer is down.
    pub is_pressed: bool,
    /// Frames drawn since the start.
    pub frames: u64,
    /// Device time of the last frame, milliseconds; 0 before the first.
    pub frame_ms: f64,
    /// Size of the last frame, pixels.
    pub frame_size: [u32; 2],
    /// Whether a scene is being prepared.
    pub is_preparing: bool,
    /// Whether the picture is up to date at full resolution.
    pub settled: bool,
    /// Name of the renderer.
    pub renderer: String,
    /// Last message.
    pub message: String,
    /// Scene file as it would be saved.
    pub scene: String,
    /// Time from the start to the first picture, milliseconds.
    pub first_picture_ms: Option<f64>,
}

/// Collects controls while they are drawn.
#[derive(Default)]
pub struct Collector(RefCell<Vec<Control>>);

impl Collector {
    /// Records a control.
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

    /// Returns the controls, in order.
    pub fn into_controls(self) -> Vec<Control> {
        self.0.into_inner()
    }
}
