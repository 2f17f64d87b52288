//! How much of a log is motion.

use super::{Check, State};
use crate::precheck::range;
use crate::read::{Axis, Recording};
use crate::residual::spread_at_rest;

/// The axis moves or rests for so long at a time, s: the support of a test function of the diagnosis (docs/method.md, section 6).
const STRETCH_S: f64 = 0.1;
/// A log that moves for less than this share of its time says less than its length makes one think.
const MOSTLY_AT_REST: f64 = 0.1;

/// For what share of the time the axis moves, and how often it turns.
pub(super) fn motion(recording: &Recording, axis: &Axis, period_s: f64) -> Check {
    let rows = ((STRETCH_S / period_s).round() as usize).max(2);
    let still = spread_at_rest(recording, axis, rows);
    let stretches = recording.position.chunks(rows);
    let (all, ends) = (stretches.len().max(1), stretches.map(range));
    let share = ends.filter(|(low, high)| high - low > still).count() as f64 / all as f64;
    let turns = match turns(&recording.position, still) {
        0 => "never turns".to_owned(),
        1 => "turns once".to_owned(),
        turns => format!("turns {turns} times"),
    };
    let found = format!("moves for {:.0} % of the time, {turns}", 100.0 * share);
    if share < MOSTLY_AT_REST {
        let hint = "; mostly standstill, which tells little and takes as long to diagnose: move more, or cut it off";
        return Check::new(State::Note, "motion", found + hint);
    }
    Check::new(State::Good, "motion", found)
}

/// How often a position goes back from where it had got to by more than `still`.
fn turns(position: &[f64], still: f64) -> usize {
    let Some(&first) = position.first() else { return 0 };
    let (mut low, mut high, mut up, mut turns) = (first, first, None, 0);
    for &at in position {
        (low, high) = (low.min(at), high.max(at));
        let turned = match up {
            Some(true) => high - at > still,
            Some(false) => at - low > still,
            None => high - low > still,
        };
        if turned {
            turns += usize::from(up.is_some());
            up = Some(up.map_or(at - low > high - at, |up: bool| !up));
            (low, high) = (at, at);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(position: impl Fn(f64) -> f64) -> Recording {
        let t_s: Vec<f64> = (0..4000).map(|row| 0.001 * f64::from(row)).collect();
        let position = t_s.iter().map(|t_s| position(*t_s)).collect();
        crate::residual::testing::recording(t_s, position)
    }

    #[test]
    fn standstill_and_turns_are_counted() {
        let axis = Axis { kind: crate::read::AxisKind::Rotary, sample_period_s: 0.001, resolution: 1e-4 };
        let said = |position: &dyn Fn(f64) -> f64| motion(&recording(position), &axis, 0.001).found;
        assert!(
            said(&|t_s| (std::f64::consts::TAU * t_s).sin()).contains("moves for 100 % of the time, turns 8 times")
        );
        let step = said(&|t_s| (t_s - 2.0).clamp(0.0, 0.2));
        assert!(step.contains("moves for 5 % of the time, never turns; mostly standstill"), "{step}");
        let there_and_back = said(&|t_s| (t_s - 2.0).abs());
        assert!(there_and_back.contains("moves for 100 % of the time, turns once"), "{there_and_back}");
    }
}
