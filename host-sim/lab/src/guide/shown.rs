//! Which effects a motion shows, by the columns of the guide on a recording that is there.

use diagnosis::hypothesis::Hypothesis;
use diagnosis::problem::Problem;
use diagnosis::search::nominal;
use diagnosis::separation::{Separation, signature};
use rayon::prelude::*;

use super::sizes::{Measure, Sized};
use super::{Guide, default_experiments, sizes};
use crate::read::{AxisKind, vocabulary};

/// Predicted power from which an effect of a clear size is shown, and told from another: nine times of ten.
const SHOWN: f64 = 0.9;

/// What a motion shows of the effects that a machine can have, each in a size that is clear on the default machine, scaled to this
/// one; those that happen once are left out, for no motion shows them.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Identifiers of those that would be seen, in the order of the vocabulary.
    pub shows: Vec<&'static str>,
    /// Of these each with those that this motion does not tell from it, whatever their sizes.
    pub alike: Vec<(&'static str, Vec<&'static str>)>,
    /// Those that would not be seen.
    pub hidden: Vec<Clear>,
}

/// An effect in the size that was asked about.
#[derive(Debug, Clone, PartialEq)]
pub struct Clear {
    /// Which.
    pub id: &'static str,
    /// The reported parameter that tells the size; its name ends in its unit.
    pub parameter: &'static str,
    /// Its value.
    pub value: f64,
}

/// What one effect leaves of the nominal model along the motion.
struct Left {
    of: Clear,
    /// Whitened innovations.
    left: Vec<f64>,
    /// Their norm, 1.
    size: f64,
}

impl Left {
    fn is_shown(&self) -> bool {
        power(self.size) >= SHOWN
    }

    /// Whether what is left beside the other, in the size that fits best, would still be seen.
    fn is_told_from(&self, other: &Self) -> bool {
        let product: f64 = self.left.iter().zip(&other.left).map(|(a, b)| a * b).sum();
        let along = product / other.size;
        power((self.size * self.size - along * along).max(0.0).sqrt()) >= SHOWN
    }
}

fn power(distance: f64) -> f64 {
    Separation { distance }.power()
}

/// What the motion of these recordings shows, with the noise that the nominal machine leaves of them; none where it cannot be
/// followed along them.
pub fn shown(problem: &Problem) -> Option<Shown> {
    let guide = Guide::default();
    let planned = guide.planned(&Hypothesis::default(), &default_experiments())?;
    let default = Measure { physics: &guide.nominal, excitation: &planned.excitation };
    let here = Measure { physics: &problem.nominal, excitation: &problem.excitation };
    let (noise, none) = (nominal(problem)?.noise, Hypothesis::default());
    let axis = if problem.excitation.linear { AxisKind::Linear } else { AxisKind::Rotary };
    let left = |sized: &Sized| {
        let effect = sized.effect;
        if !problem.may_have(effect) {
            return None;
        }
        let clear = sized.clear_on(here, default);
        let told_by = sized.example.told_by;
        let value = (effect.report)(&clear).get(told_by).copied()?;
        let parameter = vocabulary::effect(effect.id)?.parameters.get(told_by)?.id(axis);
        let left = signature(problem, &noise, &none, &none.with(effect, clear))?;
        let size = left.iter().map(|one| one * one).sum::<f64>().sqrt();
        Some(Left { of: Clear { id: effect.id, parameter, value }, left, size })
    };
    let all: Vec<Left> = sizes::all().par_iter().filter_map(left).collect();
    let (shows, hidden): (Vec<&Left>, Vec<&Left>) = all.iter().partition(|one| one.is_shown());
    let alike = |one: &&Left| {
        let others = shows.iter().filter(|other| other.of.id != one.of.id && !one.is_told_from(other));
        let others: Vec<&'static str> = others.map(|other| other.of.id).collect();
        (!others.is_empty()).then_some((one.of.id, others))
    };
    Some(Shown {
        alike: shows.iter().filter_map(alike).collect(),
        shows: shows.iter().map(|one| one.of.id).collect(),
        hidden: hidden.iter().map(|one| one.of.clone()).collect(),
    })
}
