//! What is left between two models along a motion, once the second has been fitted to the first.

use nalgebra::{DMatrix, DVector};
use plant::{Mechanics, Timeline};

use super::Rival;
use super::drive::Motion;
use super::noise::Noise;
use super::power::Block;
use crate::effects::Physics;
use crate::refit::model;

/// Gauss-Newton steps of a rival; differences are nearly linear in the few values.
const STEPS: usize = 3;

/// Positions of one model in every window.
struct Windows<'a> {
    motion: &'a Motion,
    timeline: Timeline,
    mechanics: Mechanics,
}

impl<'a> Windows<'a> {
    fn new(physics: &Physics, motion: &'a Motion) -> Option<Self> {
        let model = model(physics, 0);
        let timeline = Timeline::new(&model, &motion.t_s, &motion.commands, &motion.before).ok()?;
        Some(Self { motion, timeline, mechanics: Mechanics::new(&model).ok()? })
    }

    /// Positions in all windows, one after the other; `faster` is added to the speed at each start.
    fn positions(&self, faster: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
        let rows = self.motion.rows;
        let mut all = vec![0.0; rows * self.motion.starts.len()];
        for (index, (start, into)) in self.motion.starts.iter().zip(all.chunks_exact_mut(rows)).enumerate() {
            let t_s = &self.motion.t_s[start.row..start.row + rows];
            let more = faster(index);
            let mut state = start.state;
            state.velocity += more;
            self.mechanics.simulate(&self.timeline, t_s[0], state, t_s, into).ok()?;
        }
        Some(all)
    }
}

/// Sensitivity of each window to the speed it starts with, to first order.
struct StartSpeeds(Vec<f64>);

impl StartSpeeds {
    fn new(windows: &Windows<'_>, base: &[f64]) -> Option<Self> {
        let starts = &windows.motion.starts;
        let step = |index: usize| 1e-3 * starts[index].state.velocity.abs().max(1e-3);
        let mut all = windows.positions(step)?;
        let rows = windows.motion.rows;
        for (index, window) in all.chunks_exact_mut(rows).enumerate() {
            window.iter_mut().zip(&base[index * rows..]).for_each(|(f, b)| *f = (*f - b) / step(index));
        }
        Some(Self(all))
    }

    /// Takes out of each window what its best start would: a start is estimated, so it tells nothing.
    fn take_out(&self, values: &mut [f64], rows: usize, span_s: f64) {
        for (window, speed) in values.chunks_exact_mut(rows).zip(self.0.chunks_exact(rows)) {
            let count = rows as f64;
            let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
            let (level, slope) = (mean(window), mean(speed));
            let products: f64 = window.iter().zip(speed).map(|(w, s)| (w - level) * (s - slope)).sum();
            let squares: f64 = speed.iter().map(|s| (s - slope) * (s - slope)).sum();
            // Where the speed makes no difference, as the model sticks at once, it stays.
            let change = products / (squares + count * (1e-6 * span_s).powi(2));
            window.iter_mut().zip(speed).for_each(|(w, s)| *w -= level + change * (s - slope));
        }
    }
}

/// A rival against the model that made the motion.
pub(super) struct Contest<'a> {
    motion: &'a Motion,
    truth: Vec<f64>,
}

/// Residual of a rival with what is needed for its derivatives.
struct Point {
    values: Vec<Vec<f64>>,
    base: Vec<f64>,
    speeds: StartSpeeds,
    residual: Vec<f64>,
}

impl Point {
    fn cost(&self) -> f64 {
        self.residual.iter().map(|r| r * r).sum()
    }
}

impl<'a> Contest<'a> {
    /// Along the motion of `right`; none where it has no window or cannot be simulated.
    pub(super) fn new(right: &Rival, motion: &'a Motion) -> Option<Self> {
        if motion.starts.is_empty() || motion.rows < 8 {
            return None;
        }
        let truth = Windows::new(&right.in_a_new_recording(), motion)?.positions(|_| 0.0)?;
        Some(Self { motion, truth })
    }

    /// Against recorded positions in place of a model.
    #[cfg(test)]
    pub(super) fn recorded(position: &[f64], motion: &'a Motion) -> Self {
        let rows = |start: &super::drive::Start| position[start.row..start.row + motion.rows].to_vec();
        Self { motion, truth: motion.starts.iter().flat_map(rows).collect() }
    }

    fn span_s(&self) -> f64 {
        let first = self.motion.starts[0].row;
        self.motion.t_s[first + self.motion.rows - 1] - self.motion.t_s[first]
    }

