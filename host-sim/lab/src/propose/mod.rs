//! What to record next: the reference that tells rival hypotheses apart best.
//!
//! Each reference of a menu that stays within the machine's [`Limits`] is run in closed loop with the first hypothesis. Along that
//! motion every other one is refitted to it, on the columns that the diagnosis itself uses, and what is left of it in standard
//! deviations of the noise gives the probability that the confidence set would exclude it. A reference is as good as its worst
//! pair.

mod drive;
mod limits;
mod menu;
#[cfg(test)]
mod tests;
mod write;

use diagnosis::hypothesis::Hypothesis;
use diagnosis::likelihood::Noise;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::separation::{Separation, separation};
use rayon::prelude::*;

pub(crate) use drive::Loop;
pub use limits::Limits;
pub use menu::Item;
pub use write::reference_csv;

use crate::progress::Course;
use crate::read::{AxisKind, Machine};
use crate::report::Experiment;
use drive::Motion;
use menu::{DURATION_S, STEPS_SEED, Scale, menu};

/// What is to be told apart, and on which machine.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The machine: axis, controller, sample period.
    pub machine: &'a Machine,
    /// Two or more hypotheses on top of it; the first is the likeliest.
    pub rivals: &'a [Hypothesis],
    /// What the machine may be put through.
    pub limits: Limits,
    /// The noise that a recording will have.
    pub noise: Noise,
    /// Whether its torque column will be read as commands where it may be a measurement.
    pub as_commands: bool,
}

/// How well one reference tells two rivals apart.
#[derive(Debug, Clone, PartialEq)]
pub struct PairPower {
    /// The hypothesis that made the motion.
    pub right: String,
    /// The hypothesis that was fitted to it.
    pub rival: String,
    /// What is left between them.
    pub separation: Separation,
}

/// One reference of the menu with what it would tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// The reference, as long as it is proposed.
    pub item: Item,
    /// The first rival against each of the others.
    pub pairs: Vec<PairPower>,
}

impl Offer {
    /// The pair that it tells least of.
    fn worst(&self) -> Option<&PairPower> {
        self.pairs.iter().min_by(|a, b| a.separation.distance.total_cmp(&b.separation.distance))
    }

    /// Power of the worst pair, 1.
    pub fn power(&self) -> f64 {
        self.worst().map_or(0.0, |pair| pair.separation.power())
    }

    fn distance(&self) -> f64 {
        self.worst().map_or(0.0, |pair| pair.separation.distance)
    }

    /// The same made so many times as long.
    fn longer(&self, times: usize) -> Self {
        let pair = |pair: &PairPower| PairPower { separation: pair.separation.repeated(times), ..pair.clone() };
        Self { item: self.item.lasting(DURATION_S * times as f64), pairs: self.pairs.iter().map(pair).collect() }
    }
}

/// What to record next.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// One or two sentences: what, for how long, why.
    pub text: String,
    /// Identifiers of the rivals.
    pub separates: Vec<String>,
    /// (t, position from where the axis stands), s and rad (m); one a control period. Empty where no motion tells.
    pub reference: Vec<(f64, f64)>,
    /// The first rival against each of the others under it.
    pub pairs: Vec<PairPower>,
    /// The whole menu, best first.
    pub menu: Vec<Offer>,
    /// Of the levels of random steps.
    pub steps_seed: u32,
}

impl Proposal {
    /// As an answer has it; its reference has not been written yet.
    pub fn experiment(&self) -> Experiment {
        Experiment { text: self.text.clone(), separates: self.separates.clone(), reference_csv: None }
    }
}

/// A power that is worth the time of a recording.
const WORTH: f64 = 0.9;
/// A power below this is none: the level of the test itself, which a motion that tells nothing has.
const NO_POWER: f64 = 0.1;
/// A reference is recorded at most this many times its first length.
const LONGEST: [usize; 3] = [1, 2, 4];

/// The effects of a hypothesis in words.
pub fn name(hypothesis: &Hypothesis) -> String {
    let mut ids: Vec<&str> = hypothesis.entries.iter().map(|entry| entry.effect.id).collect();
    ids.dedup();
    if ids.is_empty() { "the nominal machine".to_owned() } else { ids.join(" and ") }
}

/// What tells rivals apart that no motion does: a measurement of another kind.
fn instead(rivals: &[Hypothesis]) -> String {
    let mut found: Vec<&str> =
        rivals.iter().flat_map(|rival| &rival.entries).filter_map(|entry| entry.effect.measured_by).collect();
    found.sort_unstable();
    found.dedup();
    let found = if found.is_empty() { "measure one of them by itself".to_owned() } else { found.join("; or ") };
    let names: Vec<String> = rivals.iter().map(name).collect();
    format!(
        "No motion within the limits of speed, torque and travel tells {} from {}. Instead {found}.",
        names[0],
        names[1..].join(" or ")
    )
}

