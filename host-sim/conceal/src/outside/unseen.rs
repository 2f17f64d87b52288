//! The list of kinds written after round 230000 of the drawn plan: families that no judge was tuned beside.

mod drive;
mod fluid;
mod friction;
mod mechanics;
mod sensor;

use std::f64::consts::TAU;

pub(super) use drive::Swing;

use super::kinds::{beside, of_drive, of_fluid, order, phase, power};
use super::later::passing_s;
use super::{Kind, Scales, Shape};

/// Fastest of what shall show in a log, Hz.
pub(super) fn top_hz(scales: &Scales) -> f64 {
    (0.12 / scales.period_s).min(60.0)
}

/// Share, Hz and phase of what swings with the time.
fn swings(scales: &Scales, strength: f64, shape: &Shape) -> Vec<f64> {
    vec![strength, top_hz(scales) * (0.05 + 0.6 * shape[1]), phase(shape)]
}

/// Of a clock that knows nothing of the recordings: its phase is the third value.
pub(super) const fn of_clock(kind: Kind) -> Kind {
    Kind { free_phase: Some(2), ..kind }
}

/// Half to two and a half turns of a phase in a recording: rad over what a recording has of something.
fn turns(per_recording: f64, shape: &Shape) -> f64 {
    TAU * (0.5 + 2.0 * shape[2]) / per_recording
}

/// The kinds.
pub(super) static KINDS: &[Kind] = &[
    of_drive(beside(
        "torque through filters",
        "notch_filter",
        &["share", "hz", "damping_ratio"],
        |c, s, u| vec![s.min(1.0), top_hz(c) * (0.1 + 0.5 * u[0]), 0.3 + 0.5 * u[1]],
        |v| Box::new(drive::Notch::new(v)),
    )),
    of_drive(beside(
        "torque through filters",
        "ringing_torque",
        &["time_s", "damping_ratio"],
        |_, s, u| vec![0.03 * s, 0.1 + 0.2 * u[0]],
        |v| Box::new(drive::Rings::new(v)),
    )),
    of_drive(of_clock(beside(
        "swings with the clock",
        "supply_pulses",
        &["share", "hz", "phase_rad"],
        |c, s, u| swings(c, s.min(0.9), u),
        |v| Box::new(drive::SupplyPulses([v[0], v[1], v[2]])),
    ))),
    of_clock(beside(
        "swings with the clock",
        "pulsing_seal",
        &["level", "hz", "phase_rad"],
        |c, s, u| swings(c, s * c.torque, u),
        |v| Box::new(friction::PulsingSeal([v[0], v[1], v[2]])),
    )),
    of_fluid(of_clock(beside(
        "swings with the clock",
        "field_hum",
        &["share", "hz", "phase_rad"],
        |c, s, u| swings(c, s.min(0.95), u),
        |v| Box::new(fluid::Hum([v[0], v[1], v[2]])),
    ))),
    beside(
        "sensor that falls behind",
        "tracking_converter",
        &["time_s", "damping_ratio", "period_s"],
        // The error goes with the square of the time.
        |c, s, u| vec![0.03 * s.sqrt(), 0.5 + 0.5 * u[0], c.period_s],
        |v| Box::new(sensor::Tracks::new(v)),
    ),
    beside(
        "sensor that falls behind",
        "dragged_reading",
        &["most", "speed", "period_s"],
        |c, s, u| vec![0.1 * s * c.travel, c.speed * (0.3 + 0.7 * u[0]), c.period_s],
        |v| Box::new(sensor::Dragged::new(v)),
    ),
    beside(
        "orders that slip",
        "slipping_cage",
        &["level", "order", "phase_rad", "slip"],
        |c, s, u| vec![s * c.torque, order(c, u), phase(u), turns(c.speed * c.duration_s, u)],
        |v| Box::new(friction::SlippingCage::new(v)),
    ),
    beside(
        "orders that slip",
        "creeping_belt",
        &["amplitude", "order", "phase_rad", "creep_per_work"],
        |c, s, u| {
            let order = order(c, u);
            vec![s * c.torque, order, phase(u), turns(order * power(c) * c.duration_s, u)]
        },
        |v| Box::new(mechanics::CreepingBelt::new(v)),
    ),
    beside(
        "friction over the track",
        "stroke_ridges",
        &["level", "width", "time_s"],
        |c, s, u| vec![2.0 * s * c.torque, c.travel * (0.05 + 0.2 * u[0]), passing_s(c) * (2.0 + 8.0 * u[1])],
        |v| Box::new(friction::Ridges::new(v)),
    ),
    beside(
        "friction over the track",
        "coat_flows_back",
        &["level", "passes", "place", "time_s"],
        |c, s, u| {
            let time_s = passing_s(c) * (3.0 + 12.0 * u[1]);
            vec![2.0 * s * c.torque, 0.5 + u[0], 0.1 * c.travel, time_s]
        },
        |v| Box::new(friction::Coat::new(v)),
    ),
    beside(
        "friction when driven",
        "worm_locks",
        &["share"],
        |_, s, _| vec![0.9 * s],
        |v| Box::new(friction::WormLocks(v[0])),
    ),
    beside(
        "friction when driven",
        "load_brake",
        &["level", "way"],
        |c, s, u| vec![s * c.torque, c.travel * (0.02 + 0.15 * u[0])],
        |v| Box::new(friction::LoadBrake::new(v)),
    ),
    beside(
        "waves in lines",
        "free_line",
        &["share", "transit_s", "rounding", "inertia"],
        // Four times of transit are a period of the line alone.
        |c, s, u| {
            let transit_s = 0.25 / (top_hz(c) * (0.2 + 0.4 * u[0]));
            vec![0.7 * s.min(1.0), transit_s, 0.05 + 0.2 * u[1], c.inertia]
        },
        |v| Box::new(mechanics::FreeLine::new(v)),
    ),
    beside(
        "waves in lines",
        "held_line",
        &["stiffness", "transit_s", "rounding"],
        |c, s, u| vec![s * c.torque / c.travel, passing_s(c) * (0.1 + 0.4 * u[0]), 0.05 + 0.2 * u[1]],
        |v| Box::new(mechanics::HeldLine::new(v)),
    ),
    of_fluid(beside(
        "fluid over acceleration",
        "bound_fluid",
        &["share", "half_level", "inertia"],
        |c, s, _| vec![s, 0.3 * c.torque, c.inertia],
        |v| Box::new(fluid::Bound::new(v)),
    )),
    of_fluid(beside(
        "fluid over acceleration",
        "speed_loop",
        &["share", "time_s", "speed"],
        |c, s, u| vec![s.min(0.95), passing_s(c) * (0.1 + 0.4 * u[0]), 0.2 * c.speed],
        |v| Box::new(fluid::SpeedLoop::new(v)),
    )),
];
