//! Time of a frame over the number of triangles and of copies.

use super::report::{quoted, significant, write_aligned};
use super::statistics::Summary;
use super::timed::fitting;
use crate::lines::{Panel, draw};
use glam::{DVec2, DVec3};
use relievo::mesh::MeshData;
use relievo::prepare::{PreparedScene, prepare};
use relievo::render::gpu::{Adapter, Choice};
use relievo::render::{CpuRenderer, GpuRenderer, RenderError, Renderer};
use relievo::scene::{Camera, Grid, Instances, Scene, SceneObject, Tier};
use relievo::{Error, Limits};
use std::f64::consts::TAU;
use std::fmt::{self, Write};
use std::path::Path;
use std::time::Instant;

/// Tiers that are measured.
const TIERS: [Tier; 3] = [Tier::Planar, Tier::Fast, Tier::Accurate];
/// Quads of the torus of the assets, around the axis and around the ring.
const QUADS: [u32; 2] = [39, 26];
/// Multiples of [`QUADS`]: from 2,028 to 1,948,908 triangles.
const FACTORS: [u32; 4] = [1, 3, 10, 31];
/// Copies of a square of 8 triangles along each side of a field: from 1 to 100,000.
const SIDES: [[u32; 2]; 6] = [[1, 1], [3, 3], [10, 10], [32, 31], [100, 100], [320, 312]];
/// The small pictures' sides, in those of the large ones. Their pixels are larger than
/// most triangles.
const SMALL: f64 = 0.1;

/// What varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// Triangles of one torus.
    Triangles,
    /// Copies of a square of 8 triangles, in a field that fills the picture.
    Copies,
}

/// Measurements of one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What varies.
    pub number: Number,
    /// How many there are.
    pub count: u64,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The tier.
    pub tier: Tier,
    /// Time of preparation, milliseconds.
    pub preparation: f64,
    /// Median time of a frame on the CPU, milliseconds.
    pub cpu: f64,
    /// Median time of a frame on the GPU by the wall clock, milliseconds; `None` where the
    /// scene does not fit, or without a GPU.
    pub gpu: Option<f64>,
}

/// All measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// Name of the GPU, if there is one.
    pub gpu: Option<String>,
    /// Number of timed frames.
    pub frames: u32,
    /// One for each scene.
    pub rows: Vec<Row>,
}

