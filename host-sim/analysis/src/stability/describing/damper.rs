//! The damper's torque over one swing, and its first harmonic.

use er_servo::{Config, ConfigError, Params};
use std::f64::consts::PI;

/// A harmonic motion A sin(wt) of the angle about the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Swing {
    /// A, rad, above 0.
    pub amplitude_rad: f64,
    /// w, rad/s, above 0.
    pub frequency_rad_s: f64,
}

impl Swing {
    /// Amplitude of the speed, rad/s.
    #[must_use]
    pub fn speed_rad_s(self) -> f64 {
        self.amplitude_rad * self.frequency_rad_s
    }
}

/// What the fluid delays, section 5 of the specification; a dead time, a lag, or one after the other.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DamperDelay {
    /// The field: the torque is a E^2 + b E of the late field.
    Field {
        /// Dead time, s.
        dead_time_s: f64,
        /// Time constant, s.
        lag_s: f64,
    },
    /// The coefficient of viscosity: the torque is the late Q times the speed now. The brake's torque is late too, in a
    /// channel of its own.
    Viscosity {
        /// Dead time, s.
        dead_time_s: f64,
        /// Time constant, s.
        lag_s: f64,
        /// Q times the speed is at most what the highest field gives, as a fluid can; false as (6) and (7) are printed.
        bounded: bool,
    },
}

impl DamperDelay {
    /// No delay.
    pub const NONE: Self = Self::Field { dead_time_s: 0.0, lag_s: 0.0 };

    /// The same with more dead time, s.
    #[must_use]
    pub fn later_by(self, more_s: f64) -> Self {
        match self {
            Self::Field { dead_time_s, lag_s } => Self::Field { dead_time_s: dead_time_s + more_s, lag_s },
            Self::Viscosity { dead_time_s, lag_s, bounded } => {
                Self::Viscosity { dead_time_s: dead_time_s + more_s, lag_s, bounded }
            }
        }
    }

    fn dead_time_and_lag_s(self) -> (f64, f64) {
        match self {
            Self::Field { dead_time_s, lag_s } | Self::Viscosity { dead_time_s, lag_s, .. } => (dead_time_s, lag_s),
        }
    }
}

/// First harmonic of a torque that opposes the motion, N m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TorqueHarmonic {
    /// In phase with the speed: damping. Never negative.
    pub with_speed_nm: f64,
    /// In phase with the angle: stiffness.
    pub with_angle_nm: f64,
}

/// The damper under the control law, with a delay.
#[derive(Debug, Clone)]
pub struct Damper {
    config: Config,
    params: Params,
    delay: DamperDelay,
}

/// Samples over half a swing; the other half repeats them.
const SAMPLES: usize = 256;

/// What the law commands at one instant.
#[derive(Debug, Clone, Copy, Default)]
struct Order {
    /// kV/mm.
    field: f64,
    /// Viscosity while damping, N m s/rad.
    viscosity: f64,
    /// Torque while braking, N m.
    brake_nm: f64,
}

impl Damper {
    /// The damper with the law's parameters.
    ///
    /// # Errors
    /// What the control library finds wrong with `config`.
    pub fn new(config: &Config, delay: DamperDelay) -> Result<Self, ConfigError> {
        Ok(Self { config: *config, params: Params::new(config)?, delay })
    }

    /// The first harmonic of the torque over a swing.
    #[must_use]
    pub fn first_harmonic(&self, swing: Swing) -> TorqueHarmonic {
        let (dead_time_s, lag_s) = self.delay.dead_time_and_lag_s();
        let late = swing.frequency_rad_s * dead_time_s;
        let delayed = |of: fn(&Order) -> f64| {
            let orders = (0..SAMPLES).map(|k| of(&self.order(swing, phase(k) - late)));
            lagged(orders.collect(), swing.frequency_rad_s * lag_s)
        };
        match self.delay {
            DamperDelay::Field { .. } => {
                let field = delayed(|order| order.field);
                first_harmonic(|k, _| self.torque_nm(field[k]))
            }
            DamperDelay::Viscosity { bounded, .. } => {
                let (viscosity, brake_nm) = (delayed(|order| order.viscosity), delayed(|order| order.brake_nm));
                let most_nm = if bounded { self.torque_nm(plant::HIGHEST_FIELD_KV_MM) } else { f64::INFINITY };
                first_harmonic(|k, cos| (viscosity[k] * swing.speed_rad_s() * cos.abs()).min(most_nm) + brake_nm[k])
            }
        }
    }

