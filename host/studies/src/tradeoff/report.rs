//! All measurements of a sweep, and their Pareto fronts.

use super::measure::Measurement;
use super::pareto::front;
use super::record::{Header, Outcome, Record, read_all};
use super::subject::Subject;
use super::sweep::{all_variants, own_variants};
use super::variant::{Axis, Class, Variant};
use crate::bench::{Summary, quoted};
use relievo::Error;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A measured variant.
#[derive(Clone, Debug)]
pub struct Row {
    /// Variant.
    pub variant: Variant,
    /// Measurement.
    pub measured: Measurement,
    /// Time as a multiple of the reference's.
    pub to_reference: Summary,
    /// Time as a multiple of that of the cheapest of its class.
    pub time: f64,
}

/// Error metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// 99th percentile of the per-pixel error, pixels.
    ErrorPixels,
    /// FLIP difference of the picture.
    Flip,
}

/// A measured sweep.
#[derive(Clone, Debug)]
pub struct Report {
    /// Header of each shard.
    pub headers: Vec<Header>,
    /// Measured variants, in the order of the grid.
    pub rows: Vec<Row>,
    /// Variants that cannot be drawn, with reasons.
    pub left_out: Vec<(Variant, String)>,
}

impl Metric {
    /// Every metric.
    pub const ALL: [Metric; 2] = [Metric::ErrorPixels, Metric::Flip];

    /// Returns the title.
    pub fn title(self) -> &'static str {
        match self {
            Metric::ErrorPixels => "error in pixels",
            Metric::Flip => "FLIP difference",
        }
    }

    /// Rounds `error` to its resolution: a FLIP difference of a thousandth is
    /// invisible and must not put a variant on the front.
    fn told_apart(self, error: f64) -> f64 {
        match self {
            Metric::ErrorPixels => error,
            Metric::Flip => (1e3 * error).round(),
        }
    }

    /// Returns the error of `row`; `None` without a truth.
    pub fn of(self, row: &Row) -> Option<f64> {
        match self {
            Metric::ErrorPixels => Some(row.measured.errors.error_px),
            Metric::Flip => row.measured.flip,
        }
    }
}

impl Report {
    /// Reads all measurements of `subject` in `folder`.
    ///
    /// # Errors
    /// [`Error::Measurements`] if they belong to different sweeps or subjects,
    /// or some are missing.
    pub fn read(folder: &Path, subject: &Subject) -> Result<Report, Error> {
        let (headers, records) = read_all(folder)?;
        let problem = |problem: String| Error::Measurements {
            path: folder.to_path_buf(),
            problem,
        };
        let Some(first) = headers.first() else {
            return Err(problem("holds no measurements".to_string()));
        };
        if first.digest != subject.digest {
            return Err(problem(format!(
                "holds measurements of another scene, or {} or a file that it names has changed since; name the right scene, or measure anew",
                subject.scene.path.display()
            )));
        }
        let there: BTreeSet<&str> = records.iter().map(|record| record.key.as_str()).collect();
        let incomplete: Vec<String> = headers
            .iter()
            .filter_map(|header| {
                let own = own_variants(subject, header);
                let keys = own.iter().map(Variant::key);
                let missing = keys.filter(|key| !there.contains(key.as_str())).count();
                let shard = header.shard;
                (missing > 0)
                    .then(|| format!("{missing} of shard {}/{}", shard.number, shard.count))
            })
            .collect();
        if !incomplete.is_empty() {
            return Err(problem(format!(
                "lacks variants: {}; run these again, which measures what is missing",
                incomplete.join(", ")
            )));
        }
        Ok(Report::new(subject, headers, records))
    }

