//! A model in closed loop along a reference: the commands and the states that every rival then starts its windows from.

use diagnosis::recorded::{ACTS_S, commands};
use diagnosis::windows::HORIZONS_S;
use er_servo::Config;
use plant::{Command, Model, Plant, State};

use super::Limits;
use super::menu::Item;
use crate::Error;
use crate::read::{AxisKind, Machine, Recording};
use crate::residual::residual;
use crate::simulate::{Reference, Setup, period_s, run};

/// Commands along a motion, and the states at the first rows of its windows.
#[derive(Debug, Clone)]
pub struct Motion {
    /// s.
    pub t_s: Vec<f64>,
    /// One a row, each held to the next.
    pub commands: Vec<Command>,
    /// Held since ever when the first command came.
    pub before: Command,
    /// Where the windows start.
    pub starts: Vec<Start>,
    /// Rows of a window.
    pub rows: usize,
    /// What it asks of the machine.
    pub asked: Limits,
}

/// Where a window starts.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// Index of the row.
    pub row: usize,
    /// State of the machine there.
    pub state: State,
    /// Index of the block it is counted in.
    pub block: usize,
}

/// Length of the windows of a comparison, s.
const HORIZON_S: f64 = HORIZONS_S[0];
/// Length of the blocks that are compared, s.
const BLOCK_S: f64 = 0.4;
/// Every second window is enough to predict with.
pub const STRIDE: usize = 2;

/// What closes the loop.
#[derive(Debug, Clone, Copy)]
pub enum Loop {
    /// The flashed law.
    Law(Config),
    /// A plain PD on the true state, without field: where the controller of a machine is not known.
    Pd {
        /// N m/rad (N/m).
        stiffness: f64,
        /// N m s/rad (N s/m).
        damping: f64,
        /// N m (N).
        torque_limit: f64,
        /// Time from one command to the next, s.
        period_s: f64,
    },
}

impl Loop {
    /// The law, or for a machine that has none a PD of the paper's gains for its delay.
    pub fn of(machine: &Machine, limits: &Limits) -> Self {
        if let Some(config) = law_of(machine) {
            return Self::Law(config);
        }
        let plant = &machine.plant;
        let period_s = machine.axis.sample_period_s;
        // The gains of control.md section 4, for the delay with that of the samples.
        let delay_s = (plant.torque_delay_s + period_s).max(4.0 * period_s);
        Self::Pd {
            stiffness: 0.08 * plant.inertia / (delay_s * delay_s),
            damping: 0.464 * plant.inertia / delay_s,
            torque_limit: limits.torque,
            period_s,
        }
    }

    /// Torque over error, N m/rad (N/m).
    pub fn stiffness(&self) -> f64 {
        match self {
            Self::Law(config) => f64::from(config.kp_nm_rad),
            Self::Pd { stiffness, .. } => *stiffness,
        }
    }

    /// Control period, s.
    pub fn period_s(&self) -> f64 {
        match self {
            Self::Law(config) => period_s(config),
            Self::Pd { period_s, .. } => *period_s,
        }
    }

    /// The motion of a model along a reference; none where it cannot be run, or trips.
    pub fn motion(&self, model: &Model, item: &Item) -> Option<Motion> {
        let reference = Reference::Experiment(item.experiment);
        let period_s = self.period_s();
        let positions = reference.positions(period_s).ok()?;
        let (commands, states) = match self {
            Self::Law(config) => law(model, config, positions.collect()).ok()??,
            Self::Pd { stiffness, damping, torque_limit, .. } => {
                let reference: Vec<f64> = positions.map(|counts| counts.to_rad() * item.unit).collect();
                pd(model, &reference, [*stiffness, *damping, *torque_limit], period_s).ok()?
            }
        };
        let t_s: Vec<f64> = (0..commands.len()).map(|row| row as f64 * period_s).collect();
        let rows = rows(period_s);
        let windows = (rows..(commands.len() + 1).saturating_sub(rows)).step_by(rows * STRIDE);
        let start = |row: usize| Start { row, state: states[row], block: (t_s[row] / BLOCK_S) as usize };
        let starts = windows.map(start).collect();
        let asked = asked(&commands, &states);
        Some(Motion { starts, rows, asked, t_s, commands, before: Command::default() })
    }
}

