//! A motion that is given, for the tests of each law by itself.

use super::Seen;

/// Step of the motion, s.
pub(super) const STEP_S: f64 = 1e-4;

/// What a law sees in a step of it.
pub(super) fn seen(t_s: f64, position: f64, speed: f64, drive: f64) -> Seen {
    Seen { t_s, step_s: STEP_S, position, speed, drive }
}

/// What a law gives at each step of a motion at speeds over the time, under a torque of 1.
pub(super) fn along(seconds: f64, speed: impl Fn(f64) -> f64, mut of: impl FnMut(&Seen) -> f64) -> Vec<f64> {
    let mut position = 0.0;
    let step = |row: u32| {
        let t_s = f64::from(row) * STEP_S;
        let at = seen(t_s, position, speed(t_s), 1.0);
        position += STEP_S * at.speed;
        of(&at)
    };
    (0..(seconds / STEP_S) as u32).map(step).collect()
}

/// The value at the end; not a number where there is none.
pub(super) fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

/// Whether one is the other within a hundredth of it, or within 1e-4 where that is more.
pub(super) fn near(one: f64, other: f64) -> bool {
    (one - other).abs() < 1e-2 * other.abs().max(1e-2)
}
