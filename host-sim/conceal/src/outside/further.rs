//! The list of kinds written after round 240000 of the drawn plan: families that no judge was tuned beside.

mod drive;
mod fluid;
mod friction;
mod mechanics;
mod sensor;

use super::Kind;
use super::kinds::{beside, of_drive, of_fluid, order, phase};
use super::later::{passing_s, sign};
use super::unseen::of_clock;

/// The kinds.
pub(super) static KINDS: &[Kind] = &[
    of_drive(of_clock(beside(
        "converter that switches",
        "mains_firing",
        &["period_s", "rounding", "phase_rad"],
        |c, s, u| vec![0.5 * s * passing_s(c), 0.02 + 0.1 * u[1], phase(u)],
        |v| Box::new(drive::MainsFiring::new(v)),
    ))),
    of_drive(beside(
        "converter that switches",
        "bridge_pause",
        &["pause_s"],
        |c, s, u| vec![s * passing_s(c) * (0.2 + 0.3 * u[0])],
        |v| Box::new(drive::BridgePause::new(v)),
    )),
    of_drive(beside(
        "torque over angle and current",
        "reluctance_torque",
        &["amplitude", "torque", "order", "phase_rad"],
        |c, s, u| vec![s * c.torque, 2.0 * c.torque, order(c, u), phase(u)],
        |v| Box::new(drive::Reluctance([v[0], v[1], v[2], v[3]])),
    )),
    of_drive(beside(
        "torque over angle and current",
        "cogging_under_load",
        &["amplitude", "torque", "order", "phase_rad"],
        |c, s, u| vec![0.5 * s * c.torque, c.torque * (0.4 + 0.6 * u[2]), order(c, u), phase(u)],
        |v| Box::new(drive::CoggingUnderLoad([v[0], v[1], v[2], v[3]])),
    )),
    beside(
        "friction over angle and load",
        "eccentric_mesh",
        &["share", "order", "phase_rad"],
        |c, s, u| vec![0.6 * s, order(c, u), phase(u)],
        |v| Box::new(friction::EccentricMesh([v[0], v[1], v[2]])),
    ),
    beside(
        "friction over angle and load",
        "drawer_jams",
        &["share", "at", "way"],
        |c, s, u| vec![s, c.travel * (u[0] - 0.5), c.travel],
        |v| Box::new(friction::DrawerJams([v[0], v[1], v[2]])),
    ),
    beside(
        "pressure that leaks",
        "one_way_cushion",
        &["level", "way", "time_s", "direction"],
        |c, s, u| {
            let time_s = passing_s(c) * (0.1 + 0.4 * u[1]);
            vec![s * c.torque, c.travel * (0.1 + 0.3 * u[0]), time_s, sign(u)]
        },
        |v| Box::new(mechanics::OneWayCushion::new(v)),
    ),
    beside(
        "pressure that leaks",
        "soft_damper",
        &["level", "way", "time_s"],
        |c, s, u| vec![s * c.torque, c.travel * (0.1 + 0.4 * u[0]), passing_s(c) * (0.2 + 0.5 * u[1])],
        |v| Box::new(mechanics::SoftDamper::new(v)),
    ),
    beside(
        "load that rearranges",
        "avalanches",
        &["amplitude", "stable", "repose", "time_s"],
        |c, s, u| {
            let stable = c.travel * (0.1 + 0.3 * u[0]);
            vec![s * c.torque, stable, stable * (0.1 + 0.4 * u[1]), passing_s(c) * (0.02 + 0.1 * u[2])]
        },
        |v| Box::new(mechanics::Avalanches::new(v)),
    ),
    beside(
        "load that rearranges",
        "cargo_slides",
        &["amplitude", "angle", "time_s"],
        |c, s, u| vec![s * c.torque, c.travel * (0.1 + 0.4 * u[0]), passing_s(c) * (0.1 + 0.4 * u[1])],
        |v| Box::new(mechanics::CargoSlides::new(v)),
    ),
    beside(
        "sensor that loses way",
        "counts_lost",
        &["share", "speed", "period_s"],
        |c, s, u| vec![s.min(1.0), c.speed * (0.3 + 0.7 * u[0]), c.period_s],
        |v| Box::new(sensor::CountsLost::new(v)),
    ),
    beside(
        "sensor that loses way",
        "wheel_skids",
        &["acceleration", "period_s"],
        |c, s, u| vec![c.torque / c.inertia * (0.02 + 0.02 * u[0]) / s, c.period_s],
        |v| Box::new(sensor::WheelSkids::new(v)),
    ),
    of_fluid(beside(
        "field in bursts",
        "skipped_pulses",
        &["share", "time_s"],
        |c, s, u| vec![s.min(0.95), passing_s(c) * (0.3 + 0.7 * u[0])],
        |v| Box::new(fluid::SkippedPulses::new(v)),
    )),
    of_fluid(beside(
        "field in bursts",
        "arcs",
        &["share", "field_kv_mm", "charging_s", "time_s"],
        |c, s, u| {
            let field_kv_mm = c.field_kv_mm * (0.4 + 0.4 * u[0]);
            vec![s.min(0.95), field_kv_mm, passing_s(c) * (0.15 + 0.3 * u[1]), passing_s(c) * (0.02 + 0.1 * u[2])]
        },
        |v| Box::new(fluid::Arcs::new(v)),
    )),
];
