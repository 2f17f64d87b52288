//! The references to choose from: all built into the firmware, so that a drive runs them without a host.

use std::f64::consts::TAU;

use er_servo::experiment::{Experiment, Shape};

use super::Limits;

/// Length that is simulated and first proposed, s.
pub(super) const DURATION_S: f64 = 8.0;

/// A reference of the menu.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// What it does, in words.
    pub name: &'static str,
    /// What the firmware runs. Its radians are multiples of `unit`.
    pub experiment: Experiment,
    /// Length of one of its radians: 1 rad on a rotary axis, the travel on a linear one, m.
    pub unit: f64,
}

/// What a menu is made for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub limits: Limits,
    /// Error at which the loop's torque overcomes dry friction and the highest braking field, rad (m).
    pub breakaway: f64,
    /// Length of one radian of a shape, rad (m).
    pub unit: f64,
    /// Whether there is a damper that brakes.
    pub brake: bool,
}

/// Every reference that fits the travel; each is made smaller until its speed and torque fit too, when it is simulated.
pub(super) fn menu(scale: &Scale) -> Vec<Item> {
    let (travel, speed) = (scale.limits.travel, scale.limits.speed);
    // An amplitude either way is at most half the travel, and a multisine goes up to twice its own.
    let either_way = |wanted: f64| rounded_deg(wanted.min(0.5 * travel / scale.unit));
    let multisine = |wanted: f64| rounded_deg(wanted.min(0.25 * travel / scale.unit));
    let one_way = |wanted: f64| rounded_deg(wanted.min(travel / scale.unit));
    let rate = |wanted: f64| rounded(wanted.min(speed / scale.unit));
    let breakaway = scale.breakaway / scale.unit;
    let steps = |wanted, dwell_s| Shape::Steps { amplitude_rad: either_way(wanted), dwell_s, seed: STEPS_SEED };
    let ramp = |wanted, travel| Shape::Ramp { speed_rad_s: rate(wanted), travel_rad: one_way(travel) };
    let sine = |wanted, hz| Shape::Chirp { amplitude_rad: either_way(wanted), from_hz: hz, to_hz: hz };
    let named = |braked, plain| if scale.brake { braked } else { plain };
    let shapes = [
        ("one step, then rest", Shape::Step { amplitude_rad: either_way(0.52) }),
        ("steps to random levels", steps(0.9, 0.5)),
        (named("short steps that make the field rise and fall", "short steps"), steps(0.35, 0.25)),
        (named("small steps near the brake", "small steps"), steps(0.06, 0.2)),
        ("slow multisine", Shape::Multisine { amplitude_rad: multisine(0.5), low_hz: 0.2, high_hz: 3.0, tones: 8 }),
        ("fast multisine", Shape::Multisine { amplitude_rad: multisine(0.2), low_hz: 1.0, high_hz: 12.0, tones: 16 }),
        ("chirp", Shape::Chirp { amplitude_rad: either_way(0.2), from_hz: 0.1, to_hz: 10.0 }),
        ("slow sine", sine(0.5, 0.3)),
        ("dither of small amplitude", sine(2.0 * breakaway, 4.0)),
        ("rising torque at standstill until it breaks away", ramp(2.0 * breakaway, 2.5 * breakaway)),
        ("slow ramp with reversals", ramp(0.15, 0.08)),
        ("constant speed both ways", ramp(0.8, 0.35)),
        ("fast constant speed both ways", ramp(4.0, 1.6)),
        ("long slow travel", ramp(1.6, TAU)),
    ];
    let item = |(name, shape)| Item {
        name,
        experiment: Experiment { shape, duration_s: DURATION_S as f32 },
        unit: scale.unit,
    };
    shapes.into_iter().map(item).collect()
}

/// Seed of the levels of steps.
pub(super) const STEPS_SEED: u32 = 1;

/// Ten to the number of decimals that three digits of a value have.
fn decimals(value: f64) -> f64 {
    10.0_f64.powf(2.0 - value.abs().max(1e-12).log10().floor())
}

/// Down to three digits, so that the flags of a command give the same motion, and no limit is passed.
fn rounded(value: f64) -> f32 {
    let decimals = decimals(value);
    ((value * decimals).floor() / decimals) as f32
}

/// Radians that are a number of degrees of three digits, as `link run` and `simulate` take them.
fn rounded_deg(radians: f64) -> f32 {
    rounded(radians.to_degrees()).to_radians()
}

impl Item {
    /// The same with its size changed by a factor, and as long as before.
    pub(super) fn resized(&self, factor: f64) -> Self {
        let sized = |radians: f32| rounded_deg(factor * f64::from(radians));
        let mut item = self.clone();
        match &mut item.experiment.shape {
            Shape::Step { amplitude_rad }
            | Shape::Steps { amplitude_rad, .. }
            | Shape::Multisine { amplitude_rad, .. }
            | Shape::Chirp { amplitude_rad, .. } => *amplitude_rad = sized(*amplitude_rad),
            Shape::Ramp { speed_rad_s, travel_rad } => {
                *speed_rad_s = rounded(factor * f64::from(*speed_rad_s));
                *travel_rad = sized(*travel_rad);
            }
        }
        item
    }

    /// The same for another time, s.
    pub(super) fn lasting(&self, duration_s: f64) -> Self {
        let experiment = Experiment { duration_s: duration_s as f32, ..self.experiment };
        Self { experiment, ..self.clone() }
    }

    /// Subcommand and flags that `servo-lab link run` takes for it; those of a linear axis mean nothing to the drive.
    pub fn flags(&self) -> String {
        let duration_s = self.experiment.duration_s;
        let shape = match self.experiment.shape {
            Shape::Step { amplitude_rad } => format!("step --amplitude-deg {}", deg(amplitude_rad)),
            Shape::Steps { amplitude_rad, dwell_s, seed } => {
                format!("steps --amplitude-deg {} --dwell-s {dwell_s} --seed {seed}", deg(amplitude_rad))
            }
            Shape::Multisine { amplitude_rad, low_hz, high_hz, tones } => {
                let amplitude = deg(amplitude_rad);
                format!("multisine --amplitude-deg {amplitude} --low-hz {low_hz} --high-hz {high_hz} --tones {tones}")
            }
            Shape::Chirp { amplitude_rad, from_hz, to_hz } => {
                format!("chirp --amplitude-deg {} --from-hz {from_hz} --to-hz {to_hz}", deg(amplitude_rad))
            }
            Shape::Ramp { speed_rad_s, travel_rad } => {
                format!("ramp --speed-rad-s {speed_rad_s} --travel-deg {}", deg(travel_rad))
            }
        };
        format!("{shape} --duration-s {duration_s}")
    }
}

/// The three digits that [`rounded_deg`] left.
fn deg(radians: f32) -> f32 {
    let degrees = f64::from(radians.to_degrees());
    let decimals = decimals(degrees);
    ((degrees * decimals).round() / decimals) as f32
}
