//! The recordings as one least-squares problem: residuals of the torque balance, in units of their own noise.

use std::sync::Arc;

use super::load::{Pull, pull};
use super::motion::Motion;
use super::waves::{ErrorWave, Waves};
use super::{balance, weak};
use crate::budget::Budget;
use crate::effects::{Effect, Load, Physics, Range};

/// Half-widths of the bumps, s: fine enough to tell a lag from a dead time, wide enough for a coarse position.
const HALF_WIDTHS_S: [f64; 3] = [0.008, 0.020, 0.050];
/// Length of the blocks that are left out together, s.
const BLOCK_S: f64 = 0.4;
/// At the start the commands before the first row are not known.
const SETTLE_S: f64 = 0.03;

/// An effect with values, as a hypothesis has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Active {
    /// Which.
    pub effect: &'static Effect,
    /// What the fit moves.
    pub values: Vec<f64>,
    /// Bounds and scale of each value.
    pub ranges: Vec<Range>,
}

impl Active {
    /// The same where the torque balance of what moves tells nothing of the values: no fit of it moves them.
    #[must_use]
    pub fn held(&self) -> Self {
        let ranges = self.values.iter().zip(&self.ranges);
        let ranges = ranges.map(|(&value, range)| Range { low: value, high: value, scale: range.scale }).collect();
        Self { ranges, ..self.clone() }
    }

    /// Whether it is held.
    pub fn is_held(&self) -> bool {
        self.ranges.iter().all(|range| range.low == range.high)
    }

    /// Whether a value stands where the search ends: at no finite value of its own it is no such effect. A bound of zero
    /// is one that nature has.
    pub fn at_bound(&self) -> bool {
        self.values.iter().zip(&self.ranges).filter(|(_, range)| range.high > range.low).any(|(value, range)| {
            let near = |bound: f64| bound.is_finite() && (value - bound).abs() <= 1e-6 * range.scale;
            near(range.high) || near(range.low) && range.low != 0.0
        })
    }
}

/// One row of the problem.
#[derive(Debug, Clone)]
pub(crate) struct Equation {
    pub recording: usize,
    pub width: usize,
    pub block: usize,
    pub row: weak::Row,
    /// Mean acceleration of the measured position.
    pub acceleration: f64,
    /// Standard deviation of that under the noise of the position alone, rad/s2.
    pub acceleration_noise: f64,
}

/// All equations of a set of recordings, with the nominal machine.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The recordings: those to fit, then those that are only predicted.
    pub(crate) motions: Vec<Motion>,
    /// Number of recordings to fit.
    pub(crate) fitted: usize,
    pub(crate) equations: Vec<Equation>,
    /// Number of blocks.
    pub(crate) blocks: usize,
    /// First block of each recording, and the length of its blocks, s.
    spans: Vec<(usize, f64)>,
    pub(crate) nominal: Physics,
    /// What may still be computed.
    pub(crate) budget: Arc<Budget>,
}

/// Cell means of the parts of the balance in each recording; kept so that a trial computes only what it changes.
#[derive(Debug, Clone)]
pub(crate) struct Parts {
    physics: Physics,
    drive: Arc<Vec<Vec<f64>>>,
    damper: Arc<Vec<Vec<f64>>>,
    friction: Arc<Vec<Vec<f64>>>,
    external: Arc<Vec<Vec<f64>>>,
    waves: Waves,
    /// Of an error of the position sensor.
    error_wave: Option<ErrorWave>,
    /// What a flexible load takes, and the inertia that stays with the rotor.
    load: Option<(Arc<Vec<Pull>>, f64)>,
}

impl Parts {
    /// Torque on the rotor in each cell of one recording, without that of a load.
    fn torques(&self, recording: usize) -> impl Iterator<Item = f64> {
        let drives = self.drive[recording].iter().zip(self.damper[recording].iter());
        let others = self.friction[recording].iter().zip(self.external[recording].iter());
        drives.zip(others).map(|((drive, damper), (friction, external))| drive - damper - friction + external)
    }
}

