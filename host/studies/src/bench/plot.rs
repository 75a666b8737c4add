//! Plot of [`Table1`]: a panel of bars for each device and one for the paper.

use super::plan::{Method, ROWS};
use super::statistics::Summary;
use super::table1::{Run, Table1};
use crate::lines::{Area, DrawResult};
use plotters::prelude::*;

const WIDTH: u32 = 1000;
const PANEL_HEIGHT: u32 = 330;
const LEGEND_HEIGHT: u32 = 90;
/// Fraction of a group's width covered by bars.
const GROUP: f64 = 0.88;

/// Frame time, milliseconds: bar height and quartiles.
type Bar = (f64, Option<[f64; 2]>);

/// One set of axes.
struct Panel {
    title: String,
    /// Bars by method for each row of the table, where measured.
    groups: Vec<Vec<Option<Bar>>>,
}

impl Panel {
    fn of_run(run: &Run) -> Panel {
        let bar = |times: &[f64]| {
            let summary = Summary::of(times)?;
            let quartiles = [summary.lower_quartile, summary.upper_quartile];
            Some((summary.median, Some(quartiles)))
        };
        Panel {
            title: format!("{}: median and quartiles", run.device),
            groups: run
                .rows
                .iter()
                .map(|row| row.iter().map(|cell| bar(&cell.milliseconds)).collect())
                .collect(),
        }
    }

    fn of_paper() -> Panel {
        let bar = |fps: f64| (1e3 / fps, None);
        Panel {
            title: "The paper's Table 1, on its machine".to_string(),
            groups: ROWS
                .iter()
                .map(|row| {
                    let bars = Method::ALL.map(|method| row.paper_fps_of(method).map(bar));
                    bars.to_vec()
                })
                .collect(),
        }
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let bars = || self.groups.iter().flatten().flatten();
        let tops = bars().map(|(height, quartiles)| quartiles.map_or(*height, |[_, top]| top));
        let top = 1.08 * tops.fold(f64::MIN_POSITIVE, f64::max);
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 17))
            .margin(8)
            .margin_right(16)
            .x_label_area_size(46)
            .y_label_area_size(70)
            .build_cartesian_2d(-0.5..ROWS.len() as f64 - 0.5, 0.0..top)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .max_light_lines(1)
            .x_labels(ROWS.len())
            .x_label_formatter(&|x| {
                ROWS.get(x.round() as usize)
                    .map_or_else(String::new, |row| {
                        format!("{} ({}, {})", row.pattern, row.repeat[0], row.repeat[1])
                    })
            })
            .label_style(("sans-serif", 14))
            .x_desc("shape map (repeats along u and v)")
            .y_desc("time of a frame / ms")
            .draw()?;
        let width = GROUP / Method::ALL.len() as f64;
        for (group, bars) in self.groups.iter().enumerate() {
            for (index, bar) in bars.iter().enumerate() {
                let Some((height, quartiles)) = *bar else {
                    continue;
                };
                let left = group as f64 - 0.5 * GROUP + index as f64 * width;
                let rectangle = [(left + 0.05 * width, 0.0), (left + 0.95 * width, height)];
                let fill = color(Method::ALL[index]).filled();
                chart.draw_series([Rectangle::new(rectangle, fill)])?;
                if let Some([low, high]) = quartiles {
                    let middle = left + 0.5 * width;
                    let ends = [(middle, low), (middle, high)];
                    chart.draw_series([PathElement::new(ends, BLACK.stroke_width(2))])?;
                }
            }
        }
        Ok(())
    }
}

/// Returns a hue for each surface, darker from technique to technique; relief
/// mapping has its own.
fn color(method: Method) -> RGBColor {
    const COLORS: [RGBColor; Method::ALL.len()] = [
        RGBColor(158, 202, 225),
        RGBColor(66, 146, 198),
        RGBColor(8, 81, 156),
        RGBColor(253, 174, 107),
        RGBColor(230, 110, 20),
        RGBColor(150, 60, 4),
        RGBColor(200, 30, 60),
        RGBColor(90, 60, 150),
        RGBColor(190, 190, 190),
        RGBColor(140, 140, 140),
        RGBColor(90, 90, 90),
    ];
    COLORS[method.index()]
}

