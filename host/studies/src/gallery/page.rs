//! Markdown page of the gallery.

use super::{Figure, Panel, Show};
use relievo::oracle::Accuracy;
use std::collections::BTreeSet;
use std::time::Duration;

/// Measurements of a panel's scene, at one sample per pixel except for the
/// time.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers {
    /// Pixels with a hit.
    pub covered: usize,
    /// Linear search steps, mean over those pixels.
    pub steps: f64,
    /// Time to draw the picture once, with all samples.
    pub time: Duration,
    /// Name of the renderer.
    pub renderer: String,
    /// Errors against the oracle, if there is one.
    pub accuracy: Option<Accuracy>,
}

/// A panel with its measurements.
pub struct Drawn {
    /// The panel.
    pub panel: Panel,
    /// Its measurements.
    pub numbers: Numbers,
}

/// A figure with its panels, row by row.
pub type DrawnFigure<'a> = (&'a Figure, Vec<Vec<Drawn>>);

const TITLE: &str = "The paper's figures";

/// Explanation of the ways.
const WAYS: &str = "Three ways are shown side by side. planar: extrusion mapping along straight \
                    rays. paper: the paper's algorithms as printed, mistakes included. fast: \
                    Relievo, with rays that bend along the local quadric.";

/// Writes the page.
pub fn markdown(figures: &[DrawnFigure<'_>], size: [u32; 2]) -> String {
    let mut text = format!("# {TITLE}\n\n{WAYS}\n");
    for (figure, rows) in figures {
        text += &format!(
            "\n## Figure {}. {}\n\n{}\n",
            figure.number, figure.title, figure.caption
        );
        let mut columns = 0;
        for row in rows {
            // A table has a fixed number of columns.
            if row.len() != columns {
                columns = row.len();
                text += &format!(
                    "\n|{}\n|{}\n",
                    "  |".repeat(columns),
                    "---|".repeat(columns)
                );
            }
            text += "|";
            for drawn in row {
                let panel = &drawn.panel;
                let label = panel.label();
                let cell: Vec<String> =
                    std::iter::once(format!("![{label}]({})", panel.picture_file()))
                        .chain([format!("**{label}**")])
                        .chain(lines(drawn))
                        .chain([format!("[scene]({})", panel.scene_file())])
                        .collect();
                text += &format!(" {} |", cell.join("<br>"));
            }
            text += "\n";
        }
    }
    text + "\n" + &notes(figures, size) + "\n"
}

/// Returns the lines of numbers under a panel.
fn lines(drawn: &Drawn) -> Vec<String> {
    let numbers = &drawn.numbers;
    let show = drawn.panel.way.show;
    let mut lines = Vec::new();
    if matches!(show, Show::Picture | Show::Mesh) {
        lines.push(format!(
            "{} pixels, {:.1} steps, {:.0} ms",
            grouped(numbers.covered),
            numbers.steps,
            1e3 * numbers.time.as_secs_f64()
        ));
    }
    if let (Some(accuracy), true) = (&numbers.accuracy, show != Show::Truth) {
        lines.push(format!(
            "IoU {:.4}; {} holes, {} of them interior; {} extra",
            accuracy.silhouette_iou,
            grouped(accuracy.holes),
            grouped(accuracy.interior_holes),
            grouped(accuracy.extra)
        ));
    }
    lines
}

/// Explains the numbers and how they were measured.
fn notes(figures: &[DrawnFigure<'_>], [width, height]: [u32; 2]) -> String {
    let renderers: BTreeSet<&str> = figures
        .iter()
        .flat_map(|(_, rows)| rows.iter().flatten())
        .map(|drawn| drawn.numbers.renderer.as_str())
        .collect();
    let renderers: Vec<&str> = renderers.into_iter().collect();
    format!(
        "Numbers: pixels with a hit, mean steps of the linear search in those, and the time of one \
         drawing with four samples per pixel on the machine that made this page (not a benchmark). \
         For the torus, at one sample per pixel: intersection over union of the silhouette with the \
         closed form, holes (pixels missed that should be hit; interior ones are more than a pixel \
         inside the outline), and extra pixels (hit, but should not be). Pictures of {width} × \
         {height} pixels, drawn by relievo {} on: {}.",
        env!("CARGO_PKG_VERSION"),
        renderers.join(", "),
    )
}

/// `1234567` → `1,234,567`.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::FIGURES;
    use super::*;

    fn drawn() -> Vec<DrawnFigure<'static>> {
        let numbers = Numbers {
            covered: 12_345,
            steps: 7.25,
            time: Duration::from_millis(41),
            renderer: "a GPU".to_string(),
            accuracy: Some(Accuracy {
                silhouette_iou: 0.98765,
                holes: 1_234,
                interior_holes: 56,
                extra: 7,
                distance_rmse: 0.0,
                distance_p99: 0.0,
                class_errors: 0.0,
                confusion: [[0; 4]; 4],
            }),
        };
        let measured = |panel| Drawn {
            panel,
            numbers: numbers.clone(),
        };
        FIGURES
            .iter()
            .map(|figure| {
                let rows = figure.rows().into_iter();
                let rows = rows.map(|row| row.into_iter().map(measured).collect());
                (figure, rows.collect())
            })
            .collect()
    }

    #[test]
    fn the_page_lists_every_panel_with_its_numbers() {
        let figures = drawn();
        let page = markdown(&figures, [400, 300]);
        assert!(page.contains("12,345 pixels, 7.2 steps, 41 ms"));
        assert!(page.contains("IoU 0.9877; 1,234 holes, 56 of them interior; 7 extra"));
        for (figure, rows) in &figures {
            assert!(page.contains(&format!("Figure {}. {}", figure.number, figure.title)));
            for drawn in rows.iter().flatten() {
                let panel = &drawn.panel;
                assert!(page.contains(&format!("]({})", panel.picture_file())));
                assert!(page.contains(&panel.scene_file()));
                assert!(page.contains(&panel.label()));
            }
        }
    }

    #[test]
    fn tables_have_as_many_cells_as_columns() {
        let text = markdown(&drawn(), [400, 300]);
        let mut columns = 0;
        for line in text.lines().filter(|line| line.starts_with('|')) {
            if line.starts_with("|---") {
                columns = line.matches('|').count();
            } else if line.contains("![") {
                assert_eq!(line.matches('|').count(), columns, "{line}");
            }
        }
        assert!(columns > 0);
    }

    #[test]
    fn numbers_are_grouped() {
        let grouped = [0, 7, 999, 1_000, 120_000, 1_234_567].map(grouped);
        assert_eq!(grouped, ["0", "7", "999", "1,000", "120,000", "1,234,567"]);
    }
}