impl Problem {
    /// Builds the equations of the recordings; those behind the first `fitted` are predicted and never fitted.
    pub(crate) fn new(motions: Vec<Motion>, fitted: usize, nominal: Physics) -> Self {
        let mut equations = Vec::new();
        let (mut blocks, mut spans) = (0, Vec::new());
        for (recording, motion) in motions.iter().enumerate() {
            let last_s = motion.t_s[motion.t_s.len() - 1];
            let span_s = (last_s - motion.t_s[0]).max(1e-6);
            // Few seconds still make enough blocks to leave one out; a long recording makes them longer.
            let block_s = BLOCK_S.min(span_s / 8.0).max(span_s / 60.0);
            spans.push((blocks, block_s));
            let mut of_recording = Vec::new();
            for (width, half_width_s) in HALF_WIDTHS_S.into_iter().enumerate() {
                let half_width_s = half_width_s.max(5.0 * motion.period_s * 1.6f64.powi(width as i32));
                for row in weak::rows(motion, half_width_s, SETTLE_S) {
                    let block = blocks + ((row.centre_s - motion.t_s[0]) / block_s) as usize;
                    let acceleration = row.acceleration(&motion.position);
                    let acceleration_noise = row.noise_gain() * motion.noise;
                    of_recording.push(Equation { recording, width, block, row, acceleration, acceleration_noise });
                }
            }
            of_recording.sort_by(|a, b| a.row.centre_s.total_cmp(&b.row.centre_s));
            blocks += (span_s / block_s).ceil() as usize + 1;
            equations.append(&mut of_recording);
        }
        Self { motions, fitted, equations, blocks, spans, nominal, budget: Arc::default() }
    }

    /// The same within a budget that others share.
    pub(crate) fn within(self, budget: &Arc<Budget>) -> Self {
        Self { budget: Arc::clone(budget), ..self }
    }

    /// The same with the recordings to fit alone.
    pub(super) fn to_fit(&self) -> Self {
        Self {
            motions: self.motions[..self.fitted].to_vec(),
            equations: self.equations[..self.fitted_equations()].to_vec(),
            spans: self.spans.clone(),
            nominal: self.nominal.clone(),
            budget: Arc::clone(&self.budget),
            ..*self
        }
    }

    /// Number of equations to fit; they come before those that are only predicted.
    pub(crate) fn fitted_equations(&self) -> usize {
        self.equations.partition_point(|equation| equation.recording < self.fitted)
    }

    /// The longest way from end to end of a recording to fit, rad (m).
    pub(crate) fn travel(&self) -> f64 {
        let range = |motion: &Motion| {
            let ends = motion.smooth.iter().fold((f64::MAX, f64::MIN), |(low, high), &q| (low.min(q), high.max(q)));
            ends.1 - ends.0
        };
        self.motions[..self.fitted].iter().map(range).fold(0.0, f64::max)
    }

    /// Number of isolated wrong samples in all recordings.
    pub(crate) fn wrong_samples(&self) -> usize {
        self.motions.iter().map(|motion| motion.glitches.len()).sum()
    }

    /// The block that a time of a recording belongs to.
    pub(crate) fn block(&self, recording: usize, t_s: f64) -> usize {
        let (first, block_s) = self.spans[recording];
        first + ((t_s - self.motions[recording].t_s[0]) / block_s) as usize
    }

    /// The machine with effects put into it.
    pub(crate) fn machine(&self, active: &[Active]) -> Physics {
        let mut physics = self.nominal.clone();
        for entry in active {
            (entry.effect.put)(&mut physics, &entry.values);
        }
        physics
    }

    /// Everything of the balance for a machine, reusing what `known` has in common with it.
    pub(crate) fn parts(&self, physics: &Physics, known: Option<&Parts>) -> Parts {
        let each = |part: &dyn Fn(usize, &Motion) -> Vec<f64>| -> Arc<Vec<Vec<f64>>> {
            Arc::new(self.motions.iter().enumerate().map(|(index, motion)| part(index, motion)).collect())
        };
        let waves = Waves::of(physics, &self.motions, known.map(|known| &known.waves));
        let error_wave = physics.eccentricity.as_ref().map(|error| {
            ErrorWave::of(error, &self.motions, &self.equations, known.and_then(|known| known.error_wave.as_ref()))
        });
        let same = |key: fn(&Physics, &Physics) -> bool| known.filter(|known| key(&known.physics, physics));
        let mut parts = Parts {
            drive: same(same_drive).map_or_else(|| each(&|_, m| balance::drive(physics, m)), |k| Arc::clone(&k.drive)),
            damper: same(same_damper)
                .map_or_else(|| each(&|_, m| balance::damper(physics, m)), |k| Arc::clone(&k.damper)),
            friction: same(same_friction)
                .map_or_else(|| each(&|_, m| balance::friction(physics, m)), |k| Arc::clone(&k.friction)),
            external: same(same_external).map_or_else(
                || each(&|i, m| balance::external(physics, m, i, waves.along(i))),
                |k| Arc::clone(&k.external),
            ),
            waves,
            error_wave,
            load: None,
            physics: physics.clone(),
        };
        if let Some(load) = &physics.load {
            // Behind a gap the load is kept on track by the whole balance.
            let alone = load.gap == 0.0;
            let kept = same(same_load).filter(|known| alone || known.physics == *physics);
            parts.load = kept.map_or_else(|| self.load(&parts, load), |known| known.load.clone());
        }
        parts
    }

