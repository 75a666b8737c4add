//! Statistics of repeated measurements.

/// Five-number summary of a set of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Smallest value.
    pub minimum: f64,
    /// First quartile.
    pub lower_quartile: f64,
    /// Median.
    pub median: f64,
    /// Third quartile.
    pub upper_quartile: f64,
    /// Largest value.
    pub maximum: f64,
}

impl Summary {
    /// Summarizes `values`, in any order and unit; `None` if there are none.
    /// Quartiles are interpolated linearly.
    ///
    /// ```
    /// use relievo_studies::bench::Summary;
    ///
    /// let summary = Summary::of(&[4.0, 1.0, 2.0]).unwrap();
    /// assert_eq!(summary.median, 2.0);
    /// ```
    pub fn of(values: &[f64]) -> Option<Summary> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let quantile = |share: f64| {
            let position = share * last as f64;
            let below = position.floor();
            let [low, high] = [below, position.ceil()].map(|index| sorted[index as usize]);
            low + (high - low) * (position - below)
        };
        Some(Summary {
            minimum: sorted[0],
            lower_quartile: quantile(0.25),
            median: quantile(0.5),
            upper_quartile: quantile(0.75),
            maximum: sorted[last],
        })
    }

    /// Summarizes the ratios of values measured in the same round, which cancel
    /// what slowed the round; `None` if there are none.
    pub fn of_ratios(numerators: &[f64], denominators: &[f64]) -> Option<Summary> {
        let ratios: Vec<f64> = numerators
            .iter()
            .zip(denominators)
            .map(|(numerator, denominator)| numerator / denominator)
            .collect();
        Summary::of(&ratios)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quartiles_of_known_values() {
        assert_eq!(Summary::of(&[]), None);
        let one = Summary::of(&[3.0]).unwrap();
        assert_eq!((one.minimum, one.median, one.maximum), (3.0, 3.0, 3.0));
        let four = Summary::of(&[4.0, 1.0, 3.0, 2.0]).unwrap();
        let expected = Summary {
            minimum: 1.0,
            lower_quartile: 1.75,
            median: 2.5,
            upper_quartile: 3.25,
            maximum: 4.0,
        };
        assert_eq!(four, expected);
    }

    #[test]
    fn ratios_are_taken_within_a_round() {
        // The second round was ten times slower for both.
        let ratios = Summary::of_ratios(&[2.0, 20.0, 2.0], &[1.0, 10.0, 1.0]).unwrap();
        assert_eq!((ratios.minimum, ratios.maximum), (2.0, 2.0));
        assert_eq!(Summary::of_ratios(&[1.0], &[]), None);
    }

    proptest! {
        #[test]
        fn the_five_numbers_are_in_order_and_lie_among_the_values(
            values in prop::collection::vec(1e-3..1e6_f64, 1..40)
        ) {
            let summary = Summary::of(&values).unwrap();
            let Summary { minimum, lower_quartile, median, upper_quartile, maximum } = summary;
            prop_assert!(minimum <= lower_quartile && lower_quartile <= median);
            prop_assert!(median <= upper_quartile && upper_quartile <= maximum);
            prop_assert!(values.contains(&minimum) && values.contains(&maximum));
            let above = values.iter().filter(|value| **value > median).count();
            let below = values.iter().filter(|value| **value < median).count();
            prop_assert!(2 * above <= values.len() && 2 * below <= values.len());
        }
    }
}
