//! One pass over a recording: innovations, their variances, and what a linearised pass needs.

// Matrices are read by their indices, as the equations have them.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::acting::Acting;
use super::belief::{BASE, Laws, Linear, POSITION, ROUNDING, SPEED, Substep};
use super::grid::Grid;
use super::noise::{Noise, Rounding};
use crate::physics::Physics;
use crate::recorded::{ACTS_S, Recorded};

/// Innovations beyond this many of their standard deviations pull no harder than one there (Huber): wrong samples. The
/// specification's figure; 6e-5 of normal innovations lie beyond.
pub(crate) const HUBER: f64 = 4.0;

/// Largest number of states: the three of every recording, shaft, bristle, spring, heat of friction and of the fluid, and last the
/// torque noise with a memory.
pub(super) const MOST_STATES: usize = BASE + 7;

/// Minus twice the log-likelihood of a whitened innovation, but for its variance: squares, straight beyond the Huber limit.
#[inline]
pub(crate) fn loss(whitened: f64) -> f64 {
    let size = whitened.abs();
    if size <= HUBER { size * size } else { HUBER * (2.0 * size - HUBER) }
}

/// What one recording leaves under one model.
#[derive(Debug, Clone, PartialEq)]
pub struct Innovations {
    /// Innovation over its standard deviation, one a row; 0 where none is taken.
    pub whitened: Vec<f64>,
    /// Recorded minus predicted position, rad (m).
    pub innovation: Vec<f64>,
    /// Log-likelihood of the sample, but for a constant; 0 where none is taken.
    pub log_likelihood: Vec<f64>,
    /// Estimated position, before the row's own sample, rad (m).
    pub position: Vec<f64>,
    /// Estimated speed behind the row's sample, rad/s (m/s).
    pub speed: Vec<f64>,
    /// Torque that was missing before this row, as its sample sees it, N m (N).
    pub left_torque: Vec<f64>,
    /// Whether the row counts.
    pub counted: Vec<bool>,
}

/// The path of a pass, for linearised passes along it.
pub(crate) enum Path {
    Three(Stored<3>),
    Four(Stored<4>),
    Five(Stored<5>),
    Six(Stored<6>),
    Most(Stored<MOST_STATES>),
}

/// A path with its number of states.
pub(crate) struct Stored<const N: usize> {
    /// Whether the last state is the torque noise's.
    pub(super) coloured: bool,
    pub(super) steps: Vec<StoredStep<N>>,
    pub(super) rows: Vec<StoredRow<N>>,
}

pub(super) struct StoredStep<const N: usize> {
    pub(super) from: [f64; N],
    pub(super) to: [f64; N],
    pub(super) linear: Linear<N>,
}

pub(super) struct StoredRow<const N: usize> {
    pub(super) position: f64,
    pub(super) slope: f64,
    pub(super) per_sd: f64,
    /// Kalman gain; zeros where the sample did not pull in proportion.
    pub(super) gain: [f64; N],
    pub(super) counted: bool,
    /// Of the state behind the sample.
    pub(super) covariance: [[f64; N]; N],
}

/// One recording with what acts in it.
#[derive(Clone)]
pub(crate) struct Driven<'a> {
    pub(crate) recorded: &'a Recorded,
    pub(crate) grid: &'a Grid,
    pub(crate) acting: &'a Acting,
    /// Rows to run over.
    pub(crate) rows: Range<usize>,
}

/// A model prepared for passes.
#[derive(Debug, Clone)]
pub(crate) struct Prepared {
    pub(super) laws: Laws,
    pub(super) eccentricity: Vec<plant::effects::Harmonic>,
    glitch: Option<(f64, f64)>,
    pub(super) rounding: Rounding,
    pub(super) torque_gain: f64,
    pub(super) torque_filter_s: f64,
}

impl Prepared {
    /// For one recording of a machine whose sensor has steps of that size, rad (m); 0 for a continuous one.
    pub(crate) fn new(physics: &Physics, recording: usize, step: f64) -> Self {
        let model = physics.model_of(recording);
        Self {
            laws: Laws::new(&model),
            eccentricity: model.sensor.eccentricity,
            glitch: physics.glitch,
            rounding: Rounding::new(step),
            torque_gain: model.torque_gain,
            torque_filter_s: physics.torque_filter_s,
        }
    }

    /// Number of states beside that noise.
    fn states(&self, noise: &Noise) -> usize {
        self.laws.states + usize::from(noise.colour.is_some())
    }

    /// What a substep costs of one of three states: covariances are squares.
    pub(crate) fn cost(&self, noise: &Noise) -> usize {
        (self.states(noise).pow(2) / 9).max(1)
    }

