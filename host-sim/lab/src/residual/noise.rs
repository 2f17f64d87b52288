//! The noise of the position sensor, from the recording itself.

use crate::read::{Axis, Recording};

/// Share of the third differences that is trusted, the smallest first; the rest may be motion that is not smooth.
const TRUSTED: f64 = 0.75;
/// Mean square of that share of a unit normal: 1 - 2 z phi(z)/0.75 with z = 1.15035.
const TRUSTED_MEAN_SQUARE: f64 = 0.368_48;

/// Standard deviation of the position's noise, rad (m): the rounding of the sensor, or what third differences show if that
/// is more. Motion smooth over four samples leaves nothing in a third difference; independent noise of deviation s leaves
/// s sqrt(20).
///
/// A mean of squares and not a median, because differences of counts are a few whole numbers and so is their median. Where
/// the motion is slow for the resolution, most differences are zero and the rounding is the answer; rounding of fast
/// motion has shorter tails than a normal distribution and comes out up to 8 % high.
pub fn sensor_noise(recording: &Recording, axis: &Axis) -> f64 {
    let rounding = axis.resolution / 12.0_f64.sqrt();
    let thirds = recording.position.windows(4).enumerate().filter(|(row, _)| is_even(recording, *row));
    let mut sizes: Vec<f64> = thirds.map(|(_, p)| (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]).abs()).collect();
    let trusted = (TRUSTED * sizes.len() as f64).round() as usize;
    if trusted == 0 || trusted >= sizes.len() {
        return rounding;
    }
    let (smallest, _, _) = sizes.select_nth_unstable_by(trusted, f64::total_cmp);
    let mean_square = smallest.iter().map(|size| size * size).sum::<f64>() / trusted as f64;
    (mean_square / TRUSTED_MEAN_SQUARE / 20.0).sqrt().max(rounding)
}

/// How far so many samples of an axis that stands spread, rad (m): as its noise does, or two steps of the sensor. The expected maximum of n
/// normal ones is at most sqrt(2 ln n) standard deviations.
pub fn spread_at_rest(recording: &Recording, axis: &Axis, samples: usize) -> f64 {
    let farthest = (2.0 * (samples.max(1) as f64).ln()).sqrt();
    (2.0 * farthest * sensor_noise(recording, axis)).max(2.0 * axis.resolution)
}

/// Whether four samples from `row` are evenly spaced to 5 %: else their third difference shows the spacing.
fn is_even(recording: &Recording, row: usize) -> bool {
    let t_s = &recording.t_s[row..row + 4];
    let steps = [t_s[1] - t_s[0], t_s[2] - t_s[1], t_s[3] - t_s[2]];
    let mean = (t_s[3] - t_s[0]) / 3.0;
    steps.iter().all(|step| (step - mean).abs() <= 0.05 * mean)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::StdRng;
    use rand_distr::{Distribution, Normal, Uniform};

    use super::*;
    use crate::read::AxisKind;
    use crate::residual::testing::recording;

    fn axis(resolution: f64) -> Axis {
        Axis { kind: AxisKind::Rotary, sample_period_s: 1e-3, resolution }
    }

    fn estimate(resolution: f64, position: impl Fn(f64) -> f64) -> f64 {
        let rounded = |x: f64| if resolution > 0.0 { (x / resolution).round() * resolution } else { x };
        let t_s: Vec<f64> = (0..20_000).map(|row| f64::from(row) * 1e-3).collect();
        let position = t_s.iter().map(|t| rounded(position(*t))).collect();
        sensor_noise(&recording(t_s, position), &axis(resolution))
    }

    #[test]
    fn rounding_of_motion_slow_and_fast() {
        let rounding = 1e-4 / 12.0_f64.sqrt();
        for (name, swing) in [("rest", 0.0), ("a step in 20 samples", 1e-3), ("a step a sample", 0.02), ("fast", 1.0)] {
            let noise = estimate(1e-4, |t| swing * (5.0 * t).sin());
            assert!((noise / rounding - 1.0).abs() < 0.08, "{name}: {:.3}", noise / rounding);
        }
    }

    #[test]
    fn noise_beyond_the_rounding_is_found_whatever_the_jumps() {
        let mut random = StdRng::seed_from_u64(1);
        let normal = Normal::new(0.0, 3e-4).unwrap_or_else(|_| unreachable!());
        let noise: Vec<f64> = normal.sample_iter(&mut random).take(20_000).collect();
        for resolution in [0.0, 1e-4, 5e-4] {
            let with_jumps = |t: f64| {
                let row = (t * 1e3).round() as usize;
                noise[row] + (3.0 * t).sin() + if row.is_multiple_of(200) { 0.3 } else { 0.0 }
            };
            let estimate = estimate(resolution, with_jumps);
            let truth = 3e-4_f64.hypot(resolution / 12.0_f64.sqrt());
            assert!((estimate / truth - 1.0).abs() < 0.05, "{resolution}: {:.3}", estimate / truth);
        }
    }

    #[test]
    fn uneven_spacing_is_no_noise_and_a_short_recording_has_the_rounding() {
        let mut random = StdRng::seed_from_u64(2);
        let jitter = Uniform::new(0.5e-3, 1.5e-3).unwrap_or_else(|_| unreachable!());
        let t_s: Vec<f64> = jitter
            .sample_iter(&mut random)
            .scan(0.0, |t, step: f64| {
                *t += step;
                Some(*t)
            })
            .take(5000)
            .collect();
        let position = t_s.iter().map(|t| 2.0 * t).collect();
        assert!(sensor_noise(&recording(t_s, position), &axis(0.0)) < 1e-4, "steps of 1 mrad of jitter are not noise");
        let short = recording(vec![0.0, 0.1, 0.2], vec![0.0, 1.0, 2.0]);
        assert_eq!(sensor_noise(&short, &axis(1.2)), 1.2 / 12.0_f64.sqrt());
    }
}
