//! The torque column is a measurement behind a first-order filter: tau dT_m/dt = T - T_m.

use super::{CURRENT_STEP, Effect, PLAIN, free, measured};
use crate::likelihood::inverse::HALF_S;

/// Slowest filter, s: one slower than half the support of the test functions leaves them next to nothing of the torque, and stood in for
/// friction and cogging of a real motor at a quarter of a second to a whole one.
const SLOWEST_S: f64 = HALF_S;

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_filter",
    sentence: "The torque column is a measurement behind a filter, not what acts: the drive's filtered current.",
    parameters: &[free(0.0, SLOWEST_S, 1e-3)],
    applies: measured,
    starts: |_, e| {
        let rows = [1.0, 3.0, 10.0, 30.0, 100.0].map(|rows| rows * e.period_s);
        rows.into_iter().filter(|filter_s| *filter_s <= SLOWEST_S).map(|filter_s| vec![filter_s]).collect()
    },
    put: |p, v| p.torque_filter_s = v[0],
    measured_by: Some(CURRENT_STEP),
    ..PLAIN
};
