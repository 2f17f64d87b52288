//! `[[effects]]` of a machine file, put into the machine's numbers.

use super::{Effect, Harmonic, Physics, Pulse, Vibration, find};
use crate::Error;
use crate::read::vocabulary::effect as named;
use crate::read::{EffectEntry, Machine};

impl Physics {
    /// The machine with its `[[effects]]`; `recordings` are the names in the order they will be numbered.
    ///
    /// # Errors
    /// An effect that is no part of a model.
    pub fn of(machine: &Machine, recordings: &[&str]) -> Result<Self, Error> {
        let mut physics = Self::nominal(machine);
        for entry in &machine.effects {
            let refuse = |message: String| Error::input(&machine.file, None, &entry.id, message);
            let effect = find(&entry.id).ok_or_else(|| refuse("is no effect of a model".to_owned()))?;
            let values = in_order(machine, entry).ok_or_else(|| refuse("lacks a parameter".to_owned()))?;
            put(&mut physics, effect, entry, &values, recordings);
        }
        Ok(physics)
    }
}

/// Values in the order of the table of names.
fn in_order(machine: &Machine, entry: &EffectEntry) -> Option<Vec<f64>> {
    let axis = machine.axis.kind;
    let value = |id: &str| entry.parameters.iter().find(|(name, _)| name == id).map(|(_, value)| *value);
    named(&entry.id)?.parameters.iter().map(|parameter| value(parameter.id(axis))).collect()
}

fn put(physics: &mut Physics, effect: &Effect, entry: &EffectEntry, values: &[f64], recordings: &[&str]) {
    let sine = |amplitude: f64, phase: f64| (amplitude * phase.cos(), amplitude * phase.sin());
    match (effect.id, values) {
        ("cogging" | "resolver_eccentricity", &[amplitude, order, phase]) => {
            let (sine, cosine) = sine(amplitude, phase);
            let harmonic = Harmonic { order, sine, cosine };
            if effect.id == "cogging" {
                physics.cogging.push(harmonic);
            } else {
                physics.eccentricity = Some(harmonic);
            }
        }
        ("gravity_load", &[amplitude, phase]) => {
            let (sine, cosine) = sine(amplitude, phase);
            (effect.put)(physics, &[sine, cosine]);
        }
        ("disturbance_pulse", &[start_s, duration_s, amplitude]) => {
            let of = |name: &str| recordings.iter().position(|other| *other == name);
            if let Some(recording) = entry.recording.as_deref().and_then(of) {
                physics.pulses.push(Pulse { recording, start_s, duration_s, amplitude });
            }
        }
        // Its phase differs from recording to recording and is no part of a model.
        ("vibration", &[frequency_hz, _]) => {
            physics.vibration = Some(Vibration { frequency_hz, phasors: Vec::new() });
        }
        _ => (effect.put)(physics, values),
    }
}
