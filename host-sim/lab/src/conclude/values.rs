//! Values beside those of the answer: what the alternatives have, and how the errors of the answer's own go together.

use diagnosis::confidence_set;
use diagnosis::hypothesis::Entry;
use diagnosis::pipeline::Conclusion;
use diagnosis::problem::Problem;
use nalgebra::DMatrix;

use crate::read::{AxisKind, vocabulary};
use crate::report::{AlternativeAnswer, AlternativeEffect, AlternativeValue, CorrelationAnswer};

/// The models beside the best one that the recordings do not exclude.
pub(super) fn alternatives(problem: &Problem, conclusion: &Conclusion, axis: AxisKind) -> Vec<AlternativeAnswer> {
    let others = conclusion.in_the_set.iter().skip(1);
    let model = |entries: &[Entry]| entries.iter().map(|entry| effect(problem, entry, axis)).collect();
    others.map(|hypothesis| AlternativeAnswer { effects: model(&hypothesis.entries) }).collect()
}

fn effect(problem: &Problem, entry: &Entry, axis: AxisKind) -> AlternativeEffect {
    let kinds = vocabulary::effect(entry.effect.id).map_or(&[][..], |kind| kind.parameters);
    let values = (entry.effect.report)(&entry.values);
    let recording = (entry.effect.span)(&entry.values).and_then(|(index, ..)| problem.recordings.get(index));
    AlternativeEffect {
        id: entry.effect.id.to_owned(),
        parameters: kinds
            .iter()
            .zip(values)
            .map(|(kind, value)| AlternativeValue {
                id: kind.id(axis).to_owned(),
                value,
                unit: kind.unit(axis).to_owned(),
            })
            .collect(),
        recording: recording.map(|recorded| recorded.name.clone()),
    }
}

/// Correlation of the errors of the reported values, in the order of the answer; values without an error are left out. None with
/// fewer than two.
pub(super) fn correlation(conclusion: &Conclusion, axis: AxisKind) -> Option<CorrelationAnswer> {
    let best = &conclusion.best.assessed;
    let entries = &best.refitted.hypothesis.entries;
    let mut taken = vec![false; entries.len()];
    let (mut names, mut slopes) = (Vec::new(), Vec::new());
    for named in &conclusion.effects {
        let Some(at) = (0..entries.len()).find(|&at| !taken[at] && entries[at] == named.entry) else { continue };
        let again = (0..entries.len()).filter(|&other| taken[other] && entries[other].effect == named.effect).count();
        taken[at] = true;
        let id = named.effect.id;
        let id = if again > 0 { format!("{id}#{}", again + 1) } else { id.to_owned() };
        let kinds = vocabulary::effect(named.effect.id).map_or(&[][..], |kind| kind.parameters);
        for (kind, slopes_of_value) in kinds.iter().zip(confidence_set::slopes(best, at)) {
            names.push(format!("{id}.{}", kind.id(axis)));
            slopes.push(slopes_of_value);
        }
    }
    of_slopes(&names, &slopes, &best.covariance)
}

/// From fitted values with that covariance to reported ones with those slopes.
fn of_slopes(names: &[String], slopes: &[Vec<f64>], covariance: &DMatrix<f64>) -> Option<CorrelationAnswer> {
    let slopes = DMatrix::from_fn(slopes.len(), covariance.nrows(), |row, column| slopes[row][column]);
    let covariance = &slopes * covariance * slopes.transpose();
    let sd = |value: usize| covariance[(value, value)].sqrt();
    let known: Vec<usize> = (0..names.len()).filter(|&value| sd(value).is_finite() && sd(value) > 0.0).collect();
    let of = |one: usize, other: usize| {
        if one == other {
            return 1.0;
        }
        // Rounding aside, the two triangles are the same.
        let both = 0.5 * (covariance[(one, other)] + covariance[(other, one)]);
        // No more digits than anybody reads.
        (1e4 * (both / (sd(one) * sd(other))).clamp(-1.0, 1.0)).round() / 1e4
    };
    (known.len() > 1).then(|| CorrelationAnswer {
        values: known.iter().map(|&value| names[value].clone()).collect(),
        matrix: known.iter().map(|&one| known.iter().map(|&other| of(one, other)).collect()).collect(),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn correlations_are_those_of_the_reported_values() {
        let names = ["sum", "first", "fixed"].map(str::to_owned);
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1.0]);
        let slopes = [vec![1.0, 0.75], vec![-1.0, 0.0], vec![0.0, 0.0]];
        let found = of_slopes(&names, &slopes, &covariance).unwrap();
        assert_eq!(found.values, ["sum", "first"]);
        assert_eq!(found.matrix, [[1.0, -0.8], [-0.8, 1.0]]);
        assert_eq!(of_slopes(&names[1..], &slopes[1..], &covariance), None);
    }
}
