//! Checks of the tool against itself, in every diagnosis: half the step, and effects that are there with no strength.
//!
//! A simulator's own numerics make phantom physics: half an integration step of lead reads as viscous friction. A window
//! must come out the same when every command is held in two halves and every sample is taken in two steps; and an effect
//! put in at its neutral value must change nothing.

use plant::{Command, Mechanics, Model, State, Timeline};

use crate::effects::{Effect, Physics};
use crate::read::Recording;
use crate::refit::{HORIZON_S, model};
use crate::residual::{horizon_s, recorded_commands};
use crate::screen::Problem;

/// Allowed difference over the travel, 1.
const TOLERANCE: f64 = 1e-9;
/// Windows of each recording that are run twice, spread evenly.
const WINDOWS: usize = 12;
/// What was commanded this long before a window may still act in it, s.
const HISTORY_S: f64 = 0.1;

/// A window with the commands that act in it.
struct Sample {
    recording: usize,
    travel: f64,
    t_s: Vec<f64>,
    commands: Vec<Command>,
    /// First row of the window; those before are history.
    start: usize,
    state: State,
}

/// Runs both checks; one sentence for each that fails.
pub(super) fn self_checks(problem: &Problem, recordings: &[Recording], vocabulary: &[&'static Effect]) -> Vec<String> {
    let samples: Vec<Sample> =
        recordings.iter().enumerate().flat_map(|(index, recording)| samples(index, recording)).collect();
    let nominal = &problem.nominal;
    let half = match worst(&samples, |sample| Some((sample.run(nominal, false)?, sample.run(nominal, true)?))) {
        Some(worst) => (worst > TOLERANCE)
            .then(|| format!("the simulator differs from itself at half the step by {worst:.1e} of the travel")),
        None => Some("the simulator refuses the nominal machine at half the step".to_owned()),
    };
    let neutral = vocabulary.iter().filter_map(|effect| not_neutral(problem, &samples, effect));
    half.into_iter().chain(neutral).map(|text| format!("self-check failed: {text}")).collect()
}

/// What an effect at its neutral value changes, in words; none where it changes nothing.
fn not_neutral(problem: &Problem, samples: &[Sample], effect: &Effect) -> Option<String> {
    let nominal = &problem.nominal;
    let mut machine = nominal.clone();
    (effect.put)(&mut machine, &neutral(effect, nominal, problem.motions.len())?);
    // The same numbers are the same machine.
    if machine == *nominal {
        return None;
    }
    let base = problem.parts(nominal, None);
    let (before, after) = (problem.residual(&base), problem.residual(&problem.parts(&machine, Some(&base))));
    let size = before.iter().fold(0.0_f64, |size, r| size.max(r.abs()));
    let weak = before.iter().zip(&after).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
    if weak > TOLERANCE * size {
        return Some(format!("{} of no strength changes the torque balance by {weak:.1e}", effect.id));
    }
    let windows = worst(samples, |sample| Some((sample.run(nominal, false)?, sample.run(&machine, false)?)));
    match windows {
        Some(worst) if worst <= TOLERANCE => None,
        Some(worst) => Some(format!("{} of no strength moves the simulation by {worst:.1e} of the travel", effect.id)),
        None => Some(format!("the simulator refuses {} of no strength", effect.id)),
    }
}

/// Values at which an effect does nothing: no strength, the delay that is nominal. None for what replaces a part of the
/// machine by another law (a delay of the viscosity, a load on a shaft) and for glitches, which no model has.
pub(super) fn neutral(effect: &Effect, nominal: &Physics, recordings: usize) -> Option<Vec<f64>> {
    let damper = nominal.damper.as_ref();
    let of_damper = |value: fn(&crate::effects::Damper) -> f64| damper.map(|damper| vec![value(damper)]);
    Some(match effect.id {
        "field_dead_time" => of_damper(|d| d.dead_time_s)?,
        "field_lag" => damper.filter(|d| d.rise_s == d.fall_s).map(|d| vec![d.rise_s])?,
        "field_lag_asymmetry" => damper.map(|d| vec![d.rise_s, d.fall_s])?,
        "field_slew_limit" => of_damper(|d| d.slew_kv_mm_s)?,
        "field_gain" => of_damper(|d| d.gain)?,
        "er_strength" => of_damper(|d| d.scale)?,
        "er_drift" => of_damper(|d| d.drift_per_s)?,
        "er_preyield" => of_damper(|d| d.preyield)?,
        "coulomb_friction" => vec![nominal.coulomb],
        "viscous_friction" => vec![nominal.viscous],
        // No excess has no velocity: any other is as good.
        "stribeck_friction" if nominal.stribeck_excess == 0.0 => vec![0.0, 0.5 * nominal.stribeck_velocity],
        "stribeck_friction" => vec![nominal.stribeck_excess, nominal.stribeck_velocity],
        "friction_asymmetry" => vec![nominal.asymmetry, nominal.asymmetry_viscous],
        "presliding" => vec![nominal.presliding],
        "torque_gain" => vec![nominal.torque_gain],
        "torque_offset" => vec![nominal.torque_offset],
        "torque_saturation" => vec![nominal.torque_limit],
        "torque_deadband" => vec![nominal.torque_deadband],
        "torque_delay" => vec![nominal.torque_delay_s],
        "torque_lag" => vec![nominal.torque_lag_s],
        "cogging" => vec![7.0, 0.0, 0.0],
        "inertia" => vec![nominal.inertia],
        "gravity_load" if nominal.gravity.is_none() => vec![0.0, 0.0],
        "spring_load" => vec![nominal.spring],
        "disturbance_pulse" => vec![0.0, 0.0, 0.1, 0.0],
        "vibration" if nominal.vibration.is_none() => {
            std::iter::once(5.0).chain(std::iter::repeat_n(0.0, 2 * recordings)).collect()
        }
        "quadratic_drag" => vec![nominal.quadratic],
        "resolver_eccentricity" if nominal.eccentricity.is_none() => vec![1.0, 0.0, 0.0],
        "sensor_latency" => vec![nominal.latency_s],
        _ => return None,
    })
}

/// Largest difference between two runs over all samples, in travels; none where one cannot be run.
fn worst(samples: &[Sample], runs: impl Fn(&Sample) -> Option<(Vec<f64>, Vec<f64>)>) -> Option<f64> {
    samples.iter().try_fold(0.0_f64, |worst, sample| {
        let (a, b) = runs(sample)?;
        let difference = a.iter().zip(&b).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        Some(worst.max(difference / sample.travel))
    })
}

/// Windows spread evenly over a recording.
fn samples(index: usize, recording: &Recording) -> Vec<Sample> {
    let t_s = &recording.t_s;
    let commands = recorded_commands(recording);
    let ends = recording.position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| (l.min(*q), h.max(*q)));
    let travel = (ends.1 - ends.0).max(1e-6);
    let horizon_s = horizon_s(recording, HORIZON_S);
    let starts = (0..WINDOWS).map(|k| (2 * k + 1) * recording.rows() / (2 * WINDOWS));
    let whole = starts.filter_map(|start| {
        let end = t_s.partition_point(|t| *t < t_s[start] + horizon_s);
        let from = t_s.partition_point(|t| *t < t_s[start] - HISTORY_S);
        (end - start >= 8).then(|| {
            let speed = (recording.position[end - 1] - recording.position[start]) / (t_s[end - 1] - t_s[start]);
            Sample {
                recording: index,
                travel,
                t_s: t_s[from..end].to_vec(),
                commands: commands[from..end].to_vec(),
                start: start - from,
                state: State::new(recording.position[start], speed),
            }
        })
    });
    whole.collect()
}

