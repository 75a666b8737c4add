//! Pareto fronts.

/// Returns for each (cost, error) whether it is on the Pareto front: no other
/// point is at most as large in both and smaller in one.
///
/// ```
/// use relievo_studies::tradeoff::front;
///
/// let points = [(1.0, 3.0), (2.0, 1.0), (3.0, 2.0)];
/// assert_eq!(front(&points), [true, true, false]);
/// ```
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let by = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    order.sort_by(|a, b| by(&points[*a], &points[*b]));
    let mut is_on = vec![false; points.len()];
    // The last point on the front; later points must have a smaller error.
    let mut last: Option<(f64, f64)> = None;
    for index in order {
        let point = points[index];
        is_on[index] = last.is_none_or(|last| point.1 < last.1 || point == last);
        if is_on[index] {
            last = Some(point);
        }
    }
    is_on
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn fronts_of_known_points() {
        let infinity = f64::INFINITY;
        let points = [
            (1.0, infinity),
            (2.0, 1.0),
            (2.0, 1.0),
            (2.0, 2.0),
            (3.0, 1.0),
            (4.0, 0.0),
        ];
        assert_eq!(front(&points), [true, true, true, false, false, true]);
        assert!(front(&[]).is_empty());
    }

    proptest! {
        #[test]
        fn nothing_beats_what_is_on_the_front_and_something_all_else(
            // Few distinct values, so that some are equal.
            points in prop::collection::vec((0..8u32, 0..8u32), 1..40)
        ) {
            let points: Vec<(f64, f64)> = points
                .into_iter()
                .map(|(cost, error)| (f64::from(cost), if error == 7 { f64::INFINITY } else { f64::from(error) }))
                .collect();
            let is_beaten = |b: &(f64, f64)| points
                .iter()
                .any(|a| a.0 <= b.0 && a.1 <= b.1 && a != b);
            for (point, is_on) in points.iter().zip(front(&points)) {
                prop_assert_eq!(is_on, !is_beaten(point));
            }
        }
    }
}