    /// The law at a phase of the swing: mode logic of Fig. 7, then (4) and (5) or the brake's field.
    fn order(&self, swing: Swing, phase: f64) -> Order {
        let (sin, cos) = phase.sin_cos();
        let (angle, speed) = (swing.amplitude_rad * sin, swing.speed_rad_s() * cos);
        let config = &self.config;
        if speed.abs() > f64::from(config.off_speed_rad_s) {
            return Order::default();
        }
        let moving_away = angle * speed > 0.0 && speed.abs() > f64::from(config.brake_deadband_rad_s);
        let limit = f64::from(config.field_limit_kv_mm);
        if moving_away && angle.abs() < f64::from(config.near_rad) {
            let field = f64::from(config.brake_field_kv_mm).min(limit);
            return Order { field, viscosity: 0.0, brake_nm: self.torque_nm(field) };
        }
        // The library computes in single precision, as the firmware does.
        #[allow(clippy::cast_possible_truncation)]
        let single = speed.abs() as f32;
        let field = f64::from(er_servo::field_for_damping_kv_mm(&self.params, single)).min(limit);
        let viscosity = f64::from(self.params.viscosity_nm_s_rad(single));
        Order { field, viscosity, brake_nm: 0.0 }
    }

    /// a E^2 + b E, equation (2) without its zero-field drag, which is the friction's.
    fn torque_nm(&self, field_kv_mm: f64) -> f64 {
        (f64::from(self.config.er_a) * field_kv_mm + f64::from(self.config.er_b)) * field_kv_mm
    }
}

/// Phase of a sample, rad, in the middle of its share of half a swing.
fn phase(k: usize) -> f64 {
    // Exact for every index.
    #[allow(clippy::cast_precision_loss)]
    let share = (k as f64 + 0.5) / SAMPLES as f64;
    share * PI
}

/// A first-order lag of `lag_rad` (w T) on an order that repeats every half swing and is constant over each sample;
/// exact for that, seen at the middle of the sample.
fn lagged(order: Vec<f64>, lag_rad: f64) -> Vec<f64> {
    if lag_rad == 0.0 {
        return order;
    }
    let share = phase(0) * 2.0 / lag_rad;
    let (whole, half) = ((-share).exp(), (-0.5 * share).exp());
    // What is left of zero after half a swing, closed onto itself.
    let once = order.iter().fold(0.0, |state, input| input + (state - input) * whole);
    let left = (-PI / lag_rad).exp();
    let mut state = once / (1.0 - left);
    order
        .into_iter()
        .map(|input| {
            let middle = input + (state - input) * half;
            state = input + (state - input) * whole;
            middle
        })
        .collect()
}

