//! Tables of [`Table1`]: Markdown, also for the terminal, and CSV.

use super::plan::{Method, ROWS};
use super::statistics::Summary;
use super::table1::Table1;
use std::fmt;

impl fmt::Display for Table1 {
    /// Writes Markdown: for each device the paper's table, then every measurement.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(
            out,
            "Torus of 2,028 triangles at {width} × {height} pixels, of which at least {:.1} % are covered; \
             maps of 1024² texels, 25 linear and 5 binary steps; rounds of all methods in turn: {}, after one to warm up.",
            100.0 * self.least_covered(),
            self.frames
        )?;
        for number in 0..self.runs.len() {
            let run = &self.runs[number];
            writeln!(out, "\n## {}\n", run.device)?;
            writeln!(out, "Times: {}.\n", run.clock.describe())?;
            writeln!(
                out,
                "Frames per second by the median time (in brackets: the paper's, on its machine):\n"
            )?;
            write_aligned(out, &self.summary(number))?;
            writeln!(
                out,
                "\nEvery measurement. Speeds are medians of the ratios within each round \
                 (in brackets: the paper's); † is not in the paper's table:\n"
            )?;
            write_aligned(out, &self.details(number))?;
        }
        Ok(())
    }
}

impl Table1 {
    /// Writes the paper's table with this machine's results beside the paper's.
    fn summary(&self, run: usize) -> Vec<Vec<String>> {
        let methods = &Method::ALL[..Method::IN_PAPER];
        let mut lines = vec![vec!["map".to_string()]];
        lines[0].extend(methods.iter().map(Method::to_string));
        for (row, cells) in ROWS.iter().zip(&self.runs[run].rows) {
            let [u, v] = row.repeat;
            let mut line = vec![format!("{} ({u}, {v})", row.pattern)];
            line.extend(row.paper_fps.iter().zip(cells).map(|(paper, cell)| {
                let time = Summary::of(&cell.milliseconds).map(|summary| summary.median);
                let fps = time.map_or_else(String::new, |time| significant(1e3 / time));
                format!("{fps} ({paper})")
            }));
            lines.push(line);
        }
        lines
    }

    /// Writes a line for each map and method.
    fn details(&self, run: usize) -> Vec<Vec<String>> {
        let header = [
            "map",
            "method",
            "median ms",
            "quartiles",
            "min–max",
            "steps a ray",
            "covered %",
            "speed to planar",
            "speed to curved relief",
        ];
        let mut lines = vec![header.map(str::to_string).to_vec()];
        for (number, row) in ROWS.iter().enumerate() {
            for cell in &self.runs[run].rows[number] {
                let Some(time) = Summary::of(&cell.milliseconds) else {
                    continue;
                };
                let method = cell.method;
                let speed = |reference: Option<Method>| {
                    let (ours, paper) = self.speeds(run, number, method, reference);
                    let ours = ours.map_or_else(String::new, |speed| format!("{speed:.3}"));
                    paper.map_or_else(|| ours.clone(), |paper| format!("{ours} ({paper:.2})"))
                };
                let mark = if method.is_in_paper() { "" } else { " †" };
                lines.push(vec![
                    row.pattern.to_string(),
                    format!("{method}{mark}"),
                    significant(time.median),
                    range(time.lower_quartile, time.upper_quartile),
                    range(time.minimum, time.maximum),
                    format!("{:.2}", cell.linear_steps),
                    format!("{:.2}", 100.0 * cell.covered),
                    speed(method.planar()),
                    speed(method.relief()),
                ]);
            }
        }
        lines
    }

    /// Formats the measured speed relative to `reference` (median), and the
    /// paper's.
    fn speeds(
        &self,
        run: usize,
        row: usize,
        method: Method,
        reference: Option<Method>,
    ) -> (Option<f64>, Option<f64>) {
        let Some(reference) = reference else {
            return (None, None);
        };
        let measured = self.runs[run].speed(row, method, reference);
        (
            measured.map(|summary| summary.median),
            ROWS[row].paper_speed(method, reference),
        )
    }

