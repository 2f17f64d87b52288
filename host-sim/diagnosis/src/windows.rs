//! The fit in the unit of the position: short simulations from estimated states against the recordings.

use std::ops::Range;

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::hypothesis::{Refitted, kept};
use crate::likelihood::Window;
use crate::problem::Problem;
use crate::recorded::Recorded;

/// Windows of each recording at two horizons.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowFit {
    /// One a recording and horizon.
    windows: Vec<[Vec<Window>; 2]>,
}

/// The horizons of the specification, s: within the shorter a delay shows most, within the longer a force.
pub const HORIZONS_S: [f64; 2] = [0.05, 0.2];
/// No horizon is shorter than this many rows.
const LEAST_ROWS: usize = 8;

/// Rows of a window of that horizon, by its place in [`HORIZONS_S`], of a recording.
fn window_rows(recorded: &Recorded, horizon: usize) -> usize {
    ((HORIZONS_S[horizon] / recorded.period_s()).round() as usize).max(LEAST_ROWS)
}

/// Length of the windows of that horizon, by its place in [`HORIZONS_S`], s: longer than that where the rows are far apart; of
/// recordings that differ, the longest.
pub fn window_s(problem: &Problem, horizon: usize) -> f64 {
    let of = |recorded: &Recorded| window_rows(recorded, horizon) as f64 * recorded.period_s();
    // Whole microseconds: the last digits of jittered times are no part of a length that is told.
    (1e6 * problem.recordings.iter().map(of).fold(0.0, f64::max)).round() / 1e6
}

impl WindowFit {
    /// Of every recording under a hypothesis.
    pub fn new(problem: &Problem, refitted: &Refitted) -> Option<Self> {
        let physics = refitted.hypothesis.physics(&problem.nominal);
        let path = kept(problem, &physics, &refitted.noise, problem.recordings.len())?;
        let of = |index: usize| {
            [0, 1].map(|horizon| path.windows(problem, index, window_rows(&problem.recordings[index], horizon)))
        };
        let windows = (0..problem.recordings.len()).into_par_iter().map(of).collect();
        Some(Self { windows })
    }

    /// Root mean square over recordings, rad (m); 0 without a window.
    pub fn rms(&self, recordings: Range<usize>, horizon: usize) -> f64 {
        self.mean_where(recordings, horizon, |_| true, |window| window.squares).sqrt()
    }

    /// What noise and estimated starts let expect of that, rad (m).
    pub fn expected_rms(&self, recordings: Range<usize>, horizon: usize) -> f64 {
        self.mean_where(recordings, horizon, |_| true, |window| window.expected).sqrt()
    }

    /// For each window of the longer horizon the logarithm by which another fit leaves more.
    pub(crate) fn log_ratios(&self, other: &Self) -> Vec<f64> {
        let pairs = self.windows.iter().zip(&other.windows).flat_map(|(own, other)| own[1].iter().zip(&other[1]));
        pairs.map(|(own, other)| (other.squares / own.squares).ln()).filter(|ratio| ratio.is_finite()).collect()
    }

    fn mean_where(
        &self,
        recordings: Range<usize>,
        horizon: usize,
        counts: impl Fn(&Window) -> bool,
        value: impl Fn(&Window) -> f64,
    ) -> f64 {
        let windows = self.windows[recordings].iter().flat_map(|of| &of[horizon]).filter(|window| counts(window));
        let (sum, rows) = windows.fold((0.0, 0), |(sum, rows), window| (sum + value(window), rows + window.rows));
        if rows == 0 { 0.0 } else { sum / rows as f64 }
    }

    /// Share of the error of the recordings that judge, under a fit that lacks an entry, that is the entry's; the larger of both horizons.
    /// Where the entry is right, the other's squares are expected to be those left plus those between the two predictions. How they fell has
    /// that mean, and scatters by what the noise of a few windows has in common with the difference of the predictions: by tens of per
    /// cent where two seconds are held out.
    pub fn accounted(&self, without: &Self, problem: &Problem) -> f64 {
        let of = |horizon| self.beside(without, problem.judged(), horizon).share_moved();
        of(0).max(of(1))
    }