    /// Creates the report from `headers` and `records` of `subject`.
    pub fn new(subject: &Subject, headers: Vec<Header>, records: Vec<Record>) -> Report {
        let mut outcomes: BTreeMap<String, Outcome> = records
            .into_iter()
            .map(|record| (record.key, record.outcome))
            .collect();
        let variants = headers
            .first()
            .map_or_else(Vec::new, |header| all_variants(subject, header));
        let (mut rows, mut left_out) = (Vec::new(), Vec::new());
        for variant in variants {
            match outcomes.remove(&variant.key()) {
                Some(Outcome::Measured(measured)) => {
                    if let Some(to_reference) = measured.time_ratio() {
                        rows.push(Row {
                            variant,
                            measured: *measured,
                            to_reference,
                            time: to_reference.median,
                        });
                    }
                }
                Some(Outcome::LeftOut(reason)) => left_out.push((variant, reason)),
                None => {}
            }
        }
        let mut cheapest: BTreeMap<Class, f64> = BTreeMap::new();
        for row in &rows {
            let least = cheapest
                .entry(row.variant.rendering.class())
                .or_insert(f64::INFINITY);
            *least = least.min(row.to_reference.median);
        }
        for row in &mut rows {
            row.time = row.to_reference.median / cheapest[&row.variant.rendering.class()];
        }
        Report {
            headers,
            rows,
            left_out,
        }
    }

    /// Returns the measured classes.
    pub fn classes(&self) -> Vec<Class> {
        let classes: BTreeSet<Class> = self
            .rows
            .iter()
            .map(|row| row.variant.rendering.class())
            .collect();
        classes.into_iter().collect()
    }

    /// Returns the rows of `class` that have this metric, with their error and
    /// whether they are on the Pareto front of time and error.
    pub fn points(&self, class: Class, metric: Metric) -> Vec<(&Row, f64, bool)> {
        let known: Vec<(&Row, f64)> = self
            .rows
            .iter()
            .filter(|row| row.variant.rendering.class() == class)
            .filter_map(|row| Some((row, metric.of(row)?)))
            .collect();
        let points = known.iter();
        let points: Vec<(f64, f64)> = points
            .map(|(row, error)| (row.time, metric.told_apart(*error)))
            .collect();
        known
            .into_iter()
            .zip(front(&points))
            .map(|((row, error), is_on)| (row, error, is_on))
            .collect()
    }

    /// Returns the rows on the front, by increasing time.
    pub fn front(&self, class: Class, metric: Metric) -> Vec<(&Row, f64)> {
        let mut on: Vec<(&Row, f64)> = self
            .points(class, metric)
            .into_iter()
            .filter(|(_, _, is_on)| *is_on)
            .map(|(row, error, _)| (row, error))
            .collect();
        on.sort_by(|a, b| a.0.time.total_cmp(&b.0.time));
        on
    }

    /// Writes CSV: a header, then a line for each variant; fields without a
    /// value are empty.
    pub fn to_csv(&self) -> String {
        let axes = Axis::ALL.map(Axis::column).join(",");
        let mut text = format!(
            "key,{axes},time_ratio_to_cheapest,\
             time_ratio_to_reference,lower_quartile,upper_quartile,median_ms,reference_median_ms,\
             clock,frames,steps_per_ray,gpu_bytes,instructions,\
             silhouette_iou,holes,interior_holes,extra_pixels,distance_p99,class_error_share,\
             error_px,misplaced_share,flip,on_front_of_error_px,on_front_of_flip,left_out\n"
        );
        let mut on_front = Metric::ALL.map(|_| BTreeSet::new());
        for (metric, keys) in Metric::ALL.into_iter().zip(&mut on_front) {
            for class in self.classes() {
                let front = self.front(class, metric);
                keys.extend(front.iter().map(|(row, _)| row.variant.key()));
            }
        }
        for row in &self.rows {
            let key = row.variant.key();
            let on_front = on_front.each_ref().map(|keys| keys.contains(&key));
            text += &line(row, &key, on_front);
        }
        for (variant, reason) in &self.left_out {
            let mut fields = vec![variant.key()];
            fields.extend(Axis::ALL.map(|axis| variant.value(axis)));
            fields.resize(1 + Axis::ALL.len() + MEASURED_FIELDS, String::new());
            fields.push(quoted(reason));
            text += &fields.join(",");
            text.push('\n');
        }
        text
    }
}

/// Returns the fields of the measurement.
const MEASURED_FIELDS: usize = 22;

