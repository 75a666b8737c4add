//! Predicts an object's error from its [`ScreenMetrics`].
//!
//! The error in pixels follows a power law in three of the metrics, with a wide
//! spread: it is an error of the worst pixels, and depends on whether an edge of
//! the pattern lies there. The model therefore only excludes tiers that are not
//! worth a trial; a trial decides whether a tier keeps the budget.

use super::metrics::ScreenMetrics;
use glam::{DMat4, DVec4};

/// Smaller errors are clamped to this, pixels.
const LEAST: f64 = 0.01;
/// Larger errors are clamped to this, pixels.
const LARGEST: f64 = 6.0;

/// Share of the fitted cases below the low bound, and share above the high one.
const BEYOND: f64 = 0.02;

/// A power law and its spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// ln error = these · (1, ln facet_px, ln way_px, ln slant), with
    /// each of the three at least 0.0001.
    pub coefficients: [f64; 4],
    /// 0.02 quantile of actual error / predicted error.
    pub low: f64,
    /// 0.98 quantile of actual error / predicted error.
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

fn terms(metrics: &ScreenMetrics) -> DVec4 {
    let logarithm = |x: f64| x.max(1e-4).ln();
    DVec4::new(
        1.0,
        logarithm(metrics.facet_px),
        logarithm(metrics.way_px),
        logarithm(metrics.slant),
    )
}

impl Model {
    /// Returns the predicted error, pixels.
    pub fn predict(&self, metrics: &ScreenMetrics) -> f64 {
        let exponent = DVec4::from_array(self.coefficients).dot(terms(metrics));
        exponent.exp().clamp(LEAST, LARGEST)
    }

    /// Returns whether an error within `budget` pixels is likely enough for a
    /// trial.
    pub fn may_keep(&self, metrics: &ScreenMetrics, budget: f64) -> bool {
        self.predict(metrics) * self.low <= budget
    }

    /// Fits the model to `cases` (metrics, and the error in pixels) by least
    /// squares of the logarithm; `None` for too few or too similar cases.
    pub fn fit(cases: &[(ScreenMetrics, f64)]) -> Option<Model> {
        let logarithm = |error: f64| error.clamp(LEAST, LARGEST).ln();
        let mut normal = DMat4::ZERO;
        let mut right = DVec4::ZERO;
        for (metrics, error) in cases {
            let row = terms(metrics);
            normal += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
            right += row * logarithm(*error);
        }
        if cases.len() < 8 || normal.determinant().abs() < 1e-9 {
            return None;
        }
        let coefficients = normal.inverse() * right;
        let mut ratios: Vec<f64> = cases
            .iter()
            .map(|(metrics, error)| (logarithm(*error) - coefficients.dot(terms(metrics))).exp())
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

    fn cases() -> Vec<ScreenMetrics> {
        let mut random = fastrand::Rng::with_seed(5);
        let mut any = || (8.0 * random.f64() - 4.0f64).exp();
        (0..50)
            .map(|_| ScreenMetrics {
                pixels: 100.0,
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
        let cases: Vec<_> = cases()
            .into_iter()
            .map(|metrics| (metrics, law.predict(&metrics)))
            .collect();
        let found = Model::fit(&cases).unwrap();
        for (found, wanted) in found.coefficients.iter().zip(law.coefficients) {
            assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
        }
        assert!((found.low - 1.0).abs() < 1e-6 && (found.high - 1.0).abs() < 1e-6);
        assert!(
            cases
                .iter()
                .all(|(metrics, error)| law.may_keep(metrics, *error))
        );
        assert!(
            !cases
                .iter()
                .any(|(metrics, error)| law.may_keep(metrics, 0.9 * error))
        );
    }

    #[test]
    fn too_few_or_equal_cases_are_no_law() {
        let metrics = cases()[0];
        assert_eq!(Model::fit(&[(metrics, 1.0); 3]), None);
        assert_eq!(Model::fit(&[(metrics, 1.0); 30]), None);
    }
}