/// Rows of a window at that sampling, s.
pub fn rows(period_s: f64) -> usize {
    (HORIZON_S / period_s).round().max(10.0) as usize
}

/// The law that will run an experiment: that of the machine file; a rotary axis with a damper has the flashed law even where
/// the file does not say, as `simulate` has it.
pub fn law_of(machine: &Machine) -> Option<Config> {
    let servo = machine.axis.kind == AxisKind::Rotary && machine.plant.er.is_some();
    machine.controller.filter(|_| machine.axis.kind == AxisKind::Rotary).or(servo.then(Config::default))
}

fn asked(commands: &[Command], states: &[State]) -> Limits {
    let ends = states.iter().fold((f64::MAX, f64::MIN), |(low, high), s| (low.min(s.position), high.max(s.position)));
    Limits {
        speed: states.iter().fold(0.0, |peak, state| peak.max(state.velocity.abs())),
        torque: commands.iter().fold(0.0, |peak, command| peak.max(command.torque.abs())),
        travel: ends.1 - ends.0,
    }
}

type Run = (Vec<Command>, Vec<State>);

/// Under the flashed law; none where it trips.
fn law(model: &Model, config: &Config, positions: Vec<er_servo::Counts>) -> Result<Option<Run>, Error> {
    let setup = Setup {
        model: model.clone(),
        config: *config,
        disturbances: Vec::new(),
        sensor_noise_rad: 0.0,
        torque_noise_nm: 0.0,
        seed: 0,
    };
    let rows = run(&setup, positions)?;
    if rows.last().is_none_or(|row| !row.outputs.supervisor.faults().is_empty()) {
        return Ok(None);
    }
    let command = |row: &crate::simulate::Row| Command {
        torque: f64::from(row.outputs.torque_nm),
        field_kv_mm: f64::from(row.outputs.field_kv_mm),
        braking: row.outputs.mode == er_servo::Mode::Brake,
        speed_estimate: f64::from(row.outputs.speed_rad_s),
        ..Command::default()
    };
    Ok(Some((rows.iter().map(command).collect(), rows.iter().map(|row| row.truth).collect())))
}

/// Under a PD of stiffness, damping and torque limit.
fn pd(model: &Model, reference: &[f64], gains: [f64; 3], period_s: f64) -> Result<Run, plant::Error> {
    let [stiffness, damping, torque_limit] = gains;
    let mut plant = Plant::new(model, State::default(), 0.0)?;
    let (mut commands, mut states) = (Vec::with_capacity(reference.len()), Vec::with_capacity(reference.len()));
    for (tick, wanted) in reference.iter().enumerate() {
        let state = *plant.state();
        let torque = stiffness * (wanted - plant.position_at_sensor()) - damping * state.velocity;
        let command =
            Command { speed_estimate: state.velocity, ..Command::new(torque.clamp(-torque_limit, torque_limit), 0.0) };
        states.push(state);
        commands.push(command);
        plant.advance(&command, (tick + 1) as f64 * period_s)?;
    }
    Ok((commands, states))
}

impl Motion {
    /// The motion of a recording, its window starts estimated under a model: what repeating it would tell.
    ///
    /// # Errors
    /// A recording too short for one window, or a machine that cannot be simulated.
    pub fn recorded(recording: &Recording, model: &Model) -> Result<Self, Error> {
        let left = residual(model, recording, HORIZON_S)?;
        let commands = commands(recording);
        let rows = left.windows.iter().map(|window| window.end - window.start).min().unwrap_or(0);
        let first_s = recording.t_s[0];
        let settled = left.windows.iter().filter(|window| recording.t_s[window.start] >= first_s + ACTS_S);
        let starts: Vec<Start> = settled
            .step_by(STRIDE)
            .map(|window| Start {
                row: window.start,
                state: window.state,
                block: ((recording.t_s[window.start] - first_s) / BLOCK_S) as usize,
            })
            .collect();
        let before = Command { speed_estimate: 0.0, ..commands.first().copied().unwrap_or_default() };
        let states: Vec<State> = starts.iter().map(|start| start.state).collect();
        let asked = asked(&commands, &states);
        Ok(Self { t_s: recording.t_s.clone(), commands, before, starts, rows, asked })
    }
}
