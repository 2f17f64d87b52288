//! Effects at multiples of what the motion can tell.

use rand::Rng;
use rand::rngs::StdRng;
use rand::seq::{IndexedRandom, SliceRandom};
use rustfft::num_complex::Complex;

use super::information::{Column, MATTERS, Motion, TOLD, product};
use super::setting::Setting;
use super::vocabulary::{possible, together, values};
use crate::catalogue::{self, Entry, for_recording};
use crate::named::on_linear_axis;
use crate::outside::{Kind, Needs, Scales, Shape};
use crate::physics::Physics;
use crate::plan::{Arm, Decoy, Drawn, kinds_of};
use crate::seal::Concealed;

/// Multiples of the detectable size, drawn log-uniformly.
const MULTIPLES: [f64; 2] = [0.5, 20.0];
/// A motion that shall not tell leaves it to the size: well above what it could.
const POOR: [f64; 2] = [4.0, 20.0];
/// Least share of a column that the others beside it cannot stand for: the square of the sine of 10 degrees. Below, no motion of
/// the kind tells them apart, and there is nothing to ask.
const OWN_SHARE: f64 = 0.03;
/// A nominal parameter that is off, by this share (diagnosis.md).
const OFF: f64 = 0.05;
/// Least detectable size, as a share of the drive's torque or of what goes with it (of 20 ms for a delay): what docs/method.md states
/// as the smallest that is of use. Where noise is small the information alone would ask for a delay to a microsecond.
pub(super) const LEAST: f64 = 1e-3;
/// Rounds of the search for a size; it doubles its digits in each where information goes with the square.
const ROUNDS: usize = 10;

/// What is put in.
#[derive(Debug, Clone, Copy)]
pub(super) enum Source {
    Vocabulary(&'static Entry),
    Outside(&'static Kind),
}

/// One effect with its values.
#[derive(Debug, Clone)]
pub(super) struct One {
    pub(super) source: Source,
    pub(super) values: Vec<f64>,
    /// Over the detectable size.
    pub(super) multiple: f64,
    /// From 0 to 1, see [`values`].
    pub(super) size: f64,
    /// Share of its column that nothing beside it can stand for.
    pub(super) share: f64,
}

/// The effects of a case.
#[derive(Debug, Clone)]
pub(super) struct Chosen {
    pub(super) effects: Vec<One>,
}

/// Where sizes are sought.
struct Search<'a> {
    setting: &'a Setting,
    scales: &'a Scales,
    motions: &'a [Motion<'a>],
    noise_left: [f64; 2],
}

/// An effect whose detectable size is known.
struct Sized {
    source: Source,
    shape: Shape,
    /// From 0 to 1, see [`values`].
    detectable: f64,
    /// At that size, of the recordings to fit.
    columns: Vec<Vec<Complex<f64>>>,
}

