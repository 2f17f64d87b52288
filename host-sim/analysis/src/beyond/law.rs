//! The modes: what they replace of the flashed law's commands, tick by tick.

use er_servo::{Config, ConfigError, Counts, Outputs, Params, Supervisor, field_for_damping_kv_mm};

use super::model::{LAG_S, Motion, Observer, field_kv_mm, torque_nm};
use crate::paper::case::COULOMB_NM;

/// What a mode has of the control beyond the paper's; all off is the flashed law itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// In tables.
    pub name: &'static str,
    /// On the command line and in recordings.
    pub key: &'static str,
    /// The field is asked for the state at which it acts, and its lag inverted.
    pub leads: bool,
    /// The PD law takes the state at which its torque acts.
    pub predicts: bool,
    /// A torque over speed without jump and without null at rest.
    pub smooth: bool,
    /// A brake that grows and fades.
    pub steady_brake: bool,
    /// Both gains times this.
    pub gains: f64,
}

/// The lag is inverted so that the wanted field is there after this, s: two periods. At once would take six times the
/// field's change, and the counts' noise with it.
const REACHED_S: f64 = 0.001;
/// Largest torque of the smooth damper, N m: about that of (5) at its peak, 0.119 rad/s.
const DAMPER_NM: f64 = 2.2;
/// Speed over which it grows from rest where dry friction does not hold the rotor, rad/s: half that of the peak of (5).
const GROWS_RAD_S: f64 = 0.06;
/// Speed away from the reference at which the steady brake is whole, rad/s: two counts a sample.
const WHOLE_RAD_S: f64 = 0.0511;
/// Time over which it fades, s: the fluid's own; less it could not follow.
const FADES_S: f64 = 0.005;

impl Mode {
    /// The flashed law as it is.
    pub const PAPER: Self = Self {
        name: "the paper's law",
        key: "paper",
        leads: false,
        predicts: false,
        smooth: false,
        steady_brake: false,
        gains: 1.0,
    };

    /// How many things it has beyond the paper's law.
    #[must_use]
    pub fn parts(&self) -> usize {
        let parts = [self.leads, self.predicts, self.smooth, self.steady_brake, self.gains != 1.0];
        parts.iter().filter(|part| **part).count()
    }

    /// Whether it has all that `other` has beyond the paper's law.
    #[must_use]
    pub fn has(&self, other: &Self) -> bool {
        (self.leads || !other.leads)
            && (self.predicts || !other.predicts)
            && (self.smooth || !other.smooth)
            && (self.steady_brake || !other.steady_brake)
            && (other.gains == 1.0 || self.gains == other.gains)
    }

    /// Parameters of the flashed law under this mode.
    #[must_use]
    pub fn config(&self, config: &Config) -> Config {
        let gains = self.gains as f32;
        Config {
            kp_nm_rad: config.kp_nm_rad * gains,
            kd_nm_s_rad: config.kd_nm_s_rad * gains,
            // The motor answers up to this late when the delay is off.
            stale_time_s: 0.1,
            ..*config
        }
    }
}

/// A mode while it runs.
#[derive(Debug)]
pub(super) struct Beside {
    mode: Mode,
    config: Config,
    params: Params,
    observer: Observer,
    /// Share of the steady brake, 0 to 1.
    brake: f64,
}

impl Beside {
    pub(super) fn new(mode: Mode, config: &Config) -> Result<Self, ConfigError> {
        let (params, observer) = (Params::new(config)?, Observer::new(config));
        Ok(Self { mode, config: *config, params, observer, brake: 0.0 })
    }

    /// Replaces the commands of one period.
    pub(super) fn tick(&mut self, reference: Counts, outputs: &mut Outputs) {
        let Mode { name, key, gains, .. } = self.mode;
        if self.mode == (Mode { name, key, gains, ..Mode::PAPER }) || outputs.supervisor != Supervisor::Running {
            return;
        }
        self.observer.correct(outputs.position.to_rad());
        let ahead = self.observer.ahead();
        let reference = reference.to_rad();
        if self.mode.predicts {
            let (k_p, k_d) = (f64::from(self.config.kp_nm_rad), f64::from(self.config.kd_nm_s_rad));
            let limit = f64::from(self.config.torque_limit_nm);
            let wanted =
                k_p * (reference - ahead.at_torque.position) - k_d * ahead.at_torque.speed - self.observer.outside();
            outputs.torque_nm = wanted.clamp(-limit, limit) as f32;
        }
        let measured = Motion { position: outputs.position.to_rad(), speed: f64::from(outputs.speed_rad_s) };
        let seen = if self.mode.leads { ahead.at_field } else { measured };
        let wanted = self.field_kv_mm(reference - seen.position, seen.speed);
        let limit = f64::from(self.config.field_limit_kv_mm);
        let asked = if self.mode.leads {
            let keep = (-REACHED_S / LAG_S).exp();
            (wanted - keep * ahead.acting_kv_mm) / (1.0 - keep)
        } else {
            wanted
        };
        outputs.field_kv_mm = asked.clamp(0.0, limit) as f32;
        self.observer.command(f64::from(outputs.torque_nm), f64::from(outputs.field_kv_mm));
    }

    /// The field for an error, rad, and a speed, rad/s: Fig. 7 with the parts of the mode in place of its own.
    fn field_kv_mm(&mut self, error: f64, speed: f64) -> f64 {
        if speed.abs() > f64::from(self.config.off_speed_rad_s) {
            self.brake = 0.0;
            return 0.0;
        }
        let near = error.abs() < f64::from(self.config.near_rad);
        let away = -error.signum() * speed;
        let braking = torque_nm(f64::from(self.config.brake_field_kv_mm));
        let damping = if self.mode.smooth {
            self.smooth_nm(error, speed)
        } else {
            torque_nm(f64::from(field_for_damping_kv_mm(&self.params, speed as f32)))
        };
        if self.mode.steady_brake {
            let fades = (-f64::from(self.config.period_s) / FADES_S).exp();
            let now = if near { (away / WHOLE_RAD_S).clamp(0.0, 1.0) } else { 0.0 };
            self.brake = now.max(self.brake * fades);
            return field_kv_mm(damping.max(self.brake * braking));
        }
        if near && away > f64::from(self.config.brake_deadband_rad_s) {
            return f64::from(self.config.brake_field_kv_mm);
        }
        field_kv_mm(damping)
    }

    /// A damper's torque, N m, that is nothing from 1.5 rad/s on and has no jump there. At rest it is whole where dry friction
    /// holds the rotor already, and grows with the speed elsewhere, so that the rotor can come nearer.
    fn smooth_nm(&self, error: f64, speed: f64) -> f64 {
        let share = speed / f64::from(self.config.off_speed_rad_s);
        let falls = (1.0 - share * share).max(0.0).powi(2);
        let held_rad = COULOMB_NM / f64::from(self.config.kp_nm_rad);
        // Over the last fifth of what friction holds, so that nothing jumps there either.
        let held = ((held_rad - error.abs()) / (0.2 * held_rad)).clamp(0.0, 1.0);
        DAMPER_NM * falls * (speed.abs() / GROWS_RAD_S).max(held).min(1.0)
    }
}
