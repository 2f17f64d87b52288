//! The state a window starts from, estimated from the window itself.

use nalgebra::{DMatrix, DVector};
use plant::{Error, Mechanics, State, Timeline};

use super::unknowns::Unknowns;

/// Trials of a descent. A window whose start is well known takes three; one that comes to rest soon after its start, where
/// the way changes with the square of the speed, up to ten.
const TRIALS: usize = 16;
/// A pass that gains less of the sum of squares than this is the last.
const SETTLED: f64 = 1e-4;
/// Two descents that end with sums of squares this near each other are believed.
const ALIKE: f64 = 1e-3;
/// Positions are mostly off by one distance where this share of their squares is that of their mean.
const MOSTLY: f64 = 0.5;
/// Rows on either side of the start from which the first guess of its speed is taken.
const NEIGHBOURS: usize = 6;

/// The recorded positions of one window and the model that is to follow them.
pub(super) struct StartState<'a> {
    pub mechanics: &'a Mechanics,
    pub timeline: &'a Timeline,
    /// s.
    pub t_s: &'a [f64],
    /// Recorded positions, rad (m).
    pub measured: &'a [f64],
    /// What is sought.
    pub unknowns: Unknowns,
}

impl StartState<'_> {
    /// The best state at the first row, and the positions the model has from it, rad (m).
    ///
    /// `speed_guess` comes from around the start. From there, from the mean motion and from rest: a model that sticks has no
    /// slope to follow from one to the other. Nor has a load in its gap from one side to the other: each is tried. Two ways
    /// that end alike are believed.
    pub(super) fn estimate(&self, speed_guess: f64) -> Result<(State, Vec<f64>), Error> {
        let (first, slope) = line(self.t_s, self.measured);
        let mean = self.measured.iter().sum::<f64>() / self.measured.len() as f64;
        let (near, rest, mean_motion) = ([self.measured[0], speed_guess], [mean, 0.0], [first, slope]);
        // What no sensor shows begins unstrained.
        let inside = State::default();
        let pack = |rotor| self.unknowns.pack(rotor, &inside);
        let mut guesses = [near, rest, mean_motion].map(pack).to_vec();
        guesses.extend(self.unknowns.touching(near, inside));
        let mut best: Option<Descent> = None;
        for guess in guesses {
            let descent = self.descend(guess)?;
            let least = best.as_ref().map_or(f64::INFINITY, |best| best.cost);
            let alike = (descent.cost - least).abs() < ALIKE * least;
            if descent.cost < least {
                best = Some(descent);
            }
            if alike {
                break;
            }
        }
        let best = best.map_or_else(|| self.at(pack(mean_motion)), Ok)?;
        let best = self.mended(best)?;
        Ok((self.unknowns.unpack(&best.at), best.simulated))
    }

    /// Levenberg-Marquardt over the unknowns.
    fn descend(&self, guess: DVector<f64>) -> Result<Descent, Error> {
        let span_s = self.t_s[self.t_s.len() - 1] - self.t_s[0];
        let travel = self.measured.iter().fold(0.0_f64, |most, p| most.max((p - self.measured[0]).abs()));
        let stays = DVector::from_vec(self.unknowns.stays(span_s, self.t_s.len() as f64));
        let products = |at: &Descent| self.products(at, &self.unknowns.steps(span_s, travel, at.at[1]));
        let mut best = self.at(guess)?;
        let (mut normal, mut right) = products(&best)?;
        let mut damping = 1e-9;
        for _ in 0..TRIALS {
            let damped = &normal + DMatrix::from_diagonal(&(normal.diagonal() * damping + &stays));
            let Some(inverse) = damped.try_inverse() else { break };
            let tried = self.at(&best.at + inverse * &right)?;
            if tried.cost < best.cost {
                let gain = 1.0 - tried.cost / best.cost;
                best = tried;
                damping *= 0.1;
                if gain < SETTLED {
                    break;
                }
                (normal, right) = products(&best)?;
            } else if damping < 1e3 {
                damping = (100.0 * damping).max(1e-3);
            } else {
                break;
            }
        }
        Ok(best)
    }

    /// A descent again where the best end is off by one distance, which no optimum is: a sensor that errs with the angle shows
    /// the rotor aside, and a slope of the speed next to nothing, while the rotor sticks, led each way far off.
    fn mended(&self, best: Descent) -> Result<Descent, Error> {
        let rows = self.measured.len() as f64;
        let aside = self.measured.iter().zip(&best.simulated).map(|(m, s)| m - s).sum::<f64>() / rows;
        if rows * aside * aside < MOSTLY * best.cost {
            return Ok(best);
        }
        let mut guess = best.at.clone();
        guess[0] += aside;
        let again = self.descend(guess)?;
        Ok(if again.cost < best.cost { again } else { best })
    }

    /// Derivatives by derivatives, and derivatives by what is left; those by the position are taken as 1.
    fn products(&self, at: &Descent, steps: &[f64]) -> Result<(DMatrix<f64>, DVector<f64>), Error> {
        let mut columns = vec![vec![1.0; self.t_s.len()]];
        for (place, step) in steps.iter().enumerate().skip(1) {
            let mut aside = at.at.clone();
            aside[place] += step;
            let moved = self.at(aside)?.simulated;
            columns.push(moved.iter().zip(&at.simulated).map(|(m, s)| (m - s) / step).collect());
        }
        let left: Vec<f64> = self.measured.iter().zip(&at.simulated).map(|(m, s)| m - s).collect();
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let normal = DMatrix::from_fn(steps.len(), steps.len(), |r, c| dot(&columns[r], &columns[c]));
        Ok((normal, DVector::from_fn(steps.len(), |r, _| dot(&columns[r], &left))))
    }

    fn at(&self, at: DVector<f64>) -> Result<Descent, Error> {
        let mut simulated = vec![0.0; self.t_s.len()];
        let start = self.unknowns.unpack(&at);
        self.mechanics.simulate(self.timeline, self.t_s[0], start, self.t_s, &mut simulated)?;
        let cost = self.measured.iter().zip(&simulated).map(|(m, s)| (m - s) * (m - s)).sum();
        Ok(Descent { at, cost, simulated })
    }
}

