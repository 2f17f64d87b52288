//! The list of kinds written after round 280000 of the drawn plan, by somebody who tunes no judge: families that none was tuned beside.

mod drive;
mod fluid;
#[cfg(test)]
mod laws;
mod mechanics;
mod sensor;
mod speed;

use std::f64::consts::TAU;

use super::kinds::{beside, of_drive, of_fluid, order, phase, power};
use super::later::{passing_s, sign};
use super::unseen::{of_clock, top_hz};
use super::{Kind, Scales, Shape};

/// Share, Hz and damping ratio of a load on a spring, and the inertia of all.
fn hung(scales: &Scales, size: f64, shape: &Shape) -> Vec<f64> {
    vec![0.6 * size.min(1.0), top_hz(scales) * (0.15 + 0.3 * shape[0]), 0.03 + 0.07 * shape[1], scales.inertia]
}

/// Energy that warms, as the square of the torque times time, the time of cooling, and the period.
fn warmed(scales: &Scales, shape: &Shape) -> [f64; 3] {
    let time_s = passing_s(scales) * (0.5 + 1.5 * shape[0]);
    [scales.torque * scales.torque * time_s, 2.0 * time_s, scales.period_s]
}

/// The kinds.
pub(super) static KINDS: &[Kind] = &[
    of_drive(beside(
        "commutation that is late",
        "angle_behind",
        &["electrical_time_s"],
        // Of the torque that share is lost at the usual speed.
        |c, s, _| vec![(2.0 * s.min(0.6)).sqrt() / c.speed],
        |v| Box::new(drive::AngleBehind(v[0])),
    )),
    of_drive(beside(
        "commutation that is late",
        "hall_hysteresis",
        &["share", "order", "phase_rad", "half_way"],
        |c, s, u| {
            let order = order(c, u);
            vec![s.min(0.9), order, phase(u), (0.3 + 0.7 * u[2]) / order]
        },
        |v| Box::new(drive::HallHysteresis::new(v)),
    )),
    of_drive(beside(
        "force over the stator",
        "short_coil",
        &["share", "at", "way"],
        |c, s, u| vec![s.min(0.95), 0.5 * c.travel * (u[0] - 0.5), c.travel * (0.5 + 0.5 * u[1])],
        |v| Box::new(drive::ShortCoil([v[0], v[1], v[2]])),
    )),
    of_drive(beside(
        "force over the stator",
        "stator_sections",
        &["share", "pitch", "pattern"],
        |c, s, u| vec![s.min(0.9), c.travel * (0.25 + 0.4 * u[1]), u[0]],
        |v| Box::new(drive::StatorSections([v[0], v[1], v[2]])),
    )),
    of_drive(beside(
        "drive that adds its own",
        "disturbance_observer",
        &["share", "time_s", "inertia"],
        |c, s, u| vec![s.min(0.95), passing_s(c) * (0.05 + 0.25 * u[0]), c.inertia],
        |v| Box::new(drive::Observer::new(v)),
    )),
    of_drive(beside(
        "drive that adds its own",
        "repeated_stroke",
        &["share", "period_s"],
        |c, s, u| vec![0.7 * s.min(1.0), passing_s(c) * (0.5 + 2.0 * u[0])],
        |v| Box::new(drive::Repeats::new(v)),
    )),
    of_drive(beside(
        "half orders",
        "solid_iron",
        &["share", "time_s"],
        |c, s, u| vec![s.min(0.95), passing_s(c) * (0.35 + 0.6 * u[0])],
        |v| Box::new(drive::SolidIron::new(v)),
    )),
    beside(
        "half orders",
        "liquid_layer",
        &["coefficient", "slowest_per_s"],
        |c, s, _| vec![s * c.torque / c.speed * passing_s(c).sqrt(), 0.1 / passing_s(c)],
        |v| Box::new(mechanics::LiquidLayer::new(v)),
    ),
    beside(
        "resonance that moves",
        "screw_length",
        &["share", "hz", "damping_ratio", "inertia", "way"],
        |c, s, u| [hung(c, s, u), vec![c.travel * (1.1 + 0.5 * u[2])]].concat(),
        |v| Box::new(mechanics::ScrewLength::new(v)),
    ),
    beside(
        "resonance that moves",
        "strain_wave_winds_up",
        &["share", "hz", "damping_ratio", "inertia", "twist"],
        |c, s, u| {
            let hung = hung(c, s, u);
            let twist = c.torque / c.inertia / (TAU * hung[1]).powi(2) * (0.5 + u[2]);
            [hung, vec![twist]].concat()
        },
        |v| Box::new(mechanics::WindsUp::new(v)),
    ),
    beside(
        "resonance that moves",
        "cracked_shaft",
        &["share", "hz", "damping_ratio", "inertia", "open"],
        |c, s, u| [hung(c, s, u), vec![0.2 + 0.3 * u[2]]].concat(),
        |v| Box::new(mechanics::Cracked::new(v)),
    ),
    beside(
        "springs that lose work",
        "superelastic_wire",
        &["stiffness", "turning", "high", "low_over_high"],
        |c, s, u| {
            let high = c.travel * (0.15 + 0.2 * u[0]);
            vec![s * c.torque / high, 0.6 * c.travel, high, 0.1 + 0.4 * u[1]]
        },
        |v| Box::new(mechanics::Superelastic::new(v)),
    ),
    beside(
        "springs that lose work",
        "pack_of_leaves",
        &["stiffness", "friction"],
        |c, s, u| vec![s * c.torque / c.travel, 0.5 + 0.4 * u[0]],
        |v| Box::new(mechanics::Leaves([v[0], v[1]])),
    ),
    beside(
        "mass that comes and goes",
        "hopper_fills",
        &["share", "from_s", "over_s", "inertia"],
        |c, s, u| vec![s, c.duration_s * (0.1 + 0.3 * u[0]), c.duration_s * (0.2 + 0.3 * u[1]), c.inertia],
        |v| Box::new(mechanics::HopperFills([v[0], v[1], v[2], v[3]])),
    ),
    beside(
        "mass that comes and goes",
        "weights_stick",
        &["share", "speed", "time_s", "inertia"],
        |c, s, u| vec![0.9 * s, c.speed * (0.7 + 0.6 * u[0]), 0.05 * passing_s(c), c.inertia],
        |v| Box::new(mechanics::WeightsStick::new(v)),
    ),
    beside(
        "wind on the axis",
        "galloping_prism",
        &["viscous", "speed"],
        |c, s, u| vec![s * c.torque / c.speed, c.speed * (0.9 + 0.6 * u[0])],
        |v| Box::new(speed::Gallops([v[0], v[1]])),
    ),
    of_clock(beside(
        "wind on the axis",
        "vortex_street",
        &["coefficient", "order", "phase_rad"],
        |c, s, u| vec![s * c.torque / c.speed.powi(2), 1.5 * order(c, u), phase(u)],
        |v| Box::new(speed::Vortices::new(v)),
    )),
    beside(
        "loads beyond a speed",
        "centrifugal_shoes",
        &["level", "speed"],
        |c, s, u| vec![s * c.torque, c.speed * (0.6 + 0.5 * u[0])],
        |v| Box::new(speed::Shoes([v[0], v[1]])),
    ),
    beside(
        "loads beyond a speed",
        "rectifier_charges",
        &["viscous", "charging_s", "discharging_s"],
        |c, s, u| {
            let viscous = 2.0 * s * power(c) / c.speed.powi(2);
            vec![viscous, passing_s(c) * (0.05 + 0.25 * u[0]), passing_s(c) * (1.0 + 3.0 * u[1])]
        },
        |v| Box::new(speed::Rectifier::new(v)),
    ),
    beside(
        "stamps that wander",
        "scan_line",
        &["rows", "way"],
        |c, s, u| vec![sign(u) * 0.1 * s * passing_s(c) / c.period_s, c.travel],
        |v| Box::new(sensor::ScanLine::new(v)),
    ),
    of_clock(beside(
        "stamps that wander",
        "two_routes",
        &["rows", "while_rows", "pattern_rad"],
        |c, s, u| {
            let passing_rows = passing_s(c) / c.period_s;
            vec![0.1 * s * passing_rows, passing_rows * (0.3 + 1.2 * u[1]), phase(u)]
        },
        |v| Box::new(sensor::TwoRoutes::new(v)),
    )),
    beside(
        "sensor that warms",
        "scale_grows",
        &["share", "energy", "cooling_s", "period_s"],
        |c, s, u| [vec![0.5 * s.min(1.0)], warmed(c, u).to_vec()].concat(),
        |v| Box::new(sensor::ScaleGrows::new(v)),
    ),
    beside(
        "sensor that warms",
        "bracket_warps",
        &["way", "energy", "cooling_s", "period_s"],
        |c, s, u| [vec![sign(u) * 0.2 * s * c.travel], warmed(c, u).to_vec()].concat(),
        |v| Box::new(sensor::BracketWarps::new(v)),
    ),
    of_fluid(beside(
        "two polarities",
        "poles_differ",
        &["difference", "field_kv_mm"],
        |c, s, u| vec![sign(u) * s.min(0.95), c.field_kv_mm],
        |v| Box::new(fluid::PolesDiffer::new(v)),
    )),
    of_fluid(of_clock(beside(
        "two polarities",
        "polarity_flips",
        &["share", "between_s", "phase_rad", "forming_s"],
        |c, s, u| {
            let between_s = passing_s(c) * (0.4 + 1.1 * u[1]);
            vec![s.min(0.95), between_s, phase(u), between_s * (0.05 + 0.15 * u[2])]
        },
        |v| Box::new(fluid::PolarityFlips([v[0], v[1], v[2], v[3]])),
    ))),
];
