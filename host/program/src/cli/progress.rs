//! Progress bars on standard error.

use indicatif::{ProgressBar, ProgressStyle};
use relievo::prepare::Step;
use std::path::Path;
use std::time::Duration;

/// A progress bar, hidden if standard error is not a terminal.
pub struct Bar(ProgressBar);

impl Bar {
    /// Creates a bar that appears once something takes a while.
    pub fn new() -> Bar {
        let bar = ProgressBar::new(1000);
        let style = ProgressStyle::with_template("{spinner} {msg} {wide_bar} {percent:>3}%")
            .expect("the template is valid");
        bar.set_style(style);
        bar.enable_steady_tick(Duration::from_millis(200));
        Bar(bar)
    }

    /// Shows `message` and `fraction`, 0…1.
    pub fn show(&self, message: String, fraction: f64) {
        self.0.set_message(message);
        self.0.set_position((1000.0 * fraction) as u64);
    }

    /// Shows a preparation step.
    pub fn step(&self, step: &Step) {
        let name = |path: &Path| {
            path.file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
        };
        match step {
            Step::Mesh(path) => self.show(format!("mesh {}", name(path)), 0.0),
            Step::ShapeMap(shape, fraction) => {
                self.show(format!("shape map {}", shape.label()), *fraction);
            }
            Step::Plan(object) => self.show(format!("plan for {object}"), 0.0),
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
