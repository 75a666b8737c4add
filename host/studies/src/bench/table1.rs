//! Measurement of the paper's Table 1 on this machine.

use super::plan::{Method, PatternRow, ROWS};
use super::statistics::Summary;
use super::timed::{Backend, Clock, Timed};
use relievo::Error;
use relievo::prepare::{PreparedScene, prepare};
use std::path::Path;

/// Measurements of one method on one shape map.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The method.
    pub method: Method,
    /// Frame times, milliseconds, one per round.
    pub milliseconds: Vec<f64>,
    /// Fraction of the picture that is covered, 0…1.
    pub covered: f64,
    /// Linear search steps, mean over the covered pixels.
    pub linear_steps: f64,
}

/// Results of one device.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the device.
    pub device: String,
    /// Source of the times.
    pub clock: Clock,
    /// A cell for each of [`Method::ALL`], for each of [`ROWS`].
    pub rows: Vec<Vec<Cell>>,
}

impl Run {
    /// Returns the speed of a method in row `row` as a multiple of that of
    /// `reference`.
    pub fn speed(&self, row: usize, method: Method, reference: Method) -> Option<Summary> {
        let [cell, reference] = [method, reference].map(|method| &self.rows[row][method.index()]);
        Summary::of_ratios(&reference.milliseconds, &cell.milliseconds)
    }
}

/// Table 1, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Table1 {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Timed frames for each method and shape map.
    pub frames: u32,
    /// Results by device.
    pub runs: Vec<Run>,
}

impl Table1 {
    /// Returns the smallest covered fraction of all pictures, 0…1.
    pub fn least_covered(&self) -> f64 {
        let cells = self.runs.iter().flat_map(|run| run.rows.iter().flatten());
        cells.map(|cell| cell.covered).fold(1.0, f64::min)
    }
}

/// Measures every method on every shape map with every backend. Each round
/// times all methods in turn, so that noise affects them alike; a first round
/// warms up and is dropped. `assets` holds the folders `meshes` and `patterns`;
/// `progress` receives a message and the fraction done.
///
/// # Errors
/// [`Error`] if an asset is missing or a device fails.
pub fn measure(
    backends: &[Backend<'_>],
    size: [u32; 2],
    frames: u32,
    assets: &Path,
    progress: &dyn Fn(String, f64),
) -> Result<Table1, Error> {
    let mut runs: Vec<Run> = Vec::new();
    for (row_number, row) in ROWS.iter().enumerate() {
        progress(format!("{}: preparing", row.pattern), 0.0);
        let scenes = Method::ALL
            .iter()
            .map(|method| prepare(&row.scene(*method, size, assets)?, &|_| ()))
            .collect::<Result<Vec<_>, Error>>()?;
        for (i, backend) in backends.iter().enumerate() {
            let measured = measure_row(row, &scenes, backend, frames, progress)?;
            match runs.get_mut(i) {
                None => runs.push(measured),
                Some(run) => run.rows.extend(measured.rows),
            }
        }
        log::info!("{} of {} shape maps done", row_number + 1, ROWS.len());
    }
    Ok(Table1 { size, frames, runs })
}

/// Measures one row on one device.
fn measure_row(
    row: &PatternRow,
    scenes: &[PreparedScene],
    backend: &Backend<'_>,
    frames: u32,
    progress: &dyn Fn(String, f64),
) -> Result<Run, Error> {
    let mut renderers = scenes
        .iter()
        .map(|scene| Timed::new(scene, backend))
        .collect::<Result<Vec<_>, _>>()?;
    let device = renderers[0].renderer().name();
    let mut cells = Vec::with_capacity(renderers.len());
    for ((method, scene), timed) in Method::ALL.into_iter().zip(scenes).zip(&mut renderers) {
        let geometry = timed.renderer().geometry(&scene.frame)?;
        let (covered, linear_steps) = geometry.coverage();
        cells.push(Cell {
            method,
            milliseconds: Vec::with_capacity(frames as usize),
            covered: covered as f64 / geometry.surface.len() as f64,
            linear_steps,
        });
    }
    let mut clock = Clock::Wall;
    for round in 0..=frames {
        let fraction = f64::from(round) / f64::from(frames + 1);
        progress(format!("{}: {device}", row.pattern), fraction);
        for ((cell, scene), timed) in cells.iter_mut().zip(scenes).zip(&mut renderers) {
            let (time, read_from) = timed.time(&scene.frame)?;
            clock = read_from;
            if round > 0 {
                cell.milliseconds.push(time);
            }
        }
    }
    Ok(Run {
        device,
        clock,
        rows: vec![cells],
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::Surface;
    use super::*;
    use std::sync::OnceLock;

    /// A small table, measured on the CPU once for all tests.
    pub fn small() -> Table1 {
        static SMALL: OnceLock<Table1> = OnceLock::new();
        let measured = SMALL.get_or_init(|| {
            let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
            measure(&[Backend::Cpu], [32, 24], 2, &assets, &|_, _| ()).unwrap()
        });
        measured.clone()
    }

    #[test]
    fn every_method_is_measured_on_every_map() {
        let table = small();
        assert_eq!(
            (table.size, table.frames, table.runs.len()),
            ([32, 24], 2, 1)
        );
        let run = &table.runs[0];
        assert_eq!((run.clock, run.rows.len()), (Clock::Wall, ROWS.len()));
        for (number, row) in run.rows.iter().enumerate() {
            let methods: Vec<Method> = row.iter().map(|cell| cell.method).collect();
            assert_eq!(methods, Method::ALL);
            for cell in row {
                assert_eq!(cell.milliseconds.len(), 2);
                assert!(cell.milliseconds.iter().all(|time| *time > 0.0));
                assert!(cell.linear_steps <= 25.0);
                // The paper's own search leaves holes.
                let least = if cell.method.surface == Surface::Paper {
                    0.3
                } else {
                    0.98
                };
                assert!(cell.covered > least, "{} {}", cell.method, cell.covered);
                let itself = run.speed(number, cell.method, cell.method).unwrap();
                assert_eq!(itself.median, 1.0);
            }
        }
    }

    #[test]
    fn assets_that_are_not_there() {
        let nowhere = Path::new("no/such/folder");
        let error = measure(&[Backend::Cpu], [8, 8], 1, nowhere, &|_, _| ()).unwrap_err();
        assert!(error.to_string().contains("no/such/folder"), "{error}");
    }
}