    fn load(&self, parts: &Parts, load: &Load) -> Option<(Arc<Vec<Pull>>, f64)> {
        let inertia = parts.physics.inertia;
        let motor = inertia / (1.0 + load.inertia_ratio);
        let pulls = self.motions.iter().enumerate().map(|(index, motion)| {
            let shown: Vec<f64> = parts
                .torques(index)
                .enumerate()
                .map(|(cell, torque)| {
                    let span = motion.t_s[cell + 1] - motion.t_s[cell];
                    torque - motor * (motion.speed[cell + 1] - motion.speed[cell]) / span
                })
                .collect();
            pull(motion, load, inertia, &shown)
        });
        Some((Arc::new(pulls.collect()), motor))
    }

    /// Residual of each equation, N m (N), unweighted: the acceleration that the model does not predict, times the nominal
    /// inertia. Against the torque itself a model would improve by scaling inertia and all torques down together.
    pub(crate) fn residual(&self, parts: &Parts) -> Vec<f64> {
        let physics = &parts.physics;
        let cells = self.motions.iter().map(Motion::cells).sum();
        self.budget.spend_cells(cells, physics.load.is_some_and(|load| load.gap > 0.0));
        let inertia = parts.load.as_ref().map_or(physics.inertia, |(_, motor)| *motor);
        let nominal = self.nominal.inertia;
        let cells: Vec<Vec<f64>> = (0..self.motions.len())
            .map(|index| match &parts.load {
                Some((pulls, _)) => {
                    parts.torques(index).zip(&pulls[index].torque).map(|(all, pull)| all - pull).collect()
                }
                None => parts.torques(index).collect(),
            })
            .collect();
        self.equations
            .iter()
            .enumerate()
            .map(|(index, equation)| {
                let error = parts.error_wave.as_ref().zip(physics.eccentricity.as_ref());
                let bent = error.map_or(0.0, |(wave, error)| wave.acceleration(error, index));
                let acceleration = equation.acceleration - bent;
                let residual = nominal * (acceleration - equation.row.mean(&cells[equation.recording]) / inertia);
                let corrected = parts.load.as_ref().map(|(pulls, _)| &pulls[equation.recording].corrected);
                match corrected.filter(|corrected| !corrected.is_empty()) {
                    Some(corrected) => {
                        let charged = nominal / inertia * equation.row.mean(corrected);
                        residual.hypot(charged).copysign(residual)
                    }
                    None => residual,
                }
            })
            .collect()
    }
}

fn same_drive(a: &Physics, b: &Physics) -> bool {
    let key = |p: &Physics| {
        [
            p.torque_gain,
            p.torque_offset,
            p.torque_limit,
            p.torque_deadband,
            p.torque_delay_s,
            p.torque_lag_s,
            p.latency_s,
        ]
    };
    key(a) == key(b)
}

fn same_damper(a: &Physics, b: &Physics) -> bool {
    a.damper == b.damper && a.latency_s == b.latency_s
}

fn same_friction(a: &Physics, b: &Physics) -> bool {
    let key = |p: &Physics| {
        [
            p.coulomb,
            p.viscous,
            p.quadratic,
            p.stribeck_excess,
            p.stribeck_velocity,
            p.asymmetry,
            p.asymmetry_viscous,
            p.presliding,
        ]
    };
    key(a) == key(b)
}

fn same_external(a: &Physics, b: &Physics) -> bool {
    a.cogging == b.cogging
        && a.gravity == b.gravity
        && a.spring == b.spring
        && a.vibration == b.vibration
        && a.pulses == b.pulses
}

fn same_load(a: &Physics, b: &Physics) -> bool {
    a.load == b.load && a.inertia == b.inertia
}
