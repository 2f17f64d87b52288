//! Bounded nonlinear least squares over the values of the active effects, and prediction of blocks left out.

use nalgebra::{DMatrix, DVector};

use super::problem::{Active, Parts, Problem};
use super::simplex::minimise;
use crate::effects::Range;

/// Points of a scan to either side.
const SCANNED: i32 = 20;

/// A hypothesis at its optimum.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Effects with the values found.
    pub active: Vec<Active>,
    /// Weighted residual of each equation.
    pub(crate) residual: DVector<f64>,
    /// Derivatives of the weighted residual by each free value; zero in the equations that do not fit that value.
    pub(crate) jacobian: DMatrix<f64>,
    /// Sum of squares of the weighted residual over the recordings to fit.
    pub sse: f64,
    /// Number of equations to fit.
    count: usize,
    /// Number of values that were free, without those of single recordings that are only predicted.
    freedom: usize,
    /// Sum of squares in each block, predicted by a fit without that block.
    pub(crate) heldout: Vec<f64>,
}

impl Fit {
    /// Sum of squares over all blocks, each predicted without itself.
    pub fn heldout_sse(&self) -> f64 {
        self.heldout.iter().sum()
    }

    /// Whether every number of it is one: a candidate that is not finite is no candidate.
    pub(crate) fn is_finite(&self) -> bool {
        let values = self.active.iter().flat_map(|entry| &entry.values);
        let numbers = values.chain(self.residual.iter()).chain(self.jacobian.iter()).chain(&self.heldout);
        self.sse.is_finite() && numbers.into_iter().all(|number| number.is_finite())
    }

    /// Whether a value of the last effect stands where the search ends.
    pub fn at_bound(&self) -> bool {
        self.active.last().is_some_and(Active::at_bound)
    }

    /// Number of equations to fit, which is the sum of squares that noise alone would leave.
    pub fn residual_count(&self) -> f64 {
        self.count as f64
    }

    /// Number of values that were free.
    pub fn freedom(&self) -> usize {
        self.freedom
    }
}

/// Balance and derivatives of a hypothesis.
#[derive(Debug)]
pub(crate) struct Base {
    parts: Parts,
    jacobian: DMatrix<f64>,
}

/// Which value of which effect a column belongs to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub effect: usize,
    pub value: usize,
    /// A small change, for derivatives.
    pub step: f64,
    pub low: f64,
    pub high: f64,
    /// Belongs to this recording alone.
    recording: Option<usize>,
}

/// The free values of a hypothesis, in the order of the columns.
pub(crate) fn places(active: &[Active]) -> Vec<Place> {
    let mut all = Vec::new();
    for (index, entry) in active.iter().enumerate() {
        for (value, &now) in entry.values.iter().enumerate() {
            if entry.effect.parameter(value).free {
                let Range { low, high, scale } = entry.ranges[value];
                let recording = entry.effect.recording_of(value);
                all.push(Place { effect: index, value, step: 1e-3 * now.abs().max(scale), low, high, recording });
            }
        }
    }
    all
}

/// One least-squares problem with the weights of its equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fitter<'a> {
    pub problem: &'a Problem,
    pub weights: &'a [f64],
}

