//! Torques that depend on the position: `cogging`, `gravity_load`, `spring_load`; and the drive's gain that does: `torque_ripple`.

use super::friction::{FASTEST_S, travel_time};
use crate::model::{check, finite, not_negative};
use crate::{Error, Model};

/// amplitude sin(order position + phase): cogging or ripple of the motor, or the error of an eccentric resolver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Amplitude, N m (N) for a torque, rad (m) for a position, 1 for a gain.
    pub amplitude: f64,
    /// Periods per revolution (rad of phase per m on a linear axis), not negative.
    pub order: f64,
    /// Phase at position zero, rad.
    pub phase_rad: f64,
}

impl Harmonic {
    pub(crate) fn validate(&self, key: &str) -> Result<(), Error> {
        finite(&format!("{key}.amplitude"), self.amplitude)?;
        check(&format!("{key}.order"), self.order, self.order >= 0.0 && self.order.is_finite(), "finite, 0 or above")?;
        finite(&format!("{key}.phase_rad"), self.phase_rad)
    }

    /// Value at a position.
    #[inline]
    pub fn at(&self, position: f64) -> f64 {
        self.amplitude * (self.order * position + self.phase_rad).sin()
    }

    /// Slope at a position, per rad (m).
    #[inline]
    pub fn slope(&self, position: f64) -> f64 {
        self.amplitude * self.order * (self.order * position + self.phase_rad).cos()
    }
}

/// An unbalanced load: -amplitude sin(position + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// Weight times lever, N m (N).
    pub amplitude: f64,
    /// Phase at position zero, rad; 0 hangs down there.
    pub phase_rad: f64,
}

/// Checks the position-dependent torques of a model.
pub(crate) fn validate(model: &Model) -> Result<(), Error> {
    model.cogging.iter().try_for_each(|harmonic| harmonic.validate("cogging"))?;
    if let Some(gravity) = model.gravity {
        finite("gravity_load.amplitude", gravity.amplitude)?;
        finite("gravity_load.phase_rad", gravity.phase_rad)?;
    }
    model.torque_ripple.iter().try_for_each(|harmonic| harmonic.validate("torque_ripple"))?;
    let depth: f64 = model.torque_ripple.iter().map(|harmonic| harmonic.amplitude.abs()).sum();
    check("torque_ripple.amplitude", depth, depth < 1.0, "below 1 in all, or the drive would pull the other way")?;
    not_negative("spring_load.stiffness", model.spring_stiffness)
}

/// The drive's gain over the position: 1 + amplitude sin(order position + phase), summed over the orders.
#[derive(Debug, Clone)]
pub struct Ripple {
    harmonics: Vec<Harmonic>,
    /// Largest slope of the gain, 1/rad.
    steepest: f64,
    highest_order: f64,
}

impl Ripple {
    /// From a validated model.
    pub fn new(model: &Model) -> Self {
        let harmonics: Vec<Harmonic> =
            model.torque_ripple.iter().filter(|harmonic| harmonic.amplitude != 0.0).copied().collect();
        Self {
            steepest: harmonics.iter().map(|h| h.amplitude.abs() * h.order).sum(),
            highest_order: harmonics.iter().map(|h| h.order).fold(0.0, f64::max),
            harmonics,
        }
    }

    /// Gain at a position, 1.
    #[inline]
    pub fn gain(&self, position: f64) -> f64 {
        self.harmonics.iter().fold(1.0, |gain, harmonic| gain + harmonic.at(position))
    }

    /// Slope of the gain at a position, 1/rad (1/m).
    #[inline]
    pub fn slope(&self, position: f64) -> f64 {
        self.harmonics.iter().map(|harmonic| harmonic.slope(position)).sum()
    }

    /// Longest step over which a drive torque times the gain is smooth, s, as [`PositionTorque::longest_step`].
    pub(crate) fn longest_step(&self, torque: f64, w: f64, acceleration: f64, inertia: f64) -> f64 {
        if self.harmonics.is_empty() {
            return f64::INFINITY;
        }
        let passed_s = travel_time(1.0 / self.highest_order, w.abs(), acceleration);
        let swung_s = 0.25 * (inertia / (self.steepest * torque.abs())).sqrt();
        passed_s.min(swung_s).max(0.25 * FASTEST_S)
    }
}

/// All of them together.
#[derive(Debug, Clone)]
pub struct PositionTorque {
    /// Cogging, then gravity as order one.
    harmonics: Vec<Harmonic>,
    spring_stiffness: f64,
    /// Largest slope of torque over position, N m/rad.
    steepest: f64,
    highest_order: f64,
    /// Largest torque of the harmonics, N m.
    amplitude: f64,
}

impl PositionTorque {
    /// From a validated model.
    pub fn new(model: &Model) -> Self {
        let gravity = model.gravity.map(|gravity| Harmonic {
            amplitude: -gravity.amplitude,
            order: 1.0,
            phase_rad: gravity.phase_rad,
        });
        let harmonics: Vec<Harmonic> = model.cogging.iter().copied().chain(gravity).collect();
        let slope: f64 = harmonics.iter().map(|h| h.amplitude.abs() * h.order).sum();
        Self {
            steepest: slope + model.spring_stiffness,
            highest_order: harmonics.iter().map(|h| h.order).fold(0.0, f64::max),
            amplitude: harmonics.iter().map(|h| h.amplitude.abs()).sum(),
            spring_stiffness: model.spring_stiffness,
            harmonics,
        }
    }

    /// Torque at a position, N m (N).
    #[inline]
    pub fn torque(&self, position: f64) -> f64 {
        let mut torque = -self.spring_stiffness * position;
        for harmonic in &self.harmonics {
            torque += harmonic.at(position);
        }
        torque
    }

    /// Slope of the torque at a position, N m/rad (N/m).
    #[inline]
    pub fn slope(&self, position: f64) -> f64 {
        self.harmonics.iter().map(|harmonic| harmonic.slope(position)).sum::<f64>() - self.spring_stiffness
    }

    /// Largest torque near a position, N m (N).
    pub(crate) fn bound(&self, position: f64) -> f64 {
        self.amplitude + self.spring_stiffness * position.abs()
    }

    /// Inertia below which the spring would be faster than [`FASTEST_S`], kg m2 (kg).
    pub(crate) fn least_inertia(&self) -> f64 {
        self.spring_stiffness * FASTEST_S * FASTEST_S
    }

    /// Longest step over which the torque is smooth, s. Waves that are passed or swung in faster than [`FASTEST_S`] are bounded
    /// and have no time to move the rotor; they set no step.
    pub(crate) fn longest_step(&self, w: f64, acceleration: f64, inertia: f64) -> f64 {
        let mut step = f64::INFINITY;
        if self.steepest > 0.0 {
            step = 0.25 * (inertia / self.steepest).sqrt();
        }
        if self.highest_order > 0.0 {
            step = step.min(travel_time(1.0 / self.highest_order, w.abs(), acceleration));
        }
        step.max(0.25 * FASTEST_S)
    }
}
