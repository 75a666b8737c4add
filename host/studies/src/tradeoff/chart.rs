//! Chart of a [`Report`]: a panel of error over time for each class of
//! renderers and each metric. Dominated variants are grey; those on the Pareto
//! front are joined and named.

use super::report::{Metric, Report};
use super::variant::Class;
use crate::lines::{Area, DrawResult};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use relievo::scene::Tier;

const WIDTH: u32 = 1420;
const LEGEND_HEIGHT: u32 = 44;
const LEAST_PANEL_HEIGHT: u32 = 400;
/// Plot area in a panel: left, right, top, and distance from the bottom,
/// pixels.
const PLOT: [i32; 4] = [96, 810, 44, 62];
/// Left edge of the names, and line height, pixels.
const NAMES: (i32, i32) = (840, 18);
/// Distance of the first name from the panel's top, pixels.
const NAMES_TOP: i32 = 66;
/// Margin that keeps marks off the border, pixels.
const INSET: f64 = 14.0;

const GREY: RGBColor = RGBColor(178, 178, 178);
const LINES: RGBColor = RGBColor(228, 228, 228);
const TEXT: RGBColor = RGBColor(40, 40, 40);
const FRONT: RGBColor = RGBColor(192, 30, 60);

/// Font sizes; the library draws text 1.24 times smaller.
const SMALL: i32 = 16;
const LARGE: i32 = 20;

/// Maps values to 0…1, with tick marks.
struct Scale {
    place: Box<dyn Fn(f64) -> f64>,
    ticks: Vec<(f64, String)>,
}

impl Scale {
    /// Logarithmic scale from `low` to `high`, both above 0; smaller values are
    /// clamped.
    fn logarithmic(low: f64, high: f64) -> Scale {
        let (from, span) = (low.ln(), (high / low).ln());
        Scale {
            place: Box::new(move |value| ((value.max(low).ln() - from) / span).clamp(0.0, 1.0)),
            ticks: ticks(low, high)
                .into_iter()
                .map(|value| (value, value.to_string()))
                .collect(),
        }
    }

    /// Scale for errors in pixels: 0 at the bottom, infinity at the top,
    /// logarithmic between.
    fn pixels() -> Scale {
        const INNER: [f64; 2] = [0.12, 0.9];
        let inner = Scale::logarithmic(0.02, 8.0);
        let mut ticks: Vec<(f64, String)> = [0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0]
            .map(|value| (value, value.to_string()))
            .to_vec();
        ticks.push((f64::INFINITY, "> 8".to_string()));
        Scale {
            place: Box::new(move |value| {
                if value <= 0.0 {
                    0.0
                } else if value.is_infinite() {
                    1.0
                } else {
                    INNER[0] + (INNER[1] - INNER[0]) * (inner.place)(value)
                }
            }),
            ticks,
        }
    }

    fn of(metric: Metric, values: &[f64]) -> Scale {
        match metric {
            Metric::ErrorPixels => Scale::pixels(),
            Metric::Flip => {
                let positive = || values.iter().copied().filter(|value| *value > 0.0);
                let low = positive().fold(f64::INFINITY, f64::min);
                let high = positive().fold(0.0, f64::max);
                if high > 0.0 {
                    Scale::logarithmic(low / 1.02, high * 1.02)
                } else {
                    Scale::logarithmic(1e-3, 1.0)
                }
            }
        }
    }
}

/// Returns about four to ten round values from `low` to `high`.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    const STEPS: [&[f64]; 4] = [
        &[1.0],
        &[1.0, 2.0, 5.0],
        &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        &[
            1.0, 1.1, 1.2, 1.3, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0,
        ],
    ];
    let first = low.log10().floor() as i32;
    let last = high.log10().ceil() as i32;
    let of = |steps: &[f64]| -> Vec<f64> {
        let decades = first..=last;
        decades
            // Parsed, so that they print as short decimals.
            .flat_map(|decade| {
                steps
                    .iter()
                    .filter_map(move |step| format!("{step}e{decade}").parse().ok())
            })
            .filter(|value| (low..=high).contains(value))
            .collect()
    };
    let enough = STEPS
        .iter()
        .map(|steps| of(steps))
        .find(|values| values.len() >= 4);
    enough.unwrap_or_else(|| of(STEPS[STEPS.len() - 1]))
}

/// A variant in a panel.
struct Point {
    at: (i32, i32),
    tier: Tier,
}

/// One set of axes.
struct Panel {
    title: String,
    metric: Metric,
    /// Time, error and tier of dominated variants.
    dominated: Vec<(f64, f64, Tier)>,
    /// Time, error, tier and name of the front, by increasing time.
    front: Vec<(f64, f64, Tier, String)>,
}