impl Sample {
    /// Positions of a machine at the rows of the window, with every row cut in two or not; none where it cannot be run.
    fn run(&self, machine: &Physics, halves: bool) -> Option<Vec<f64>> {
        let model: Model = model(machine, self.recording);
        let (t_s, commands, step) = if halves { self.halved() } else { (self.t_s.clone(), self.commands.clone(), 1) };
        let before = Command { speed_estimate: 0.0, ..commands[0] };
        let timeline = Timeline::new(&model, &t_s, &commands, &before).ok()?;
        let sampled = &t_s[self.start * step..];
        let mut positions = vec![0.0; sampled.len()];
        let mechanics = Mechanics::new(&model).ok()?;
        mechanics.simulate(&timeline, self.t_s[self.start], self.state, sampled, &mut positions).ok()?;
        Some(positions.into_iter().step_by(step).collect())
    }

    /// Every row, and its command once more in the middle before the next.
    fn halved(&self) -> (Vec<f64>, Vec<Command>, usize) {
        let last = self.t_s.len() - 1;
        let middle = |row: usize| 0.5 * (self.t_s[row] + self.t_s[(row + 1).min(last)]);
        let mut t_s: Vec<f64> = (0..=last).flat_map(|row| [self.t_s[row], middle(row)]).collect();
        // The last row has no next one.
        t_s.pop();
        let mut commands: Vec<Command> = self.commands.iter().flat_map(|command| [*command; 2]).collect();
        commands.pop();
        (t_s, commands, 2)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::decide::testing::{machine, recording};
    use crate::effects::VOCABULARY;
    use crate::screen::Motion;

    #[test]
    fn a_sound_tool_passes_and_a_neutral_value_that_is_none_is_named() {
        let machine = machine();
        let nominal = Physics::nominal(&machine);
        let recordings = [recording(&nominal, 0.02, 4.0, 1)];
        let motions = recordings.iter().map(|r| Motion::new(r, &nominal, machine.axis.resolution)).collect();
        let problem = Problem::new(motions, 1, nominal);
        assert_eq!(self_checks(&problem, &recordings, &VOCABULARY), Vec::<String>::new());
        // An effect whose neutral value is not: a spring of its own in every put.
        let put = |physics: &mut Physics, _: &[f64]| physics.spring = 0.3;
        let wrong = Effect { put, ..copy(crate::effects::find("spring_load").unwrap()) };
        let wrong: &'static Effect = Box::leak(Box::new(wrong));
        let failed = self_checks(&problem, &recordings, &[wrong]);
        assert!(failed.len() == 1 && failed[0].contains("spring_load of no strength"), "{failed:?}");
    }

    fn copy(effect: &Effect) -> Effect {
        let Effect { id, sentence, parameters, applies, starts, put, report } = *effect;
        Effect { id, sentence, parameters, applies, starts, put, report }
    }

    #[test]
    fn values_are_neutral_wherever_an_effect_has_such() {
        let nominal = Physics::nominal(&machine());
        let without: Vec<&str> =
            VOCABULARY.iter().filter(|effect| neutral(effect, &nominal, 1).is_none()).map(|effect| effect.id).collect();
        assert_eq!(without, ["viscosity_dead_time", "viscosity_lag", "compliance", "backlash", "sensor_glitch"]);
    }
}
