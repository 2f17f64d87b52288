//! A model in closed loop along a reference: the recording that it would make.

use diagnosis::physics::Physics;
use diagnosis::recorded::Recorded;
use er_servo::Config;
use plant::{Command, Model, Plant, State};

use super::Limits;
use super::menu::Item;
use crate::Error;
use crate::read::{AxisKind, Machine};
use crate::simulate::{Reference, Setup, period_s, run};

/// The recording of a motion without noise.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    pub(crate) recorded: Recorded,
    /// What it asks of the machine.
    pub(crate) asked: Limits,
}

/// Rows of a motion that is planned are no nearer than this, s: no drive controls its position faster, and eight seconds are 80,000
/// of them.
const FASTEST_S: f64 = 1e-4;

/// What closes the loop.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Loop {
    /// The flashed law.
    Law(Config),
    /// A plain PD on the true state, without field: where the controller of a machine is not known.
    Pd { stiffness: f64, damping: f64, torque_limit: f64, period_s: f64 },
}

impl Loop {
    /// The law, or for a machine that has none a PD of the paper's gains for its delay.
    pub(crate) fn of(machine: &Machine, limits: &Limits) -> Self {
        if let Some(config) = law_of(machine) {
            return Self::Law(config);
        }
        let plant = &machine.plant;
        let period_s = machine.axis.sample_period_s.max(FASTEST_S);
        // The gains of control.md section 4, for the delay with that of the samples.
        let delay_s = (plant.torque_delay_from_sample_s() + period_s).max(4.0 * period_s);
        Self::Pd {
            stiffness: 0.08 * plant.inertia / (delay_s * delay_s),
            damping: 0.464 * plant.inertia / delay_s,
            torque_limit: limits.torque,
            period_s,
        }
    }

    /// Torque over error, N m/rad (N/m).
    pub(super) fn stiffness(&self) -> f64 {
        match self {
            Self::Law(config) => f64::from(config.kp_nm_rad),
            Self::Pd { stiffness, .. } => *stiffness,
        }
    }

    /// Control period, s.
    pub(super) fn period_s(&self) -> f64 {
        match self {
            Self::Law(config) => period_s(config),
            Self::Pd { period_s, .. } => *period_s,
        }
    }

    /// The motion of a machine along a reference; none where it cannot be run, or trips. Events do not come again.
    pub(crate) fn motion(&self, physics: &Physics, item: &Item) -> Option<Motion> {
        let model = Physics { pushes: Vec::new(), ..physics.clone() }.model_of(0);
        let reference = Reference::Experiment(item.experiment);
        let period_s = self.period_s();
        let positions = reference.positions(period_s).ok()?;
        let rows = match self {
            Self::Law(config) => law(&model, config, positions.collect()).ok()??,
            Self::Pd { stiffness, damping, torque_limit, .. } => {
                let reference: Vec<f64> = positions.map(|counts| counts.to_rad() * item.unit).collect();
                pd(&model, &reference, [*stiffness, *damping, *torque_limit], period_s).ok()?
            }
        };
        let recorded = Recorded {
            name: item.name.to_owned(),
            // The path along which the rivals are held against each other: what the sensor makes of it is in their columns.
            t_s: (0..rows.len()).map(|row| row as f64 * period_s).collect(),
            position: rows.iter().map(|row| row.state.position).collect(),
            commands: rows.iter().map(|row| row.command).collect(),
            skipped: vec![false; rows.len()],
            after_gap: vec![false; rows.len()],
        };
        Some(Motion { recorded, asked: asked(&rows) })
    }
}

/// The law that will run an experiment: that of the machine file; a rotary axis with a damper has the flashed law even where
/// the file does not say, as `simulate` has it.
pub(super) fn law_of(machine: &Machine) -> Option<Config> {
    let servo = machine.axis.kind == AxisKind::Rotary && machine.plant.er.is_some();
    machine.controller.filter(|_| machine.axis.kind == AxisKind::Rotary).or(servo.then(Config::default))
}

/// One control period.
struct Row {
    command: Command,
    state: State,
}

fn asked(rows: &[Row]) -> Limits {
    let positions = rows.iter().map(|row| row.state.position);
    let (low, high) = positions.fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p), high.max(p)));
    Limits {
        speed: rows.iter().fold(0.0, |peak, row| peak.max(row.state.velocity.abs())),
        torque: rows.iter().fold(0.0, |peak, row| peak.max(row.command.torque.abs())),
        travel: high - low,
    }
}

/// Under the flashed law; none where it trips.
fn law(model: &Model, config: &Config, positions: Vec<er_servo::Counts>) -> Result<Option<Vec<Row>>, Error> {
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
    let row = |row: &crate::simulate::Row| Row {
        command: Command {
            torque: f64::from(row.outputs.torque_nm),
            field_kv_mm: f64::from(row.outputs.field_kv_mm),
            braking: row.outputs.mode == er_servo::Mode::Brake,
            speed_estimate: f64::from(row.outputs.speed_rad_s),
            ..Command::default()
        },
        state: row.truth,
    };
    Ok(Some(rows.iter().map(row).collect()))
}

/// Under a PD of stiffness, damping and torque limit.
fn pd(model: &Model, reference: &[f64], gains: [f64; 3], period_s: f64) -> Result<Vec<Row>, plant::Error> {
    let [stiffness, damping, torque_limit] = gains;
    let mut plant = Plant::new(model, State::default(), 0.0)?;
    let mut rows = Vec::with_capacity(reference.len());
    for (tick, wanted) in reference.iter().enumerate() {
        let (state, seen) = (*plant.state(), plant.position_at_sensor());
        let torque = stiffness * (wanted - seen) - damping * state.velocity;
        let command =
            Command { speed_estimate: state.velocity, ..Command::new(torque.clamp(-torque_limit, torque_limit), 0.0) };
        rows.push(Row { command, state });
        plant.advance(&command, (tick + 1) as f64 * period_s)?;
    }
    Ok(rows)
}
