//! From commanded to acting torque.

use crate::delay::{DeadTime, Lag, Play};
use crate::physics;

#[derive(Debug, Clone)]
pub(crate) struct Drive {
    law: physics::Drive,
    play: Option<(f64, Play)>,
    dead_time: DeadTime,
    lag: Lag,
}

impl Drive {
    pub(crate) fn new(law: &physics::Drive, step_s: f64) -> Self {
        let initial = law.offset_nm.clamp(-law.limit_nm, law.limit_nm);
        Self {
            law: law.clone(),
            play: law.memory.map(|(share, half_width)| (share, Play::new(half_width, initial))),
            dead_time: DeadTime::new(law.delay_s, step_s, initial),
            lag: Lag::new(law.lag_s, law.lag_s, step_s, initial),
        }
    }

    /// Acting torque in the middle of a step with this command at an angle, N m.
    pub(crate) fn pass(&mut self, command_nm: f64, position_rad: f64) -> f64 {
        let law = &self.law;
        let past_deadband = command_nm.signum() * (command_nm.abs() - law.deadband_nm).max(0.0);
        let mut torque_nm = law.gain * past_deadband + law.offset_nm;
        if let Some((share, play)) = &mut self.play {
            torque_nm += *share * (play.pass(torque_nm) - torque_nm);
        }
        if let Some(level) = law.saturation_nm {
            torque_nm = level * (torque_nm / level).tanh();
        }
        let gain = 1.0 + law.ripple.iter().map(|wave| wave.at(position_rad)).sum::<f64>();
        gain * self.lag.pass(self.dead_time.pass(torque_nm.clamp(-law.limit_nm, law.limit_nm)))
    }
}
