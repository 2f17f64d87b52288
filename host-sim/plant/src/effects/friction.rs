//! Friction as a function of speed and direction: `coulomb_friction`, `viscous_friction`, `stribeck_friction`,
//! `friction_asymmetry`, `quadratic_drag`; and of the load: `load_dependent_friction`; and dry friction as a bristle:
//! `presliding`.

use crate::model::{check, finite, not_negative, positive};
use crate::{Error, Model};

/// Friction over the Coulomb level near standstill: excess exp(-(w / velocity)^2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    /// Excess at standstill, N m (N), not negative.
    pub excess: f64,
    /// Speed at which 37 % of it is left, rad/s (m/s), above 0.
    pub velocity: f64,
}

/// What friction has more of in the positive than in the negative direction; the mean is the nominal value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Asymmetry {
    /// Of the Coulomb level, N m (N); at most twice that level either way.
    pub coulomb: f64,
    /// Of the viscous coefficient, N m s/rad (N s/m); at most twice that coefficient either way.
    pub viscous: f64,
}

/// Checks the friction of a model.
pub(crate) fn validate(model: &Model) -> Result<(), Error> {
    not_negative("coulomb", model.coulomb)?;
    not_negative("viscous", model.viscous)?;
    not_negative("quadratic_drag", model.quadratic_drag)?;
    let pairs = [
        ("friction_asymmetry.coulomb", model.asymmetry.coulomb, model.coulomb),
        ("friction_asymmetry.viscous", model.asymmetry.viscous, model.viscous),
    ];
    for (key, difference, mean) in pairs {
        finite(key, difference)?;
        check(key, difference, difference.abs() <= 2.0 * mean, "at most twice the mean, or friction would drive")?;
    }
    if let Some(stribeck) = model.stribeck {
        not_negative("stribeck_friction.excess", stribeck.excess)?;
        positive("stribeck_friction.velocity", stribeck.velocity)?;
    }
    let (per_load, bristle) = (model.load_friction, model.presliding_stiffness);
    let key = "load_dependent_friction.coefficient";
    check(key, per_load, (0.0..1.0).contains(&per_load), "0 or above and below 1, or no torque would move the rotor")?;
    let carried = per_load == 0.0 || bristle.is_none() || model.coulomb > 0.0;
    check(key, per_load, carried, "0 for a bristle without a Coulomb level, which it scales")?;
    model.viscous_warming.map_or(Ok(()), |warming| warming.validate("temperature_viscosity"))?;
    bristle.map_or(Ok(()), |stiffness| positive("presliding.stiffness", stiffness))
}

/// The fastest time constant that is followed, s, a tenth of the fastest sampling: what is faster has settled long before the
/// next sample. Laws without a closed form that are stiffer against the inertia get as much inertia, or as little
/// stiffness, as makes them that fast, so that the cost of a second does not depend on them.
pub(crate) const FASTEST_S: f64 = 5e-5;
/// A bristle that bends less than this, rad (m), may bend as much: it is less than a step of a usual sensor.
const UNSEEN: f64 = 1e-5;

/// The stiffness of a bristle with that level that is followed on an inertia: one whose bending is seen keeps it.
pub(crate) fn followed(stiffness: f64, level: f64, inertia: f64) -> f64 {
    stiffness.min((inertia / (FASTEST_S * FASTEST_S)).max(level / UNSEEN))
}

/// Beyond this many times its velocity less than 1e-21 of a Stribeck excess is left.
const BEYOND: f64 = 7.0;

/// Friction levels by direction, index 0 forward and 1 backward.
#[derive(Debug, Clone, Copy)]
pub struct Friction {
    coulomb: [f64; 2],
    /// Dry drag for each N m of the drive's torque, 1.
    per_load: f64,
    viscous: [f64; 2],
    stribeck: Stribeck,
    /// One over the Stribeck velocity, s/rad.
    per_velocity: f64,
    quadratic: f64,
    /// Speed beyond which the quadratic drag goes on along its slope, rad/s.
    quadratic_until: f64,
    /// Bristle stiffness of the dry part; none for set-valued friction.
    stiffness: Option<f64>,
}

impl Friction {
    /// From a validated model.
    pub fn new(model: &Model) -> Self {
        let by_direction = |mean: f64, difference: f64| [mean + 0.5 * difference, mean - 0.5 * difference];
        let stribeck = model.stribeck.unwrap_or(Stribeck { excess: 0.0, velocity: 1.0 });
        Self {
            coulomb: by_direction(model.coulomb, model.asymmetry.coulomb),
            per_load: model.load_friction,
            viscous: by_direction(model.viscous, model.asymmetry.viscous),
            stribeck,
            per_velocity: stribeck.velocity.recip(),
            quadratic: model.quadratic_drag,
            quadratic_until: 0.5 * model.inertia / (FASTEST_S * model.quadratic_drag),
            stiffness: model.presliding_stiffness.map(|stiffness| followed(stiffness, model.coulomb, model.inertia)),
        }
    }

    /// Inertia below which a law would be faster than [`FASTEST_S`], kg m2 (kg).
    pub(crate) fn least_inertia(&self) -> f64 {
        let viscous = self.viscous[0].max(self.viscous[1]);
        (viscous * FASTEST_S).max(self.stiffness.unwrap_or(0.0) * FASTEST_S * FASTEST_S)
    }

