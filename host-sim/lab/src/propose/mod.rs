//! What to record next: the reference that tells rival models apart best.
//!
//! Each reference of a menu that stays within the machine's [`Limits`] is run in closed loop with the first model of
//! each pair. The second one is driven by the same commands in short windows, fitted to them with the values it has, and
//! what is left of it is held against the noise: [`Proposal::power`] is the probability that the paired test over blocks of
//! 0.4 s (of the windows' sums of squares) tells the two apart at p < 1e-3. A reference is as good
//! as its worst pair.

mod ambiguous;
mod drive;
mod limits;
mod menu;
mod noise;
mod power;
mod rival;
mod separation;
mod signature;
#[cfg(test)]
mod tests;
mod write;

use rayon::prelude::*;

pub use ambiguous::for_ambiguous;
pub use limits::Limits;
pub use menu::Item;
pub use power::P_VALUE;
pub use rival::Rival;
pub use signature::{floor_of, mismatch, power_of, signature};
pub use write::reference_csv;

use crate::Error;
use crate::read::{AxisKind, Machine, Recording};
use crate::refit::HORIZON_S;
use crate::report::Experiment;
use drive::{Loop, Motion, STRIDE};
use menu::{DURATION_S, STEPS_SEED, Scale, menu};
use noise::Noise;
use power::{Block, SEED, noncentrality, power};
use separation::Contest;

/// What is to be told apart, and on which machine.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The machine: axis, controller, sample period.
    pub machine: &'a Machine,
    /// Two or more models; the first is the likeliest.
    pub rivals: &'a [Rival],
    /// What the machine may be put through.
    pub limits: Limits,
    /// Standard deviation of the position's noise, rad (m).
    pub sensor_rms: f64,
    /// What noise of sensor and torque together leaves in windows of 50 ms, root mean square, rad (m).
    pub floor_rms: f64,
}

/// How well one reference tells two rivals apart.
#[derive(Debug, Clone, PartialEq)]
pub struct PairPower {
    /// The model that made the motion.
    pub right: String,
    /// The model that was fitted to it.
    pub rival: String,
    /// What is left of the rival after its best fit over what noise leaves, both root mean square, 1.
    pub left_over_noise: f64,
    /// Standard deviations by which a test that knew the difference would see it, 1.
    pub noncentrality: f64,
    /// Probability that the test tells them apart, 1.
    pub power: f64,
}

/// One reference of the menu with what it would tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    /// The reference, as long as it is proposed.
    pub item: Item,
    /// Each pair of rivals.
    pub power: Vec<PairPower>,
}

impl Offer {
    /// Power of the worst pair, 1.
    pub fn worst(&self) -> f64 {
        self.power.iter().map(|pair| pair.power).fold(1.0, f64::min)
    }