/// One point of a descent.
struct Descent {
    at: DVector<f64>,
    /// Sum of squares.
    cost: f64,
    simulated: Vec<f64>,
}

/// Speed at `row`, rad/s (m/s): the slope there of the least-squares parabola through the rows around it, within `from..to`.
pub(super) fn speed_at(t_s: &[f64], position: &[f64], row: usize, from: usize, to: usize) -> f64 {
    let rows = row.saturating_sub(NEIGHBOURS).max(from)..(row + NEIGHBOURS + 1).min(to);
    let (t_s, position, at_s) = (&t_s[rows.clone()], &position[rows], t_s[row]);
    let bend = curvature(t_s, position);
    // What the parabola's bend leaves is a line, whose slope is that of the parabola at `at_s`.
    let straight: Vec<f64> = t_s.iter().zip(position).map(|(t, p)| p - 0.5 * bend * (t - at_s) * (t - at_s)).collect();
    line(t_s, &straight).1
}

/// Value at the first time and slope of the least-squares line.
pub(super) fn line(t_s: &[f64], values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let (mean_t, mean) = (t_s.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
    let (mut products, mut squares) = (0.0, 0.0);
    for (t, value) in t_s.iter().zip(values) {
        products += (t - mean_t) * (value - mean);
        squares += (t - mean_t) * (t - mean_t);
    }
    let slope = if squares > 0.0 { products / squares } else { 0.0 };
    (mean + slope * (t_s[0] - mean_t), slope)
}

/// Second derivative of the least-squares parabola: the projection on the part of t^2/2 that a line cannot follow.
pub(super) fn curvature(t_s: &[f64], values: &[f64]) -> f64 {
    let half_squares: Vec<f64> = t_s.iter().map(|t| 0.5 * (t - t_s[0]) * (t - t_s[0])).collect();
    let (first, slope) = line(t_s, &half_squares);
    let (mut products, mut squares) = (0.0, 0.0);
    for ((t, value), half) in t_s.iter().zip(values).zip(&half_squares) {
        let bend = half - first - slope * (t - t_s[0]);
        products += bend * value;
        squares += bend * bend;
    }
    if squares > 0.0 { products / squares } else { 0.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use plant::{Command, Model};

    use super::*;

    #[test]
    fn lines_parabolas_and_speeds_are_exact_on_themselves() {
        let t_s: Vec<f64> = [0.0, 0.1, 0.15, 0.3, 0.32, 0.5].map(|t| t + 7.0).to_vec();
        let parabola: Vec<f64> = t_s.iter().map(|t| 2.0 - 3.0 * (t - 7.0) + 4.0 * (t - 7.0).powi(2)).collect();
        assert!((curvature(&t_s, &parabola) - 8.0).abs() < 1e-9);
        assert!((speed_at(&t_s, &parabola, 3, 0, 6) - (-3.0 + 8.0 * 0.3)).abs() < 1e-9);
        let straight: Vec<f64> = t_s.iter().map(|t| 2.0 - 3.0 * (t - 7.0)).collect();
        let (first, slope) = line(&t_s, &straight);
        assert!((first - 2.0).abs() < 1e-12 && (slope + 3.0).abs() < 1e-12);
        assert_eq!(line(&[1.0], &[5.0]), (5.0, 0.0));
    }

    /// A rotor with dry friction that slides, sticks, is pushed off again, and every mixture of them.
    #[test]
    fn the_start_is_found_through_stick_and_slip() {
        let model = Model { coulomb: 0.5, ..Model::new(0.075) };
        let t_s: Vec<f64> = (0..100).map(|row| f64::from(row) * 5e-4).collect();
        let mechanics = Mechanics::new(&model).unwrap();
        for (torque, speed) in
            [(0.0, 0.03), (0.0, 0.3), (0.0, -2.0), (0.4, 0.1), (1.5, 0.0), (1.5, -0.2), (-0.7, 0.05), (0.0, 0.0)]
        {
            // Pushed for the second half of the window only.
            let command = |t: f64| Command::new(if t < 0.025 { 0.0 } else { torque }, 0.0);
            let commands: Vec<Command> = t_s.iter().map(|t| command(*t)).collect();
            let timeline = Timeline::new(&model, &t_s, &commands, &Command::default()).unwrap();
            let mut measured = vec![0.0; t_s.len()];
            mechanics.simulate(&timeline, 0.0, State::new(1.0, speed), &t_s, &mut measured).unwrap();
            let window = StartState {
                mechanics: &mechanics,
                timeline: &timeline,
                t_s: &t_s,
                measured: &measured,
                unknowns: Unknowns::of(&model),
            };
            let (state, simulated) = window.estimate(speed_at(&t_s, &measured, 0, 0, 100)).unwrap();
            let worst = measured.iter().zip(&simulated).map(|(m, s)| (m - s).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-8, "torque {torque}, speed {speed}: {worst:e} rad from {state:?}");
        }
    }
}
