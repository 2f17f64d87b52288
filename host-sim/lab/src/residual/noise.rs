//! The noise of the position sensor, from the recording itself.

use crate::read::{Axis, Recording};

/// Standard deviation of the position's noise, rad (m): the step of the sensor, or what third differences show if that is
/// more. Motion smooth over four samples leaves nothing in a third difference; independent noise of deviation s leaves
/// s sqrt(20). The median ignores the few places where the motion is not smooth.
pub fn sensor_noise(recording: &Recording, axis: &Axis) -> f64 {
    let quantisation = axis.resolution / 12.0_f64.sqrt();
    let thirds = recording.position.windows(4).enumerate().filter(|(row, _)| is_even(recording, *row));
    let mut sizes: Vec<f64> = thirds.map(|(_, p)| (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]).abs()).collect();
    if sizes.is_empty() {
        return quantisation;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    // 0.6745 is the median of the absolute value of a unit normal.
    (*median / 0.6745 / 20.0_f64.sqrt()).max(quantisation)
}

/// Whether four samples from `row` are evenly spaced to 5 %: else their third difference shows the spacing.
fn is_even(recording: &Recording, row: usize) -> bool {
    let t_s = &recording.t_s[row..row + 4];
    let steps = [t_s[1] - t_s[0], t_s[2] - t_s[1], t_s[3] - t_s[2]];
    let mean = (t_s[3] - t_s[0]) / 3.0;
    steps.iter().all(|step| (step - mean).abs() <= 0.05 * mean)
}