    fn noncentrality(&self) -> f64 {
        self.power.iter().map(|pair| pair.noncentrality).fold(f64::INFINITY, f64::min)
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
    /// Each pair of rivals under it.
    pub power: Vec<PairPower>,
    /// The whole menu, best first.
    pub menu: Vec<Offer>,
    /// Of the levels of random steps.
    pub steps_seed: u32,
    /// Of the drawn noise that the power is counted over.
    pub power_seed: u64,
}

impl Proposal {
    /// As an answer has it; its reference has not been written yet.
    pub fn experiment(&self) -> Experiment {
        Experiment { text: self.text.clone(), separates: self.separates.clone(), reference_csv: None }
    }
}

/// A power that is worth the time of a recording.
const WORTH: f64 = 0.9;
/// A power below this is none: of twenty recordings at most one would tell.
const NO_POWER: f64 = 0.05;
/// A reference is recorded at most this many times its first length.
const LONGEST: [usize; 3] = [1, 2, 4];

/// What tells rivals apart that no motion does: a measurement of another kind.
fn instead(rivals: &[Rival]) -> String {
    let concerns =
        |ids: &[&str]| rivals.iter().flat_map(|rival| &rival.active).any(|entry| ids.contains(&entry.effect.id));
    let of_inertia = ["inertia", "torque_gain", "torque_saturation"];
    let others: [(&[&str], &str); 5] = [
        (&of_inertia, "weigh what moves, or measure the torque constant: the command that holds a known weight"),
        (&["field_gain", "er_strength", "er_drift"], "measure the voltage over the gap of the fluid"),
        (
            &["sensor_latency", "torque_delay", "torque_lag"],
            "measure the drive's answer to a step of current by itself",
        ),
        (
            &["gravity_load", "spring_load", "cogging", "torque_offset"],
            "measure the torque that holds some positions at rest",
        ),
        (&["compliance", "backlash"], "measure the load's position as well, or hold the load and turn the motor"),
    ];
    let found: Vec<&str> = others.into_iter().filter(|(ids, _)| concerns(ids)).map(|(_, text)| text).collect();
    let found = if found.is_empty() { "measure one of them by itself".to_owned() } else { found.join("; or ") };
    let ids: Vec<&str> = rivals.iter().map(|rival| rival.id.as_str()).collect();
    format!(
        "No motion within the limits of speed, torque and travel tells {} apart. Instead {found}.",
        ids.join(" and ")
    )
}

/// The reference of the menu that tells the rivals apart best; without one, where no reference tells anything, what would
/// instead. None for fewer than two rivals, or where no reference can be run within the limits.
pub fn best(request: &Request<'_>) -> Option<Proposal> {
    if request.rivals.len() < 2 {
        return None;
    }
    let planner = Planner::new(request);
    let items = menu(&planner.scale());
    let mut judged: Vec<Judged> = items.par_iter().filter_map(|item| planner.judge(item)).collect();
    // Equal powers are ordered by what is behind them; a stable sort keeps the order of the menu after that.
    let rank = |judged: &Judged| (judged.offer.worst(), judged.offer.noncentrality());
    judged.sort_by(|a, b| rank(b).0.total_cmp(&rank(a).0).then(rank(b).1.total_cmp(&rank(a).1)));
    let first = judged.first()?;
    let chosen = planner.long_enough(first);
    let tells = chosen.worst() >= NO_POWER;
    let reference = if tells { planner.reference(&chosen.item)? } else { Vec::new() };
    Some(Proposal {
        text: if tells { planner.text(&chosen) } else { instead(request.rivals) },
        separates: request.rivals.iter().map(|rival| rival.id.clone()).collect(),
        reference,
        power: chosen.power,
        menu: judged.into_iter().map(|judged| judged.offer).collect(),
        steps_seed: STEPS_SEED,
        power_seed: SEED,
    })
}

/// What making a recording again would tell, each pair of rivals; the windows start where the recording's do.
///
/// # Errors
/// A recording too short for one window, or a machine that cannot be simulated.
pub fn repeating(request: &Request<'_>, recording: &Recording) -> Result<Vec<PairPower>, Error> {
    let planner = Planner::new(request);
    let mut all = Vec::new();
    for (index, right) in request.rivals.iter().enumerate() {
        let motion = Motion::recorded(recording, right)?;
        for rival in &request.rivals[index + 1..] {
            if let Some((power, _)) = planner.pair(right, rival, &motion) {
                all.push(power);
            }
        }
    }
    Ok(all)
}

/// An offer with the blocks of each pair, to predict a longer recording by.
struct Judged {
    offer: Offer,
    blocks: Vec<Vec<Block>>,
    noise: Noise,
}

struct Planner<'a> {
    request: &'a Request<'a>,
    drive: Loop,
}

