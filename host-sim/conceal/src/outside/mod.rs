//! What no vocabulary has: effects for the proof that the tool is told nothing about, in families.
//!
//! A kind changes the machine where it acts (drive, friction, torque, field, drag, inertia, sensor) and keeps what it remembers. Its values
//! are in the SI units of the axis: N m or N, rad or m.

mod afield;
mod aloft;
#[cfg(test)]
mod at_work;
mod beyond;
mod drive;
mod fluid;
mod friction;
mod further;
#[cfg(test)]
mod given_motion;
mod kinds;
mod later;
mod mechanics;
#[cfg(test)]
mod named_since;
mod sensor;
mod spring;
mod unseen;

use std::f64::consts::TAU;
use std::fmt;

use rand::Rng;
use rand::rngs::StdRng;

pub use kinds::{families, find, kinds};

use crate::physics::Physics;

/// What a hidden effect sees in a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    /// Since the start, s.
    pub(crate) t_s: f64,
    /// Of the integrator, s.
    pub(crate) step_s: f64,
    /// rad or m.
    pub(crate) position: f64,
    /// rad/s or m/s.
    pub(crate) speed: f64,
    /// Torque of the drive, N m or N.
    pub(crate) drive: f64,
}

impl Seen {
    /// Share of the way to where it tends that a lag of first order goes in this step.
    fn share_of_lag(&self, time_s: f64) -> f64 {
        -(-self.step_s / time_s).exp_m1()
    }
}

/// What becomes of the bearings' friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rub {
    /// The dry level is multiplied by this, 1.
    pub(crate) share: f64,
    /// And raised by this, N m or N.
    pub(crate) level: f64,
    /// Added to the viscous coefficient, N m s/rad or N s/m.
    pub(crate) viscous: f64,
}

impl Rub {
    pub(crate) const NONE: Self = Self { share: 1.0, level: 0.0, viscous: 0.0 };

    fn level(level: f64) -> Self {
        Self { level, ..Self::NONE }
    }
}

/// An effect at work: each place that it may change, once a step.
pub(crate) trait Hidden {
    fn drive(&mut self, _: &Seen, torque: f64) -> f64 {
        torque
    }
    fn friction(&mut self, _: &Seen) -> Rub {
        Rub::NONE
    }
    fn torque(&mut self, _: &Seen) -> f64 {
        0.0
    }
    /// Field that acts in place of the commanded one, kV/mm.
    fn field(&mut self, field_kv_mm: f64) -> f64 {
        field_kv_mm
    }
    /// Drag of the damper.
    fn drag(&mut self, _: &Seen, level: f64) -> f64 {
        level
    }
    /// Inertia that the axis moves directly, over the nominal one.
    fn inertia(&self, _: &Seen) -> f64 {
        1.0
    }
    /// Tells a sensor the torque of the drive, before its reading.
    fn feels(&mut self, _: f64) {}
    /// Position as the sensor has it.
    fn measured(&mut self, position: f64) -> f64 {
        position
    }
}

/// What sizes are measured in: typical values of the motion of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Root mean square of the drive's torque, N m or N.
    pub torque: f64,
    /// Root mean square of the speed while moving, rad/s or m/s.
    pub speed: f64,
    /// Half the way between the ends of the motion, rad or m.
    pub travel: f64,
    /// Length of a recording, s.
    pub duration_s: f64,
    /// Control period, s.
    pub period_s: f64,
    /// Of the nominal machine, kg m2 or kg.
    pub inertia: f64,
    /// Dry friction of the nominal machine, N m or N.
    pub coulomb: f64,
    /// Largest commanded field, kV/mm; 0 without a damper.
    pub field_kv_mm: f64,
}

/// Draws that a size does not change: phases, signs, frequencies; each uniform from 0 to 1.
pub type Shape = [f64; 4];

/// How a kind is put into a machine.
#[derive(Clone, Copy)]
pub(crate) enum Put {
    /// A number of [`Physics`].
    Number(fn(&mut Physics, &[f64])),
    /// One that works beside it.
    Beside(fn(&[f64]) -> Box<dyn Hidden>),
}

/// What a machine and its log must have for a kind to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// An axis.
    Nothing,
    /// A damper.
    Fluid,
    /// A torque column that was commanded.
    Command,
}

/// A kind of effect outside the vocabulary.
pub struct Kind {
    /// Identifier.
    pub id: &'static str,
    /// Kinds of one family are alike enough that a tool which was tuned to one knows the others.
    pub family: &'static str,
    /// What the values are.
    pub parameters: &'static [&'static str],
    /// What a machine must have for it.
    pub needs: Needs,
    /// Values at a size: 0 for no effect, 1 for one as large as the motion's own torques. The first tells the strength.
    pub(crate) values: fn(&Scales, f64, &Shape) -> Vec<f64>,
    pub(crate) put: Put,
    /// Which value is a phase that each recording has of its own, as the clock of something else has nothing to do with their start.
    pub(crate) free_phase: Option<usize>,
}

impl Kind {
    /// Puts it into a machine.
    pub(crate) fn conceal(&'static self, physics: &mut Physics, values: &[f64]) {
        match self.put {
            Put::Number(put) => put(physics, values),
            Put::Beside(_) => physics.hidden = Some(Hiding { kind: self, values: values.to_vec() }),
        }
    }
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

/// A kind with its values in a machine.
#[derive(Debug, Clone)]
pub struct Hiding {
    /// Which.
    pub kind: &'static Kind,
    /// In the order of its parameters.
    pub values: Vec<f64>,
}

impl PartialEq for Hiding {
    fn eq(&self, other: &Self) -> bool {
        self.kind.id == other.kind.id && self.values == other.values
    }
}

impl Hiding {
    /// Draws what differs from one recording to the next.
    pub(crate) fn for_recording(&mut self, random: &mut StdRng) {
        if let Some(index) = self.kind.free_phase {
            self.values[index] = random.random_range(0.0..TAU);
        }
    }

    /// The effect before its first step; none for a kind that is a number of the machine.
    pub(crate) fn begin(&self) -> Option<Box<dyn Hidden>> {
        match self.kind.put {
            Put::Number(_) => None,
            Put::Beside(make) => Some(make(&self.values)),
        }
    }
}

/// Kinds that were outside the vocabulary when a plan was made, and the effects that are the same law now; a kind stays in the list, for
/// results name it.
pub const NAMED_SINCE: [(&str, &str); 3] = [
    ("friction_by_load", "load_dependent_friction"),
    ("torque_ripple", "torque_ripple"),
    // Warmed by the power of the drive and not of the drag: the same but while the axis gains speed.
    ("grease_warms", "temperature_viscosity"),
];

/// From 0 below to 1 above, over a width on either side.
fn ramp(value: f64, width: f64) -> f64 {
    (0.5 + 0.5 * value / width).clamp(0.0, 1.0)
}

/// Warmth: work that comes in, and cools away.
#[derive(Debug, Clone, Copy)]
struct Heat {
    energy_j: f64,
    cooling_s: f64,
    heat: f64,
}

impl Heat {
    fn new(energy_j: f64, cooling_s: f64) -> Self {
        Self { energy_j, cooling_s, heat: 0.0 }
    }

    /// How warm, from 0 to 1, after a step with that much power.
    fn after(&mut self, power_w: f64, step_s: f64) -> f64 {
        self.heat += step_s * (power_w / self.energy_j - self.heat / self.cooling_s);
        1.0 - (-self.heat).exp()
    }
}
