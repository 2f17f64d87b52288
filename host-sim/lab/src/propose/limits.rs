//! What the machine may be put through.

use super::drive::law_of;
use crate::read::{Machine, Recording};

/// Bounds of an experiment; units of the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest speed, rad/s (m/s).
    pub speed: f64,
    /// Largest commanded torque, N m (N).
    pub torque: f64,
    /// From one end of the motion to the other, rad (m).
    pub travel: f64,
}

/// A machine whose trip speed is known is asked for no more than this share of it.
const OF_TRIP_SPEED: f64 = 0.5;

impl Limits {
    /// What the machine file states; where it states nothing, what the recordings have already shown to do no harm.
    ///
    /// The law that will run the experiment has the torque and the speed it trips at. A rotary axis under it may turn once
    /// around, as nothing in a machine file bounds its angle; any other axis keeps to the travel of its recordings.
    pub fn of(machine: &Machine, recordings: &[Recording]) -> Self {
        let shown =
            recordings.iter().map(Self::shown).fold(Self { speed: 0.0, torque: 0.0, travel: 0.0 }, Self::either);
        let Some(config) = law_of(machine) else {
            return Self { torque: shown.torque.min(machine.plant.torque_limit.unwrap_or(f64::INFINITY)), ..shown };
        };
        let stated = f64::from(config.torque_limit_nm).min(machine.plant.torque_limit.unwrap_or(f64::INFINITY));
        let speed = OF_TRIP_SPEED * f64::from(config.max_speed_rad_s);
        Self { speed: speed.max(shown.speed), torque: stated, travel: shown.travel.max(std::f64::consts::TAU) }
    }

    /// Ranges of one recording; the speed is taken over 10 ms, or the steps of the sensor would be speeds.
    fn shown(recording: &Recording) -> Self {
        let position = &recording.position;
        let rows = recording.t_s.partition_point(|t| *t < recording.t_s[0] + 0.01).max(1);
        let ends = recording.t_s.windows(rows + 1).zip(position.windows(rows + 1));
        let speeds = ends.map(|(t, p)| (p[rows] - p[0]) / (t[rows] - t[0]));
        let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(low, high), &p| (low.min(p), high.max(p)));
        Self {
            speed: speeds.fold(0.0, |peak, v| peak.max(v.abs())),
            torque: recording.effort_cmd.iter().fold(0.0, |peak, u| peak.max(u.abs())),
            travel: (high - low).max(0.0),
        }
    }

    fn either(self, other: Self) -> Self {
        Self {
            speed: self.speed.max(other.speed),
            torque: self.torque.max(other.torque),
            travel: self.travel.max(other.travel),
        }
    }

    /// Whether a motion stays within, to 1 %.
    pub(super) fn allow(&self, motion: &Self) -> bool {
        motion.speed <= 1.01 * self.speed && motion.torque <= 1.01 * self.torque && motion.travel <= 1.01 * self.travel
    }
}