impl Panel {
    fn new(report: &Report, class: Class, metric: Metric) -> Option<Panel> {
        let points = report.points(class, metric);
        if points.is_empty() {
            return None;
        }
        let tier = |row: &super::Row| row.variant.settings.model.tier;
        let dominated = points.iter().filter(|(_, _, is_on)| !is_on);
        Some(Panel {
            title: format!("{}: time against {}", class.name(), metric.title()),
            metric,
            dominated: dominated
                .map(|(row, error, _)| (row.time, *error, tier(row)))
                .collect(),
            front: report
                .front(class, metric)
                .into_iter()
                .map(|(row, error)| (row.time, error, tier(row), row.variant.key()))
                .collect(),
        })
    }

    fn height(&self) -> u32 {
        let names = NAMES_TOP + NAMES.1 * (self.front.len() as i32 + 1);
        LEAST_PANEL_HEIGHT.max(names.unsigned_abs())
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let [left, right, top, below] = PLOT;
        let bottom = area.dim_in_pixel().1 as i32 - below;
        let dominated = self.dominated.iter().map(|(x, y, _)| (*x, *y));
        let all: Vec<(f64, f64)> = dominated
            .chain(self.front.iter().map(|(x, y, ..)| (*x, *y)))
            .collect();
        let longest = all.iter().map(|(x, _)| *x).fold(1.1, f64::max);
        let across = Scale::logarithmic(1.0, longest);
        let errors: Vec<f64> = all.iter().map(|(_, y)| *y).collect();
        let up = Scale::of(self.metric, &errors);
        let inner = |length: i32| f64::from(length) - 2.0 * INSET;
        let x = |time: f64| left + (INSET + inner(right - left) * (across.place)(time)) as i32;
        let y = |error: f64| bottom - (INSET + inner(bottom - top) * (up.place)(error)) as i32;

        let heading = ("sans-serif", LARGE).into_font().color(&TEXT);
        area.draw(&Text::new(self.title.clone(), (left, 14), heading.clone()))?;
        let frame = [(left, top), (right, bottom)];
        area.draw(&Rectangle::new(frame, LINES.stroke_width(1)))?;
        let text = |h, v| {
            let font = ("sans-serif", SMALL).into_font();
            font.color(&TEXT).pos(Pos::new(h, v))
        };
        for (time, label) in &across.ticks {
            let ends = [(x(*time), top), (x(*time), bottom)];
            area.draw(&PathElement::new(ends, LINES))?;
            let place = (x(*time), bottom + 8);
            area.draw(&Text::new(
                label.clone(),
                place,
                text(HPos::Center, VPos::Top),
            ))?;
        }
        for (error, label) in &up.ticks {
            let ends = [(left, y(*error)), (right, y(*error))];
            area.draw(&PathElement::new(ends, LINES))?;
            let place = (left - 8, y(*error));
            area.draw(&Text::new(
                label.clone(),
                place,
                text(HPos::Right, VPos::Center),
            ))?;
        }
        let place = ((left + right) / 2, bottom + 32);
        let title = "time of a frame, as a multiple of the cheapest";
        area.draw(&Text::new(title, place, text(HPos::Center, VPos::Top)))?;
        let font = ("sans-serif", SMALL).into_font();
        let turned = font.transform(FontTransform::Rotate270).color(&TEXT);
        let turned = turned.pos(Pos::new(HPos::Center, VPos::Top));
        let place = (22, (top + bottom) / 2);
        area.draw(&Text::new(self.metric.title(), place, turned))?;

        for (time, error, tier) in &self.dominated {
            draw_mark(area, (x(*time), y(*error)), *tier, 4, GREY)?;
        }
        let on: Vec<Point> = self
            .front
            .iter()
            .map(|(time, error, tier, _)| Point {
                at: (x(*time), y(*error)),
                tier: *tier,
            })
            .collect();
        let mut path = staircase(&on);
        if let Some(&(_, last)) = path.last() {
            path.push((right, last));
        }
        area.draw(&PathElement::new(path, FRONT.stroke_width(1)))?;
        for point in &on {
            draw_mark(area, point.at, point.tier, 6, FRONT)?;
        }
        let dominated = self.dominated.iter();
        let others: Vec<(i32, i32)> = dominated
            .map(|(time, error, _)| (x(*time), y(*error)))
            .collect();
        let places = number_places(&on, &others, [left, right, top, bottom]);
        let number = ("sans-serif", SMALL)
            .into_font()
            .style(FontStyle::Bold)
            .color(&FRONT);
        let number = number.pos(Pos::new(HPos::Center, VPos::Center));
        for (index, place) in places.into_iter().enumerate() {
            area.draw(&Text::new((index + 1).to_string(), place, number.clone()))?;
        }

        let (start, step) = NAMES;
        area.draw(&Text::new("Pareto front", (start, NAMES_TOP - 28), heading))?;
        for (index, (.., name)) in self.front.iter().enumerate() {
            let line = NAMES_TOP + step * index as i32;
            let font = ("monospace", SMALL - 1).into_font().color(&TEXT);
            let right = text(HPos::Right, VPos::Top);
            area.draw(&Text::new(
                (index + 1).to_string(),
                (start + 16, line),
                right,
            ))?;
            area.draw(&Text::new(name.clone(), (start + 24, line), font))?;
        }
        Ok(())
    }
}

