//! A hypothesis with the values it may adapt.

use nalgebra::DVector;

use crate::effects::{Effect, Excitation, Physics, Range};
use crate::screen::Active;

/// One of the models that the recordings so far cannot tell apart.
#[derive(Debug, Clone)]
pub struct Rival {
    /// How it is named in the proposal: its effect, or what makes it differ from the others.
    pub id: String,
    /// The machine that the effects are added to.
    pub base: Physics,
    /// Effects with their values; the free ones adapt to the new recording.
    pub active: Vec<Active>,
}

/// A free value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub effect: usize,
    pub value: usize,
    pub range: Range,
}

impl Rival {
    /// A single effect on a machine.
    pub fn single(base: &Physics, effect: &'static Effect, values: Vec<f64>, excitation: &Excitation) -> Self {
        let ranges = effect.ranges(values.len(), base, excitation);
        Self { id: effect.id.to_owned(), base: base.clone(), active: vec![Active { effect, values, ranges }] }
    }

    pub(super) fn values(&self) -> Vec<Vec<f64>> {
        self.active.iter().map(|entry| entry.values.clone()).collect()
    }

    pub(super) fn places(&self) -> Vec<Place> {
        let of = |(effect, entry): (usize, &Active)| {
            let free = (0..entry.values.len()).filter(|&value| entry.effect.parameter(value).free);
            free.map(|value| Place { effect, value, range: entry.ranges[value] }).collect::<Vec<_>>()
        };
        self.active.iter().enumerate().flat_map(of).collect()
    }

    /// The machine with other values of its effects. A push does not come again in a new recording.
    pub(super) fn with(&self, values: &[Vec<f64>]) -> Physics {
        let mut physics = self.base.clone();
        for (entry, values) in self.active.iter().zip(values) {
            (entry.effect.put)(&mut physics, values);
        }
        physics.pulses.clear();
        physics
    }

    /// The machine as it will be when it is recorded again.
    pub(super) fn in_a_new_recording(&self) -> Physics {
        self.with(&self.values())
    }

    /// Values after a step, held within what physics allows.
    pub(super) fn moved(&self, values: &[Vec<f64>], step: &DVector<f64>) -> Vec<Vec<f64>> {
        let mut moved = values.to_vec();
        for (place, change) in self.places().iter().zip(step.iter()) {
            let value = &mut moved[place.effect][place.value];
            *value = (*value + change).clamp(place.range.low, place.range.high);
        }
        moved
    }
}
