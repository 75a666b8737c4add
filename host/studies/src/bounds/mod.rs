//! Errors of the f32 mathematics relative to the same sources in f64, by the
//! binary exponent of a quantity that makes the input hard. Written as tables
//! and checked against stated bounds.
//!
//! Both sides start from the same f32 inputs, so that only the error of the
//! function itself is measured. Division and square root are compared with
//! exact arithmetic.

mod numbers;
mod page;
mod paths;
mod rays;
mod sample;

pub use page::page;

use fastrand::Rng;
use rayon::prelude::*;
use sample::Sample;
use serde::{Deserialize, Deserializer, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A function, or part of its result, and its domain.
pub struct Function {
    /// Module and result.
    pub name: &'static str,
    /// Quantity whose exponents make the rows.
    pub over: &'static str,
    /// Quantity that errors are relative to.
    pub relative_to: &'static str,
    /// Half-open range of binary exponents: 2^first to 2^end.
    pub exponents: [i32; 2],
    /// Exponents per row.
    pub stride: usize,
    /// Largest error allowed in the whole domain.
    pub bound: f64,
    /// Largest fraction of a row's inputs with another discrete result (another
    /// class or column), both being within a rounding error.
    pub others: f64,
    /// Evaluates one input for which the quantity in `over` has this magnitude.
    sample: fn(&mut Rng, f64) -> Sample,
}

/// Errors found for a range of exponents.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// First exponent.
    pub exponent: i32,
    /// Number of inputs compared.
    pub count: usize,
    /// Fraction with another discrete result; these have no error.
    pub others: f64,
    /// Median error of the rest.
    #[serde(deserialize_with = "number")]
    pub median: f64,
    /// Largest error of the rest; infinite if one is NaN.
    #[serde(deserialize_with = "number")]
    pub worst: f64,
}

/// Reads a number. JSON has null for infinity.
fn number<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

/// Returns every function.
pub fn functions() -> impl Iterator<Item = &'static Function> {
    [numbers::LIST, rays::LIST, paths::LIST]
        .into_iter()
        .flatten()
}

/// Returns the rows of all functions: a function and its first exponent.
pub fn rows() -> Vec<(&'static Function, i32)> {
    functions()
        .flat_map(|function| function.rows().map(move |exponent| (function, exponent)))
        .collect()
}

/// Measures `count` inputs of each of `rows`. `progress` gets a function's name and the share that
/// is done.
pub fn measure(
    rows: &[(&Function, i32)],
    count: usize,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Vec<Row> {
    let done = AtomicUsize::new(0);
    let measure = |(function, exponent): &(&Function, i32)| {
        let row = function.measure_row(*exponent, count);
        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
        progress(function.name, done as f64 / rows.len() as f64);
        row
    };
    rows.par_iter().map(measure).collect()
}

impl Function {
    /// Returns the first exponent of each row.
    pub fn rows(&self) -> impl Iterator<Item = i32> + use<> {
        let [first, end] = self.exponents;
        (first..end).step_by(self.stride)
    }

    /// Measures `count` inputs of the row from `exponent`, the same in every run.
    pub fn measure_row(&self, exponent: i32, count: usize) -> Row {
        let above = (exponent + self.stride as i32).min(self.exponents[1]);
        let mut rng = Rng::with_seed(exponent as u64);
        let samples = (0..count).map(|_| {
            let power = f64::from(exponent) + f64::from(above - exponent) * rng.f64();
            (self.sample)(&mut rng, power.exp2())
        });
        Row::of(exponent, samples)
    }

    /// Measures `count` inputs of each row.
    pub fn measure(&self, count: usize) -> Vec<Row> {
        let rows: Vec<i32> = self.rows().collect();
        let rows = rows.par_iter();
        rows.map(|&exponent| self.measure_row(exponent, count))
            .collect()
    }

    /// Returns whether `row` keeps the bounds.
    pub fn holds(&self, row: &Row) -> bool {
        row.count > 0 && row.worst <= self.bound && row.others <= self.others
    }
}

impl Row {
    fn of(exponent: i32, samples: impl Iterator<Item = Sample>) -> Row {
        let (mut errors, mut others) = (Vec::new(), 0);
        for sample in samples {
            match sample {
                Sample::Error(error) if error.is_nan() => errors.push(f64::INFINITY),
                Sample::Error(error) => errors.push(error),
                Sample::Other => others += 1,
                Sample::Unfit => (),
            }
        }
        errors.sort_by(f64::total_cmp);
        let count = errors.len() + others;
        Row {
            exponent,
            count,
            others: others as f64 / count.max(1) as f64,
            median: errors.get(errors.len() / 2).copied().unwrap_or_default(),
            worst: errors.last().copied().unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_keeps_its_bound() {
        for function in functions() {
            for row in function.measure(2_000) {
                assert!(function.holds(&row), "{}: {row:?}", function.name);
                // Enough inputs were usable.
                assert!(row.count > 1_500, "{}: {row:?}", function.name);
            }
        }
    }

    #[test]
    fn a_row_tells_nan_and_other_answers() {
        let row = |samples: Vec<Sample>| Row::of(3, samples.into_iter());
        let error = Sample::Error;
        let found = row(vec![
            error(0.3),
            error(0.1),
            Sample::Other,
            error(0.2),
            Sample::Unfit,
        ]);
        assert_eq!((found.count, found.others), (4, 0.25));
        assert_eq!((found.median, found.worst), (0.2, 0.3));
        assert_eq!(row(vec![error(f64::NAN)]).worst, f64::INFINITY);
        // A row without usable inputs does not pass.
        let function = functions().next().unwrap();
        assert!(!function.holds(&row(vec![Sample::Unfit])));
        assert!(!function.holds(&row(vec![error(f64::NAN)])));
        assert!(!function.holds(&row(vec![error(0.0), Sample::Other])));
    }
}