    /// Writes CSV: a header, then a line for each device, map and method. Times
    /// are milliseconds, speeds medians of the ratios within each round; fields
    /// without a value are empty.
    pub fn to_csv(&self) -> String {
        let mut text = "device,clock,width,height,map,repeat_u,repeat_v,method,in_paper,frames,\
             min_ms,lower_quartile_ms,median_ms,upper_quartile_ms,max_ms,\
             linear_steps_per_ray,covered_share,speed_to_planar,paper_speed_to_planar,\
             speed_to_curved_relief,paper_speed_to_curved_relief,paper_fps\n"
            .to_string();
        let optional = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.5}"));
        for (number, run) in self.runs.iter().enumerate() {
            for (row_number, row) in ROWS.iter().enumerate() {
                for cell in &run.rows[row_number] {
                    let Some(time) = Summary::of(&cell.milliseconds) else {
                        continue;
                    };
                    let method = cell.method;
                    let (planar, paper_planar) =
                        self.speeds(number, row_number, method, method.planar());
                    let (relief, paper_relief) =
                        self.speeds(number, row_number, method, method.relief());
                    let mut fields = vec![
                        quoted(&run.device),
                        quoted(run.clock.describe()),
                        self.size[0].to_string(),
                        self.size[1].to_string(),
                        row.pattern.to_string(),
                        row.repeat[0].to_string(),
                        row.repeat[1].to_string(),
                        method.to_string(),
                        method.is_in_paper().to_string(),
                        cell.milliseconds.len().to_string(),
                    ];
                    let numbers = [
                        time.minimum,
                        time.lower_quartile,
                        time.median,
                        time.upper_quartile,
                        time.maximum,
                        cell.linear_steps,
                        cell.covered,
                    ];
                    fields.extend(numbers.map(|value| optional(Some(value))));
                    fields.extend([planar, paper_planar, relief, paper_relief].map(optional));
                    let paper = row.paper_fps_of(method);
                    fields.push(paper.map_or_else(String::new, |fps| fps.to_string()));
                    text += &fields.join(",");
                    text.push('\n');
                }
            }
        }
        text
    }
}

/// Quotes text as a CSV field.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// Formats a positive number with at least three significant digits.
pub(crate) fn significant(value: f64) -> String {
    let decimals = (2.0 - value.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

fn range(low: f64, high: f64) -> String {
    format!("{}–{}", significant(low), significant(high))
}

/// Writes an aligned Markdown table; the first line is its header.
pub(crate) fn write_aligned(out: &mut impl fmt::Write, lines: &[Vec<String>]) -> fmt::Result {
    let columns = lines.first().map_or(0, Vec::len);
    let width = |column: usize| {
        let lengths = lines.iter().map(|line| line[column].chars().count());
        lengths.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for (number, line) in lines.iter().enumerate() {
        for (text, width) in line.iter().zip(&widths) {
            write!(out, "| {text:width$} ")?;
        }
        writeln!(out, "|")?;
        if number == 0 {
            for width in &widths {
                write!(out, "|-{:-<width$}-", "")?;
            }
            writeln!(out, "|")?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::table1::tests::small;
    use super::*;

    #[test]
    fn every_line_of_the_csv_has_the_headers_fields() {
        let mut table = small();
        table.runs[0].device = "A \"card\", fast".to_string();
        let csv = table.to_csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 1 + ROWS.len() * Method::ALL.len());
        let columns: Vec<&str> = lines[0].split(',').collect();
        for line in &lines[1..] {
            let rest = line.strip_prefix("\"A \"\"card\"\", fast\",").unwrap();
            let fields: Vec<&str> = rest.split(',').collect();
            assert_eq!(fields.len(), columns.len() - 1, "{line}");
            let field = |name: &str| {
                let index = columns.iter().position(|column| *column == name).unwrap();
                fields[index - 1]
            };
            assert!(field("median_ms").parse::<f64>().unwrap() > 0.0);
            assert_eq!(field("in_paper") == "true", !field("paper_fps").is_empty());
        }
        // Curved basic extrusion on the first map.
        assert!(lines[4].contains(",curved basic,true,2,"), "{}", lines[4]);
        assert!(lines[4].ends_with(",192"), "{}", lines[4]);
        assert!(lines[4].contains(",0.96000,"), "{}", lines[4]);
    }

    #[test]
    fn the_tables_line_up() {
        let text = small().to_string();
        let lines: Vec<&str> = text.lines().collect();
        let mut tables = 0;
        for pair in lines.windows(2) {
            if pair[0].starts_with('|') && pair[1].starts_with('|') {
                let places = |line: &str| -> Vec<usize> {
                    let bars = line.chars().enumerate().filter(|(_, c)| *c == '|');
                    bars.map(|(place, _)| place).collect()
                };
                assert_eq!(places(pair[0]), places(pair[1]));
            } else if pair[0].starts_with('|') {
                tables += 1;
            }
        }
        // The last table ends the text.
        assert_eq!((tables, lines.last().unwrap().starts_with('|')), (1, true));
        assert!(text.contains("(200)") && text.contains("(1.41)"), "{text}");
    }

    #[test]
    fn numbers_keep_three_digits() {
        let cases = [
            (0.01234, "0.0123"),
            (1.5, "1.50"),
            (12.34, "12.3"),
            (1234.5, "1234"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
    }
}
