//! Which experiments, with which parameters of the law.

use er_servo::experiment::{Experiment, Shape};
use er_servo::{Config, FIELD_CEILING_KV_MM};

use crate::Error;

/// How far and how hard the axis may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Travel, rad: ramps run from where the axis stands to so far in the positive direction, the others to and fro by at most a
    /// third of it.
    pub travel_rad: f32,
    /// Greatest torque, whole N m; 0 for no bound but the parameter's.
    pub max_torque_nm: u8,
}

/// What an experiment is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Purpose {
    /// Torque at constant speed under a constant field.
    Steady {
        /// Of the reference, rad/s.
        speed_rad_s: f64,
        /// kV/mm.
        field_kv_mm: f64,
    },
    /// Inertia and delay of the motor.
    Motion,
    /// Times of the field.
    FieldSteps,
}

/// One experiment.
#[derive(Debug, Clone)]
pub struct Planned {
    /// As the file of its recording is called.
    pub name: String,
    /// What it is for.
    pub purpose: Purpose,
    /// Parameters of the law that differ.
    pub parameters: Vec<(&'static str, f32)>,
    /// What the reference does.
    pub experiment: Experiment,
}

/// The recording of [`Purpose::Motion`].
pub(super) const MOTION: &str = "motion.csv";
/// The recording of [`Purpose::FieldSteps`].
pub(super) const FIELD_STEPS: &str = "field-steps.csv";
/// Speeds of the friction sweep, as shares of the travel a second.
const FRICTION_SPEEDS: [f32; 4] = [0.1, 0.25, 0.5, 1.0];
/// Highest speed under a field, as a share of the travel a second, and at most, rad/s: the law of the fluid is a fit over
/// 0.1 to 0.5 rad/s (control specification, section 2).
const FIELD_SPEED: (f32, f32) = (0.5, 0.5);
/// Field, as a share of the field limit, and speed, as a share of that speed: a sweep of the field at one speed, and one of the
/// speed at the highest field, for the fluid's torque may depend on it.
const FIELDS: [(f32, f32); 7] = [(0.2, 0.6), (0.4, 0.6), (0.6, 0.6), (0.8, 0.6), (1.0, 0.3), (1.0, 0.6), (1.0, 1.0)];
/// Least field limit, kV/mm: a fifth of it is still three steps of the fluid's torque over what the sensor resolves.
const LEAST_FIELD_KV_MM: f32 = 0.5;
/// Passes of each ramp: to and fro.
const PASSES: f32 = 2.0;
/// Longest time of a pass, s: slow ramps end before the whole travel.
const LONGEST_PASS_S: f32 = 5.0;
/// Exponent of a law that wants more than any limit: 100 N m s/rad, with the weakest fluid there is.
const SATURATED: [(&str, f32); 5] =
    [("er_q0", 4.6), ("er_q1_s_rad", 0.0), ("er_q2_s2_rad2", 0.0), ("er_a", 1e-3), ("er_b", 0.0)];
/// The field of the steps goes off above this, rad/s.
const STEP_SPEED_RAD_S: f32 = 0.5;
/// Duration of the two multisines, s: at 2 kHz some 16,000 rows, which a likelihood fits within seconds.
const MULTISINE_S: f32 = 8.0;

impl Plan {
    /// The experiments, in order; each stays within the position, speed and field limits of the law as it is.
    ///
    /// # Errors
    /// [`Error::Usage`] where the law may not command a field, or hardly one.
    pub fn runs(&self, before: &Config) -> Result<Vec<Planned>, Error> {
        let limit = before.field_limit_kv_mm.min(FIELD_CEILING_KV_MM);
        if !before.er_enabled || limit < LEAST_FIELD_KV_MM {
            return Err(Error::Usage(format!(
                "er_enabled is {} and field_limit_kv_mm {limit}: the law of the fluid is measured with a field, \
                 {LEAST_FIELD_KV_MM} kV/mm at least must be allowed",
                before.er_enabled
            )));
        }
        let mut runs: Vec<Planned> =
            FRICTION_SPEEDS.iter().map(|share| self.ramp(share * self.travel_rad, 0.0)).collect();
        let fastest = (FIELD_SPEED.0 * self.travel_rad).min(FIELD_SPEED.1);
        runs.extend(FIELDS.iter().map(|(share, speed)| self.ramp(speed * fastest, share * limit)));
        runs.push(Planned {
            name: MOTION.to_owned(),
            purpose: Purpose::Motion,
            parameters: parameters(0.0, 1.5),
            experiment: self.multisine(12.0, 0.5),
        });
        runs.push(Planned {
            name: FIELD_STEPS.to_owned(),
            purpose: Purpose::FieldSteps,
            parameters: parameters(limit, STEP_SPEED_RAD_S),
            experiment: self.multisine(6.0, 1.0),
        });
        Ok(runs)
    }

    /// How far the axis moves up and down from where it stands, rad.
    pub fn room_rad(&self) -> (f32, f32) {
        (self.travel_rad, self.travel_rad / 3.0)
    }

    /// How long the axis moves, s.
    pub fn duration_s(runs: &[Planned]) -> f32 {
        runs.iter().map(|run| run.experiment.duration_s).sum()
    }

    fn ramp(&self, speed_rad_s: f32, field_kv_mm: f32) -> Planned {
        let travel_rad = self.travel_rad.min(LONGEST_PASS_S * speed_rad_s);
        Planned {
            name: format!("ramp-{speed_rad_s:.3}rad_s-{field_kv_mm:.2}kv_mm.csv"),
            purpose: Purpose::Steady { speed_rad_s: speed_rad_s.into(), field_kv_mm: field_kv_mm.into() },
            parameters: parameters(field_kv_mm, 1.5),
            experiment: Experiment {
                shape: Shape::Ramp { speed_rad_s, travel_rad },
                duration_s: PASSES * travel_rad / speed_rad_s,
            },
        }
    }

    fn multisine(&self, high_hz: f32, share: f32) -> Experiment {
        // The sum is shifted to begin at 0, so that it reaches twice its amplitude at most.
        let amplitude_rad = share * self.travel_rad / 6.0;
        let shape = Shape::Multisine { amplitude_rad, low_hz: 0.5, high_hz, tones: 12 };
        Experiment { shape, duration_s: MULTISINE_S }
    }
}

/// A law whose field is constant while the axis moves slower than `off_speed_rad_s`.
fn parameters(field_kv_mm: f32, off_speed_rad_s: f32) -> Vec<(&'static str, f32)> {
    let on = if field_kv_mm > 0.0 { 1.0 } else { 0.0 };
    let mut parameters = vec![
        ("er_enabled", on),
        ("near_rad", 0.0),
        ("hold", 0.0),
        ("off_speed_rad_s", off_speed_rad_s),
        ("field_limit_kv_mm", field_kv_mm),
    ];
    parameters.extend(SATURATED);
    parameters
}