/// Draws the effects of a blueprint; none where this machine or motion has no such.
pub(super) fn choose(
    blueprint: &Drawn,
    setting: &Setting,
    scales: &Scales,
    motions: &[Motion<'_>],
    random: &mut StdRng,
) -> Option<Chosen> {
    let noise_left = motions.last()?.noise_left(random.random());
    let search = Search { setting, scales, motions, noise_left };
    let sources = search.sources(blueprint, random)?;
    let mut sized = Vec::new();
    for source in sources {
        let shape: Shape = std::array::from_fn(|_| random.random());
        sized.push(search.size(source, shape)?);
    }
    let shares = match blueprint.arm {
        Arm::Outside => search.beyond_vocabulary(&sized, random)?,
        _ => beyond_each_other(&sized)?,
    };
    let bounds = if blueprint.arm == Arm::Poor { POOR } else { MULTIPLES };
    let mut effects = Vec::new();
    for (one, share) in sized.iter().zip(shares) {
        let drawn = bounds[0] * (bounds[1] / bounds[0]).powf(random.random());
        let detectable = one.detectable / share.sqrt();
        let multiple = if blueprint.decoy == Some(Decoy::Nominal) { search.off(one)? / detectable } else { drawn };
        let size = multiple * detectable;
        // Larger than the motion's own torques nothing is hidden.
        let values = (size <= 1.0).then(|| search.values(one.source, size, &one.shape)).flatten()?;
        effects.push(One { source: one.source, values, multiple, size, share });
    }
    Some(Chosen { effects })
}

/// Share of each column that the others cannot stand for: one over (inverse of the Gram matrix times its diagonal), for at most
/// three columns by elimination.
fn beyond_each_other(sized: &[Sized]) -> Option<Vec<f64>> {
    let n = sized.len();
    let product = |a: usize, b: usize| -> f64 {
        sized[a].columns.iter().zip(&sized[b].columns).map(|(one, other)| product(one, other)).sum()
    };
    let mut shares = Vec::new();
    for target in 0..n {
        // The target last: what is left of it is the last pivot.
        let order: Vec<usize> = (0..n).filter(|&k| k != target).chain([target]).collect();
        let mut gram: Vec<Vec<f64>> = order.iter().map(|&a| order.iter().map(|&b| product(a, b)).collect()).collect();
        let whole = gram[n - 1][n - 1];
        for pivot in 0..n - 1 {
            for row in pivot + 1..n {
                let factor = gram[row][pivot] / gram[pivot][pivot];
                let above = gram[pivot].clone();
                gram[row].iter_mut().zip(above).for_each(|(cell, above)| *cell -= factor * above);
            }
        }
        shares.push(gram[n - 1][n - 1] / whole);
    }
    shares.iter().all(|share| *share > OWN_SHARE).then_some(shares)
}

/// Columns of the recordings to fit, the last being held out, and how far the effect is beyond what can be told: 1 at the detectable size.
pub(super) fn weighed(
    motions: &[Motion<'_>],
    column: &impl Fn(usize, &Motion<'_>) -> Column,
    noise_left: &[f64; 2],
    is_event: bool,
) -> (Vec<Vec<Complex<f64>>>, f64) {
    let fitted = motions.len().saturating_sub(1);
    let columns: Vec<_> =
        motions[..fitted].iter().enumerate().map(|(k, motion)| motion.whitened(&column(k, motion))).collect();
    let told = columns.iter().map(|column| product(column, column)).sum::<f64>() / TOLD;
    let matters = match motions.last() {
        Some(held_out) if !is_event => (held_out.relevance(&column(fitted, held_out), noise_left) / MATTERS).powi(2),
        _ => f64::INFINITY,
    };
    (columns, told.min(matters))
}

impl Search<'_> {
    /// Which effects, so that all can be in this machine together.
    fn sources(&self, blueprint: &Drawn, random: &mut StdRng) -> Option<Vec<Source>> {
        if blueprint.arm == Arm::Outside {
            let possible = |kind: &&'static Kind| match kind.needs {
                Needs::Nothing => true,
                Needs::Fluid => self.setting.has_fluid(),
                Needs::Command => self.setting.measured.is_none(),
            };
            let kinds: Vec<&'static Kind> = kinds_of(&blueprint.families).into_iter().filter(possible).collect();
            // By family first: a family of three kinds is no likelier than one of two.
            let mut families: Vec<&str> = kinds.iter().map(|kind| kind.family).collect();
            families.dedup();
            let family = families.choose(random)?;
            let own: Vec<&'static Kind> = kinds.into_iter().filter(|kind| kind.family == *family).collect();
            return own.choose(random).map(|&kind| vec![Source::Outside(kind)]);
        }
        let mut ids: Vec<&'static Entry> = self.vocabulary().collect();
        if blueprint.decoy == Some(Decoy::Nominal) {
            ids.retain(|entry| crate::plan::NOMINAL.contains(&entry.id));
        }
        ids.shuffle(random);
        let mut taken: Vec<&'static Entry> = Vec::new();
        for entry in ids {
            if taken.len() < blueprint.effects && taken.iter().all(|other| together(entry.id, other.id)) {
                taken.push(entry);
            }
        }
        (taken.len() == blueprint.effects).then(|| taken.into_iter().map(Source::Vocabulary).collect())
    }

    fn vocabulary(&self) -> impl Iterator<Item = &'static Entry> {
        let (setting, scales) = (self.setting, self.scales);
        catalogue::ENTRIES.iter().filter(move |entry| entry.in_vocabulary && possible(entry.id, setting, scales))
    }

    fn values(&self, source: Source, size: f64, shape: &Shape) -> Option<Vec<f64>> {
        let values = match source {
            Source::Vocabulary(entry) => values(entry.id, self.setting, self.scales, size, shape)?,
            Source::Outside(kind) => (kind.values)(self.scales, size, shape),
        };
        values.iter().all(|value| value.is_finite()).then_some(values)
    }

    /// Size of a parameter that is off by [`OFF`].
    fn off(&self, one: &Sized) -> Option<f64> {
        let Source::Vocabulary(entry) = one.source else { return None };
        Some(match entry.id {
            "coulomb_friction" => OFF * self.scales.coulomb / self.scales.torque,
            _ => OFF,
        })
    }

    fn with(&self, source: Source, size: f64, shape: &Shape) -> Option<Physics> {
        let mut physics = self.motions[0].nominal.clone();
        source.put(&mut physics, &self.values(source, size, shape)?);
        Some(physics)
    }

    /// Columns of the recordings to fit, and how far the effect is beyond what can be told: 1 at the detectable size.
    fn weigh(&self, source: Source, size: f64, shape: &Shape) -> Option<(Vec<Vec<Complex<f64>>>, f64)> {
        use rand::SeedableRng as _;
        let physics = self.with(source, size, shape)?;
        let of = |index: usize, motion: &Motion<'_>| {
            motion.column(&for_recording(&physics, index, &mut StdRng::seed_from_u64(index as u64)))
        };
        Some(weighed(self.motions, &of, &self.noise_left, source.is_event()))
    }

    /// The size at which the effect can just be told and is of use.
    fn size(&self, source: Source, shape: Shape) -> Option<Sized> {
        match self.weigh(source, LEAST, &shape) {
            Some((columns, excess)) if excess >= 1.0 => Some(Sized { source, shape, detectable: LEAST, columns }),
            _ => self.size_above_least(source, shape),
        }
    }

    fn size_above_least(&self, source: Source, shape: Shape) -> Option<Sized> {
        let mut size: f64 = 0.02;
        let (mut low, mut high) = (LEAST, 4.0_f64);
        for _ in 0..ROUNDS {
            let Some((columns, excess)) = self.weigh(source, size, &shape) else {
                // Not a machine any more: smaller.
                high = size;
                size = (low * high).sqrt();
                continue;
            };
            if !excess.is_finite() {
                return None;
            }
            if (excess.ln()).abs() < 0.1 {
                return Some(Sized { source, shape, detectable: size, columns });
            }
            if excess < 1.0 {
                low = size
            } else {
                high = size
            }
            let next = size * excess.max(1e-6).powf(-0.5).clamp(1e-2, 30.0);
            size = if low < next && next < high { next } else { (low * high).sqrt() };
            if low > 2.0 {
                return None;
            }
        }
        None
    }

    /// Share of each column that no single effect of the vocabulary can stand for.
    fn beyond_vocabulary(&self, sized: &[Sized], random: &mut StdRng) -> Option<Vec<f64>> {
        let mut shares = Vec::new();
        for one in sized {
            let own: f64 = one.columns.iter().map(|column| product(column, column)).sum();
            let mut share = 1.0_f64;
            for entry in self.vocabulary() {
                let shape: Shape = std::array::from_fn(|_| random.random());
                let Some((columns, _)) = self.weigh(Source::Vocabulary(entry), 0.05, &shape) else { continue };
                let its: f64 = columns.iter().map(|column| product(column, column)).sum();
                let both: f64 = columns.iter().zip(&one.columns).map(|(a, b)| product(a, b)).sum();
                share = share.min(1.0 - both * both / (own * its).max(f64::MIN_POSITIVE));
            }
            shares.push(share);
        }
        shares.iter().all(|share| *share > OWN_SHARE).then_some(shares)
    }
}

