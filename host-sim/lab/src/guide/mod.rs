//! A field guide to the vocabulary on the default machine: what each effect leaves of the nominal model, which others leave
//! nearly the same on which motion, what tells them apart, and how small an effect the default experiments still show.
//!
//! All of it is predicted from the models with the noise of [`Guide`]; only `prove` measures what `diagnose` finds.

mod figure;
mod shown;
mod sizes;
mod table;

pub use shown::{Clear, Shown, shown};
pub use table::markdown;

use diagnosis::effects::{Effect, VOCABULARY};
use diagnosis::hypothesis::Hypothesis;
use diagnosis::likelihood::Noise;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::separation::{Separation, separation, signature};
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use rayon::prelude::*;

use crate::plot::Figure;
use crate::progress::Progress;
use crate::propose::{Item, Limits, Loop, Request, best};
use crate::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal, vocabulary};
use sizes::Sized;

/// Signatures closer than this are confused, degrees.
const CONFUSED_DEG: f64 = 25.0;
/// Others listed at most.
const LISTED: usize = 3;

/// An effect that leaves nearly the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Confused {
    /// Which.
    pub id: &'static str,
    /// Angle between the two signatures, degrees; 0 is the same but for size.
    pub angle_deg: f64,
}

/// What the guide says of one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Which.
    pub id: &'static str,
    /// Residual torque of the nominal model over the channel that explains most of it.
    pub figure: Option<Figure>,
    /// Nearest others on the default experiments.
    pub on_rich: Vec<Confused>,
    /// Nearest others on a slow sine.
    pub on_sine: Vec<Confused>,
    /// Reference that tells it from the nearest of these, and the predicted power.
    pub separated_by: Option<(&'static str, Item, f64)>,
    /// Parameter that tells the size, with its unit.
    pub parameter: &'static str,
    /// Its value on the default machine; none where that is no number.
    pub nominal: Option<f64>,
    /// Value at which the predicted power is 50 %, and 90 %; none where no size reaches it, or none is small enough.
    pub detectable: [Option<f64>; 2],
}

/// What the guide is computed on.
#[derive(Debug, Clone)]
pub struct Guide {
    machine: Machine,
    nominal: Physics,
    limits: Limits,
    noise: Noise,
}

/// Each effect but events and wrong samples, in the order of the vocabulary, with fitted values at which it is clear on the default
/// machine.
pub fn clear() -> impl Iterator<Item = (&'static Effect, Vec<f64>)> {
    VOCABULARY.iter().filter_map(|&effect| Some((effect, (effect.example?.at)(1.0))))
}

/// Torque noise held over each control period, N m.
pub(super) const TORQUE_NOISE_NM: f64 = 0.05;

impl Default for Guide {
    /// The servo of the paper, the steps of its resolver, and 0.05 N m of torque noise.
    fn default() -> Self {
        let resolution = std::f64::consts::TAU / 491_520.0;
        let machine = Machine {
            file: "machine.toml".into(),
            name: "er-dd-servo".to_owned(),
            axis: Axis { kind: AxisKind::Rotary, sample_period_s: 5e-4, resolution },
            plant: PlantNominal {
                inertia: 0.075,
                coulomb: 0.763,
                viscous: 0.0,
                torque_gain: 1.0,
                torque_offset: 0.0,
                torque_limit: Some(30.0),
                sample_to_output_s: 0.0,
                torque_delay_s: 0.005,
                er: Some(ErNominal { a: 0.0704, b: 0.470, dead_time_s: 0.002, lag_s: 0.003, fluid: None }),
            },
            controller: Some(Config::default()),
            columns: Default::default(),
            effects: Vec::new(),
        };
        let nominal = Physics::nominal(&machine, &[]);
        let noise = Noise::white(
            resolution / 12.0_f64.sqrt(),
            TORQUE_NOISE_NM * TORQUE_NOISE_NM * machine.axis.sample_period_s,
        );
        Self { limits: Limits::of(&machine, &[]), nominal, machine, noise }
    }
}

fn item(name: &'static str, shape: Shape) -> Item {
    Item { name, experiment: Experiment { shape, duration_s: 8.0 }, unit: 1.0 }
}

/// The default experiments: what is recorded where nothing is known yet.
fn default_experiments() -> [Item; 2] {
    [
        item("steps", Shape::Steps { amplitude_rad: 0.9, dwell_s: 0.5, seed: 1 }),
        item("multisine", Shape::Multisine { amplitude_rad: 0.5, low_hz: 0.2, high_hz: 3.0, tones: 8 }),
    ]
}

/// A motion that tells little.
fn slow_sine() -> [Item; 1] {
    [item("slow sine", Shape::Chirp { amplitude_rad: 0.35, from_hz: 0.3, to_hz: 0.3 })]
}

impl Guide {
    fn hypothesis(sized: &Sized, size: f64) -> Hypothesis {
        Hypothesis::default().with(sized.effect, (sized.example.at)(size))
    }

    /// What a machine with those effects would record along each experiment; none where one cannot be run.
    fn planned(&self, right: &Hypothesis, items: &[Item]) -> Option<Problem> {
        let drive = Loop::of(&self.machine, &self.limits);
        let physics = right.physics(&self.nominal);
        let motions: Option<Vec<_>> = items.iter().map(|item| Some(drive.motion(&physics, item)?.recorded)).collect();
        Some(Problem::new(self.nominal.clone(), motions?, items.len(), self.machine.axis.resolution, false))
    }

    fn noises(&self, items: &[Item]) -> Vec<Noise> {
        vec![self.noise; items.len()]
    }

