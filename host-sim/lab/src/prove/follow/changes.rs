//! Changes of recordings and nominal model whose effect on the answer is known without any truth.

use super::log::Log;
use crate::read::Machine;

/// A change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// The recordings in the reverse order.
    Order,
    /// The axis counts the other way.
    Sign,
    /// Torque, or force, and all that moves by it in a unit eight times smaller.
    Units,
    /// Each recording as two.
    Split,
    /// Every other row.
    Decimated,
    /// The drive pushes: an offset is added to what the commands hold back.
    Offset,
    /// The commands carry a spring that was not there.
    Spring,
    /// The commands overcome a viscous friction that was not there.
    Viscous,
}

/// Factor of the units: a power of two, so that no digit is lost.
const FACTOR: f64 = 8.0;
/// Size of an added effect over the root mean square of the commands.
const ADDED: f64 = 0.3;
/// Rows on either side that a speed is the slope of.
const AROUND: usize = 4;

/// Recordings and nominal model.
#[derive(Debug, Clone)]
pub(super) struct Subject {
    pub(super) machine: Machine,
    pub(super) fitted: Vec<Log>,
    pub(super) held_out: Vec<Log>,
}

/// An effect that was added: its parameter, and by how much that is more.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Added {
    pub(super) id: &'static str,
    pub(super) parameter: &'static str,
    pub(super) nominal: f64,
    pub(super) by: f64,
}

impl Change {
    /// Every change.
    pub const ALL: [Self; 8] =
        [Self::Order, Self::Sign, Self::Units, Self::Split, Self::Decimated, Self::Offset, Self::Spring, Self::Viscous];

    /// As the flag takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Order => "order",
            Self::Sign => "sign",
            Self::Units => "units",
            Self::Split => "split",
            Self::Decimated => "decimated",
            Self::Offset => "offset",
            Self::Spring => "spring",
            Self::Viscous => "viscous",
        }
    }

    /// Changes a subject; gives what was added. None where the change is none for it.
    pub(super) fn apply(self, subject: &mut Subject) -> Option<Option<Added>> {
        // The law is of the axis as it was.
        subject.machine.controller = None;
        match self {
            Self::Order => {
                subject.fitted.reverse();
                (subject.fitted.len() > 1).then_some(None)
            }
            Self::Sign => {
                each(subject, |log| {
                    for beginning in ["position_", "reference_", "velocity_", "torque_", "force_"] {
                        log.change(beginning, |_, value| -value);
                    }
                });
                self.machine(&mut subject.machine);
                Some(None)
            }
            Self::Units => {
                each(subject, |log| {
                    ["torque_", "force_"].iter().for_each(|one| log.change(one, |_, value| FACTOR * value))
                });
                self.machine(&mut subject.machine);
                Some(None)
            }
            Self::Split => {
                let halves = |log: &Log| [log.part(0..log.len() / 2), log.part(log.len() / 2..log.len())];
                subject.fitted = subject.fitted.iter().flat_map(halves).collect();
                Some(None)
            }
            Self::Decimated => {
                each(subject, |log| *log = log.halved());
                subject.machine.axis.sample_period_s *= 2.0;
                Some(None)
            }
            Self::Offset | Self::Spring | Self::Viscous => self.add(subject).map(Some),
        }
    }

    /// The nominal model and its effects under the change.
    fn machine(self, machine: &mut Machine) {
        let linear = machine.axis.kind == crate::read::AxisKind::Linear;
        for entry in &mut machine.effects {
            for (parameter, value) in &mut entry.parameters {
                *value = self.value(&entry.id, parameter, *value);
            }
        }
        let plant = &mut machine.plant;
        let scaled = if linear { "force_n" } else { "torque_nm" };
        for value in [&mut plant.inertia, &mut plant.coulomb, &mut plant.viscous] {
            *value = self.value("", scaled, *value);
        }
        plant.torque_offset = self.value("torque_offset", scaled, plant.torque_offset);
        plant.torque_limit = plant.torque_limit.map(|limit| self.value("", scaled, limit));
        if let Some(er) = &mut plant.er {
            (er.a, er.b) = (self.value("", scaled, er.a), self.value("", scaled, er.b));
        }
    }

    /// What a value of the answer becomes.
    pub(super) fn value(self, id: &str, parameter: &str, value: f64) -> f64 {
        const SIGNED: [(&str, &str); 6] = [
            ("torque_offset", ""),
            ("friction_asymmetry", ""),
            ("disturbance_pulse", "amplitude"),
            ("gravity_load", "phase"),
            ("cogging", "phase"),
            ("resolver_eccentricity", "phase"),
        ];
        const TORQUES: [&str; 10] =
            ["_nm", "_n", "_nm_s_rad", "_n_s_m", "_nm_rad", "_n_m", "_nm_s2_rad2", "_n_s2_m2", "_kg_m2", "_kg"];
        match self {
            Self::Sign if SIGNED.iter().any(|(of, begins)| *of == id && parameter.starts_with(begins)) => -value,
            Self::Units if TORQUES.iter().any(|unit| parameter.ends_with(unit)) => FACTOR * value,
            _ => value,
        }
    }

    /// Adds an effect to every recording: the commands are what a machine that also has it would need for the same motion, so much
    /// earlier as its drive is late.
    fn add(self, subject: &mut Subject) -> Option<Added> {
        let machine = &subject.machine;
        // Of another gain it is not known whether it is the drive's or the column's.
        if machine.plant.torque_gain != 1.0 {
            return None;
        }
        let delay_s = machine.plant.torque_delay_from_sample_s();
        let linear = machine.axis.kind == crate::read::AxisKind::Linear;
        let by_axis = |rotary: &'static str, on_linear: &'static str| if linear { on_linear } else { rotary };
        let commands: Vec<f64> = subject.fitted.iter().filter_map(effort).flatten().collect();
        let motions: Vec<Motion> = subject.fitted.iter().filter_map(Motion::of).collect();
        let torque = rms(commands.iter().copied());
        let (id, parameter, nominal, by) = match self {
            Self::Offset => {
                ("torque_offset", by_axis("offset_nm", "offset_n"), machine.plant.torque_offset, ADDED * torque)
            }
            Self::Spring => {
                let way = rms(motions.iter().flat_map(|motion| motion.position.iter().copied()));
                ("spring_load", by_axis("stiffness_nm_rad", "stiffness_n_m"), 0.0, ADDED * torque / way)
            }
            _ => {
                let speed = rms(motions.iter().flat_map(|motion| motion.speed.iter().copied()));
                let parameter = by_axis("viscous_nm_s_rad", "viscous_n_s_m");
                ("viscous_friction", parameter, machine.plant.viscous, ADDED * torque / speed)
            }
        };
        if !by.is_finite() || by == 0.0 {
            return None;
        }
        each(subject, |log| {
            let Some(motion) = Motion::of(log) else { return };
            let needed = |row: usize| match self {
                Self::Offset => -by,
                Self::Spring => by * motion.later(&motion.position, row, delay_s),
                _ => by * motion.later(&motion.speed, row, delay_s),
            };
            ["torque_", "force_"].iter().for_each(|one| log.change(one, |row, value| value + needed(row)));
        });
        Some(Added { id, parameter, nominal, by })
    }
}

