//! Values of the effects with the start states that suit them, and what they leave of the recordings.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::track::{Machine, Span, Tracks, knows_where};
use super::windows::HORIZON_S;
use crate::residual::Unknowns;
use crate::screen::{Active, Problem, moved, places};

/// Squares of a window beyond this many times its freedom count by their root: an event that the noise shifted is no
/// reason to move what all other windows agree on.
const FAR: f64 = 2.0;

/// A window with more than this times its freedom may have a better start;
const MUCH: f64 = 1.3;
/// it is looked for in so many passes.
const PASSES: usize = 8;

/// Robust sum of squares of a window, and the weight its rows have.
pub(super) fn robust(squares: f64, freedom: f64) -> (f64, f64) {
    if !squares.is_finite() {
        return (f64::INFINITY, 0.0);
    }
    let limit = FAR * freedom.max(1.0);
    if squares <= limit { (squares, 1.0) } else { (2.0 * (limit * squares).sqrt() - limit, (limit / squares).sqrt()) }
}

/// One window of a point.
#[derive(Debug, Clone)]
pub(super) struct Shot {
    /// Position, rad (m), and speed, rad/s (m/s), at the first row, and what the machine has inside.
    pub start: DVector<f64>,
    /// Measured minus simulated, rad (m).
    pub residual: Vec<f64>,
    /// Robust sum of squares of the white residual; what further start states take of the noise is added again, so that
    /// machines with and without them compare.
    pub loss: f64,
    /// Weight of its rows.
    pub weight: f64,
}

/// Everything at one set of values.
#[derive(Debug)]
pub(super) struct Point {
    pub active: Vec<Active>,
    pub machines: Vec<Machine>,
    pub shots: Vec<Shot>,
}

impl Point {
    /// Sum over all windows.
    pub(super) fn loss(&self) -> f64 {
        self.shots.iter().map(|shot| shot.loss).sum()
    }
}

/// Derivatives of the white residual of one window, as their products; columns are position, speed, and the free values.
#[derive(Debug, Clone)]
pub(super) struct Slopes {
    /// Of the start state by itself, inverted.
    own: DMatrix<f64>,
    /// Start state by values.
    cross: DMatrix<f64>,
    /// Start state by residual.
    pull: DVector<f64>,
    /// Values by values with the start state eliminated, weighed.
    pub normal: DMatrix<f64>,
    /// Values by residual, likewise.
    pub gradient: DVector<f64>,
}

impl Slopes {
    /// As if nothing were known of how start states follow that many values.
    pub(super) fn without_values(self, count: usize) -> Self {
        Self { cross: DMatrix::zeros(self.pull.len(), count), ..self }
    }

    /// The change of the start state that suits a change of the values best.
    fn start_step(&self, values: &DVector<f64>) -> DVector<f64> {
        -(&self.own * (&self.pull + &self.cross * values))
    }
}

/// Evaluates points.
#[derive(Debug)]
pub(super) struct Gauge<'a> {
    pub problem: &'a Problem,
    pub tracks: Tracks<'a>,
}