    /// One page for each effect that an experiment can show, in the order of the vocabulary; with `only`, of those named.
    pub fn pages(&self, only: &[String]) -> Vec<Page> {
        let all = sizes::all();
        let rich = self.signatures(&all, &default_experiments());
        let sine = self.signatures(&all, &slow_sine());
        let is_wanted = |index: &usize| only.is_empty() || only.iter().any(|id| id == all[*index].effect.id);
        let wanted: Vec<usize> = (0..all.len()).filter(is_wanted).collect();
        let progress = Progress::new("field guide, effects", wanted.len() as u64);
        let page = |index| {
            let page = self.page(&all, index, &rich, &sine);
            progress.advance(1);
            page
        };
        wanted.into_par_iter().filter_map(page).collect()
    }

    /// Signature of each effect along motions of the default machine, as a unit vector.
    fn signatures(&self, all: &[Sized], items: &[Item]) -> Vec<Option<Vec<f64>>> {
        let nominal = Hypothesis::default();
        let Some(planned) = self.planned(&nominal, items) else { return vec![None; all.len()] };
        let noise = self.noises(items);
        let of = |sized: &Sized| {
            let mut difference = signature(&planned, &noise, &nominal, &Self::hypothesis(sized, 1.0))?;
            let size = difference.iter().map(|d| d * d).sum::<f64>().sqrt();
            difference.iter_mut().for_each(|d| *d /= size);
            (size > 0.0).then_some(difference)
        };
        all.par_iter().map(of).collect()
    }

    fn page(&self, all: &[Sized], index: usize, rich: &[Option<Vec<f64>>], sine: &[Option<Vec<f64>>]) -> Option<Page> {
        let sized = &all[index];
        let Sized { effect, example } = sized;
        let (on_rich, on_sine) = (confused(all, index, rich), confused(all, index, sine));
        let nearest = on_rich.iter().chain(&on_sine).min_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
        let kind = vocabulary::effect(effect.id)?;
        let told = |size: f64| (effect.report)(&(example.at)(size)).get(example.told_by).copied();
        Some(Page {
            id: effect.id,
            figure: figure::figure(self, sized, &default_experiments()),
            separated_by: nearest
                .and_then(|other| self.separated(sized, all.iter().find(|sized| sized.effect.id == other.id)?)),
            on_rich,
            on_sine,
            parameter: kind.parameters.get(example.told_by)?.id(AxisKind::Rotary),
            nominal: told(0.0).filter(|value| example.nested && value.is_finite()),
            detectable: [0.5, 0.9].map(|power| self.detectable(sized, power).and_then(told)),
        })
    }

    fn separated(&self, sized: &Sized, other: &Sized) -> Option<(&'static str, Item, f64)> {
        let rivals = [sized, other].map(|of| Self::hypothesis(of, 1.0));
        let request = Request {
            machine: &self.machine,
            rivals: &rivals,
            limits: self.limits,
            noise: self.noise,
            as_commands: false,
        };
        let offer = best(&request)?.menu.into_iter().next()?;
        let power = offer.power();
        Some((other.effect.id, offer.item, power))
    }

    /// Smallest size that the default experiments show with a power, to 3 %.
    fn detectable(&self, sized: &Sized, wanted: f64) -> Option<f64> {
        if !sized.example.nested {
            return None;
        }
        let (items, nominal) = (default_experiments(), Hypothesis::default());
        // A machine that trips is found at once.
        let seen = |size: f64| {
            let right = Self::hypothesis(sized, size);
            let power = self.planned(&right, &items).and_then(|planned| {
                separation(&planned, &self.noises(&items), &right, &nominal).map(Separation::power)
            });
            power.unwrap_or(1.0) >= wanted
        };
        let (mut low, mut high) = (1e-3, 3.0);
        if seen(low) || !seen(high) {
            return None;
        }
        while high > 1.03 * low {
            let middle = f64::sqrt(low * high);
            if seen(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }
}

/// The others whose signature points the same way or the opposite one, nearest first.
fn confused(all: &[Sized], index: usize, signatures: &[Option<Vec<f64>>]) -> Vec<Confused> {
    let Some(own) = &signatures[index] else { return Vec::new() };
    let others = all.iter().zip(signatures).enumerate().filter(|(other, _)| *other != index);
    let mut found: Vec<Confused> = others
        .filter_map(|(_, (sized, signature))| {
            let product: f64 = own.iter().zip(signature.as_ref()?).map(|(a, b)| a * b).sum();
            Some(Confused { id: sized.effect.id, angle_deg: product.abs().min(1.0).acos().to_degrees() })
        })
        .filter(|confused| confused.angle_deg < CONFUSED_DEG)
        .collect();
    found.sort_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
    found.truncate(LISTED);
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn weak_fluid_is_confused_with_low_gain_on_a_sine_and_friction_is_seen_long_before_it_is_clear() {
        let guide = Guide::default();
        let all = sizes::all();
        let place = |id: &str| all.iter().position(|sized| sized.effect.id == id).unwrap();
        let sine = guide.signatures(&all, &slow_sine());
        let weak = confused(&all, place("er_strength"), &sine);
        assert!(weak.iter().any(|other| other.id == "field_gain"), "{weak:?}");
        assert!(weak.is_sorted_by(|a, b| a.angle_deg <= b.angle_deg));
        let friction = all[place("coulomb_friction")];
        let [half, most] = [0.5, 0.9].map(|power| guide.detectable(&friction, power).unwrap());
        assert!(half <= most && most < 1.0, "{half} {most}");
    }
}