fn draw_legend(area: &Area<'_>) -> DrawResult {
    const COLUMNS: usize = 4;
    const FONT: (&str, i32) = ("sans-serif", 14);
    for (index, method) in Method::ALL.into_iter().enumerate() {
        let x = 76 + 230 * (index % COLUMNS) as i32;
        let y = 12 + 25 * (index / COLUMNS) as i32;
        let square = [(x, y), (x + 14, y + 14)];
        area.draw(&Rectangle::new(square, color(method).filled()))?;
        let mark = if method.is_in_paper() { "" } else { " †" };
        area.draw(&Text::new(format!("{method}{mark}"), (x + 20, y), FONT))?;
    }
    let last = (76 + 230 * (COLUMNS as i32 - 1), 12 + 25 * 2);
    area.draw(&Text::new("† not in the paper's table", last, FONT))?;
    Ok(())
}

impl Table1 {
    /// Draws the plot as an SVG file.
    ///
    /// # Errors
    /// The drawing library's message.
    pub fn to_svg(&self) -> Result<String, String> {
        let mut panels: Vec<Panel> = self.runs.iter().map(Panel::of_run).collect();
        panels.push(Panel::of_paper());
        let height = LEGEND_HEIGHT + PANEL_HEIGHT * panels.len() as u32;
        let mut text = String::new();
        draw(&panels, SVGBackend::with_string(&mut text, (WIDTH, height)))
            .map_err(|error| error.to_string())?;
        Ok(text)
    }
}

fn draw(panels: &[Panel], backend: SVGBackend<'_>) -> DrawResult {
    let root = backend.into_drawing_area();
    root.fill(&WHITE)?;
    let (legend, plots) = root.split_vertically(LEGEND_HEIGHT);
    draw_legend(&legend)?;
    for (panel, area) in panels.iter().zip(plots.split_evenly((panels.len(), 1))) {
        panel.draw(&area)?;
    }
    root.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::table1::tests::small;
    use super::*;

    /// Returns whether all tags of `text` are balanced and every ampersand
    /// starts an entity.
    fn is_well_formed(text: &str) -> bool {
        let mut open = Vec::new();
        for part in text.split('<').skip(1) {
            let Some((tag, content)) = part.split_once('>') else {
                return false;
            };
            let entities = content.split('&').skip(1);
            if content.contains('>')
                || tag.matches('"').count() % 2 != 0
                || entities.into_iter().any(|rest| !rest.contains(';'))
            {
                return false;
            }
            let name = tag.split([' ', '\n', '/']).next().unwrap_or("");
            if let Some(name) = tag.strip_prefix('/') {
                if open.pop() != Some(name) {
                    return false;
                }
            } else if !tag.ends_with('/') && !tag.starts_with(['?', '!']) {
                open.push(name);
            }
        }
        open.is_empty()
    }

    #[test]
    fn the_plot_is_well_formed_and_has_titled_axes() {
        let mut table = small();
        table.runs[0].device = "A <card> & more".to_string();
        let svg = table.to_svg().unwrap();
        assert!(svg.starts_with("<svg") && is_well_formed(&svg), "{svg}");
        let count = |text: &str| svg.matches(text).count();
        // Two panels, one of them the paper's.
        assert_eq!(count("time of a frame / ms"), 2);
        assert_eq!(count("shape map (repeats along u and v)"), 2);
        for row in ROWS {
            let [u, v] = row.repeat;
            assert_eq!(count(&format!("{} ({u}, {v})", row.pattern)), 2);
        }
        for method in Method::ALL {
            let RGBColor(r, g, b) = color(method);
            // One bar for each map and panel, and one in the legend.
            let bars = if method.is_in_paper() { 7 } else { 4 };
            let fill = format!("fill=\"#{r:02X}{g:02X}{b:02X}\"");
            assert_eq!(count(&fill), bars, "{method}");
        }
    }

    #[test]
    fn the_check_finds_broken_files() {
        assert!(is_well_formed("<a><b x=\"1\"/>5 &lt; 6</a>"));
        for broken in ["<a>", "<a></b>", "<a x=\">\"></a>", "<a>5 & 6</a>", "<a"] {
            assert!(!is_well_formed(broken), "{broken}");
        }
    }
}
