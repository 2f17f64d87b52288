//! The list of kinds written after the first two rounds of the drawn plan: families that no judge was tuned beside.

use super::kinds::{beside, of_drive, of_fluid, order, phase};
use super::{Kind, Scales, Shape, drive, fluid, friction, mechanics, sensor};

/// A time in which the axis goes through half of its way, s.
pub(super) fn passing_s(scales: &Scales) -> f64 {
    scales.travel / scales.speed
}

/// Sign that a shape draws.
pub(super) fn sign(shape: &Shape) -> f64 {
    if shape[3] < 0.5 { 1.0 } else { -1.0 }
}

/// The kinds.
pub(super) static KINDS: &[Kind] = &[
    beside(
        "rolling hysteresis",
        "rolling_hysteresis",
        &["level", "way"],
        |c, s, u| vec![s * c.torque, c.travel * (0.1 + 0.4 * u[0])],
        |v| Box::new(friction::Rolling::new(v)),
    ),
    beside(
        "rolling hysteresis",
        "wedged_balls",
        &["level", "way"],
        |c, s, u| vec![2.0 * s * c.torque, c.travel * (0.03 + 0.2 * u[0])],
        |v| Box::new(friction::Wedged::new(v)),
    ),
    of_drive(beside(
        "drive over speed",
        "back_emf_limit",
        &["share", "speed", "torque"],
        // Peaks are about three times the root mean square: at 1 these just meet the limit.
        |c, s, _| vec![s, 3.0 * c.speed, 3.0 * c.torque],
        |v| Box::new(drive::BackEmf([v[0], v[1], v[2]])),
    )),
    beside(
        "drive over speed",
        "eddy_brake",
        &["level", "speed"],
        |c, s, u| vec![2.0 * s * c.torque, c.speed * (0.2 + 0.6 * u[0])],
        |v| Box::new(friction::EddyBrake([v[0], v[1]])),
    ),
    beside(
        "torque over angle and speed",
        "uneven_film",
        &["viscous", "order", "phase_rad"],
        |c, s, u| vec![s * c.torque / c.speed, order(c, u), phase(u)],
        |v| Box::new(friction::UnevenFilm([v[0], v[1], v[2]])),
    ),
    beside(
        "torque over angle and speed",
        "whirl",
        &["coefficient", "order", "phase_rad"],
        |c, s, u| vec![s * c.torque / c.speed.powi(2), order(c, u), phase(u)],
        |v| Box::new(mechanics::Whirl([v[0], v[1], v[2]])),
    ),
    of_drive(beside(
        "drive in steps",
        "torque_steps",
        &["step", "offset"],
        |c, s, u| vec![2.0 * s * c.torque, u[0]],
        |v| Box::new(drive::Steps([v[0], v[1]])),
    )),
    of_drive(beside(
        "drive in steps",
        "torque_slew",
        &["torque_per_s"],
        |c, s, _| vec![c.torque / (s * passing_s(c))],
        |v| Box::new(drive::Slew::new(v)),
    )),
    beside(
        "load that follows",
        "governor",
        &["share", "speed"],
        |c, s, u| vec![0.8 * s.min(1.0), c.speed * (0.7 + u[0])],
        |v| Box::new(mechanics::Governor([v[0], v[1]])),
    ),
    beside(
        "load that follows",
        "stirred_fill",
        &["coefficient", "inertia"],
        |c, s, u| vec![s * c.torque / c.speed.powi(2), c.inertia * (0.3 + u[0])],
        |v| Box::new(mechanics::Fill::new(v)),
    ),
    beside(
        "sensor over time",
        "drifting_interpolation",
        &["amplitude", "order", "phase_rad", "phase_per_row"],
        // A tenth to a whole turn of the error's phase in a recording.
        |c, s, u| {
            let turn = std::f64::consts::TAU * (0.1 + 0.9 * u[2]) * c.period_s / c.duration_s;
            vec![0.05 * s * c.travel, order(c, u), phase(u), turn]
        },
        |v| Box::new(sensor::Interpolation::new(v)),
    ),
    beside(
        "sensor over time",
        "clock_beat",
        &["rows", "beats_per_row"],
        // The converter's clock gains a whole sample some 3 to 20 times in a recording.
        |c, s, u| vec![(20.0 * s).min(1.0), (3.0 + 17.0 * u[0]) * c.period_s / c.duration_s],
        |v| Box::new(sensor::ClockBeat::new(v)),
    ),
    beside(
        "loads that drift",
        "offset_grows",
        &["torque", "time_s"],
        |c, s, u| vec![sign(u) * s * c.torque, c.duration_s * (0.1 + 0.4 * u[0])],
        |v| Box::new(mechanics::Grows([v[0], v[1]])),
    ),
    beside(
        "loads that drift",
        "stiffening_hose",
        &["stiffness_per_s"],
        |c, s, _| vec![s * c.torque / (c.travel * c.duration_s)],
        |v| Box::new(mechanics::Hose(v[0])),
    ),
    of_fluid(beside(
        "fluid over direction",
        "one_way_fluid",
        &["difference"],
        |_, s, u| vec![sign(u) * s.min(0.95)],
        |v| Box::new(fluid::OneWay(v[0])),
    )),
    of_fluid(beside(
        "fluid over direction",
        "overshoot_at_turns",
        &["share", "way"],
        |c, s, u| vec![3.0 * s, c.travel * (0.03 + 0.2 * u[0])],
        |v| Box::new(fluid::Overshoot::new(v)),
    )),
];