impl Fitter<'_> {
    /// Weighted residual of a hypothesis.
    pub(crate) fn residual(&self, active: &[Active], known: Option<&Parts>) -> (DVector<f64>, Parts) {
        let parts = self.problem.parts(&self.problem.machine(active), known);
        let raw = self.problem.residual(&parts);
        (DVector::from_iterator(raw.len(), raw.iter().zip(self.weights).map(|(r, w)| r * w)), parts)
    }

    /// Derivative by one value, one-sided: the residual at the values themselves is known.
    fn column(&self, active: &[Active], place: Place, residual: &DVector<f64>, parts: &Parts) -> DVector<f64> {
        let mut moved = active.to_vec();
        let value = active[place.effect].values[place.value];
        let step = if value + place.step > place.high { -place.step } else { place.step };
        moved[place.effect].values[place.value] = value + step;
        (self.residual(&moved, Some(parts)).0 - residual) / step
    }

    /// Derivatives by all free values; the first columns are taken as they are where they are given.
    fn jacobian(
        &self,
        active: &[Active],
        residual: &DVector<f64>,
        parts: &Parts,
        given: Option<&DMatrix<f64>>,
    ) -> DMatrix<f64> {
        let places = places(active);
        let mut jacobian = DMatrix::zeros(residual.len(), places.len());
        let known = given.map_or(0, DMatrix::ncols);
        if let Some(given) = given {
            jacobian.columns_mut(0, known).copy_from(given);
        }
        for (index, &place) in places.iter().enumerate().skip(known) {
            let mut column = self.column(active, place, residual, parts);
            // What is only predicted teaches nothing but the phases that each recording has for itself.
            if place.recording.is_none_or(|recording| recording < self.problem.fitted) {
                column.rows_range_mut(self.count()..).fill(0.0);
            }
            jacobian.set_column(index, &column);
        }
        jacobian
    }

    /// Number of equations to fit.
    fn count(&self) -> usize {
        self.problem.fitted_equations()
    }

    /// Sum of squares over the equations to fit; infinite where a residual is no number, so that no search goes there.
    fn squares(&self, residual: &DVector<f64>) -> f64 {
        let squares = residual.rows_range(..self.count()).norm_squared();
        if squares.is_finite() { squares } else { f64::INFINITY }
    }

    /// What one bounded step from these values would reach: sum of squares, and the values.
    pub(crate) fn glimpse(&self, active: &[Active], base: &Base) -> (f64, Vec<Active>) {
        let (residual, parts) = self.residual(active, Some(&base.parts));
        let jacobian = self.jacobian(active, &residual, &parts, Some(&base.jacobian));
        let step = bounded_step(active, &jacobian.tr_mul(&jacobian), &jacobian.tr_mul(&residual), 1e-9);
        let reached = moved(active, &step);
        let (after, _) = self.residual(&reached, Some(&parts));
        let (before, after) = (self.squares(&residual), self.squares(&after));
        if after < before { (after, reached) } else { (before, active.to_vec()) }
    }

    /// The values of the last effect at a low sum of squares, found without derivatives; sizes move by their logarithms.
    pub(crate) fn feel(&self, active: &[Active], base: &Base, evaluations: usize) -> (f64, Vec<Active>) {
        let Some(last) = active.last() else { return (f64::INFINITY, Vec::new()) };
        let at = |logs: &DVector<f64>| {
            let mut moved = active.to_vec();
            if let Some(entry) = moved.last_mut() {
                for ((value, range), log) in entry.values.iter_mut().zip(&entry.ranges).zip(logs.iter()) {
                    *value = log.exp().clamp(range.low, range.high);
                }
            }
            moved
        };
        let start = DVector::from_iterator(last.values.len(), last.values.iter().map(|value| value.max(1e-12).ln()));
        let cost = |logs: &DVector<f64>| self.squares(&self.residual(&at(logs), Some(&base.parts)).0);
        let (sse, logs) = minimise(&start, evaluations, cost);
        (sse, at(&logs))
    }

    /// The best first value of the last effect on a geometric row over a decade either way, the others as they are: impacts
    /// lock a gap to where it began, and no slope leads out.
    pub(crate) fn scan(&self, active: &[Active], base: &Base) -> (f64, Vec<Active>) {
        let tried = (-SCANNED..=SCANNED).filter_map(|k| {
            let mut moved = active.to_vec();
            let entry = moved.last_mut()?;
            let factor = 10.0_f64.powf(f64::from(k) / f64::from(SCANNED));
            let value = entry.values.first_mut()?;
            *value = (*value * factor).clamp(entry.ranges[0].low, entry.ranges[0].high);
            Some((self.squares(&self.residual(&moved, Some(&base.parts)).0), moved))
        });
        tried.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, active.to_vec()))
    }

    /// What a hypothesis shares with those that add to it.
    pub(crate) fn base(&self, fit: &Fit) -> Base {
        Base { parts: self.residual(&fit.active, None).1, jacobian: fit.jacobian.clone() }
    }

    /// Levenberg-Marquardt within the bounds; never ends above where it started.
    pub(crate) fn fit(&self, start: &[Active], iterations: usize) -> Fit {
        self.descend(start, iterations, None)
    }

    /// The same for a hypothesis that adds to a base: the derivatives of the base are taken as they were there.
    pub(crate) fn fit_on(&self, start: &[Active], iterations: usize, base: &Base) -> Fit {
        self.descend(start, iterations, Some(base))
    }

    fn descend(&self, start: &[Active], iterations: usize, base: Option<&Base>) -> Fit {
        let given = base.map(|base| &base.jacobian);
        let mut active = start.to_vec();
        let (mut residual, mut parts) = self.residual(&active, base.map(|base| &base.parts));
        let mut jacobian = self.jacobian(&active, &residual, &parts, given);
        let mut damping = 1e-4;
        for _ in 0..iterations {
            if jacobian.ncols() == 0 {
                break;
            }
            let (normal, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&residual));
            let step = bounded_step(&active, &normal, &gradient, damping);
            let trial = moved(&active, &step);
            let (after, after_parts) = self.residual(&trial, Some(&parts));
            let (old, new) = (self.squares(&residual), self.squares(&after));
            if new < old {
                (active, residual, parts) = (trial, after, after_parts);
                jacobian = self.jacobian(&active, &residual, &parts, given);
                damping = (damping * 0.2).max(1e-9);
                if old - new < 1e-5 * old {
                    break;
                }
            } else {
                damping *= 20.0;
                if damping > 1e4 {
                    break;
                }
            }
        }
        let heldout = self.heldout(&active, &residual, &jacobian);
        let own = |place: &Place| place.recording.is_some_and(|recording| recording >= self.problem.fitted);
        let freedom = places(&active).iter().filter(|place| !own(place)).count();
        Fit { active, sse: self.squares(&residual), residual, jacobian, heldout, count: self.count(), freedom }
    }

    /// Squares of each block as a fit without it predicts them, by one Gauss-Newton step from the common optimum.
    fn heldout(&self, active: &[Active], residual: &DVector<f64>, jacobian: &DMatrix<f64>) -> Vec<f64> {
        let equations = &self.problem.equations;
        let mut squares = vec![0.0; self.problem.blocks];
        let columns = jacobian.ncols();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.problem.blocks];
        for (index, equation) in equations.iter().enumerate() {
            members[equation.block].push(index);
        }
        let normal = jacobian.tr_mul(jacobian);
        let gradient = jacobian.tr_mul(residual);
        let places = places(active);
        for (block, rows) in members.iter().enumerate().filter(|(_, rows)| !rows.is_empty()) {
            let part = DMatrix::from_fn(rows.len(), columns, |r, c| jacobian[(rows[r], c)]);
            let here = DVector::from_fn(rows.len(), |r, _| residual[rows[r]]);
            let (others, pull) = (&normal - part.tr_mul(&part), &gradient - part.tr_mul(&here));
            let mut step = solve_near(&others, &normal, &pull);
            for (value, place) in step.iter_mut().zip(&places) {
                // An event informs its own block only; nothing can predict it from the others.
                if active[place.effect].effect.is_event() {
                    *value = 0.0;
                }
                let now = active[place.effect].values[place.value];
                *value = (now + *value).clamp(place.low, place.high) - now;
            }
            squares[block] = (here + part * step).norm_squared();
        }
        squares
    }
}