impl Gauge<'_> {
    fn shot(&self, span: &Span, machines: &[Machine], start: DVector<f64>) -> Result<Shot, plant::Error> {
        let mut residual = Vec::new();
        self.tracks.residual(span, machines, &start, &mut residual)?;
        Ok(judged(span, start, residual))
    }

    /// Values from the start states that the smoothed motion has, or from rest where that fits better.
    pub(super) fn first(&self, active: &[Active]) -> Result<Point, plant::Error> {
        let machines = self.tracks.machines(&self.problem.machine(active), None)?;
        let shots = self.tracks.spans.par_iter().map(|span| {
            let moving = self.shot(span, &machines, machines[span.track].start(span, span.guess))?;
            let resting = self.shot(span, &machines, machines[span.track].start(span, [span.guess[0], 0.0]))?;
            Ok(if resting.loss < moving.loss { resting } else { moving })
        });
        let shots = shots.collect::<Result<_, plant::Error>>()?;
        Ok(Point { active: active.to_vec(), machines, shots })
    }

    /// The same shots under the weights of now.
    pub(super) fn weighed(&self, point: Point) -> Point {
        let pairs = self.tracks.spans.par_iter().zip(point.shots);
        let shots = pairs.map(|(span, shot)| judged(span, shot.start, shot.residual)).collect();
        Point { shots, ..point }
    }

    /// Derivatives at a point, one-sided: what the values leave is known. `values` is false for start states alone.
    pub(super) fn slopes(&self, point: &Point, values: bool) -> Result<Vec<Slopes>, plant::Error> {
        let places = if values { places(&point.active) } else { Vec::new() };
        let mut steps = Vec::with_capacity(places.len());
        let mut neighbours = Vec::with_capacity(places.len());
        for place in &places {
            let value = point.active[place.effect].values[place.value];
            let step = if value + place.step > place.high { -place.step } else { place.step };
            let mut active = point.active.clone();
            active[place.effect].values[place.value] = value + step;
            neighbours.push(self.tracks.machines(&self.problem.machine(&active), Some(&point.machines))?);
            steps.push(step);
        }
        let located = knows_where(&self.problem.machine(&point.active));
        let pairs = self.tracks.spans.par_iter().zip(&point.shots);
        pairs
            .map(|(span, shot)| {
                let columns = self.columns(span, shot, &point.machines, (&neighbours, &steps), located)?;
                Ok(products(span, &point.machines[span.track].unknowns, shot, &columns))
            })
            .collect()
    }

    /// White derivatives of a window's residual by position, speed and values.
    fn columns(
        &self,
        span: &Span,
        shot: &Shot,
        machines: &[Machine],
        (neighbours, steps): (&[Vec<Machine>], &[f64]),
        located: bool,
    ) -> Result<Vec<Vec<f64>>, plant::Error> {
        let track = &self.tracks.tracks[span.track];
        let (t_s, measured) = (&track.t_s[span.start..span.end], &track.position[span.start..span.end]);
        let travel = measured.iter().fold(0.0_f64, |most, p| most.max((p - measured[0]).abs()));
        let span_s = t_s[t_s.len() - 1] - t_s[0];
        let difference = |machines: &[Machine], start: &DVector<f64>, step: f64| {
            let mut column = Vec::new();
            self.tracks.residual(span, machines, start, &mut column)?;
            column.iter_mut().zip(&shot.residual).for_each(|(value, base)| *value = (*value - base) / step);
            Ok::<_, plant::Error>(column)
        };
        let aside = machines[span.track].unknowns.steps(span_s, travel, shot.start[1]);
        let mut columns = Vec::with_capacity(aside.len() + steps.len());
        for (state, &step) in aside.iter().enumerate() {
            if state == 0 && !located {
                columns.push(vec![-1.0; t_s.len()]);
                continue;
            }
            let mut moved = shot.start.clone();
            moved[state] += step;
            columns.push(difference(machines, &moved, step)?);
        }
        for (neighbour, &step) in neighbours.iter().zip(steps) {
            columns.push(difference(neighbour, &shot.start, step)?);
        }
        columns.iter_mut().for_each(|column| span.whitener.apply(column));
        Ok(columns)
    }

    /// The point after a step of the values; start states follow, or stay where following is worse.
    pub(super) fn after(&self, point: &Point, slopes: &[Slopes], step: &DVector<f64>) -> Result<Point, plant::Error> {
        let active = moved(&point.active, step);
        let machines = self.tracks.machines(&self.problem.machine(&active), Some(&point.machines))?;
        let each = self.tracks.spans.par_iter().zip(&point.shots).zip(slopes);
        let shots = each.map(|((span, shot), slopes)| {
            let change = slopes.start_step(step);
            let follows = self.shot(span, &machines, &shot.start + &change)?;
            if follows.loss <= shot.loss {
                return Ok(follows);
            }
            let stays = self.shot(span, &machines, shot.start.clone())?;
            let half = self.shot(span, &machines, &shot.start + 0.5 * change)?;
            let best = if stays.loss < half.loss { stays } else { half };
            Ok(if best.loss < follows.loss { best } else { follows })
        });
        let shots = shots.collect::<Result<_, plant::Error>>()?;
        Ok(Point { active, machines, shots })
    }

    /// The same values with start states moved to their best, in at most `passes` passes; never worse.
    pub(super) fn settled(&self, mut point: Point, passes: usize) -> Result<Point, plant::Error> {
        for _ in 0..passes {
            if self.problem.budget.is_over() {
                break;
            }
            let slopes = self.slopes(&point, false)?;
            let each = self.tracks.spans.par_iter().zip(&point.shots).zip(&slopes);
            let shots = each.map(|((span, shot), slopes)| self.better_start(span, &point.machines, shot, slopes));
            let shots: Vec<Shot> = shots.collect::<Result<_, plant::Error>>()?;
            let before = point.loss();
            point.shots = shots;
            if before - point.loss() < 1e-3 * (1.0 + 1e-3 * before) {
                break;
            }
        }
        Ok(point)
    }

    /// The same values with start states tried anew where much is left: a window in which the model sticks has no slope to
    /// follow from one start to the other.
    pub(super) fn rescued(&self, mut point: Point) -> Result<Point, plant::Error> {
        if self.problem.budget.is_over() {
            return Ok(point);
        }
        let pairs = self.tracks.spans.par_iter().zip(point.shots);
        let shots = pairs.map(|(span, mut shot)| {
            if shot.loss < MUCH * span.freedom() {
                return Ok(shot);
            }
            for start in point.machines[span.track].starts(span, shot.start[0]) {
                let mut tried = self.shot(span, &point.machines, start)?;
                for _ in 0..PASSES {
                    let columns = self.columns(span, &tried, &point.machines, (&[], &[]), true)?;
                    let slopes = products(span, &point.machines[span.track].unknowns, &tried, &columns);
                    let next = self.better_start(span, &point.machines, &tried, &slopes)?;
                    let gain = tried.loss - next.loss;
                    tried = next;
                    if gain < 1e-2 {
                        break;
                    }
                }
                if tried.loss < shot.loss {
                    shot = tried;
                }
            }
            Ok(shot)
        });
        point.shots = shots.collect::<Result<_, plant::Error>>()?;
        Ok(point)
    }

    /// A full, half or eighth step of the start state, or none.
    fn better_start(
        &self,
        span: &Span,
        machines: &[Machine],
        shot: &Shot,
        slopes: &Slopes,
    ) -> Result<Shot, plant::Error> {
        let change = slopes.start_step(&DVector::zeros(slopes.cross.ncols()));
        for part in [1.0, 0.5, 0.125] {
            let tried = self.shot(span, machines, &shot.start + part * &change)?;
            if tried.loss < shot.loss {
                return Ok(tried);
            }
        }
        Ok(shot.clone())
    }
}