impl Source {
    fn put(self, physics: &mut Physics, values: &[f64]) {
        match self {
            Self::Vocabulary(entry) => entry.put(physics, values),
            Self::Outside(kind) => kind.conceal(physics, values),
        }
    }

    /// Whether it is judged on the recording it happens in and not on what is held out.
    pub(super) fn is_event(self) -> bool {
        matches!(self, Self::Vocabulary(entry) if matches!(entry.id, "disturbance_pulse" | "sensor_glitch"))
    }
}

impl Chosen {
    /// The machine with the effects.
    pub(super) fn conceal(&self, physics: &Physics) -> Physics {
        let mut physics = physics.clone();
        self.effects.iter().for_each(|one| one.source.put(&mut physics, &one.values));
        physics
    }
}

impl One {
    pub(super) fn family(&self) -> Option<&'static str> {
        match self.source {
            Source::Vocabulary(_) => None,
            Source::Outside(kind) => Some(kind.family),
        }
    }

    /// As the seal has it; parameters under the names of the axis.
    pub(super) fn sealed(&self, linear: bool) -> Concealed {
        let (id, names, in_vocabulary) = match self.source {
            Source::Vocabulary(entry) => (entry.id, entry.parameters(), true),
            Source::Outside(kind) => (kind.id, kind.parameters, false),
        };
        let names = names.iter().map(|name| if linear { on_linear_axis(name) } else { (*name).to_owned() });
        Concealed {
            id: id.to_owned(),
            in_vocabulary,
            size: self.multiple,
            strength: self.size,
            parameters: names.zip(self.values.iter().copied()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use rand::SeedableRng;

    use super::super::{Base, families};
    use super::*;

    /// Machines drawn, and single effects for each.
    const MACHINES: u64 = 60;
    const EFFECTS: usize = 60;

    #[test]
    fn every_effect_of_the_vocabulary_is_drawn_within_sixty_machines_and_has_a_size_there() {
        let blueprint = Drawn { arm: Arm::Single, effects: 1, decoy: None, families: Vec::new() };
        let mut drawn: BTreeSet<&str> = BTreeSet::new();
        for seed in 0..MACHINES {
            let random = &mut StdRng::seed_from_u64(seed);
            let setting = Setting::draw(false, random);
            let families = families(&blueprint, random);
            let base = Base::run(&setting, &setting.physics, None, &families, random.random());
            let Some(scales) = base.and_then(|base| base.scales(&setting)) else { continue };
            let search = Search { setting: &setting, scales: &scales, motions: &[], noise_left: [1.0; 2] };
            for _ in 0..EFFECTS {
                let Some(sources) = search.sources(&blueprint, random) else { continue };
                let shape: Shape = std::array::from_fn(|_| random.random());
                for source in sources {
                    if let (Source::Vocabulary(entry), Some(_)) = (source, search.values(source, 0.2, &shape)) {
                        drawn.insert(entry.id);
                    }
                }
            }
        }
        let all: BTreeSet<&str> =
            catalogue::ENTRIES.iter().filter(|entry| entry.in_vocabulary).map(|entry| entry.id).collect();
        let missing: Vec<_> = all.difference(&drawn).collect();
        println!("{} of {} effects in {MACHINES} machines", drawn.len(), all.len());
        assert!(missing.is_empty(), "{missing:?}");
    }
}
