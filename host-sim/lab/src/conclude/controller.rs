//! The controller first: where the recorded commands are not what the law computes, no physics may be named.

use er_servo::Config;
use er_servo::parameters::{Parameter, TABLE};

use crate::read::Recording;
use crate::replay::{Difference, replay};
use crate::report::{EffectAnswer, Evidence};

/// Factors tried on each parameter, one parameter at a time.
const FACTORS: [f32; 18] =
    [0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.5, 2.0];

/// The first recording whose commands differ, as the effect `controller`; none where all replay to the bit. Recordings
/// that cannot be replayed are warned about.
pub(super) fn mismatch(config: &Config, recordings: &[&Recording], warnings: &mut Vec<String>) -> Option<EffectAnswer> {
    for &recording in recordings {
        match replay(recording, config) {
            Ok(found) => {
                if let Some(difference) = found.difference {
                    return Some(answer(config, recording, &difference));
                }
            }
            Err(error) => warnings.push(format!("the controller was not checked: {error}")),
        }
    }
    None
}

fn answer(config: &Config, recording: &Recording, difference: &Difference) -> EffectAnswer {
    let Difference { row, t_s, column, recorded, computed } = difference;
    let text = format!(
        "The recorded commands are not what this control law computes: row {row} (t = {t_s} s), {column} is {recorded}, the \
         law computes {computed}. {}",
        cause(config, recording)
    );
    EffectAnswer {
        id: crate::read::vocabulary::CONTROLLER.to_owned(),
        text,
        equivalent: Vec::new(),
        nuisances: Vec::new(),
        parameters: Vec::new(),
        evidence: Evidence { heldout_gain: 0.0, p_value: 0.0, excess_explained: 0.0 },
        recording: Some(recording.name.clone()),
    }
}

/// The parameter whose change makes the replay identical, or else fits the most rows before the first difference.
fn cause(config: &Config, recording: &Recording) -> String {
    let first_difference = |config: &Config| match replay(recording, config) {
        Ok(found) if found.compared == 0 => Some(0),
        Ok(found) => found.difference.map(|difference| difference.row),
        Err(_) => Some(0),
    };
    let start = first_difference(config).unwrap_or(0);
    let mut best: Option<(usize, &Parameter, f32)> = None;
    for parameter in TABLE {
        for value in trials(parameter, (parameter.get)(config)) {
            let mut changed = *config;
            (parameter.set)(&mut changed, value);
            match first_difference(&changed) {
                None => {
                    let Parameter { name, unit, .. } = parameter;
                    return format!("With {name} = {value} {unit} it is identical: that is what ran.");
                }
                Some(row) if row > start + 5 && best.is_none_or(|(most, _, _)| row > most) => {
                    best = Some((row, parameter, value));
                }
                Some(_) => (),
            }
        }
    }
    match best {
        Some((row, parameter, _)) => {
            format!("A change of {} fits up to row {row}; no single change fits all.", parameter.name)
        }
        None => "No single gain or limit makes it identical: another build of the law, or lost frames.".to_owned(),
    }
}

fn trials(parameter: &Parameter, now: f32) -> Vec<f32> {
    if parameter.unit == "flag" {
        return vec![1.0 - now];
    }
    let allowed = |value: &f32| (parameter.min..=parameter.max).contains(value) && *value != now;
    let default = (parameter.get)(&Config::default());
    FACTORS.iter().map(|factor| factor * now).chain([default, 0.0]).filter(allowed).collect()
}
