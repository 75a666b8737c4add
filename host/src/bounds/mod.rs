//! How far the f32 mathematics is from the same sources in f64, by the binary
//! exponent of what makes it hard: as a table, and against a stated bound.
//!
//! Both sides start from the same f32 numbers, so that what is measured is what
//! the function itself loses. Where even that is easy, the judge is exact
//! arithmetic (division and square root).

mod numbers;
mod page;
mod paths;
mod rays;
mod sample;

pub use page::page;

use fastrand::Rng;
use rayon::prelude::*;
use sample::Sample;

/// A function, or a part of its result, and over what it is measured.
pub struct Function {
    /// Module and result.
    pub name: &'static str,
    /// What the exponents are of.
    pub over: &'static str,
    /// What errors are relative to.
    pub relative_to: &'static str,
    /// The binary exponents of the domain: from 2^first up to, not including, 2^end.
    pub exponents: [i32; 2],
    /// Exponents in a row.
    pub stride: usize,
    /// The largest error promised, anywhere in the domain.
    pub bound: f64,
    /// Share of the inputs of a row that may have another answer (another class
    /// of hit, or another column), because both are within a rounding error.
    pub others: f64,
    /// One input: what the exponents are of has this magnitude.
    sample: fn(&mut Rng, f64) -> Sample,
}

/// What was found for some exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The first exponent.
    pub exponent: i32,
    /// Inputs that were compared.
    pub count: usize,
    /// Share of them with another answer, which have no error.
    pub others: f64,
    /// The error that half of the rest do not exceed.
    pub median: f64,
    /// The largest of them; infinite for a NaN.
    pub worst: f64,
}

/// Every function.
pub fn functions() -> impl Iterator<Item = &'static Function> {
    [numbers::LIST, rays::LIST, paths::LIST]
        .into_iter()
        .flatten()
}

impl Function {
    /// Measures `count` inputs for each row. The inputs are the same in every run.
    pub fn measure(&self, count: usize) -> Vec<Row> {
        let [first, end] = self.exponents;
        let rows: Vec<i32> = (first..end).step_by(self.stride).collect();
        let row = |&exponent: &i32| {
            let above = (exponent + self.stride as i32).min(end);
            let mut rng = Rng::with_seed(exponent as u64);
            let samples = (0..count).map(|_| {
                let power = f64::from(exponent) + f64::from(above - exponent) * rng.f64();
                (self.sample)(&mut rng, power.exp2())
            });
            Row::of(exponent, samples)
        };
        rows.par_iter().map(row).collect()
    }

    /// Whether `row` keeps what is promised.
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
                // Enough of the inputs count.
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
        // Nothing that counts is nothing that is kept.
        let function = functions().next().unwrap();
        assert!(!function.holds(&row(vec![Sample::Unfit])));
        assert!(!function.holds(&row(vec![error(f64::NAN)])));
        assert!(!function.holds(&row(vec![error(0.0), Sample::Other])));
    }
}