    fn at(&self, rival: &Rival, values: Vec<Vec<f64>>) -> Option<Point> {
        let windows = Windows::new(&rival.with(&values), self.motion)?;
        let base = windows.positions(|_| 0.0)?;
        let speeds = StartSpeeds::new(&windows, &base)?;
        let mut residual: Vec<f64> = self.truth.iter().zip(&base).map(|(t, b)| t - b).collect();
        speeds.take_out(&mut residual, self.motion.rows, self.span_s());
        Some(Point { values, base, speeds, residual })
    }

    /// What is left of the rival with the values it comes with, rad (m), window after window.
    pub(super) fn unfitted(&self, rival: &Rival) -> Option<Vec<f64>> {
        self.at(rival, rival.values()).map(|point| point.residual)
    }

    /// Positions of the model that made the motion, window after window, rad (m).
    pub(super) fn positions(&self) -> &[f64] {
        &self.truth
    }

    /// What is left of the rival at its best values, rad (m), window after window.
    pub(super) fn left(&self, rival: &Rival) -> Option<Vec<f64>> {
        let mut best = self.at(rival, rival.values())?;
        let places = rival.places();
        for _ in 0..if places.is_empty() { 0 } else { STEPS } {
            let Some(step) = self.step(rival, &best) else { break };
            let before = best.cost();
            // Friction and limits are not smooth: half a step may still help where a whole one does not.
            let tried = [1.0, 0.3].into_iter().find_map(|part| {
                let point = self.at(rival, rival.moved(&best.values, &(&step * part)))?;
                (point.cost() < before).then_some(point)
            });
            let Some(point) = tried else { break };
            best = point;
            if best.cost() > 0.98 * before {
                break;
            }
        }
        Some(best.residual)
    }

    /// Gauss-Newton step from a point.
    fn step(&self, rival: &Rival, at: &Point) -> Option<DVector<f64>> {
        let places = rival.places();
        let mut columns = DMatrix::zeros(at.residual.len(), places.len());
        for (column, place) in places.iter().enumerate() {
            let now = at.values[place.effect][place.value];
            let size = 1e-2 * place.range.scale.max(0.1 * now.abs());
            let size = if now + size > place.range.high { -size } else { size };
            let mut values = at.values.clone();
            values[place.effect][place.value] = now + size;
            let moved = Windows::new(&rival.with(&values), self.motion)?.positions(|_| 0.0)?;
            let mut change: Vec<f64> = moved.iter().zip(&at.base).map(|(m, b)| (m - b) / size).collect();
            at.speeds.take_out(&mut change, self.motion.rows, self.span_s());
            columns.set_column(column, &DVector::from_vec(change));
        }
        Some(least_squares(&columns, &DVector::from_column_slice(&at.residual)))
    }

    /// What is left in each block, as the test sees it. Windows that were passed over are as those that were looked at.
    pub(super) fn blocks(&self, left: &[f64], noise: &Noise, stride: usize) -> Vec<Block> {
        let count = self.motion.starts.last().map_or(0, |start| start.block + 1);
        let mut blocks = vec![Block::default(); count];
        for (start, window) in self.motion.starts.iter().zip(left.chunks_exact(self.motion.rows)) {
            let block = &mut blocks[start.block];
            let weight = stride as f64;
            block.windows += weight;
            block.energy += weight * window.iter().map(|d| d * d).sum::<f64>();
            block.variance += weight * noise.variance_along(window);
        }
        blocks.retain(|block| block.windows > 0.0);
        blocks
    }
}

/// The least-squares solution by normal equations of unit diagonal; values that make no difference stay.
fn least_squares(columns: &DMatrix<f64>, wanted: &DVector<f64>) -> DVector<f64> {
    let sizes: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
    let size = |index: usize| if sizes[index] > 0.0 { sizes[index] } else { f64::INFINITY };
    let count = sizes.len();
    let products = columns.tr_mul(columns);
    let normal = DMatrix::from_fn(count, count, |r, c| {
        products[(r, c)] / (size(r) * size(c)) + if r == c { 1e-9 + f64::from(u8::from(sizes[r] == 0.0)) } else { 0.0 }
    });
    let right = columns.tr_mul(wanted);
    let right = DVector::from_fn(count, |index, _| right[index] / size(index));
    let solved = normal.cholesky().map_or_else(|| DVector::zeros(count), |factor| factor.solve(&right));
    DVector::from_fn(count, |index, _| solved[index] / size(index))
}