fn line(row: &Row, key: &str, on_front: [bool; 2]) -> String {
    let optional = |value: Option<u64>| value.map_or_else(String::new, |v| v.to_string());
    let real = |value: f64| format!("{value:.6}");
    let median = |values: &[f64]| {
        Summary::of(values).map_or_else(String::new, |summary| real(summary.median))
    };
    let Row {
        variant, measured, ..
    } = row;
    let errors = &measured.errors;
    let mut fields = vec![key.to_string()];
    fields.extend(Axis::ALL.map(|axis| variant.value(axis)));
    fields.extend([
        real(row.time),
        real(row.to_reference.median),
        real(row.to_reference.lower_quartile),
        real(row.to_reference.upper_quartile),
        median(&measured.milliseconds),
        median(&measured.reference_milliseconds),
        quoted(measured.clock.describe()),
        measured.milliseconds.len().to_string(),
        real(measured.steps_per_ray),
        optional(measured.gpu_bytes),
        optional(measured.instructions),
        real(errors.silhouette_iou),
        errors.holes.to_string(),
        errors.interior_holes.to_string(),
        errors.extra.to_string(),
        format!("{:e}", errors.distance_p99),
        real(errors.class_errors),
        errors.error_px.to_string(),
        real(errors.misplaced),
        measured.flip.map_or_else(String::new, real),
    ]);
    fields.extend(on_front.map(|is_on| is_on.to_string()));
    fields.push(String::new());
    fields.join(",") + "\n"
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::grid::Grid;
    use super::super::record::tests::{header, record};
    use super::super::tests::subject;
    use super::super::variant::Rendering;
    use super::*;
    use crate::tradeoff::variants;

    /// Returns a sweep of the small grid with made-up measurements, on CPU and
    /// GPU.
    pub fn report() -> Report {
        let subject = subject("");
        let mut header = header(1, 1);
        header.renderings = vec![Rendering::Cpu, Rendering::GpuExact, Rendering::GpuFast];
        let variants = variants(&subject, Grid::Quick, &header.renderings);
        let errors = [f64::INFINITY, 1.5, 0.35, 0.1, 0.0];
        let mut records: Vec<Record> = variants
            .iter()
            .enumerate()
            .map(|(i, variant)| {
                let time = 0.5 + ((7 * i) % 13) as f64 / 5.0;
                record(
                    &variant.key(),
                    time,
                    errors[(3 * i) % 5],
                    0.01 + 0.002 * ((11 * i) % 17) as f64,
                )
            })
            .collect();
        let last = records.last_mut().unwrap();
        last.outcome = Outcome::LeftOut("the \"map\" folds, here".to_string());
        Report::new(&subject, vec![header], records)
    }

    #[test]
    fn times_are_ratios_to_the_cheapest_of_the_class() {
        let report = report();
        assert_eq!(report.classes(), [Class::Cpu, Class::Gpu]);
        for class in report.classes() {
            for metric in Metric::ALL {
                let points = report.points(class, metric);
                let least = points.iter().map(|(row, _, _)| row.time);
                assert_eq!(least.fold(f64::INFINITY, f64::min), 1.0);
                let front = report.front(class, metric);
                assert_eq!(front[0].0.time, 1.0);
                assert!(front.windows(2).all(|pair| pair[0].1 >= pair[1].1));
            }
        }
    }

    #[test]
    fn every_line_of_the_csv_has_the_headers_fields() {
        let report = report();
        let csv = report.to_csv();
        let mut reader = csv.lines();
        let columns: Vec<&str> = reader.next().unwrap().split(',').collect();
        assert_eq!(columns.len(), 1 + Axis::ALL.len() + MEASURED_FIELDS + 1);
        let lines: Vec<&str> = reader.collect();
        assert_eq!(lines.len(), 3 * 14);
        let place = |name: &str| columns.iter().position(|column| *column == name).unwrap();
        let (last, measured) = lines.split_last().unwrap();
        for line in measured {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), columns.len(), "{line}");
            assert!(
                fields[place("time_ratio_to_cheapest")]
                    .parse::<f64>()
                    .unwrap()
                    >= 1.0
            );
            assert!(fields[place("error_px")].parse::<f64>().unwrap() >= 0.0);
            let axes: Vec<&str> = fields[0].split('/').collect();
            assert_eq!(axes, fields[1..=Axis::ALL.len()]);
        }
        assert!(last.ends_with(",\"the \"\"map\"\" folds, here\""), "{last}");
        let before = last.split(",\"").next().unwrap();
        assert_eq!(before.split(',').count(), columns.len() - 1);
        assert!(csv.contains(",inf,"));
    }
}
