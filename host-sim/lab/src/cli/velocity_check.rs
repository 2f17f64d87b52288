//! Whether a logged velocity is the derivative of the position beside it.

use std::fmt;

use crate::precheck::windows::median_period_s;
use crate::read::Recording;

/// Stretches over which both are compared, s: longer than a filter of the velocity delays, and shorter ones for motions that
/// turn within that. The one in which both go together best counts.
const STRETCHES_S: [f64; 3] = [0.1, 0.02, 0.004];
/// Fewest stretches that tell anything.
const FEWEST: usize = 30;
/// Velocities that are right are within this share of the derivative.
const RIGHT_WITHIN: f64 = 0.1;
/// Correlation below which the two have nothing to do with each other.
const RELATED: f64 = 0.9;

/// What is wrong with a logged velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WrongVelocity {
    /// It goes with the position, but this many times as slow.
    Scaled(f64),
    /// It does not go with the position: of something else, or of a place behind a shaft, or filtered and late. No error by itself.
    Unlike,
}

impl fmt::Display for WrongVelocity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scaled(factor) => write!(
                f,
                "the position moves {factor:.3} times as fast as the velocity column says: scale it by that, or do not use it"
            ),
            Self::Unlike => f.write_str(
                "the velocity column does not go with the position: it is of another place, filtered, or late",
            ),
        }
    }
}

/// What is wrong with the velocity of a recording; none where it is right or there is none.
pub(super) fn wrong_velocity(recording: &Recording) -> Option<WrongVelocity> {
    let velocity = recording.velocity.as_ref()?;
    let compared = STRETCHES_S.into_iter().filter_map(|stretch_s| compared(recording, velocity, stretch_s));
    let (factor, correlation) = compared.max_by(|one, other| one.1.total_cmp(&other.1))?;
    if correlation < RELATED {
        return Some(WrongVelocity::Unlike);
    }
    ((factor - 1.0).abs() > RIGHT_WITHIN).then_some(WrongVelocity::Scaled(factor))
}

/// What the velocity must be multiplied by to be the derivative of the position, and how well the two go together, 0 to 1; none
/// where too few stretches move.
fn compared(recording: &Recording, velocity: &[f64], stretch_s: f64) -> Option<(f64, f64)> {
    let rows = ((stretch_s / median_period_s(&recording.t_s)).round() as usize).max(2);
    let stretches: Vec<(f64, f64)> = (0..recording.rows().saturating_sub(rows))
        .step_by(rows)
        .filter(|start| !recording.gaps.iter().any(|gap| (*start..start + rows).contains(gap)))
        .map(|start| {
            let moved = recording.position[start + rows] - recording.position[start];
            let step =
                |row: usize| 0.5 * (velocity[row] + velocity[row + 1]) * (recording.t_s[row + 1] - recording.t_s[row]);
            (moved, (start..start + rows).map(step).sum())
        })
        .collect();
    let sum = |of: &dyn Fn(&(f64, f64)) -> f64| stretches.iter().map(of).sum::<f64>();
    let (moved, told) = (sum(&|pair| pair.0 * pair.0), sum(&|pair| pair.1 * pair.1));
    let both = sum(&|pair| pair.0 * pair.1);
    if stretches.len() < FEWEST || moved <= 0.0 {
        return None;
    }
    // A velocity of nothing but zeros follows nothing.
    Some(if told > 0.0 { (both / told, both.abs() / (moved * told).sqrt()) } else { (0.0, 0.0) })
}