/// First harmonic of a torque of this size that opposes the motion, from its size at each sample and the cosine of the
/// phase there.
fn first_harmonic(size_nm: impl Fn(usize, f64) -> f64) -> TorqueHarmonic {
    let mut harmonic = TorqueHarmonic::default();
    #[allow(clippy::cast_precision_loss)]
    let weight = 2.0 / SAMPLES as f64;
    for k in 0..SAMPLES {
        let (sin, cos) = phase(k).sin_cos();
        let torque_nm = size_nm(k, cos) * cos.signum();
        harmonic.with_speed_nm += weight * torque_nm * cos;
        harmonic.with_angle_nm += weight * torque_nm * sin;
    }
    harmonic
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn damper(delay: DamperDelay) -> Damper {
        let config = Config { brake_deadband_rad_s: 0.0, ..Config::default() };
        Damper::new(&config, delay).unwrap()
    }

    #[test]
    fn a_relay_has_four_over_pi() {
        let relay = first_harmonic(|_, _| 2.0);
        assert!((relay.with_speed_nm - 8.0 / PI).abs() < 1e-4 && relay.with_angle_nm.abs() < 1e-12);
    }

    #[test]
    fn a_late_size_of_a_constant_viscosity_has_its_closed_form() {
        // |cos(p - d)| sgn(cos p): with the speed (2/pi)(sin d + (pi/2 - d) cos d).
        for d in [0.0, 0.3, 1.0, FRAC_PI_2] {
            let late = first_harmonic(|k, _| (phase(k) - d).cos().abs());
            let exact = (d.sin() + (FRAC_PI_2 - d) * d.cos()) / FRAC_PI_2;
            assert!((late.with_speed_nm - exact).abs() < 1e-4, "{d}: {late:?}, {exact}");
        }
    }

    #[test]
    fn a_lag_repeats_and_keeps_the_mean() {
        let square: Vec<f64> = (0..SAMPLES).map(|k| f64::from(u8::from(k < SAMPLES / 4))).collect();
        for lag_rad in [1e-3, 0.3, 5.0] {
            let out = lagged(square.clone(), lag_rad);
            let mean = out.iter().sum::<f64>() / SAMPLES as f64;
            assert!((mean - 0.25).abs() < 2e-3, "{lag_rad}: {mean}");
        }
        assert!(lagged(square, 50.0).iter().all(|v| (v - 0.25).abs() < 0.02));
    }

    #[test]
    fn without_delay_the_law_is_a_viscosity_outside_the_brake() {
        // Equation (4) inverts (2), so the torque is Q(w) w: no stiffness, and both channels alike.
        let config = Config { near_rad: 0.0, ..Config::default() };
        let swing = Swing { amplitude_rad: 0.1, frequency_rad_s: 10.0 };
        let nothing = DamperDelay::Viscosity { dead_time_s: 0.0, lag_s: 0.0, bounded: true };
        let [field, viscosity] =
            [DamperDelay::NONE, nothing].map(|delay| Damper::new(&config, delay).unwrap().first_harmonic(swing));
        assert!((field.with_speed_nm / viscosity.with_speed_nm - 1.0).abs() < 1e-4);
        assert!(field.with_angle_nm.abs() < 1e-6 * field.with_speed_nm);
    }

    #[test]
    fn the_brake_adds_stiffness_and_a_delay_turns_it() {
        let swing = Swing { amplitude_rad: 0.01, frequency_rad_s: 50.0 };
        let at_once = damper(DamperDelay::NONE).first_harmonic(swing);
        assert!(at_once.with_angle_nm > 0.0);
        let late = damper(DamperDelay::Field { dead_time_s: 0.01, lag_s: 0.0 }).first_harmonic(swing);
        assert!(late.with_angle_nm < at_once.with_angle_nm);
    }

    #[test]
    fn no_delay_makes_the_damper_push() {
        for delay_s in [0.0, 0.002, 0.005, 0.02, 0.05] {
            for (dead_time_s, lag_s) in [(delay_s, 0.0), (0.0, delay_s), (0.4 * delay_s, 0.6 * delay_s)] {
                let viscosity = |bounded| DamperDelay::Viscosity { dead_time_s, lag_s, bounded };
                for delay in [DamperDelay::Field { dead_time_s, lag_s }, viscosity(true), viscosity(false)] {
                    for (a, w) in [(1e-3, 20.0), (5e-3, 100.0), (0.01, 300.0), (0.3, 30.0)] {
                        let swing = Swing { amplitude_rad: a, frequency_rad_s: w };
                        assert!(damper(delay).first_harmonic(swing).with_speed_nm >= 0.0);
                    }
                }
            }
        }
    }
}