/// Returns the torus of the assets with `factor` times its quads along both sides.
fn torus(factor: u32) -> MeshData {
    let [around, ring] = QUADS.map(|quads| quads * factor);
    let mut mesh = MeshData::new(format!("torus {factor}"), [], []);
    for j in 0..=ring {
        for i in 0..=around {
            let uv =
                DVec2::new(f64::from(i), f64::from(j)) / DVec2::new(around.into(), ring.into());
            let (sin, cos) = (TAU * uv.x).sin_cos();
            let outwards = DVec3::new(sin, 0.0, cos);
            let (sin, cos) = (TAU * uv.y).sin_cos();
            let normal = outwards * cos + DVec3::Y * sin;
            mesh.positions.push((outwards + normal * 0.4).to_array());
            mesh.normals.push(normal.to_array());
            mesh.uvs.push(uv.to_array());
            if i < around && j < ring {
                let a = j * (around + 1) + i;
                let [b, c, d] = [a + 1, a + around + 2, a + around + 1];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// Returns a torus of `factor`² times the triangles of the assets'.
fn triangles(factor: u32, assets: &Path) -> Scene {
    let object = SceneObject::new(torus(factor), assets.join("patterns/discs.png"))
        .repeat(24, 10)
        .depth(0.08);
    Scene::default()
        .camera(Camera::new([0.0, 2.3, 3.4], [0.0, -0.08, 0.0]))
        .field_of_view(38.0)
        .object(object)
}

/// Returns a field of copies that fills the picture.
fn copies(sides: [u32; 2], assets: &Path) -> Scene {
    let mut object = SceneObject::new(
        assets.join("meshes/plane.obj"),
        assets.join("patterns/bricks.png"),
    )
    .repeat(4, 4)
    .depth(0.05);
    object.instances = Some(Instances::Grid(Grid {
        count: [sides[0], 1, sides[1]],
        spacing: [2.2, 0.0, 2.2],
    }));
    let width = 2.2 * f64::from(sides[0].max(sides[1]));
    Scene::default()
        .camera(Camera::new([0.0, 0.9 * width, 1.1 * width], [0.0; 3]))
        .field_of_view(38.0)
        .object(object)
}

/// Measures every scene on the CPU and on `adapter`, `frames` times in turn, with pictures
/// of `size` pixels and a tenth of it. `assets` holds the folders `meshes` and `patterns`.
///
/// # Errors
/// [`Error`] if a scene cannot be prepared or drawn.
pub fn scaling(
    adapter: Option<&Adapter>,
    size: [u32; 2],
    frames: u32,
    assets: &Path,
    progress: &dyn Fn(String, f64),
) -> Result<Scaling, Error> {
    let small = size.map(|side| ((f64::from(side) * SMALL).round() as u32).max(1));
    let tori = FACTORS.into_iter().flat_map(|factor| {
        let scene = triangles(factor, assets);
        let count = u64::from(2 * QUADS[0] * QUADS[1] * factor * factor);
        [size, small].map(|size| (Number::Triangles, count, size, scene.clone()))
    });
    let fields = SIDES.into_iter().map(|sides| {
        let count = sides.map(u64::from).iter().product();
        (Number::Copies, count, size, copies(sides, assets))
    });
    let all: Vec<_> = tori.chain(fields).collect();
    let mut rows = Vec::new();
    for (done, (number, count, size, scene)) in all.iter().enumerate() {
        for tier in TIERS {
            let what = format!("{count} {}, {} tier", number.name(), tier.name());
            progress(what, done as f64 / all.len() as f64);
            let mut scene = scene
                .clone()
                .limits(Limits::trusting())
                .size(size[0], size[1]);
            for object in &mut scene.objects {
                *object = object.clone().tier(tier);
                if tier == Tier::Accurate {
                    object.tolerance = 0.25;
                }
            }
            let prepared = prepare(&scene, &|_| ())?;
            let (cpu, gpu) = time(&prepared, adapter, frames)?;
            rows.push(Row {
                number: *number,
                count: *count,
                size: *size,
                tier,
                preparation: 1e3 * prepared.preparation.as_secs_f64(),
                cpu,
                gpu,
            });
        }
    }
    Ok(Scaling {
        gpu: adapter.map(Adapter::describe),
        frames,
        rows,
    })
}

/// Returns the median times of a frame on CPU and GPU, milliseconds.
fn time(
    scene: &PreparedScene,
    adapter: Option<&Adapter>,
    frames: u32,
) -> Result<(f64, Option<f64>), RenderError> {
    let mut cpu = CpuRenderer::new(scene);
    let gpu = adapter.map(|adapter| GpuRenderer::new(scene, adapter, Choice::Trusted));
    let mut gpu = fitting(gpu)?;
    let (mut cpu_times, mut gpu_times) = (Vec::new(), Vec::new());
    for round in 0..=frames {
        let start = Instant::now();
        cpu.color(&scene.frame)?;
        let cpu_time = start.elapsed();
        let gpu_time = match &mut gpu {
            Some(gpu) => Some(gpu.time_color(&scene.frame)?.wall),
            None => None,
        };
        if round > 0 {
            cpu_times.push(1e3 * cpu_time.as_secs_f64());
            gpu_times.extend(gpu_time.map(|time| 1e3 * time.as_secs_f64()));
        }
    }
    let median = |times: &[f64]| Summary::of(times).map(|summary| summary.median);
    Ok((median(&cpu_times).unwrap_or(0.0), median(&gpu_times)))
}

impl Number {
    fn name(self) -> &'static str {
        match self {
            Number::Triangles => "triangles",
            Number::Copies => "copies",
        }
    }
}

impl fmt::Display for Scaling {
    /// Writes Markdown: a table for each series.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gpu = self.gpu.as_deref().unwrap_or("no GPU");
        writeln!(
            out,
            "GPU: {gpu}. CPU / GPU in ms, medians of {} frames in turn.",
            self.frames
        )?;
        for rows in self.series() {
            let Row { number, size, .. } = rows[0];
            writeln!(out, "\n{} × {} pixels:\n", size[0], size[1])?;
            let mut lines = vec![vec![number.name().to_string()]];
            lines[0].extend(TIERS.map(|tier| tier.name().to_string()));
            for rows in rows.chunks(TIERS.len()) {
                let mut line = vec![rows[0].count.to_string()];
                line.extend(rows.iter().map(|row| {
                    let gpu = row.gpu.map_or_else(|| "–".to_string(), significant);
                    format!("{} / {gpu}", significant(row.cpu))
                }));
                lines.push(line);
            }
            write_aligned(out, &lines)?;
        }
        Ok(())
    }
}

impl Scaling {
    /// Returns the rows of each series: the same picture size, the same kind of number.
    fn series(&self) -> Vec<Vec<&Row>> {
        let mut all: Vec<Vec<&Row>> = Vec::new();
        for row in &self.rows {
            let same =
                |rows: &&mut Vec<&Row>| (rows[0].number, rows[0].size) == (row.number, row.size);
            match all.iter_mut().find(same) {
                Some(rows) => rows.push(row),
                None => all.push(vec![row]),
            }
        }
        all
    }

    /// Writes CSV: a header, then a line for each scene.
    pub fn to_csv(&self) -> String {
        let mut text =
            "gpu,number,count,width,height,tier,preparation_ms,cpu_ms,gpu_ms\n".to_string();
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{:.4},{:.4},{}",
                quoted(self.gpu.as_deref().unwrap_or("")),
                row.number.name(),
                row.count,
                row.size[0],
                row.size[1],
                row.tier.name(),
                row.preparation,
                row.cpu,
                row.gpu
                    .map_or_else(String::new, |time| format!("{time:.4}"))
            );
        }
        text
    }

    /// Draws the times over the numbers.
    ///
    /// # Errors
    /// What the drawing library reports.
    pub fn to_svg(&self) -> Result<String, String> {
        let panels = self.series().into_iter().map(|rows| {
            let Row { number, size, .. } = rows[0];
            let panel = |device: &str, time: &dyn Fn(&Row) -> Option<f64>| Panel {
                title: format!("{device}, ms a frame, {} × {} pixels", size[0], size[1]),
                x: number.name().to_string(),
                lines: TIERS
                    .iter()
                    .map(|tier| {
                        let rows = rows.iter().filter(|row| row.tier == *tier);
                        rows.filter_map(|row| Some((row.count as f64, time(row)?)))
                            .collect()
                    })
                    .collect(),
            };
            vec![
                panel("CPU", &|row| Some(row.cpu)),
                panel("GPU", &|row| row.gpu),
            ]
        });
        draw(&TIERS.map(Tier::name), &panels.collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_torus_is_that_of_the_assets() {
        let mesh = torus(1);
        assert_eq!(mesh.triangles.len(), 2028);
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let ours = triangles(1, &assets);
        let mut theirs = ours.clone();
        theirs.objects[0].mesh = assets.join("meshes/torus.obj").into();
        let [ours, theirs] = [ours, theirs].map(|scene| {
            let prepared = prepare(&scene.size(40, 30), &|_| ()).unwrap();
            CpuRenderer::new(&prepared)
                .geometry(&prepared.frame)
                .unwrap()
        });
        let same = (0..1200)
            .filter(|&i| ours.class(i) == theirs.class(i))
            .count();
        assert!(same > 1190, "{same}");
        assert!(ours.coverage().0 > 300);
    }

    #[test]
    fn fields_of_copies_fill_the_same_part_of_the_picture() {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let covered = SIDES.map(|sides| {
            let prepared = prepare(&copies(sides, &assets).size(80, 60), &|_| ()).unwrap();
            let words = CpuRenderer::new(&prepared)
                .geometry(&prepared.frame)
                .unwrap();
            words.coverage().0
        });
        for count in covered {
            assert!(count > 1200 && count < 4000, "{covered:?}");
        }
    }

    #[test]
    fn tables_and_charts_hold_every_series() {
        let row = |number, count, side, tier| Row {
            number,
            count,
            size: [side, side],
            tier,
            preparation: 1.0,
            cpu: 2.0 * count as f64,
            gpu: (tier != Tier::Accurate).then_some(3.0),
        };
        let mut rows = Vec::new();
        for count in [10, 100] {
            for side in [64, 6] {
                rows.extend(TIERS.map(|tier| row(Number::Triangles, count, side, tier)));
            }
        }
        rows.extend(TIERS.map(|tier| row(Number::Copies, 1, 64, tier)));
        let scaling = Scaling {
            gpu: None,
            frames: 1,
            rows,
        };
        let text = scaling.to_string();
        assert_eq!(text.matches("pixels:").count(), 3);
        assert!(
            text.contains("| 20.0 / 3.00 | 20.0 / 3.00 | 20.0 / –"),
            "{text}"
        );
        assert_eq!(scaling.to_csv().lines().count(), 16);
        assert_eq!(scaling.to_svg().unwrap().matches("ms a frame").count(), 6);
    }
}
