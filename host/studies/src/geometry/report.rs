//! Tables and charts of triangles beside extrusions.

use super::measure::{Cell, ERROR_PX, Method, Row, Setting};
use crate::bench::{quoted, significant, write_aligned};
use crate::lines::{Panel, draw};
use std::fmt::{self, Write};

/// All measurements of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Name of the scene.
    pub scene: String,
    /// Name of the GPU, if there is one.
    pub gpu: Option<String>,
    /// Number of timed frames.
    pub frames: u32,
    /// One for each setting.
    pub rows: Vec<Row>,
}

impl fmt::Display for Comparison {
    /// Writes a Markdown table.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gpu = self.gpu.as_deref().unwrap_or("no GPU");
        writeln!(
            out,
            "{}; GPU: {gpu}. Medians of {} frames in turn. The triangles are as few as an error of \
             {ERROR_PX} pixels allows in each view, are drawn by the rasteriser of the GPU, and on the \
             CPU by rays through a hierarchy of boxes. Preparation is all from the scene file to a \
             renderer on the CPU; memory is that of the buffers on a GPU, without pictures.\n",
            self.scene, self.frames
        )?;
        let header = [
            "repeats",
            "distance",
            "pixels",
            "drawn as",
            "error px",
            "triangles",
            "MB",
            "preparation ms",
            "CPU ms",
            "GPU ms",
        ];
        let mut lines = vec![header.map(str::to_string).to_vec()];
        for row in &self.rows {
            let Setting {
                repeat, distance, ..
            } = row.setting;
            for cell in &row.cells {
                lines.push(vec![
                    format!("{repeat}²"),
                    distance.to_string(),
                    format!("{} × {}", row.size[0], row.size[1]),
                    cell.method.name().to_string(),
                    if cell.error_px.is_finite() {
                        cell.error_px.to_string()
                    } else {
                        "> 8".to_string()
                    },
                    cell.triangles.to_string(),
                    significant(cell.bytes as f64 / 1e6),
                    significant(cell.preparation),
                    significant(cell.cpu),
                    cell.gpu.map_or_else(|| "–".to_string(), significant),
                ]);
            }
        }
        write_aligned(out, &lines)
    }
}

impl Comparison {
    /// Writes CSV: a header, then a line for each setting and method.
    pub fn to_csv(&self) -> String {
        let mut text = "scene,gpu,repeat,distance,width,height,method,error_px,triangles,bytes,\
             preparation_ms,cpu_ms,gpu_ms\n"
            .to_string();
        for row in &self.rows {
            for cell in &row.cells {
                let fields = [
                    quoted(&self.scene),
                    quoted(self.gpu.as_deref().unwrap_or("")),
                    row.setting.repeat.to_string(),
                    row.setting.distance.to_string(),
                    row.size[0].to_string(),
                    row.size[1].to_string(),
                    cell.method.name().to_string(),
                    cell.error_px.to_string(),
                    cell.triangles.to_string(),
                    cell.bytes.to_string(),
                    format!("{:.4}", cell.preparation),
                    format!("{:.4}", cell.cpu),
                    cell.gpu
                        .map_or_else(String::new, |time| format!("{time:.4}")),
                ];
                let _ = writeln!(text, "{}", fields.join(","));
            }
        }
        text
    }

    /// Draws time, memory and preparation over repeats, distance and resolution.
    ///
    /// # Errors
    /// What the drawing library reports.
    pub fn to_svg(&self) -> Result<String, String> {
        let first = |row: &&Row| row.setting.distance == 1.0 && row.setting.scale == 1.0;
        let middle = self
            .rows
            .iter()
            .find(|row| !first(row))
            .map(|row| row.setting.repeat);
        let repeats: Vec<&Row> = self.rows.iter().filter(first).collect();
        let varied = |same: &dyn Fn(&Row) -> bool| -> Vec<&Row> {
            let rows = self
                .rows
                .iter()
                .filter(|row| Some(row.setting.repeat) == middle);
            rows.filter(|row| same(row)).collect()
        };
        let distances = varied(&|row| row.setting.scale == 1.0);
        let sizes = varied(&|row| row.setting.distance == 1.0);
        type Place = fn(&Row) -> f64;
        let groups: [(&str, Vec<&Row>, Place); 3] = [
            ("repeats along u and v", repeats, |row| {
                f64::from(row.setting.repeat)
            }),
            ("distance, in the scene's", distances, |row| {
                row.setting.distance
            }),
            ("pixels", sizes, |row| {
                row.size.map(f64::from).iter().product()
            }),
        ];
        type Value = fn(&Cell) -> Option<f64>;
        let values: [(&str, Value); 4] = [
            ("CPU, ms a frame", |cell| Some(cell.cpu)),
            ("GPU, ms a frame", |cell| cell.gpu),
            ("memory, MB", |cell| Some(cell.bytes as f64 / 1e6)),
            ("preparation, ms", |cell| Some(cell.preparation)),
        ];
        let rows: Vec<Vec<Panel>> = groups
            .iter()
            .map(|(x, rows, place)| {
                let panel = |(title, value): &(&str, Value)| Panel {
                    title: title.to_string(),
                    x: x.to_string(),
                    lines: (0..Method::ALL.len())
                        .map(|method| {
                            let points = rows
                                .iter()
                                .filter_map(|row| Some((place(row), value(&row.cells[method])?)));
                            let mut points: Vec<_> = points.collect();
                            points.sort_by(|a, b| a.0.total_cmp(&b.0));
                            points
                        })
                        .collect(),
                };
                values.iter().map(panel).collect()
            })
            .collect();
        draw(&Method::ALL.map(Method::name), &rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_charts_hold_every_setting() {
        let row = |repeat, distance, scale: f64| Row {
            setting: Setting {
                repeat,
                distance,
                scale,
            },
            size: [(100.0 * scale) as u32, 75],
            cells: Method::ALL
                .map(|method| Cell {
                    method,
                    error_px: if repeat == 1 { f64::INFINITY } else { 0.5 },
                    triangles: 12_345,
                    bytes: 1_000_000,
                    preparation: 10.0,
                    cpu: 2.0 * distance,
                    gpu: (method != Method::Triangles).then_some(3.0),
                })
                .to_vec(),
        };
        let comparison = Comparison {
            scene: "torus".to_string(),
            gpu: None,
            frames: 5,
            rows: vec![
                row(1, 1.0, 1.0),
                row(4, 1.0, 1.0),
                row(4, 2.0, 1.0),
                row(4, 1.0, 2.0),
            ],
        };
        let text = comparison.to_string();
        assert_eq!(text.matches("12345").count(), 12);
        assert!(text.contains("> 8") && text.contains("no GPU"), "{text}");
        let csv = comparison.to_csv();
        let fields = |line: &str| line.split(',').count();
        assert!(csv.lines().all(|line| fields(line) == 13), "{csv}");
        let svg = comparison.to_svg().unwrap();
        // Three rows of panels: two points a line, and one line less where none was drawn.
        let points = 3 * (4 * 3 - 1) * 2;
        assert_eq!(svg.matches("<circle").count(), points);
    }
}
