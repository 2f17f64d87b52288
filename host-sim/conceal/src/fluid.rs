//! The damper: from commanded field to drag.

use crate::delay::{DeadTime, Lag, Play};
use crate::physics::{self, FluidDelay};
use crate::rotor::Command;

/// Speed below which a commanded torque is no coefficient of viscosity, rad/s.
const SLOWEST_RAD_S: f64 = 0.002;

/// Drag of one step: a level that holds at rest, a coefficient times speed, and the level that coefficient may reach.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drag {
    pub(crate) level_nm: f64,
    pub(crate) viscosity_nm_s_rad: f64,
    pub(crate) viscous_limit_nm: f64,
}

#[derive(Debug, Clone)]
enum Channels {
    Field {
        dead_time: DeadTime,
        slewed_kv_mm: f64,
        lag: Lag,
    },
    /// Viscosity, then the torque of the brake, each with the delay.
    DeadTimes([DeadTime; 2]),
    Lags([Lag; 2]),
}

#[derive(Debug, Clone)]
struct Warmth {
    law: [f64; 4],
    heat: f64,
    felt: Play,
}

#[derive(Debug, Clone)]
pub(crate) struct Fluid {
    law: physics::Fluid,
    step_s: f64,
    channels: Channels,
    leaked: Option<(f64, Lag)>,
    warmth: Option<Warmth>,
}

impl Fluid {
    pub(crate) fn new(law: &physics::Fluid, step_s: f64) -> Self {
        let channels = match law.delay {
            FluidDelay::Field => Channels::Field {
                dead_time: DeadTime::new(law.dead_time_s, step_s, 0.0),
                slewed_kv_mm: 0.0,
                lag: Lag::new(law.rise_s, law.fall_s, step_s, 0.0),
            },
            FluidDelay::ViscosityDeadTime(dead_time_s) => {
                Channels::DeadTimes([0, 1].map(|_| DeadTime::new(dead_time_s, step_s, 0.0)))
            }
            FluidDelay::ViscosityLag(lag_s) => Channels::Lags([Lag::new(lag_s, lag_s, step_s, 0.0); 2]),
        };
        Self {
            step_s,
            channels,
            leaked: law.leakage.map(|(share, time_s)| (share, Lag::new(time_s, time_s, step_s, 0.0))),
            warmth: law.warmth.map(|law| Warmth { law, heat: 0.0, felt: Play::new(law[3], 0.0) }),
            law: law.clone(),
        }
    }

    /// a E^2 + b E, N m.
    fn torque_nm(&self, field_kv_mm: f64) -> f64 {
        (self.law.a * field_kv_mm + self.law.b) * field_kv_mm
    }

    /// Drag in the middle of the step that begins at `t_s`, with the rotor at `speed_rad_s`.
    pub(crate) fn pass(&mut self, command: &Command, t_s: f64, speed_rad_s: f64) -> Drag {
        let share = self.law.scale * (1.0 + self.law.drift_per_s * t_s).max(0.0) * self.cold_share();
        let commanded_nm = self.torque_nm(command.field_kv_mm * self.law.field_gain);
        let drag = match &mut self.channels {
            Channels::Field { dead_time, slewed_kv_mm, lag } => {
                let wanted = dead_time.pass(command.field_kv_mm);
                let most = self.law.slew_kv_mm_s.map_or(f64::INFINITY, |slew| slew * self.step_s);
                *slewed_kv_mm += (wanted - *slewed_kv_mm).clamp(-most, most);
                let mut field = lag.pass(*slewed_kv_mm) * self.law.field_gain;
                if let Some((share, leaked)) = &mut self.leaked {
                    field = (field - *share * leaked.pass(field)).max(0.0);
                }
                Drag { level_nm: share * self.torque_nm(field), viscosity_nm_s_rad: 0.0, viscous_limit_nm: 0.0 }
            }
            viscous => {
                let asked = commanded_nm / command.speed_rad_s.abs().max(SLOWEST_RAD_S);
                let viscosity = if command.braking { 0.0 } else { command.viscosity_nm_s_rad.unwrap_or(asked) };
                let brake_nm = if command.braking { commanded_nm } else { 0.0 };
                let [viscosity, brake_nm] = match viscous {
                    Channels::DeadTimes([of_viscosity, of_brake]) => {
                        [of_viscosity.pass(viscosity), of_brake.pass(brake_nm)]
                    }
                    Channels::Lags([of_viscosity, of_brake]) => [of_viscosity.pass(viscosity), of_brake.pass(brake_nm)],
                    Channels::Field { .. } => [0.0, 0.0],
                };
                // One gap has both: what brakes leaves so much to the viscosity.
                let limit_nm = (self.torque_nm(self.law.viscous_limit_kv_mm) - brake_nm).max(0.0);
                Drag {
                    level_nm: share * brake_nm,
                    viscosity_nm_s_rad: share * viscosity,
                    viscous_limit_nm: share * limit_nm,
                }
            }
        };
        self.heat(drag.level_nm, speed_rad_s);
        drag
    }

    fn cold_share(&mut self) -> f64 {
        self.warmth.as_mut().map_or(1.0, |warmth| {
            let felt = warmth.felt.pass(warmth.heat).max(0.0);
            1.0 - warmth.law[0] * (1.0 - (-felt).exp())
        })
    }

    fn heat(&mut self, drag_nm: f64, speed_rad_s: f64) {
        if let Some(Warmth { law: [_, energy_j, cooling_s, _], heat, .. }) = &mut self.warmth {
            *heat += self.step_s * (drag_nm * speed_rad_s.abs() / *energy_j - *heat / *cooling_s);
        }
    }
}
