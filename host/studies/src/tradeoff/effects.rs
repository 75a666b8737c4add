//! Main effects: the effect of changing one axis alone.

use super::report::{Report, Row};
use super::variant::{Axis, Class, Variant};
use crate::bench::Summary;
use std::collections::BTreeMap;

/// Effect of one value of an axis instead of another, over all pairs of
/// variants that differ only in this axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// The value.
    pub value: String,
    /// Number of pairs.
    pub pairs: usize,
    /// Median time ratio.
    pub time: f64,
    /// Median error before and after, pixels.
    pub error_px: [f64; 2],
    /// Median fraction of misplaced pixels before and after, 0…1.
    pub misplaced: [f64; 2],
    /// Median ratio of the FLIP differences, if any.
    pub flip: Option<f64>,
}

/// Returns the effects of the values of `axis` in `class` relative to its value
/// in `start`; empty if there is no other value.
pub fn effects(report: &Report, class: Class, axis: Axis, start: &Variant) -> Vec<Effect> {
    let base = start.value(axis);
    let rows: Vec<&Row> = report
        .rows
        .iter()
        .filter(|row| row.variant.rendering.class() == class)
        .collect();
    let bases: BTreeMap<String, &Row> = rows
        .iter()
        .filter(|row| row.variant.value(axis) == base)
        .map(|row| (row.variant.key_without(axis), *row))
        .collect();
    let mut pairs: Vec<(String, Vec<[&Row; 2]>)> = Vec::new();
    for row in rows {
        let value = row.variant.value(axis);
        if value == base {
            continue;
        }
        if let Some(before) = bases.get(&row.variant.key_without(axis)) {
            match pairs.iter_mut().find(|(known, _)| *known == value) {
                Some((_, known)) => known.push([before, row]),
                None => pairs.push((value, vec![[before, row]])),
            }
        }
    }
    let effects = pairs.into_iter();
    effects
        .filter_map(|(value, pairs)| effect(value, &pairs))
        .collect()
}

fn effect(value: String, pairs: &[[&Row; 2]]) -> Option<Effect> {
    let median = |of: &dyn Fn(&[&Row; 2]) -> f64| {
        let values: Vec<f64> = pairs.iter().map(of).collect();
        middle(&values)
    };
    let both = |of: &dyn Fn(&Row) -> f64| -> Option<[f64; 2]> {
        Some([median(&|pair| of(pair[0]))?, median(&|pair| of(pair[1]))?])
    };
    let flips: Vec<f64> = pairs
        .iter()
        .filter_map(|[before, after]| Some(after.measured.flip? / before.measured.flip?))
        .filter(|ratio| ratio.is_finite())
        .collect();
    Some(Effect {
        value,
        pairs: pairs.len(),
        time: median(&|[before, after]| after.time / before.time)?,
        error_px: both(&|row| row.measured.errors.error_px)?,
        misplaced: both(&|row| row.measured.errors.misplaced)?,
        flip: Summary::of(&flips).map(|summary| summary.median),
    })
}

/// Returns the lower median, which may be infinite.
fn middle(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::super::grid::{Grid, reference, variants};
    use super::super::record::tests::{header, record};
    use super::super::tests::subject;
    use super::super::variant::Rendering;
    use super::*;

    #[test]
    fn only_what_one_axis_changes_counts() {
        let subject = subject("");
        let start = Variant {
            settings: reference(&subject),
            rendering: Rendering::Cpu,
        };
        // In every tier, 24 steps cost half; planar costs a quarter less.
        let records = variants(&subject, Grid::Quick, &[Rendering::Cpu])
            .iter()
            .map(|variant| {
                let is_short = variant.value(Axis::Steps) == "24+4";
                let is_planar = variant.value(Axis::Tier) == "planar";
                let time = if is_short { 1.0 } else { 2.0 } * if is_planar { 0.75 } else { 1.0 };
                let error = if is_planar { f64::INFINITY } else { 0.5 };
                record(&variant.key(), time, error, 0.1)
            })
            .collect();
        let report = Report::new(&subject, vec![header(1, 1)], records);
        let steps = effects(&report, Class::Cpu, Axis::Steps, &start);
        assert_eq!(steps.len(), 1);
        assert_eq!((steps[0].value.as_str(), steps[0].pairs), ("24+4", 4));
        assert_eq!((steps[0].time, steps[0].flip), (0.5, Some(1.0)));
        let tiers = effects(&report, Class::Cpu, Axis::Tier, &start);
        assert_eq!(tiers.len(), 3);
        let planar = &tiers[0];
        assert_eq!(
            (planar.value.as_str(), planar.pairs, planar.time),
            ("planar", 2, 0.75)
        );
        assert_eq!(planar.error_px, [0.5, f64::INFINITY]);
        assert!(effects(&report, Class::Gpu, Axis::Tier, &start).is_empty());
        assert!(effects(&report, Class::Cpu, Axis::Renderer, &start).is_empty());
    }
}
