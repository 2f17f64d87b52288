//! A hypothesis: effects with values on top of the nominal machine.

mod along;
mod differences;
mod evaluate;
mod noise_fit;
mod orders;
mod refit;
mod rough;

use crate::effects::{Effect, Parameter};
use crate::physics::Physics;
use crate::problem::Problem;

pub(crate) use along::variance_along;
pub use evaluate::{Evaluation, evaluate};
pub(crate) use evaluate::{Kept, KeptRecording, kept, product};
pub(crate) use noise_fit::over_excerpts;
pub use noise_fit::{coloured_noise, noise_of};
pub(crate) use orders::{OrderSpread, order_spread};
pub use refit::{Refitted, refit};
pub(crate) use refit::{columns, ranges, refit_linearised, refit_under};

/// One effect with its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The effect.
    pub effect: &'static Effect,
    /// Fitted values, in the order of the effect's parameters.
    pub values: Vec<f64>,
}

impl Entry {
    /// Whether its first value is the last that is looked at, beyond which it may be likelier still; 0 is the last that physics has.
    pub(crate) fn is_at_an_end(&self, problem: &Problem) -> bool {
        let value = self.values[0];
        let range = self.effect.ranges(1, &problem.nominal, &problem.excitation)[0];
        value != 0.0 && (value <= range.low || value >= range.high)
    }

    /// Whether no motion of the machine tells another effect from this one by its values.
    pub(crate) fn indistinct(&self, problem: &Problem, other: &Effect) -> bool {
        match problem.nominal.model.er {
            None => self.effect.alike.contains(&other.id),
            Some(_) => (self.effect.alike_beside_a_fluid)(&self.values).contains(&other.id) && problem.may_have(other),
        }
    }
}

/// Effects on top of the nominal machine; none is the nominal machine itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hypothesis {
    /// In the order they came.
    pub entries: Vec<Entry>,
}

impl Hypothesis {
    /// The machine.
    pub fn physics(&self, nominal: &Physics) -> Physics {
        let mut physics = nominal.clone();
        for entry in &self.entries {
            (entry.effect.put)(&mut physics, &entry.values);
        }
        physics
    }

    /// With one effect more.
    pub fn with(&self, effect: &'static Effect, values: Vec<f64>) -> Self {
        let mut entries = self.entries.clone();
        entries.push(Entry { effect, values });
        Self { entries }
    }

    /// Without the effect at `index`.
    pub fn without(&self, index: usize) -> Self {
        let mut entries = self.entries.clone();
        entries.remove(index);
        Self { entries }
    }

    /// With one value moved by `by`.
    pub(crate) fn moved(&self, (entry, index): (usize, usize), by: f64) -> Self {
        let mut moved = self.clone();
        moved.entries[entry].values[index] += by;
        moved
    }

    /// A share of the way to another with the same entries.
    pub(crate) fn towards(&self, other: &Self, share: f64) -> Self {
        let mut between = self.clone();
        for (own, other) in between.entries.iter_mut().zip(&other.entries) {
            own.values.iter_mut().zip(&other.values).for_each(|(own, other)| *own += share * (other - *own));
        }
        between
    }

    /// Whether an entry may be the explanation of anything: its order comes back, and the rest of the machine lets it act.
    pub(crate) fn explains(&self, problem: &Problem, entry: usize) -> bool {
        let own = &self.entries[entry];
        orders::comes_back(problem, own) && (own.effect.explains)(&self.physics(&problem.nominal), &problem.excitation)
    }

    /// Places of the free numbers: entry, index of its value.
    pub fn free(&self) -> Vec<(usize, usize)> {
        self.places(|parameter| parameter.free)
    }

    /// Places of the numbers that no derivative tells.
    pub fn searched(&self) -> Vec<(usize, usize)> {
        self.places(|parameter| parameter.searched)
    }

    /// Places of the free numbers whose likelihood is rough.
    pub(crate) fn rough(&self) -> Vec<(usize, usize)> {
        self.places(|parameter| parameter.rough)
    }

    fn places(&self, which: impl Fn(Parameter) -> bool) -> Vec<(usize, usize)> {
        let indices = |entry: &Entry| (0..entry.values.len()).filter(|&at| which(entry.effect.parameter(at))).collect();
        let of = |(at, entry)| -> Vec<(usize, usize)> {
            let indices: Vec<usize> = indices(entry);
            indices.into_iter().map(|index| (at, index)).collect()
        };
        self.entries.iter().enumerate().flat_map(of).collect()
    }

    /// How many of the recordings tell its values: those to fit, or all where a value belongs to one that is held out.
    pub(crate) fn told_by(&self, problem: &Problem) -> usize {
        let beyond = self.alone().iter().any(|of| of.is_some_and(|of| of >= problem.fitted));
        if beyond { problem.recordings.len() } else { problem.fitted }
    }

    /// For each free number the recording that it belongs to alone.
    pub fn alone(&self) -> Vec<Option<usize>> {
        let of = |(entry, index): (usize, usize)| {
            let entry = &self.entries[entry];
            (entry.effect.recording_of)(&entry.values, index)
        };
        self.free().into_iter().map(of).collect()
    }
}

/// With what no slope leads to in one of its entries, an order or a rough number, at the top of its likelihood, all else refitted beside
/// it; none where it is there.
pub(crate) fn with_likelier_neighbour(problem: &Problem, from: &Refitted, entry: usize) -> Option<Refitted> {
    let found = orders::with_likelier_order(problem, from, entry);
    rough::with_likelier_rough(problem, found.as_ref().unwrap_or(from), entry).or(found)
}
