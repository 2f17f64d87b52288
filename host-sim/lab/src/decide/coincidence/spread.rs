//! A torque that is called late and is blurred.
//!
//! A delay claims that all of a command acts at one time. Where it acts over a span of times, with a mean m and a standard
//! deviation s, its Laplace transform is exp(-m p) (1 + (s p)^2 / 2 - ...): beside the best delay there is the second
//! derivative of the command, whatever blurs it.

use nalgebra::DVector;

use crate::effects::Physics;
use crate::screen::{MAX_P, MIN_T, Motion, Outcome, Problem, drive, f_test, fall_t};

/// The second derivative is taken over steps of this, s: the shortest bumps do not see finer.
const STEP_S: f64 = 1e-3;
/// A delay is none where the times spread by this share of it: a first-order lag spreads by all of it.
const OF_THE_DELAY: f64 = 0.5;

/// In words, that the delay of the best model is none.
pub(in crate::decide) fn spread(problem: &Problem, outcome: &Outcome) -> Option<String> {
    let fit = &outcome.fit;
    let delay = fit.active.iter().find(|entry| entry.effect.id == "torque_delay")?;
    let late_s = delay.values[0] - problem.nominal.torque_delay_s;
    let column = bends(problem, outcome);
    let blocks = Blocks::new(problem, &column, fit.residual.as_slice());
    let share = least(blocks.normal, blocks.pull);
    let spread_s = STEP_S * (2.0 * share).max(0.0).sqrt();
    let left = &fit.residual + share * DVector::from_vec(column);
    let p_value = f_test(problem, fit.sse, &left, (1, fit.freedom() + 1));
    let t = fall_t(&blocks.before(), &blocks.held());
    (late_s > 0.0 && spread_s > OF_THE_DELAY * late_s && p_value < MAX_P && t >= MIN_T).then(|| {
        format!(
            "torque_delay: what acts {late_s:.4} s later is spread over times by {spread_s:.4} s, so it is not late by one time"
        )
    })
}

/// How each weighted residual changes with the second derivative of the torque of the drive, in units of a step squared.
fn bends(problem: &Problem, outcome: &Outcome) -> Vec<f64> {
    let machine = problem.machine(&outcome.fit.active);
    let of = |motion: &Motion| {
        let at = |late_s: f64| {
            let moved = Physics { torque_delay_s: machine.torque_delay_s + late_s, ..machine.clone() };
            drive(&moved, motion)
        };
        let (early, now, late) = (at(-STEP_S), at(0.0), at(STEP_S));
        early.iter().zip(&now).zip(&late).map(|((early, now), late)| early - 2.0 * now + late).collect::<Vec<f64>>()
    };
    let cells: Vec<Vec<f64>> = problem.motions.iter().map(of).collect();
    let scale = -problem.nominal.inertia / machine.inertia;
    let each = problem.equations.iter().zip(&outcome.weights);
    each.map(|(equation, weight)| scale * weight * equation.row.mean(&cells[equation.recording])).collect()
}

/// How much of a column leaves least.
fn least(normal: f64, pull: f64) -> f64 {
    if normal > 0.0 { -pull / normal } else { 0.0 }
}

/// One column beside a residual: sums over each block of recordings to fit, and over all.
struct Blocks {
    /// Squares of the residual, of the column, and their product, by block.
    each: Vec<[f64; 3]>,
    normal: f64,
    pull: f64,
}

impl Blocks {
    fn new(problem: &Problem, column: &[f64], residual: &[f64]) -> Self {
        let mut each = vec![[0.0; 3]; problem.blocks];
        let rows = problem.equations.iter().zip(column.iter().zip(residual)).take(problem.fitted_equations());
        for (equation, (change, left)) in rows {
            let sums = &mut each[equation.block];
            for (sum, product) in sums.iter_mut().zip([left * left, change * change, change * left]) {
                *sum += product;
            }
        }
        let total = |part: usize| each.iter().map(|sums| sums[part]).sum();
        Self { normal: total(1), pull: total(2), each }
    }

    fn before(&self) -> Vec<f64> {
        self.each.iter().map(|sums| sums[0]).collect()
    }

    /// Squares of each block with a share of the column that is fitted to the others.
    fn held(&self) -> Vec<f64> {
        let predicted = |[squares, normal, pull]: &[f64; 3]| {
            let share = least(self.normal - normal, self.pull - pull);
            squares + 2.0 * share * pull + share * share * normal
        };
        self.each.iter().map(predicted).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::nominal;
    use super::*;
    use crate::decide::testing::recording;
    use crate::effects::find;
    use crate::screen::Search;

    fn words(machine: &Physics) -> Option<String> {
        let recorded = recording(machine, 0.05, 5.0, 3);
        let problem = Problem::new(vec![Motion::new(&recorded, &nominal(), 1.3e-5)], 1, nominal());
        let outcome = Search::new(&problem, &[find("torque_delay").unwrap()], false).run(&[]);
        assert_eq!(outcome.fit.active.len(), 1);
        spread(&problem, &outcome)
    }

    #[test]
    fn a_lag_that_is_called_a_delay_is_spread_and_a_delay_is_not() {
        let blurred = words(&Physics { torque_lag_s: 1.5e-3, ..nominal() }).unwrap();
        assert!(blurred.starts_with("torque_delay: "), "{blurred}");
        assert_eq!(words(&Physics { torque_delay_s: 6.2e-3, ..nominal() }), None);
    }
}
