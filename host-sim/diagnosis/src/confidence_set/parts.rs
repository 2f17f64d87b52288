//! Effects that say the same as one value of an entry: an offset and half the difference of an asymmetry, wherever the axis moves.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::information::Assessed;
use super::intervals::TWO_SIDED_95;
use crate::effects::{Columns, Effect};
use crate::hypothesis::{Kept, columns, kept};
use crate::problem::Problem;

/// Of an entry of several values the effects of one value, of a vocabulary, that these recordings do not tell from one of them: with it in
/// that value's place, and all others refitted, the linearised likelihood falls by less than a 95 % interval allows, and without it by more.
pub(crate) fn alike_in_part(
    problem: &Problem,
    best: &Assessed,
    entry: usize,
    vocabulary: &[&'static Effect],
) -> Vec<&'static Effect> {
    let entries = &best.refitted.hypothesis.entries;
    let own = entries[entry].effect;
    if own.columns != Columns::Each || own.parameters.len() < 2 {
        return Vec::new();
    }
    let of_one_value = |effect: &&'static Effect| {
        effect.columns == Columns::Each
            && effect.parameters.len() == 1
            && (effect.applies)(&problem.nominal, &problem.excitation)
            && entries.iter().all(|entry| entry.effect != *effect)
    };
    let others: Vec<&'static Effect> = vocabulary.iter().copied().filter(of_one_value).collect();
    let Some(parts) = Parts::of(problem, best, entry) else { return Vec::new() };
    let missed = parts.missed();
    others.into_par_iter().filter(|effect| parts.one_is_said_by(problem, best, &missed, effect)).collect()
}

/// The values of an entry, as columns beside those of all others.
struct Parts {
    path: Kept,
    weight: Vec<f64>,
    /// Of all free values of the hypothesis.
    columns: Vec<Vec<f64>>,
    /// Of the entry's values: the place of each among the columns, and how far it is from the machine without it.
    values: Vec<(usize, f64)>,
    /// What twice a fall of the log-likelihood is to stay under.
    limit: f64,
}

impl Parts {
    fn of(problem: &Problem, best: &Assessed, entry: usize) -> Option<Self> {
        let hypothesis = &best.refitted.hypothesis;
        let path = kept(problem, &hypothesis.physics(&problem.nominal), &best.refitted.noise, problem.fitted)?;
        let columns: Option<Vec<Vec<f64>>> =
            columns(problem, hypothesis, &path).into_iter().map(|column| Some(column?.concat())).collect();
        let entry_of = &hypothesis.entries[entry];
        let without = (entry_of.effect.starts)(&problem.nominal, &problem.excitation).into_iter().next()?;
        let places = hypothesis.free().into_iter().enumerate().filter(|(_, (of, _))| *of == entry);
        let values = places.map(|(place, (_, index))| (place, entry_of.values[index] - without[index])).collect();
        let (_, weight) = path.weighted();
        let limit = TWO_SIDED_95 * TWO_SIDED_95 * best.inflation(entry);
        Some(Self { path, weight, columns: columns?, values, limit })
    }

    /// The values without which, all others refitted, the likelihood falls.
    fn missed(&self) -> Vec<(usize, f64)> {
        let falls = |&(place, by): &(usize, f64)| self.fall(place, by, None).is_some_and(|fall| fall > self.limit);
        self.values.iter().copied().filter(falls).collect()
    }

    /// Whether an effect of one value may stand in the place of one of these.
    fn one_is_said_by(
        &self,
        problem: &Problem,
        best: &Assessed,
        these: &[(usize, f64)],
        effect: &'static Effect,
    ) -> bool {
        let column = || {
            let values = (effect.starts)(&problem.nominal, &problem.excitation).into_iter().next()?;
            let by = effect.ranges(1, &problem.nominal, &problem.excitation)[0].scale;
            let other = best.refitted.hypothesis.with(effect, vec![values.first()? + by]);
            Some(self.path.response(problem, &other.physics(&problem.nominal))?.concat())
        };
        let Some(column) = column() else { return false };
        let mut falls = these.iter().filter_map(|&(place, by)| self.fall(place, by, Some(&column)));
        falls.any(|fall| fall <= self.limit)
    }

    /// Twice what the linearised log-likelihood falls by where the value at a place goes by so much, the others are refitted, and another
    /// column, if any, with them; none where that column is made of theirs.
    fn fall(&self, place: usize, by: f64, other: Option<&Vec<f64>>) -> Option<f64> {
        let beside = self.columns.iter().enumerate().filter(|(at, _)| *at != place).map(|(_, column)| column);
        let beside: Vec<&Vec<f64>> = beside.chain(other).collect();
        let own = &self.columns[place];
        let many = beside.len();
        let cross = DVector::from_fn(many, |i, _| self.dot(beside[i], own));
        let gram = DMatrix::from_fn(many, many, |i, j| self.dot(beside[i], beside[j]));
        let whole = self.dot(own, own);
        let left = whole - cross.dot(&gram.cholesky()?.solve(&cross));
        Some(by * by * left.max(0.0))
    }

    fn dot(&self, one: &[f64], other: &[f64]) -> f64 {
        self.weight.iter().zip(one).zip(other).map(|((weight, one), other)| weight * one * other).sum()
    }
}