/// The reference of the menu that tells the rivals apart best; without one, where no reference tells anything, what would
/// instead. None for fewer than two rivals, or where no reference can be run within the limits.
pub fn best(request: &Request<'_>) -> Option<Proposal> {
    best_on(request, &Course::unseen())
}

/// The same, which shows how far it is.
pub fn best_on(request: &Request<'_>, course: &Course) -> Option<Proposal> {
    if request.rivals.len() < 2 {
        return None;
    }
    let planner = Planner::new(request);
    let items = menu(&planner.scale());
    let count = course.count("what to record next", items.len() as u64);
    let judged = |item: &Item| {
        let offer = planner.judge(item);
        count.advance();
        offer
    };
    let mut offers: Vec<Offer> = items.par_iter().filter_map(judged).collect();
    // A stable sort keeps the order of the menu among equals.
    offers.sort_by(|a, b| b.distance().total_cmp(&a.distance()));
    let first = offers.first()?;
    let mut longer = LONGEST.into_iter().map(|times| first.longer(times));
    let chosen = longer.clone().find(|offer| offer.power() >= WORTH).or_else(|| longer.next_back())?;
    let tells = chosen.power() >= NO_POWER;
    let reference = if tells { planner.reference(&chosen.item)? } else { Vec::new() };
    Some(Proposal {
        text: if tells { planner.text(&chosen) } else { instead(request.rivals) },
        separates: request.rivals.iter().map(name).collect(),
        reference,
        pairs: chosen.pairs,
        menu: offers,
        steps_seed: STEPS_SEED,
    })
}

struct Planner<'a> {
    request: &'a Request<'a>,
    nominal: Physics,
    drive: Loop,
}

impl<'a> Planner<'a> {
    fn new(request: &'a Request<'a>) -> Self {
        let nominal = Physics::nominal(request.machine, &[]);
        Self { request, nominal, drive: Loop::of(request.machine, &request.limits) }
    }

    fn scale(&self) -> Scale {
        let Request { machine, limits, .. } = *self.request;
        let brake = machine.plant.er.as_ref().map_or(0.0, |er| er.a * 9.0 + er.b * 3.0);
        let linear = machine.axis.kind == AxisKind::Linear;
        Scale {
            limits,
            breakaway: (machine.plant.coulomb + brake) / self.drive.stiffness(),
            unit: if linear { limits.travel } else { 1.0 },
            brake: machine.plant.er.is_some(),
        }
    }

    /// Motion of the first rival along a reference, made smaller until the limits allow it.
    fn motion(&self, item: &Item) -> Option<(Item, Motion)> {
        let physics = self.request.rivals.first()?.physics(&self.nominal);
        let mut item = item.clone();
        for _ in 0..6 {
            match self.drive.motion(&physics, &item) {
                Some(motion) if self.request.limits.allow(&motion.asked) => return Some((item, motion)),
                _ => item = item.resized(0.6),
            }
        }
        None
    }

    fn judge(&self, item: &Item) -> Option<Offer> {
        let (item, motion) = self.motion(item)?;
        let Request { machine, rivals, noise, as_commands, .. } = self.request;
        let linear = machine.axis.kind == AxisKind::Linear;
        let planned = Problem::new(self.nominal.clone(), vec![motion.recorded], 1, machine.axis.resolution, linear);
        let planned = if *as_commands { planned.as_commands().unwrap_or(planned) } else { planned };
        let (right, others) = rivals.split_first()?;
        let pair = |rival: &Hypothesis| {
            let separation = separation(&planned, &[*noise], right, rival)?;
            Some(PairPower { right: name(right), rival: name(rival), separation })
        };
        let pairs: Option<Vec<PairPower>> = others.iter().map(pair).collect();
        Some(Offer { item, pairs: pairs? })
    }

    fn reference(&self, item: &Item) -> Option<Vec<(f64, f64)>> {
        let period_s = self.drive.period_s();
        let sequence = item.experiment.start(period_s as f32).ok()?;
        let row = |(tick, counts): (usize, er_servo::Counts)| (tick as f64 * period_s, counts.to_rad() * item.unit);
        Some(sequence.enumerate().map(row).collect())
    }

    fn text(&self, offer: &Offer) -> String {
        let duration_s = offer.item.experiment.duration_s;
        let Some(worst) = offer.worst() else { return String::new() };
        let how = match self.drive {
            Loop::Law(_) => format!("`servo-lab link run {}`, or the reference as CSV", offer.item.flags()),
            Loop::Pd { .. } => "the reference as CSV".to_owned(),
        };
        let PairPower { right, rival, separation } = worst;
        let power = separation.power();
        let verdict = if power < 0.5 {
            format!("no reference of the menu tells {right} from {rival} well; this one comes nearest")
        } else {
            format!("it tells {right} from {rival} best")
        };
        format!(
            "Record {}, {duration_s} s, from rest ({how}). Of all within the limits of speed, torque and travel {verdict}: \
             fitted to it, {rival} stays {:.1} standard deviations away where {right} is right, predicted power {power:.2}.",
            offer.item.name, separation.distance
        )
    }
}