fn each(subject: &mut Subject, change: impl Fn(&mut Log)) {
    subject.fitted.iter_mut().chain(&mut subject.held_out).for_each(change);
}

fn effort(log: &Log) -> Option<Vec<f64>> {
    log.numbers("torque_").or_else(|| log.numbers("force_"))
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Mean position and speed while a row's command was held.
struct Motion {
    t_s: Vec<f64>,
    position: Vec<f64>,
    speed: Vec<f64>,
}

impl Motion {
    fn of(log: &Log) -> Option<Self> {
        let (t_s, position) = (log.numbers("t_s")?, log.numbers("position_")?);
        let last = position.len().checked_sub(1)?;
        let next = |row: usize| (row + 1).min(last);
        let slope = |row: usize| {
            let (from, to) = (row.saturating_sub(AROUND), (row + 1 + AROUND).min(last));
            (position[to] - position[from]) / (t_s[to] - t_s[from])
        };
        Some(Self {
            position: (0..=last).map(|row| 0.5 * (position[row] + position[next(row)])).collect(),
            speed: (0..=last).map(slope).collect(),
            t_s,
        })
    }

    /// A column of it some time after a row, between rows by a straight line; the last row holds.
    fn later(&self, column: &[f64], row: usize, delay_s: f64) -> f64 {
        let wanted_s = self.t_s[row] + delay_s;
        let after = self.t_s.partition_point(|t_s| *t_s < wanted_s).min(column.len() - 1);
        if after == 0 {
            return column[0];
        }
        let (from_s, to_s) = (self.t_s[after - 1], self.t_s[after]);
        let share = ((wanted_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
        column[after - 1] + share * (column[after] - column[after - 1])
    }
}
