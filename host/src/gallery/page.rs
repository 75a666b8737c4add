//! The gallery's page, in HTML for a browser and in Markdown for a repository.

use super::{Figure, Numbers, Panel, Show};
use std::collections::BTreeSet;

/// A panel and what was measured of it.
pub struct Drawn {
    /// The panel.
    pub panel: Panel,
    /// Its numbers.
    pub numbers: Numbers,
}

/// A figure with its panels, row by row.
pub type DrawnFigure<'a> = (&'a Figure, Vec<Vec<Drawn>>);

const TITLE: &str = "The paper's figures";

/// What the ways are.
const WAYS: &str = "Three ways are shown side by side. planar: extrusion mapping along straight \
                    rays. paper: the paper's algorithms as printed, mistakes included. fast: \
                    Relievo, with rays that bend along the local quadric.";

const STYLE: &str = include_str!("page.css");

/// The page for a browser; it needs nothing but the pictures beside it.
pub fn html(figures: &[DrawnFigure<'_>], size: [u32; 2]) -> String {
    let mut body = String::new();
    for (figure, rows) in figures {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
        let panels: String = rows
            .iter()
            .flatten()
            .map(|drawn| html_panel(drawn, size))
            .collect();
        body += &format!(
            "<section id=\"figure-{number}\">\n<h2>Figure {number}. {}</h2>\n<p>{}</p>\n\
             <div class=\"panels\" style=\"--columns: {columns}\">\n{panels}</div>\n</section>\n",
            escaped(figure.title),
            escaped(figure.caption),
            number = figure.number,
        );
    }
    let links: String = figures
        .iter()
        .map(|(figure, _)| format!("<a href=\"#figure-{0}\">{0}</a>\n", figure.number))
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>Relievo: {TITLE}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<h1>{TITLE}</h1>\n<p>{WAYS}</p>\n<nav>Figure {links}</nav>\n</header>\n\
         <main>\n{body}</main>\n<footer>\n<p>{}</p>\n</footer>\n</body>\n</html>\n",
        escaped(&notes(figures, size)),
    )
}

fn html_panel(drawn: &Drawn, [width, height]: [u32; 2]) -> String {
    let panel = &drawn.panel;
    let (picture, scene) = (panel.picture_file(), panel.scene_file());
    let lines: String = lines(drawn)
        .iter()
        .map(|line| format!("<span>{}</span>\n", escaped(line)))
        .collect();
    format!(
        "<figure>\n<a href=\"{picture}\"><img src=\"{picture}\" width=\"{width}\" \
         height=\"{height}\" loading=\"lazy\" alt=\"{label}\"></a>\n\
         <figcaption>\n<b>{label}</b>\n{lines}<a href=\"{scene}\">scene</a>\n\
         </figcaption>\n</figure>\n",
        label = escaped(&panel.label()),
    )
}

/// The page for a repository's reader.
pub fn markdown(figures: &[DrawnFigure<'_>], size: [u32; 2]) -> String {
    let mut text = format!("# {TITLE}\n\n{WAYS}\n");
    for (figure, rows) in figures {
        text += &format!(
            "\n## Figure {}. {}\n\n{}\n",
            figure.number, figure.title, figure.caption
        );
        let mut columns = 0;
        for row in rows {
            // A table has one number of columns.
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

/// The numbers under a panel, line by line.
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

/// What the numbers are, and how they came about.
fn notes(figures: &[DrawnFigure<'_>], [width, height]: [u32; 2]) -> String {
    let renderers: BTreeSet<&str> = figures
        .iter()
        .flat_map(|(_, rows)| rows.iter().flatten())
        .map(|drawn| drawn.numbers.renderer.as_str())
        .collect();
    let renderers: Vec<&str> = renderers.into_iter().collect();
    format!(
        "The numbers: pixels in which something is hit, average steps of the linear search in \
         those, and the time of drawing this picture once with four samples a pixel, in one run \
         on the machine that made this page: no benchmark. Of a torus also: agreement of the \
         silhouette with the closed form (intersection over union), pixels that should be hit \
         and are not (holes; interior ones lie more than a pixel inside the outline), and pixels \
         that are hit and should not be (extra), at one sample a pixel. Pictures of {width} × \
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

/// `text` as it may stand in HTML, in quotes too.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::FIGURES;
    use super::*;
    use crate::oracle::Accuracy;
    use std::time::Duration;

    fn drawn() -> Vec<DrawnFigure<'static>> {
        let numbers = Numbers {
            covered: 12_345,
            steps: 7.25,
            time: Duration::from_millis(41),
            renderer: "GPU <new & fast>".to_string(),
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
    fn both_pages_list_every_panel_with_its_numbers() {
        let figures = drawn();
        let pages = [html(&figures, [400, 300]), markdown(&figures, [400, 300])];
        for page in &pages {
            assert!(page.contains("12,345 pixels, 7.2 steps, 41 ms"));
            assert!(page.contains("IoU 0.9877; 1,234 holes, 56 of them interior; 7 extra"));
            for (figure, rows) in &figures {
                assert!(page.contains(&format!("Figure {}. {}", figure.number, figure.title)));
                for drawn in rows.iter().flatten() {
                    let panel = &drawn.panel;
                    assert!(
                        page.contains(&format!("{}\"", panel.picture_file()))
                            || page.contains(&format!("]({})", panel.picture_file()))
                    );
                    assert!(page.contains(&panel.scene_file()));
                    assert!(page.contains(&panel.label()));
                }
            }
        }
        assert!(pages[0].contains("GPU &lt;new &amp; fast&gt;"));
        // Nothing is loaded from elsewhere.
        assert!(!pages[0].contains("http") && !pages[0].contains("<script"));
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
