//! Charts of lines on logarithmic axes, in panels.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::series::LineSeries;
use std::error::Error as StdError;

/// Any error of the drawing library.
pub(crate) type DrawResult = Result<(), Box<dyn StdError>>;
/// A part of a drawing.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const PANEL: (u32, u32) = (340, 270);
const LEGEND_HEIGHT: u32 = 34;
const COLORS: [RGBColor; 6] = [
    RGBColor(192, 30, 60),
    RGBColor(31, 95, 180),
    RGBColor(40, 140, 80),
    RGBColor(230, 140, 20),
    RGBColor(120, 80, 170),
    RGBColor(90, 90, 90),
];

/// A line: x and y of its points, all above 0, in the order of x.
pub type Line = Vec<(f64, f64)>;

/// One pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// What is shown, with its unit.
    pub title: String,
    /// What varies.
    pub x: String,
    /// A line for each name of the legend; empty where nothing was measured.
    pub lines: Vec<Line>,
}

/// Draws rows of panels below a legend of `names`, as SVG.
///
/// # Errors
/// What the drawing library reports.
pub fn draw(names: &[&str], rows: &[Vec<Panel>]) -> Result<String, String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let size = (
        columns * PANEL.0,
        LEGEND_HEIGHT + rows.len() as u32 * PANEL.1,
    );
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let (legend, body) = root.split_vertically(LEGEND_HEIGHT);
        let drawn = root
            .fill(&WHITE)
            .map_err(|error| error.to_string())
            .and_then(|()| {
                draw_legend(&legend, names).map_err(|error| error.to_string())?;
                let areas = body.split_evenly((rows.len(), columns as usize));
                for (row, areas) in rows.iter().zip(areas.chunks(columns.max(1) as usize)) {
                    for (panel, area) in row.iter().zip(areas) {
                        panel.draw(area).map_err(|error| error.to_string())?;
                    }
                }
                root.present().map_err(|error| error.to_string())
            });
        drawn?;
    }
    Ok(svg)
}

fn draw_legend(area: &Area<'_>, names: &[&str]) -> DrawResult {
    let mut x = 20;
    for (name, color) in names.iter().zip(COLORS) {
        area.draw(&PathElement::new(
            [(x, 18), (x + 28, 18)],
            color.stroke_width(3),
        ))?;
        area.draw(&Text::new(
            name.to_string(),
            (x + 36, 11),
            ("sans-serif", 17),
        ))?;
        x += 80 + 8 * name.chars().count() as i32;
    }
    Ok(())
}

impl Panel {
    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let points = || self.lines.iter().flatten();
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            // Room around the lines; something to draw without any.
            if high > 0.0 {
                (low / 1.3)..(high * 1.3)
            } else {
                1.0..10.0
            }
        };
        let x = range(&mut points().map(|point| point.0));
        let y = range(&mut points().map(|point| point.1));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 16))
            .margin(6)
            .margin_right(14)
            .x_label_area_size(38)
            .y_label_area_size(56)
            .build_cartesian_2d(x.log_scale(), y.log_scale())?;
        chart
            .configure_mesh()
            .max_light_lines(1)
            .x_labels(6)
            .y_labels(6)
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .label_style(("sans-serif", 13))
            .x_desc(&self.x)
            .draw()?;
        for (line, color) in self.lines.iter().zip(COLORS) {
            chart.draw_series(LineSeries::new(line.iter().copied(), color.stroke_width(2)))?;
            let marks = line
                .iter()
                .map(|point| Circle::new(*point, 3, color.filled()));
            chart.draw_series(marks)?;
        }
        Ok(())
    }
}

/// Formats a tick: 0.5, 20, 3k, 2M.
fn short(value: &f64) -> String {
    let scaled = |divisor: f64, unit: &str| {
        let number = value / divisor;
        let rounded = (number * 100.0).round() / 100.0;
        format!("{rounded}{unit}")
    };
    match *value {
        value if value >= 1e6 => scaled(1e6, "M"),
        value if value >= 1e3 => scaled(1e3, "k"),
        _ => scaled(1.0, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_and_name_is_drawn() {
        let panel = |title: &str| Panel {
            title: title.to_string(),
            x: "repeats".to_string(),
            lines: vec![vec![(1.0, 2.0), (1000.0, 3e6)], Vec::new()],
        };
        let rows = [vec![panel("time"), panel("memory")], vec![panel("less")]];
        let svg = draw(&["first", "second"], &rows).unwrap();
        for text in ["first", "second", "time", "memory", "less", "repeats"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg.matches("<circle").count(), 6);
        assert!(draw(&[], &[]).is_ok());
    }

    #[test]
    fn ticks_are_short() {
        let cases = [(0.5, "0.5"), (20.0, "20"), (3000.0, "3k"), (2e6, "2M")];
        for (value, text) in cases {
            assert_eq!(short(&value), text);
        }
    }
}
