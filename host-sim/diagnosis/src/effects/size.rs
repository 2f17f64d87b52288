//! The sizes of a machine that bounds and scales of parameters are multiples of.

use super::Excitation;
use crate::physics::Physics;

/// What the numbers of a parameter are measured by on a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// The unit itself.
    Unit,
    /// Root mean square of the commanded torque.
    Torque,
    /// Largest commanded torque.
    TorquePeak,
    /// Torque over the largest speed.
    Damping,
    /// Torque over the square of the largest speed.
    Drag,
    /// The largest commanded field.
    Field,
    /// Torque over the travel.
    Stiffness,
    /// The largest speed.
    Speed,
    /// The nominal inertia.
    Inertia,
    /// The travel.
    Travel,
    /// One over the work of that torque at the largest speed for the longest recording.
    PerWork,
    /// One over the longest recording.
    PerDuration,
    /// One over the sample period.
    Rate,
    /// The sensor's step.
    Step,
}

impl Size {
    /// In SI units of the axis.
    pub fn of(self, physics: &Physics, excitation: &Excitation) -> f64 {
        let (speed, travel) = (excitation.speed_peak.max(1e-9), excitation.travel.max(1e-9));
        match self {
            Self::Unit => 1.0,
            Self::Torque => excitation.torque_rms,
            Self::TorquePeak => excitation.torque_peak,
            Self::Damping => excitation.torque_rms / speed,
            Self::Drag => excitation.torque_rms / (speed * speed),
            Self::Field => excitation.field_peak,
            Self::Stiffness => excitation.torque_rms / travel,
            Self::Speed => speed,
            Self::Inertia => physics.model.inertia,
            Self::Travel => travel,
            Self::PerWork => (excitation.torque_rms * speed * excitation.duration_s).max(1e-9).recip(),
            Self::PerDuration => excitation.duration_s.max(1e-6).recip(),
            Self::Rate => excitation.period_s.max(1e-6).recip(),
            Self::Step if excitation.step > 0.0 => excitation.step,
            // Of a continuous sensor, what shows in a travel of a million steps.
            Self::Step => 1e-6 * travel,
        }
    }
}
