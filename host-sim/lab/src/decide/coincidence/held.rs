//! A push that only held a rotor at rest.
//!
//! Where the rotor rests for as long as a push acts, all that is seen is that it did not break away. Friction that is higher
//! there, as after a long rest, does the same.

use crate::screen::{Active, Problem};

/// A rotor rests that moves by no more than this many standard deviations of its sensor's noise: twice what noise alone spans.
const RESTS: f64 = 20.0;

/// In words, which pushes of a model only held a rotor at rest.
pub(in crate::decide) fn held(problem: &Problem, active: &[Active]) -> Vec<String> {
    let pushes = active.iter().filter(|entry| entry.effect.is_event());
    let spans = pushes.map(|push| (push.values[0] as usize, push.values[1], push.values[1] + push.values[2]));
    let held = spans.filter(|&(recording, start_s, end_s)| rests(problem, recording, start_s, end_s));
    held.map(|(_, start_s, end_s)| {
        format!(
            "disturbance_pulse: the rotor rests from {start_s:.2} to {end_s:.2} s, so a friction that is higher there does \
             the same as a push that holds it"
        )
    })
    .collect()
}

/// Whether the sensor shows no motion of a recording from one time to another.
fn rests(problem: &Problem, recording: usize, start_s: f64, end_s: f64) -> bool {
    let Some(motion) = problem.motions.get(recording) else { return false };
    let row = |t_s: f64| motion.t_s.partition_point(|t| *t < t_s);
    let shown = &motion.position[row(start_s)..row(end_s)];
    let (low, high) =
        shown.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &q| (low.min(q), high.max(q)));
    !shown.is_empty() && high - low <= RESTS * motion.noise
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::nominal;
    use super::*;
    use crate::decide::testing::multisine;
    use crate::effects::find;
    use crate::screen::Motion;

    #[test]
    fn a_push_while_the_rotor_rests_only_held_it() {
        let recorded = multisine(&nominal(), 0.05, 4.0, 3);
        let mut motion = Motion::new(&recorded, &nominal(), 1.3e-5);
        let (from, to) = (1000, 1400);
        let still = motion.position[from];
        motion.position[from..to].fill(still);
        let (from_s, to_s) = (motion.t_s[from], motion.t_s[to]);
        let problem = Problem::new(vec![motion], 1, nominal());
        let push = find("disturbance_pulse").unwrap();
        let found = |start_s: f64| {
            let values = vec![0.0, start_s, 0.1, 2.0];
            held(&problem, &[Active { effect: push, values, ranges: Vec::new() }]).len()
        };
        assert_eq!((found(from_s), found(to_s - 0.11), found(to_s - 0.05), found(0.0)), (1, 1, 0, 0));
    }
}