/// The hypothesis after a step of its free values, within their bounds.
pub(crate) fn moved(active: &[Active], step: &DVector<f64>) -> Vec<Active> {
    let mut moved = active.to_vec();
    for (place, change) in places(active).iter().zip(step.iter()) {
        let value = &mut moved[place.effect].values[place.value];
        *value = (*value + change).clamp(place.low, place.high);
    }
    moved
}

/// The damped step that lowers the squares, with values at a bound held there where the step would leave it.
/// `gradient` is half that of the squares.
pub(crate) fn bounded_step(
    active: &[Active],
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> DVector<f64> {
    let places = places(active);
    let mut open: Vec<usize> = (0..places.len()).collect();
    let mut step = DVector::zeros(places.len());
    while !open.is_empty() {
        let part = DMatrix::from_fn(open.len(), open.len(), |r, c| normal[(open[r], open[c])]);
        // Held values keep the way to their bound, the open ones answer to it.
        let held: DVector<f64> = normal * step_of(&step, &open);
        let pull = DVector::from_fn(open.len(), |r, _| gradient[open[r]] + held[open[r]]);
        let solved = solve(&part, &pull, damping);
        let mut leaves = None;
        for (&index, &change) in open.iter().zip(solved.iter()) {
            let place = places[index];
            let now = active[place.effect].values[place.value];
            step[index] = change;
            if now + change < place.low || now + change > place.high {
                step[index] = (now + change).clamp(place.low, place.high) - now;
                leaves = Some(index);
            }
        }
        match leaves {
            Some(index) => open.retain(|&other| other != index),
            None => break,
        }
    }
    step
}

/// The step with open values at zero.
fn step_of(step: &DVector<f64>, open: &[usize]) -> DVector<f64> {
    let mut held = step.clone();
    open.iter().for_each(|&index| held[index] = 0.0);
    held
}

/// Solves part x = -gradient for a part of the equations, held near zero by a thousandth of what all of them know.
pub(crate) fn solve_near(part: &DMatrix<f64>, normal: &DMatrix<f64>, gradient: &DVector<f64>) -> DVector<f64> {
    let mut held = part.clone();
    for index in 0..gradient.len() {
        held[(index, index)] += 1e-3 * normal[(index, index)];
    }
    solve(&held, gradient, 0.0)
}

/// Solves normal x = -gradient, scaled to a unit diagonal, damped.
pub(crate) fn solve(normal: &DMatrix<f64>, gradient: &DVector<f64>, damping: f64) -> DVector<f64> {
    let scale = DVector::from_fn(gradient.len(), |i, _| {
        let diagonal = normal[(i, i)];
        if diagonal > 0.0 { 1.0 / diagonal.sqrt() } else { 0.0 }
    });
    let mut scaled = DMatrix::from_fn(gradient.len(), gradient.len(), |r, c| normal[(r, c)] * scale[r] * scale[c]);
    for index in 0..gradient.len() {
        scaled[(index, index)] = if scale[index] > 0.0 { 1.0 + damping + 1e-10 } else { 1.0 };
    }
    let pull = gradient.component_mul(&scale);
    let step = scaled.cholesky().map(|factor| -factor.solve(&pull).component_mul(&scale));
    // A step that is no number leads nowhere.
    step.filter(|step| step.iter().all(|change| change.is_finite())).unwrap_or_else(|| DVector::zeros(gradient.len()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::decide::testing::{machine, recording};
    use crate::effects::{Physics, find};
    use crate::screen::{Motion, Search};

    #[test]
    fn a_gap_is_felt_out_on_the_recordings_to_fit_only() {
        let nominal = Physics::of(&machine(), &[]).unwrap();
        let reached = |held_out: &Physics| {
            let recordings = [recording(&nominal, 0.05, 2.0, 1), recording(held_out, 0.05, 2.0, 2)];
            let motions = recordings.iter().map(|recording| Motion::new(recording, &nominal, 1.3e-5)).collect();
            let problem = Problem::new(motions, 1, nominal.clone());
            let gap = find("backlash").unwrap();
            let start = Search::new(&problem, &[gap], false).starts(&[], gap).swap_remove(20);
            let weights = vec![1.0; problem.equations.len()];
            let fitter = Fitter { problem: &problem, weights: &weights };
            let base = fitter.base(&fitter.fit(&[], 0));
            let tried = [fitter.feel(std::slice::from_ref(&start), &base, 10), fitter.scan(&[start], &base)];
            tried.map(|(sse, active)| (sse, active[0].values.clone()))
        };
        assert_eq!(reached(&nominal), reached(&Physics { inertia: 0.1, ..nominal.clone() }));
    }
}
