//! Whether a logged velocity is the derivative of the position beside it.

use crate::precheck::windows::median_period_s;
use crate::read::Recording;

/// Stretches over which both are compared, s: longer than a filter of the velocity delays, shorter than most motions.
const STRETCH_S: f64 = 0.1;
/// Fewest stretches that tell anything.
const FEWEST: usize = 30;
/// Velocities that are right are within this share of the derivative.
const RIGHT_WITHIN: f64 = 0.1;
/// Correlation below which the two have nothing to do with each other.
const RELATED: f64 = 0.9;

/// What is wrong with the velocity of a recording, and what to do; none where it is right or there is none.
pub(super) fn wrong_velocity(recording: &Recording) -> Option<String> {
    let velocity = recording.velocity.as_ref()?;
    let rows = ((STRETCH_S / median_period_s(&recording.t_s)).round() as usize).max(2);
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
    let factor = both / told;
    if told <= 0.0 || both.abs() < RELATED * (moved * told).sqrt() {
        return Some("the velocity column does not follow the position: it is of something else, or late".to_owned());
    }
    let wrong = (factor - 1.0).abs() > RIGHT_WITHIN;
    wrong.then(|| {
        format!("the position moves {factor:.3} times as fast as the velocity column says: scale it by that, or do not use it")
    })
}