    /// Probability that the windows of all recordings speak as much against an entry if it is right; 1 where they are nearer to the recordings
    /// with it. No value was fitted to them, so that what is left in them is expected to have nothing in common with the difference of
    /// the two predictions; where the entry is wrong it is that difference, turned round. At the horizon where it moves them most, a
    /// window's products with it taken for independent of another's.
    pub fn p_of_being_right(&self, without: &Self) -> f64 {
        let [short, long] = [0, 1].map(|horizon| self.beside(without, 0..self.windows.len(), horizon));
        let Beside { fell, product, products_squared, .. } =
            if long.share_moved() > short.share_moved() { long } else { short };
        if fell >= 0.0 || products_squared == 0.0 {
            return 1.0;
        }
        Normal::standard().cdf(product / products_squared.sqrt())
    }

    /// What tells the windows of these recordings at that horizon from those without an entry.
    fn beside(&self, without: &Self, recordings: Range<usize>, horizon: usize) -> Beside {
        let pairs =
            recordings.flat_map(|index| self.windows[index][horizon].iter().zip(&without.windows[index][horizon]));
        pairs.fold(Beside::default(), |mut sum, (own, other)| {
            let (fell, moved) = (other.squares - own.squares, own.squares_between(other));
            let product = fell - moved;
            sum.left += own.squares;
            sum.moved += moved;
            sum.fell += fell;
            sum.product += product;
            sum.products_squared += product * product;
            sum
        })
    }

    /// Largest relative fall of the root mean square against another fit, over both horizons, on the recordings that judge.
    pub fn fall_from(&self, other: &Self, problem: &Problem) -> f64 {
        self.fall_where(other, problem.judged(), |_| true)
    }

    /// The same around an event: in its recording, in windows that touch these rows.
    pub fn fall_at(&self, other: &Self, recording: usize, rows: &Range<usize>) -> f64 {
        let near = |window: &Window| window.start < rows.end && window.start + window.rows > rows.start;
        self.fall_where(other, recording..recording + 1, near)
    }

    fn fall_where(&self, other: &Self, recordings: Range<usize>, counts: impl Fn(&Window) -> bool) -> f64 {
        let fall = |horizon: usize| {
            let of = |fit: &Self| fit.mean_where(recordings.clone(), horizon, &counts, |window| window.squares).sqrt();
            let (before, after) = (of(other), of(self));
            if before > 0.0 { 1.0 - after / before } else { 0.0 }
        };
        fall(0).max(fall(1))
    }
}

/// Sums over windows with an entry and without it.
#[derive(Default)]
struct Beside {
    /// Squares that are left with the entry.
    left: f64,
    /// Squares between the two predictions.
    moved: f64,
    /// By how much the squares fell.
    fell: f64,
    /// What they fell beyond what was moved: twice the product of what is left and the difference of the predictions.
    product: f64,
    /// The same of each window, squared.
    products_squared: f64,
}

impl Beside {
    /// Share of the error without the entry that is expected to be the entry's where it is right.
    fn share_moved(&self) -> f64 {
        if self.moved > 0.0 { 1.0 - (self.left / (self.left + self.moved)).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Windows of ten rows that leave this.
    fn leaving(left: impl Fn(usize) -> f64, windows: usize) -> WindowFit {
        let window = |index: usize| {
            let mut window = Window::new(10 * index, 10);
            (0..10).for_each(|row| window.push(left(10 * index + row)));
            window
        };
        let all: Vec<Window> = (0..windows).map(window).collect();
        WindowFit { windows: vec![[all.clone(), all]] }
    }

    /// Independent of the motion below.
    fn noise(row: usize) -> f64 {
        (row as f64 * 2.399).sin()
    }

    /// What an entry adds.
    fn moved(row: usize) -> f64 {
        0.4 * (row as f64 * 0.71).cos()
    }

    #[test]
    fn windows_refute_what_moves_them_away_and_not_what_chance_does() {
        let (true_motion, with_more) = (leaving(noise, 60), leaving(|row| noise(row) + moved(row), 60));
        assert_eq!(true_motion.p_of_being_right(&with_more), 1.0);
        let p = with_more.p_of_being_right(&true_motion);
        assert!(p < 1e-6, "{p}");
        // In three windows with more noise than motion nothing is refuted.
        let loud = |row| 10.0 * noise(row);
        let p = leaving(|row| loud(row) + moved(row), 3).p_of_being_right(&leaving(loud, 3));
        assert!(p > 0.05, "{p}");
        // What moves nothing is not refuted.
        assert_eq!(true_motion.p_of_being_right(&true_motion), 1.0);
    }
}