/// Returns the step line of a front: the error of the last point reached at
/// each time. Points are sorted.
fn staircase(points: &[Point]) -> Vec<(i32, i32)> {
    let mut path: Vec<(i32, i32)> = Vec::new();
    for point in points {
        if let Some(&(_, before)) = path.last() {
            path.push((point.at.0, before));
        }
        path.push(point.at);
    }
    path
}

/// Half width and height of a number, pixels.
const NUMBER: (i32, i32) = (9, 8);

/// Returns the centre of the number beside each point of a front, within
/// `bounds` (left, right, top, bottom) and clear of other numbers and of the
/// front's points. Avoids the front's line and `others` if there is room.
fn number_places(points: &[Point], others: &[(i32, i32)], bounds: [i32; 4]) -> Vec<(i32, i32)> {
    const DIRECTIONS: usize = 16;
    let line = staircase(points);
    let candidates = |point: &Point| {
        let (x, y) = point.at;
        let radii = [16.0, 21.0, 27.0, 34.0, 42.0, 51.0, 61.0];
        radii.into_iter().flat_map(move |radius| {
            (0..DIRECTIONS).map(move |direction| {
                // Start at the upper right, where the front is not.
                let turn = 0.125 + direction as f64 / DIRECTIONS as f64;
                let (up, right) = (std::f64::consts::TAU * turn).sin_cos();
                (x + (radius * right) as i32, y - (radius * up) as i32)
            })
        })
    };
    let is_near = |a: (i32, i32), b: (i32, i32), (width, height): (i32, i32)| {
        (a.0 - b.0).abs() < width && (a.1 - b.1).abs() < height
    };
    let is_on_line = |place: (i32, i32)| {
        line.windows(2).any(|ends| {
            let [x, y] = [[ends[0].0, ends[1].0], [ends[0].1, ends[1].1]];
            let is_beside =
                |at: i32, [a, b]: [i32; 2], half: i32| at + half > a.min(b) && at - half < a.max(b);
            is_beside(place.0, x, NUMBER.0) && is_beside(place.1, y, NUMBER.1)
        })
    };
    let mut taken: Vec<(i32, i32)> = Vec::new();
    for point in points {
        let is_possible = |place: &(i32, i32)| {
            let [left, right, top, bottom] = bounds;
            let on_number =
                |other: &(i32, i32)| is_near(*other, *place, (2 * NUMBER.0, 2 * NUMBER.1));
            let on_point = |other: &Point| is_near(other.at, *place, (NUMBER.0 + 6, NUMBER.1 + 6));
            (left + NUMBER.0..right - NUMBER.0).contains(&place.0)
                && (top + NUMBER.1..bottom - NUMBER.1).contains(&place.1)
                && !taken.iter().any(on_number)
                && !points.iter().any(on_point)
        };
        let is_free = |place: &(i32, i32)| {
            let on_other =
                |other: &(i32, i32)| is_near(*other, *place, (NUMBER.0 + 4, NUMBER.1 + 4));
            is_possible(place) && !is_on_line(*place) && !others.iter().any(on_other)
        };
        let place = candidates(point)
            .find(is_free)
            .or_else(|| candidates(point).find(is_possible));
        taken.push(place.unwrap_or((point.at.0 + 14, point.at.1 - 14)));
    }
    taken
}

/// Draws a mark of `radius` pixels in the shape of the tier.
fn draw_mark(
    area: &Area<'_>,
    (x, y): (i32, i32),
    tier: Tier,
    radius: i32,
    color: RGBColor,
) -> DrawResult {
    match tier {
        Tier::Planar => {
            area.draw(&TriangleMarker::new((x, y), radius + 1, color.filled()))?;
        }
        Tier::Fast => area.draw(&Circle::new((x, y), radius, color.filled()))?,
        Tier::Paper => area.draw(&Cross::new((x, y), radius, color.stroke_width(2)))?,
        Tier::Accurate => {
            let half = radius - 1;
            let square = [(x - half, y - half), (x + half, y + half)];
            area.draw(&Rectangle::new(square, color.filled()))?;
        }
    }
    Ok(())
}

