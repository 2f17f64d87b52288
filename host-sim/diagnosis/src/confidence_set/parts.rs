//! Effects that say the same as one value of an entry: an offset and half the difference of an asymmetry, wherever the axis moves.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::information::Assessed;
use super::intervals::TWO_SIDED_95;
use crate::effects::{Columns, Effect};
use crate::hypothesis::{Kept, columns, kept, product};
use crate::problem::Problem;

/// For each entry of the best hypothesis the effects of one value, of a vocabulary, that these recordings do not tell from one of its several
/// values: with it in that value's place, and all others refitted, the linearised likelihood falls by less than a 95 % interval
/// allows, and without it by more.
pub(crate) fn alike_in_part(
    problem: &Problem,
    best: &Assessed,
    vocabulary: &[&'static Effect],
) -> Vec<Vec<&'static Effect>> {
    let entries = &best.refitted.hypothesis.entries;
    let has_parts = |entry: usize| {
        let effect = entries[entry].effect;
        effect.columns == Columns::Each && effect.parameters.len() > 1
    };
    let parts = (0..entries.len()).any(has_parts).then(|| Parts::of(problem, best, vocabulary)).flatten();
    let of = |entry: usize| match &parts {
        Some(parts) if has_parts(entry) => parts.said_by_others(best, entry),
        _ => Vec::new(),
    };
    (0..entries.len()).map(of).collect()
}

/// The free values of a hypothesis, and effects of one value beside it.
struct Parts {
    /// Products of the columns of all of them, the free values first.
    products: DMatrix<f64>,
    /// Number of free values.
    own: usize,
    others: Vec<&'static Effect>,
}

impl Parts {
    fn of(problem: &Problem, best: &Assessed, vocabulary: &[&'static Effect]) -> Option<Self> {
        let hypothesis = &best.refitted.hypothesis;
        let path = kept(problem, &hypothesis.physics(&problem.nominal), &best.refitted.noise, problem.fitted)?;
        let mut all: Vec<Vec<f64>> = columns(problem, hypothesis, &path)
            .into_iter()
            .map(|column| Some(column?.concat()))
            .collect::<Option<_>>()?;
        let own = all.len();
        let beside = |effect: &&'static Effect| Some((column_of(problem, best, &path, effect)?, *effect));
        let (of_others, others): (Vec<Vec<f64>>, Vec<&'static Effect>) =
            vocabulary.par_iter().filter_map(beside).unzip();
        all.extend(of_others);
        let (_, weight) = path.weighted();
        let of = |i: usize, j: usize| if i < j { 0.0 } else { product(&weight, &all[i], &all[j]) };
        let mut products = DMatrix::from_fn(all.len(), all.len(), of);
        products.fill_upper_triangle_with_lower_triangle();
        Some(Self { products, own, others })
    }

    /// The others that may stand in the place of a value of an entry.
    fn said_by_others(&self, best: &Assessed, entry: usize) -> Vec<&'static Effect> {
        let hypothesis = &best.refitted.hypothesis;
        let limit = TWO_SIDED_95 * TWO_SIDED_95 * best.inflation(entry);
        let places = hypothesis.free().into_iter().enumerate().filter(|(_, (of, _))| *of == entry);
        // Each of several values is nothing where it is zero.
        let values = places.map(|(place, (of, index))| (place, hypothesis.entries[of].values[index]));
        let falls = |(place, value): (usize, f64), other| self.fall(place, value, other).map(|fall| fall > limit);
        let missed: Vec<(usize, f64)> = values.filter(|&value| falls(value, None) == Some(true)).collect();
        let says_one = |index: usize| missed.iter().any(|&value| falls(value, Some(self.own + index)) == Some(false));
        (0..self.others.len()).filter(|&index| says_one(index)).map(|index| self.others[index]).collect()
    }

    /// Twice what the linearised log-likelihood falls by where the value at a place is zero, the others are refitted, and another column, if
    /// any, with them; none where that column is made of theirs.
    fn fall(&self, place: usize, value: f64, other: Option<usize>) -> Option<f64> {
        let beside: Vec<usize> = (0..self.own).filter(|&at| at != place).chain(other).collect();
        let cross = DVector::from_fn(beside.len(), |i, _| self.products[(beside[i], place)]);
        let among = DMatrix::from_fn(beside.len(), beside.len(), |i, j| self.products[(beside[i], beside[j])]);
        let left = self.products[(place, place)] - cross.dot(&among.cholesky()?.solve(&cross));
        Some(value * value * left.max(0.0))
    }
}

/// The column of an effect of one value beside a hypothesis; none where it has several, is in it, or is nothing there.
fn column_of(problem: &Problem, best: &Assessed, path: &Kept, effect: &'static Effect) -> Option<Vec<f64>> {
    let hypothesis = &best.refitted.hypothesis;
    let is_one = effect.columns == Columns::Each && effect.parameters.len() == 1;
    let is_in = hypothesis.entries.iter().any(|entry| entry.effect == effect);
    if !is_one || is_in || !problem.may_have(effect) {
        return None;
    }
    let value = *(effect.starts)(&problem.nominal, &problem.excitation).first()?.first()?;
    let by = effect.ranges(1, &problem.nominal, &problem.excitation)[0].scale;
    let column = path.response(problem, &hypothesis.with(effect, vec![value + by]).physics(&problem.nominal))?.concat();
    column.iter().any(|value| *value != 0.0).then_some(column)
}
