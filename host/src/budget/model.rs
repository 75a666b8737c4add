//! What an object's errors are likely to be, from what a picture shows of it.
//!
//! The error in pixels follows a power law in three numbers of the [`View`],
//! within a wide spread: it is an error of the worst pixels, and depends on
//! whether an edge of the pattern lies there. So the model says which tiers are
//! not worth a trial; a trial says which keeps the budget.

use super::View;
use glam::{DMat4, DVec4};

/// Errors below this are not told apart, pixels.
const LEAST: f64 = 0.01;
/// Errors above this are not told apart, pixels.
const LARGEST: f64 = 6.0;

/// Shares of the fitted cases that lie below the low and above the high bound.
const BEYOND: f64 = 0.02;

/// A power law and its spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// ln error = these · (1, ln facet_px, ln way_px, ln slant), with
    /// each of the three at least 0.0001.
    pub coefficients: [f64; 4],
    /// All but one in fifty errors are at least this times what the law says.
    pub low: f64,
    /// All but one in fifty errors are at most this times what the law says.
    pub high: f64,
}

/// Errors of the planar tier; fitted by
/// `relievo bench budget --fit --series 1 --scenes 120 --size 128x96`.
pub const PLANAR: Model = Model {
    coefficients: [-0.936, 0.186, 0.441, 0.853],
    low: 0.081,
    high: 12.3,
};

/// Errors of the fast tier; fitted by
/// `relievo bench budget --fit --series 1 --scenes 120 --size 128x96`.
pub const FAST: Model = Model {
    coefficients: [-4.262, -0.126, 0.641, 1.116],
    low: 0.058,
    high: 13.0,
};

fn terms(view: &View) -> DVec4 {
    let logarithm = |x: f64| x.max(1e-4).ln();
    DVec4::new(
        1.0,
        logarithm(view.facet_px),
        logarithm(view.way_px),
        logarithm(view.slant),
    )
}

impl Model {
    /// The likely error, pixels.
    pub fn predict(&self, view: &View) -> f64 {
        let exponent = DVec4::from_array(self.coefficients).dot(terms(view));
        exponent.exp().clamp(LEAST, LARGEST)
    }

    /// Whether an error within `budget` pixels is likely enough for a trial.
    pub fn may_keep(&self, view: &View, budget: f64) -> bool {
        self.predict(view) * self.low <= budget
    }

    /// The law that fits `cases` (what was seen, and the error in pixels) best
    /// in the mean square of its logarithm; `None` where they are too few.
    pub fn fit(cases: &[(View, f64)]) -> Option<Model> {
        let logarithm = |error: f64| error.clamp(LEAST, LARGEST).ln();
        let mut normal = DMat4::ZERO;
        let mut right = DVec4::ZERO;
        for (view, error) in cases {
            let row = terms(view);
            normal += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
            right += row * logarithm(*error);
        }
        if cases.len() < 8 || normal.determinant().abs() < 1e-9 {
            return None;
        }
        let coefficients = normal.inverse() * right;
        let mut ratios: Vec<f64> = cases
            .iter()
            .map(|(view, error)| (logarithm(*error) - coefficients.dot(terms(view))).exp())
            .collect();
        ratios.sort_by(f64::total_cmp);
        let last = (ratios.len() - 1) as f64;
        Some(Model {
            coefficients: coefficients.to_array(),
            low: ratios[(BEYOND * last).floor() as usize],
            high: ratios[((1.0 - BEYOND) * last).ceil() as usize],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views() -> Vec<View> {
        let mut random = fastrand::Rng::with_seed(5);
        let mut any = || (8.0 * random.f64() - 4.0f64).exp();
        (0..50)
            .map(|_| View {
                rays: 100,
                facet_px: any(),
                way_px: any(),
                slant: 1.0 + any(),
                texel_px: 1.0,
            })
            .collect()
    }

    #[test]
    fn a_power_law_is_found_again() {
        let law = Model {
            coefficients: [-1.2, 0.2, 0.1, 0.3],
            low: 1.0,
            high: 1.0,
        };
        let cases: Vec<_> = views()
            .into_iter()
            .map(|view| (view, law.predict(&view)))
            .collect();
        let found = Model::fit(&cases).unwrap();
        for (found, wanted) in found.coefficients.iter().zip(law.coefficients) {
            assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
        }
        assert!((found.low - 1.0).abs() < 1e-6 && (found.high - 1.0).abs() < 1e-6);
        assert!(cases.iter().all(|(view, error)| law.may_keep(view, *error)));
        assert!(
            !cases
                .iter()
                .any(|(view, error)| law.may_keep(view, 0.9 * error))
        );
    }

    #[test]
    fn too_few_or_equal_cases_are_no_law() {
        let view = views()[0];
        assert_eq!(Model::fit(&[(view, 1.0); 3]), None);
        assert_eq!(Model::fit(&[(view, 1.0); 30]), None);
    }
}