    /// Quadratic drag against motion of that sign, N m, and its slope, N m s/rad.
    #[inline]
    fn quadratic(&self, sign: f64, w: f64) -> (f64, f64) {
        let (speed, until) = (w.abs(), self.quadratic_until);
        let within = speed.min(until);
        let slope = 2.0 * self.quadratic * within;
        (sign * (self.quadratic * within * within + slope * (speed - within)), slope)
    }

    /// Coulomb level against motion of that sign, N m.
    #[inline]
    pub fn coulomb(&self, sign: f64) -> f64 {
        self.coulomb[usize::from(sign < 0.0)]
    }

    /// Viscous coefficient against motion of that sign, N m s/rad.
    #[inline]
    pub fn viscous(&self, sign: f64) -> f64 {
        self.viscous[usize::from(sign < 0.0)]
    }

    /// Whether the dry part is a bristle, which never holds by itself.
    pub(crate) fn is_bristle(&self) -> bool {
        self.stiffness.is_some()
    }

    /// Dry drag that a torque of the drive adds to the Coulomb level, N m.
    #[inline]
    pub fn of_load(&self, drive_torque: f64) -> f64 {
        self.per_load * drive_torque.abs()
    }

    /// Whether the drag depends on the drive's torque.
    pub(crate) fn follows_load(&self) -> bool {
        self.per_load != 0.0
    }

    /// Largest dry drag that holds at standstill against a push of that sign with that torque of the drive, N m.
    pub(crate) fn hold(&self, sign: f64, drive_torque: f64) -> f64 {
        if self.is_bristle() { 0.0 } else { self.coulomb(sign) + self.stribeck.excess + self.of_load(drive_torque) }
    }

    /// What dry friction has over its Coulomb level at that speed (Stribeck), N m.
    #[inline]
    pub fn excess(&self, w: f64) -> f64 {
        let ratio = w * self.per_velocity;
        if self.stribeck.excess == 0.0 || ratio.abs() > BEYOND {
            0.0
        } else {
            self.stribeck.excess * (-ratio * ratio).exp()
        }
    }

    /// Coefficient of w |w|, N m s2/rad2.
    pub fn quadratic_coefficient(&self) -> f64 {
        self.quadratic
    }

    /// Stiffness of the bristle, N m/rad; none for set-valued friction.
    pub fn stiffness(&self) -> Option<f64> {
        self.stiffness
    }

    /// Drag torque, signed like the motion, N m; `bristle` is the force of the bristle, used where there is one, `viscous_share`
    /// what warming has left of the viscous coefficient.
    #[inline]
    pub(crate) fn torque(&self, sign: f64, w: f64, bristle: f64, drive_torque: f64, viscous_share: f64) -> f64 {
        let mut torque = viscous_share * self.viscous(sign) * w;
        if self.quadratic != 0.0 {
            torque += self.quadratic(sign, w).0;
        }
        let excess = self.excess(w) + self.of_load(drive_torque);
        if self.stiffness.is_none() {
            torque += sign * (self.coulomb(sign) + excess);
        } else {
            // Excess and load scale the bristle's force, so that the force stays continuous at reversal.
            torque += bristle * (1.0 + excess / self.mean_coulomb().max(f64::MIN_POSITIVE));
        }
        torque
    }

    /// The bristle's force after `travel` (signed) from `bristle`: Dahl's rate-independent law
    /// df/dx = stiffness (1 - s f / level) in closed form.
    #[inline]
    pub fn bristle_after(&self, sign: f64, bristle: f64, travel: f64) -> f64 {
        let Some(stiffness) = self.stiffness else { return 0.0 };
        let level = self.coulomb(sign);
        if sign == 0.0 || level == 0.0 {
            return if sign == 0.0 { bristle } else { 0.0 };
        }
        sign * level + (bristle - sign * level) * (-stiffness * sign * travel / level).exp()
    }

    /// Longest step over which the laws are smooth, s, at speed `w` and an acceleration of at most `acceleration`.
    pub(crate) fn longest_step(&self, sign: f64, w: f64, bristle: f64, acceleration: f64, inertia: f64) -> f64 {
        let mut step = 0.25 * inertia / (self.viscous(sign) + self.quadratic(sign, w).1);
        if self.stribeck.excess > 0.0 {
            let beyond = w.abs() - BEYOND * self.stribeck.velocity;
            let slow = (0.5 * self.stribeck.velocity / acceleration)
                .min(0.5 * inertia * self.stribeck.velocity / self.stribeck.excess);
            step = step.min(slow.max(beyond / acceleration));
        }
        if let Some(stiffness) = self.stiffness {
            step = step.min(0.5 * (inertia / stiffness).sqrt());
            let level = self.coulomb(sign);
            if level > 0.0 && (bristle - sign * level).abs() > 1e-13 * level {
                step = step.min(travel_time(0.5 * level / stiffness, w.abs(), acceleration));
            }
        }
        step
    }

    fn mean_coulomb(&self) -> f64 {
        0.5 * (self.coulomb[0] + self.coulomb[1])
    }
}

/// Time in which no more than `distance` is travelled from speed `w` under at most `acceleration`, s.
pub(crate) fn travel_time(distance: f64, w: f64, acceleration: f64) -> f64 {
    2.0 * distance / (w + (w * w + 2.0 * acceleration * distance).sqrt())
}