    /// Log-likelihood of a whitened innovation, and how much it pulls: of a wrong sample, nothing. Without wrong samples in
    /// the hypothesis the loss is Huber's.
    fn judged(&self, whitened: f64, per_sd: f64) -> (f64, f64) {
        let Some((share, size)) = self.glitch else {
            return (per_sd.ln() - 0.5 * loss(whitened), (HUBER / whitened.abs()).min(1.0));
        };
        let right = (1.0 - share) * (-0.5 * loss(whitened)).exp();
        let off = size * per_sd;
        let by = |off: f64| (-0.5 * loss(whitened - off)).exp();
        let wrong = 0.5 * share * (by(off) + by(-off));
        let all = (right + wrong).max(f64::MIN_POSITIVE);
        (per_sd.ln() + all.ln(), right / all)
    }

    /// Measured position and its slope over the true one.
    pub(super) fn seen(&self, position: f64) -> (f64, f64) {
        let (mut seen, mut slope) = (position, 1.0);
        for harmonic in &self.eccentricity {
            seen += harmonic.at(position);
            slope += harmonic.amplitude * harmonic.order * (harmonic.order * position + harmonic.phase_rad).cos();
        }
        (seen, slope)
    }

    /// Runs over a recording.
    pub(crate) fn run(&self, driven: Driven<'_>, noise: &Noise) -> Innovations {
        match self.states(noise) {
            3 => self.pass::<3>(driven, noise, None),
            4 => self.pass::<4>(driven, noise, None),
            5 => self.pass::<5>(driven, noise, None),
            6 => self.pass::<6>(driven, noise, None),
            _ => self.pass::<MOST_STATES>(driven, noise, None),
        }
    }

    /// Runs over a recording and keeps the path.
    pub(crate) fn run_kept(&self, driven: Driven<'_>, noise: &Noise) -> (Innovations, Path) {
        fn kept<const N: usize>(prepared: &Prepared, driven: Driven<'_>, noise: &Noise) -> (Innovations, Stored<N>) {
            let (steps, rows) = (driven.grid.substeps(), driven.recorded.rows());
            let coloured = noise.colour.is_some();
            let mut stored = Stored { coloured, steps: Vec::with_capacity(steps), rows: Vec::with_capacity(rows) };
            (prepared.pass(driven, noise, Some(&mut stored)), stored)
        }
        macro_rules! path {
            ($many:expr, $name:ident) => {{
                let (innovations, stored) = kept::<$many>(self, driven, noise);
                (innovations, Path::$name(stored))
            }};
        }
        match self.states(noise) {
            3 => path!(3, Three),
            4 => path!(4, Four),
            5 => path!(5, Five),
            6 => path!(6, Six),
            _ => path!(MOST_STATES, Most),
        }
    }

    // Over 40 lines: the two halves of a Kalman filter's step, correction and prediction, belong side by side.
    fn pass<const N: usize>(&self, driven: Driven<'_>, noise: &Noise, mut keep: Option<&mut Stored<N>>) -> Innovations {
        let Driven { recorded, grid, acting, rows: range } = driven;
        let rows = range.len();
        let mut found = Innovations {
            whitened: Vec::with_capacity(rows),
            innovation: Vec::with_capacity(rows),
            log_likelihood: Vec::with_capacity(rows),
            position: Vec::with_capacity(rows),
            speed: Vec::with_capacity(rows),
            left_torque: Vec::with_capacity(rows),
            counted: Vec::with_capacity(rows),
        };
        let start = Start::of(recorded, grid.torque_rms, &range);
        let (mut x, mut p) = self.begin::<N>(&start, range.start == 0, noise);
        let mut lost = Lost::default();
        let settled_s = recorded.t_s[range.start] + start.settling_s;
        for row in range.clone() {
            if recorded.after_gap[row] {
                // What was commanded meanwhile is not known: any speed that the torques of the recording allow.
                let lost_s = recorded.t_s[row] - recorded.t_s[row.saturating_sub(1)];
                let speed = start.torque_rms * self.laws.per_inertia() * lost_s;
                p[SPEED][SPEED] += speed * speed;
                p[POSITION][POSITION] += (0.5 * speed * lost_s).powi(2);
            }
            if row > range.start && recorded.skipped[row - 1] && !recorded.skipped[row] {
                // What acted until here is not known either, and had its samples all the same.
                let speed = start.torque_rms * self.laws.per_inertia() * ACTS_S;
                p[SPEED][SPEED] += speed * speed;
            }
            let (seen, slope) = self.seen(x[POSITION]);
            let innovation = recorded.position[row] - seen - x[ROUNDING];
            let mut variance = seen_variance(&p, slope, noise);
            if lost.after(innovation, variance) {
                let since_s = recorded.t_s[row] - recorded.t_s[row - LOST_ROWS.min(row)];
                p[POSITION][POSITION] += innovation * innovation;
                p[SPEED][SPEED] += (innovation / since_s.max(f64::MIN_POSITIVE)).powi(2);
                variance = seen_variance(&p, slope, noise);
            }
            let per_sd = variance.sqrt().recip();
            let whitened = innovation * per_sd;
            let counted = recorded.t_s[row] >= settled_s && !recorded.skipped[row] && !recorded.after_gap[row];
            found.whitened.push(whitened);
            found.innovation.push(innovation);
            found.position.push(x[POSITION]);
            found.counted.push(counted);
            let (log_likelihood, pull) = self.judged(whitened, per_sd);
            found.log_likelihood.push(if counted { log_likelihood } else { 0.0 });
            let mut line = [0.0; N];
            for (i, line) in line.iter_mut().enumerate() {
                *line = p[i][POSITION] * slope + p[i][ROUNDING];
            }
            let gain = line.map(|covariance| covariance * per_sd * per_sd);
            for i in 0..N {
                x[i] += gain[i] * innovation * pull;
                for j in 0..N {
                    p[i][j] -= gain[i] * line[j];
                }
            }
            found.speed.push(x[SPEED]);
            let since_s = recorded.t_s[row] - recorded.t_s[row.saturating_sub(1)];
            let change = gain[SPEED] * innovation * pull * self.laws.inertia;
            let coloured = noise.colour.map_or(0.0, |_| x[N - 1]);
            found.left_torque.push(if since_s > 0.0 { change / since_s + coloured } else { 0.0 });
            if let Some(stored) = keep.as_deref_mut() {
                let gain = if pull < 0.5 { [0.0; N] } else { gain };
                stored.rows.push(StoredRow {
                    position: found.position[row - range.start],
                    slope,
                    per_sd,
                    gain,
                    counted,
                    covariance: p,
                });
            }
            if row + 1 == range.end {
                break;
            }
            for index in grid.first[row] as usize..grid.first[row + 1] as usize {
                let step = Substep::of(acting, index, grid.dt_s[row]);
                let from = x;
                let linear = self.laws.predict(&mut x, &mut p, &step, noise, &self.rounding);
                if let Some(stored) = keep.as_deref_mut() {
                    stored.steps.push(StoredStep { from, to: x, linear });
                }
            }
        }
        found
    }

