//! A vibration in step with the machine's own motion.

use std::f64::consts::TAU;

use super::first;
use crate::report::EffectAnswer;
use crate::screen::{Motion, Problem};

/// Multiples of the motion's frequency at which what follows it repeats: a friction that differs by direction has the second.
/// At the first the motion may be the vibration's.
const MULTIPLES: [f64; 2] = [2.0, 3.0];
/// Points of a recording that its spectrum is made of.
const POINTS: usize = 2000;
/// Frequencies of the spectrum for each that the duration tells apart.
const FINER: f64 = 4.0;

/// In words, that a vibration is two or three times as fast as the motion of a recording: anything that follows the motion
/// has those frequencies.
pub(super) fn in_step(problem: &Problem, effects: &[EffectAnswer]) -> Option<String> {
    let frequency_hz = first(effects, "vibration")?.value;
    let own_hz = problem.motions[..problem.fitted].iter().find_map(|motion| {
        let own_hz = strongest_hz(motion, 1.5 * frequency_hz)?;
        let apart_hz = 1.0 / duration_s(motion);
        MULTIPLES.iter().any(|times| (frequency_hz - times * own_hz).abs() < apart_hz).then_some(own_hz)
    })?;
    Some(format!(
        "vibration: {frequency_hz:.3} Hz is in step with the motion itself, which is strongest at {own_hz:.3} Hz: what follows \
         the motion looks like it"
    ))
}

fn duration_s(motion: &Motion) -> f64 {
    motion.t_s[motion.t_s.len() - 1] - motion.t_s[0]
}

/// The frequency up to a limit at which the speed is largest, Hz; none where the motion has no more than two periods of it.
fn strongest_hz(motion: &Motion, limit_hz: f64) -> Option<f64> {
    let step_hz = 1.0 / (FINER * duration_s(motion));
    let mean = motion.smooth.iter().sum::<f64>() / motion.smooth.len() as f64;
    let stride = motion.smooth.len().div_ceil(POINTS);
    let points: Vec<(f64, f64)> =
        motion.t_s.iter().zip(&motion.smooth).step_by(stride).map(|(&t_s, &q)| (t_s, q - mean)).collect();
    let speed = |hz: f64| {
        let (sine, cosine) = points.iter().fold((0.0, 0.0), |(sine, cosine), (t_s, q)| {
            let (s, c) = (TAU * hz * t_s).sin_cos();
            (sine + q * s, cosine + q * c)
        });
        hz * f64::hypot(sine, cosine)
    };
    let last = (limit_hz / step_hz) as u32;
    // Beyond what so few points tell apart nothing is compared.
    let grid = (2 * FINER as u32..=last.min(POINTS as u32)).map(|k| f64::from(k) * step_hz);
    grid.map(|hz| (hz, speed(hz))).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(hz, _)| hz)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::{effect, nominal};
    use super::*;
    use crate::decide::testing::multisine;

    #[test]
    fn what_follows_the_motion_is_no_vibration() {
        let recorded = multisine(&nominal(), 0.05, 8.0, 3);
        let problem = Problem::new(vec![Motion::new(&recorded, &nominal(), 1.3e-5)], 1, nominal());
        let own_hz = strongest_hz(&problem.motions[0], 5.0).unwrap();
        let judged = |hz: f64| in_step(&problem, &[effect("vibration", &[hz, 0.1])]);
        assert!(judged(2.0 * own_hz).is_some() && judged(3.0 * own_hz).is_some());
        assert_eq!(judged(23.0), None);
    }
}