fn draw_legend(area: &Area<'_>) -> DrawResult {
    let font = ("sans-serif", SMALL).into_font().color(&TEXT);
    let y = 24;
    let mut x = PLOT[0];
    for tier in Tier::ALL {
        draw_mark(area, (x, y), tier, 5, TEXT)?;
        let text = format!("{} tier", tier.name());
        area.draw(&Text::new(text, (x + 12, y - 7), font.clone()))?;
        x += 130;
    }
    for (color, text) in [
        (
            FRONT,
            "on the Pareto front: nothing is both as fast and as right",
        ),
        (GREY, "dominated"),
    ] {
        let square = [(x, y - 6), (x + 12, y + 6)];
        area.draw(&Rectangle::new(square, color.filled()))?;
        area.draw(&Text::new(text, (x + 18, y - 7), font.clone()))?;
        x += 430;
    }
    Ok(())
}

impl Report {
    /// Draws the chart as an SVG file.
    ///
    /// # Errors
    /// The drawing library's message.
    pub fn to_svg(&self) -> Result<String, String> {
        let panels: Vec<Panel> = self
            .classes()
            .into_iter()
            .flat_map(|class| Metric::ALL.map(|metric| Panel::new(self, class, metric)))
            .flatten()
            .collect();
        let height = LEGEND_HEIGHT + panels.iter().map(Panel::height).sum::<u32>();
        let mut text = String::new();
        draw(&panels, SVGBackend::with_string(&mut text, (WIDTH, height)))
            .map_err(|error| error.to_string())?;
        Ok(text)
    }
}

fn draw(panels: &[Panel], backend: SVGBackend<'_>) -> DrawResult {
    let root = backend.into_drawing_area();
    root.fill(&WHITE)?;
    let (legend, mut rest) = root.split_vertically(LEGEND_HEIGHT);
    draw_legend(&legend)?;
    for panel in panels {
        let (area, below) = rest.split_vertically(panel.height());
        panel.draw(&area)?;
        rest = below;
    }
    root.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::report::tests::report;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_chart_names_what_is_on_the_front() {
        let report = report();
        let svg = report.to_svg().unwrap();
        for class in report.classes() {
            for metric in Metric::ALL {
                for (row, _) in report.front(class, metric) {
                    assert!(svg.contains(&row.variant.key()));
                }
            }
        }
        let count = |text: &str| svg.matches(text).count();
        assert_eq!(count("time of a frame, as a multiple of the cheapest"), 4);
        // Dominated variants are drawn without names.
        assert!(count("#B2B2B2") > 20);
        assert!(count("/cpu\n") < report.rows.len());
    }

    #[test]
    fn ticks_are_round_and_not_many() {
        for (low, high) in [
            (1.0, 1.3),
            (1.0, 2.0),
            (1.0, 40.0),
            (0.003, 0.09),
            (0.01, 0.011),
        ] {
            let found = ticks(low, high);
            assert!(found.len() <= 12, "{low} {high} {found:?}");
            assert!(
                found.iter().all(|value| value.to_string().len() <= 6),
                "{found:?}"
            );
        }
        assert_eq!(ticks(1.0, 12.0), [1.0, 2.0, 5.0, 10.0]);
    }

    #[test]
    fn errors_grow_upwards_from_nothing_to_infinity() {
        let scale = Scale::pixels();
        let mut errors = vec![0.0];
        errors.extend(relievo::oracle::RADII);
        errors.push(f64::INFINITY);
        let places: Vec<f64> = errors
            .into_iter()
            .map(|error| (scale.place)(error))
            .collect();
        assert!(
            places.windows(2).all(|pair| pair[0] < pair[1]),
            "{places:?}"
        );
        assert_eq!((places[0], places[places.len() - 1]), (0.0, 1.0));
    }

    proptest! {
        #[test]
        fn no_number_lies_on_another(
            steps in prop::collection::vec((1..60i32, 1..30i32), 1..15)
        ) {
            let mut at = (PLOT[0] + 14, PLOT[2] + 14);
            let mut points = Vec::new();
            for (dx, dy) in steps {
                points.push(Point { at, tier: Tier::Fast });
                at = ((at.0 + dx).min(PLOT[1] - 14), at.1 + dy);
            }
            let others: Vec<(i32, i32)> = points.iter().map(|point| (point.at.0 + 20, point.at.1 - 5)).collect();
            let places = number_places(&points, &others, [PLOT[0], PLOT[1], PLOT[2], 520]);
            for (i, a) in places.iter().enumerate() {
                for b in &places[..i] {
                    let is_apart = (a.0 - b.0).abs() >= 2 * NUMBER.0 || (a.1 - b.1).abs() >= 2 * NUMBER.1;
                    prop_assert!(is_apart, "{:?} {:?}", a, b);
                }
            }
        }
    }
}