    fn begin<const N: usize>(&self, start: &Start, cold: bool, noise: &Noise) -> ([f64; N], [[f64; N]; N]) {
        let (mut x, mut p) = ([0.0; N], [[0.0; N]; N]);
        (x[POSITION], x[SPEED]) = (start.position, start.speed);
        let position_sd = start.position_sd.max((noise.sensor_sd * noise.sensor_sd + self.rounding.variance).sqrt());
        let spread = self.laws.spread(position_sd, start.speed_sd, start.torque_rms, cold);
        for (i, sd) in spread.iter().enumerate() {
            p[i][i] = sd * sd;
        }
        p[ROUNDING][ROUNDING] = self.rounding.variance;
        if let Some(colour) = noise.colour {
            p[N - 1][N - 1] = colour.sd * colour.sd;
        }
        (x, p)
    }
}

/// Variance of a sample before it is taken.
fn seen_variance<const N: usize>(p: &[[f64; N]; N], slope: f64, noise: &Noise) -> f64 {
    let of_position = slope * (slope * p[POSITION][POSITION] + 2.0 * p[POSITION][ROUNDING]);
    of_position + p[ROUNDING][ROUNDING] + noise.sensor_sd * noise.sensor_sd
}

/// Rows in a row beyond the Huber limit on one side after which the belief, and not the samples, is wrong: among normal
/// innovations three have a probability below 1e-13.
const LOST_ROWS: usize = 3;

/// Counts innovations that the belief held impossible.
#[derive(Debug, Default)]
struct Lost {
    rows: usize,
    sign: f64,
}

impl Lost {
    /// Whether the belief has lost the rotor, with this innovation the last of several; it counts anew then.
    fn after(&mut self, innovation: f64, variance: f64) -> bool {
        if innovation * innovation <= HUBER * HUBER * variance {
            self.rows = 0;
            return false;
        }
        self.rows = if innovation.signum() == self.sign { self.rows + 1 } else { 1 };
        self.sign = innovation.signum();
        let lost = self.rows >= LOST_ROWS;
        if lost {
            self.rows = 0;
        }
        lost
    }
}

/// Where a recording begins.
struct Start {
    position: f64,
    position_sd: f64,
    speed: f64,
    speed_sd: f64,
    torque_rms: f64,
    settling_s: f64,
}

/// Rows from which position and speed at the start are read.
const FIRST_ROWS: usize = 6;

impl Start {
    fn of(recorded: &Recorded, torque_rms: f64, range: &Range<usize>) -> Self {
        let first = range.start;
        let rows = range.len().min(FIRST_ROWS);
        let last = first + rows.saturating_sub(1);
        let length_s = (recorded.t_s[last] - recorded.t_s[first]).max(f64::MIN_POSITIVE);
        let travel = recorded.position[last] - recorded.position[first];
        let speed = if rows > 1 { travel / length_s } else { 0.0 };
        let rough =
            recorded.position[first..first + rows].windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        Self {
            position: recorded.position[first],
            position_sd: rough,
            speed,
            speed_sd: speed.abs() + 2.0 * rough / length_s,
            torque_rms,
            settling_s: length_s,
        }
    }
}