fn judged(span: &Span, start: DVector<f64>, residual: Vec<f64>) -> Shot {
    let mut white = residual.clone();
    span.whitener.apply(&mut white);
    let taken = start.len() as f64 - 2.0;
    let (loss, weight) = robust(white.iter().map(|r| r * r).sum::<f64>() + taken, span.freedom());
    Shot { start, residual, loss, weight }
}

/// Products of a window's columns with each other and with the residual, the start state eliminated.
fn products(span: &Span, unknowns: &Unknowns, shot: &Shot, columns: &[Vec<f64>]) -> Slopes {
    let mut white = shot.residual.clone();
    span.whitener.apply(&mut white);
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let states = shot.start.len();
    let count = columns.len() - states;
    let mut own = DMatrix::from_fn(states, states, |r, c| dot(&columns[r], &columns[c]));
    own += DMatrix::from_diagonal(&DVector::from_vec(unknowns.stays(HORIZON_S, own[(0, 0)].max(1e-300))));
    let own = own.try_inverse().unwrap_or_else(|| DMatrix::zeros(states, states));
    let cross = DMatrix::from_fn(states, count, |r, c| dot(&columns[r], &columns[states + c]));
    let pull = DVector::from_fn(states, |r, _| dot(&columns[r], &white));
    let normal = DMatrix::from_fn(count, count, |r, c| dot(&columns[states + r], &columns[states + c]));
    let gradient = DVector::from_fn(count, |r, _| dot(&columns[states + r], &white));
    let normal = (normal - cross.transpose() * &own * &cross) * shot.weight;
    let gradient = (gradient - cross.transpose() * (&own * &pull)) * shot.weight;
    Slopes { own, cross, pull, normal, gradient }
}