impl<'a> Planner<'a> {
    fn new(request: &'a Request<'a>) -> Self {
        Self { request, drive: Loop::of(request.machine, &request.limits) }
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

    /// Motions of all rivals but the last along a reference, made smaller until the limits allow them.
    fn motions(&self, item: &Item) -> Option<(Item, Vec<Motion>)> {
        let rivals = self.request.rivals;
        let mut item = item.clone();
        for _ in 0..6 {
            let motions: Option<Vec<Motion>> =
                rivals[..rivals.len() - 1].iter().map(|rival| self.drive.motion(rival, &item)).collect();
            match motions {
                Some(motions) if motions.iter().all(|motion| self.request.limits.allow(&motion.asked)) => {
                    return Some((item, motions));
                }
                _ => item = item.resized(0.6),
            }
        }
        None
    }

    fn judge(&self, item: &Item) -> Option<Judged> {
        let (item, motions) = self.motions(item)?;
        let (mut pairs, mut blocks) = (Vec::new(), Vec::new());
        for (index, motion) in motions.iter().enumerate() {
            let right = &self.request.rivals[index];
            for rival in &self.request.rivals[index + 1..] {
                let (pair, of_pair) = self.pair(right, rival, motion)?;
                pairs.push(pair);
                blocks.push(of_pair);
            }
        }
        let noise = self.noise(motions.first()?);
        Some(Judged { offer: Offer { item, power: pairs }, blocks, noise })
    }

    fn noise(&self, motion: &Motion) -> Noise {
        let period_s = HORIZON_S / motion.rows as f64;
        Noise::new(self.request.sensor_rms, self.request.floor_rms, motion.rows, period_s)
    }

    fn pair(&self, right: &Rival, rival: &Rival, motion: &Motion) -> Option<(PairPower, Vec<Block>)> {
        let contest = Contest::new(right, motion)?;
        let left = contest.left(rival)?;
        let noise = self.noise(motion);
        let blocks = contest.blocks(&left, &noise, STRIDE);
        let rms = (left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64).sqrt();
        let pair = PairPower {
            right: right.id.clone(),
            rival: rival.id.clone(),
            left_over_noise: rms / noise.rms(),
            noncentrality: noncentrality(&blocks),
            power: power(&blocks, 1, &noise),
        };
        Some((pair, blocks))
    }

    /// The reference for as long as it takes, up to four times its length, to be worth recording.
    fn long_enough(&self, judged: &Judged) -> Offer {
        let longer = |repeats: usize| {
            let pairs = judged.offer.power.iter().zip(&judged.blocks);
            let power = pairs.map(|(pair, blocks)| PairPower {
                power: power(blocks, repeats, &judged.noise),
                noncentrality: pair.noncentrality * (repeats as f64).sqrt(),
                ..pair.clone()
            });
            Offer { item: judged.offer.item.lasting(DURATION_S * repeats as f64), power: power.collect() }
        };
        let mut chosen = longer(LONGEST[0]);
        for repeats in &LONGEST[1..] {
            if chosen.worst() >= WORTH {
                break;
            }
            chosen = longer(*repeats);
        }
        chosen
    }

    fn reference(&self, item: &Item) -> Option<Vec<(f64, f64)>> {
        let period_s = self.drive.period_s();
        let sequence = item.experiment.start(period_s as f32).ok()?;
        let row = |(tick, counts): (usize, er_servo::Counts)| (tick as f64 * period_s, counts.to_rad() * item.unit);
        Some(sequence.enumerate().map(row).collect())
    }

    fn text(&self, offer: &Offer) -> String {
        let duration_s = offer.item.experiment.duration_s;
        let worst = offer.power.iter().min_by(|a, b| a.power.total_cmp(&b.power));
        let Some(worst) = worst else { return String::new() };
        let how = match self.drive {
            Loop::Law(_) => format!("`servo-lab link run {}`, or the reference as CSV", offer.item.flags()),
            Loop::Pd { .. } => "the reference as CSV".to_owned(),
        };
        let PairPower { right, rival, left_over_noise, power, .. } = worst;
        let verdict = if *power < 0.5 {
            format!("no reference of the menu tells {right} from {rival} well; this one comes nearest")
        } else {
            format!("it tells {right} from {rival} best")
        };
        format!(
            "Record {}, {duration_s} s, from rest ({how}). Of all within the limits of speed, torque and travel {verdict}: \
             fitted to it, {rival} leaves {left_over_noise:.2} times the noise where {right} is right, predicted power \
             {power:.2} at p < {P_VALUE}.",
            offer.item.name
        )
    }
}
