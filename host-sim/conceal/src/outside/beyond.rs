//! The list of kinds written after round 250000 of the drawn plan: families that no judge was tuned beside.

mod drive;
mod fluid;
mod friction;
#[cfg(test)]
mod laws;
mod mechanics;
mod sensor;

use std::f64::consts::TAU;

use super::kinds::{beside, of_drive, of_fluid, order, phase, power};
use super::later::{passing_s, sign};
use super::unseen::of_clock;
use super::{Kind, Scales, Seen, Shape};

/// A number from 0 to 1 that belongs to a place in a pattern, the same each time (Steele and others, Fast Splittable Pseudorandom Number
/// Generators, 2014: its last mixing).
pub(super) fn scatter(place: f64, pattern: f64) -> f64 {
    let mut bits = (place as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ pattern.to_bits();
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (bits ^ (bits >> 31)) as f64 / u64::MAX as f64
}

/// The way travelled, either way, in stretches.
struct Way {
    stretch: f64,
    travelled: f64,
}

impl Way {
    fn new(stretch: f64) -> Self {
        Self { stretch, travelled: 0.0 }
    }

    /// Which stretch, and how far within, from 0 to 1.
    fn after(&mut self, seen: &Seen) -> (f64, f64) {
        self.travelled += seen.step_s * seen.speed.abs() / self.stretch;
        (self.travelled.floor(), self.travelled.fract())
    }
}

/// Which of two states a speed leaves, changed over at a speed and back at a share of it, each within a short time.
pub(super) struct TwoStates {
    speed: f64,
    back: f64,
    time_s: f64,
    fast: bool,
    at: f64,
}

impl TwoStates {
    pub(super) fn new(speed: f64, back: f64, time_s: f64) -> Self {
        Self { speed, back, time_s, fast: false, at: 0.0 }
    }

    /// From 0, slow, to 1, fast.
    pub(super) fn after(&mut self, seen: &Seen) -> f64 {
        self.fast = seen.speed.abs() > if self.fast { self.back * self.speed } else { self.speed };
        self.at += seen.share_of_lag(self.time_s) * (f64::from(u8::from(self.fast)) - self.at);
        self.at
    }
}

/// Gain of speed, a little late.
struct Gain {
    time_s: f64,
    late: f64,
}

impl Gain {
    fn new(time_s: f64) -> Self {
        Self { time_s, late: 0.0 }
    }

    fn after(&mut self, seen: &Seen) -> f64 {
        let gained = seen.speed - self.late;
        self.late += seen.share_of_lag(self.time_s) * gained;
        gained / self.time_s
    }
}

/// Hz of what else moves on the same machine: slower than the axis itself or not much faster.
fn beside_hz(scales: &Scales, shape: &Shape) -> f64 {
    (0.1 + 0.4 * shape[1]) / passing_s(scales)
}

/// One over the angular frequency, s, of what an order meets at usual speeds.
fn met_s(scales: &Scales, order: f64, shape: &Shape) -> f64 {
    1.0 / (order * scales.speed * (0.4 + 0.6 * shape[2]))
}

/// The kinds.
pub(super) static KINDS: &[Kind] = &[
    of_drive(beside(
        "torque that needs a flux",
        "flux_builds",
        &["time_s", "torque"],
        |c, s, u| vec![s * passing_s(c) * (0.3 + 0.7 * u[0]), c.torque * (0.5 + u[1])],
        |v| Box::new(drive::FluxBuilds::new(v)),
    )),
    of_drive(beside(
        "torque that needs a flux",
        "flux_returns_late",
        &["time_s", "speed"],
        |c, s, u| vec![s * passing_s(c) * (0.3 + 0.7 * u[0]), c.speed * (0.3 + 0.5 * u[1])],
        |v| Box::new(drive::FluxReturnsLate::new(v)),
    )),
    of_drive(beside(
        "drive that protects itself",
        "folds_back",
        &["share", "torque", "time_s"],
        |c, s, u| vec![s.min(1.0), c.torque * (0.5 + 0.4 * u[1]), c.duration_s * (0.02 + 0.08 * u[0])],
        |v| Box::new(drive::Foldback::new(v)),
    )),
    of_drive(beside(
        "drive that protects itself",
        "bus_fills",
        &["share", "energy"],
        |c, s, u| vec![s.min(0.95), power(c) * passing_s(c) * (0.03 + 0.15 * u[0])],
        |v| Box::new(drive::BusFills::new(v)),
    )),
    of_drive(beside(
        "ranges that switch",
        "two_ranges",
        &["difference", "torque"],
        |c, s, u| vec![sign(u) * s.min(0.9), c.torque * (0.5 + u[0])],
        |v| Box::new(drive::TwoRanges::new(v)),
    )),
    of_drive(beside(
        "ranges that switch",
        "windings_reconnect",
        &["pause_s", "speed"],
        |c, s, u| vec![s * passing_s(c) * (0.2 + 0.4 * u[0]), c.speed * (0.5 + 0.7 * u[1])],
        |v| Box::new(drive::Reconnects::new(v)),
    )),
    of_drive(of_clock(beside(
        "here and there by chance",
        "brushes_bounce",
        &["share", "way", "pattern_rad"],
        |c, s, u| vec![s.min(0.95), c.travel * (0.05 + 0.3 * u[1]), phase(u)],
        |v| Box::new(drive::BrushBounce::new(v)),
    ))),
    of_clock(beside(
        "here and there by chance",
        "chips_in_guide",
        &["level", "way", "pattern_rad"],
        |c, s, u| vec![2.0 * s * c.torque, c.travel * (0.05 + 0.3 * u[1]), phase(u)],
        |v| Box::new(friction::Debris::new(v)),
    )),
    beside(
        "friction over load and speed",
        "gear_film",
        &["share", "speed"],
        |c, s, u| vec![0.9 * s, c.speed * (0.1 + 0.2 * u[0])],
        |v| Box::new(friction::GearFilm([v[0], v[1]])),
    ),
    beside(
        "friction over load and speed",
        "flash_heat",
        &["share", "power"],
        |c, s, u| vec![s.min(0.95), power(c) * (0.3 + 0.7 * u[0])],
        |v| Box::new(friction::FlashHeat([v[0], v[1]])),
    ),
    beside(
        "two states over speed",
        "bearing_lifts_off",
        &["share", "speed", "time_s"],
        |c, s, u| vec![s.min(0.95), c.speed * (0.7 + 0.5 * u[0]), 0.02 * passing_s(c)],
        |v| Box::new(friction::LiftsOff::new(v)),
    ),
    of_fluid(beside(
        "two states over speed",
        "wall_slip",
        &["share", "speed", "time_s"],
        |c, s, u| vec![s.min(0.95), c.speed * (0.7 + 0.5 * u[0]), 0.02 * passing_s(c)],
        |v| Box::new(fluid::WallSlip::new(v)),
    )),
    beside(
        "friction over acceleration",
        "mass_beside_guide",
        &["share", "inertia", "time_s"],
        |c, s, u| vec![sign(u) * 0.9 * s, c.inertia, passing_s(c) * (0.02 + 0.06 * u[0])],
        |v| Box::new(friction::MassBeside::new(v)),
    ),
    beside(
        "friction over acceleration",
        "inertia_brake",
        &["level", "acceleration", "time_s"],
        |c, s, u| {
            let acceleration = c.torque / c.inertia * (0.05 + 0.3 * u[1]);
            vec![s * c.torque, acceleration, passing_s(c) * (0.02 + 0.06 * u[0])]
        },
        |v| Box::new(friction::InertiaBrake::new(v)),
    ),
    beside(
        "loads taken one way",
        "freewheel",
        &["share", "engaging_s", "coasting_s", "inertia"],
        |c, s, u| vec![s, 0.02 * passing_s(c), passing_s(c) * (1.0 + 4.0 * u[0]), c.inertia],
        |v| Box::new(mechanics::Freewheel::new(v)),
    ),
    beside(
        "loads taken one way",
        "chain_picked_up",
        &["share", "way", "inertia"],
        |c, s, u| vec![1.5 * s.min(1.0), c.travel * (0.6 + 0.6 * u[0]), c.inertia],
        |v| Box::new(mechanics::PicksUp([v[0], v[1], v[2]])),
    ),
    beside(
        "springs that snap",
        "buckled_strip",
        &["level", "at", "time_s"],
        |c, s, u| vec![s * c.torque, c.travel * (0.05 + 0.3 * u[0]), 0.03 * passing_s(c)],
        |v| Box::new(mechanics::Snaps::new(v)),
    ),
    beside(
        "springs that snap",
        "clicking_pawl",
        &["level", "pitch"],
        |c, s, u| vec![2.0 * s * c.torque, c.travel * (0.1 + 0.3 * u[0])],
        |v| Box::new(mechanics::Clicks::new(v)),
    ),
    beside(
        "gyroscopes",
        "dry_gimbal",
        &["stiffness", "speed"],
        |c, s, u| vec![s * c.torque / c.travel, c.speed * (0.2 + 0.4 * u[0])],
        |v| Box::new(mechanics::DryGimbal::new(v)),
    ),
    beside(
        "gyroscopes",
        "gimbal_stops",
        &["stiffness", "hz", "most"],
        |c, s, u| vec![s * c.torque / c.travel, 1.0 / passing_s(c), TAU * c.travel * (0.1 + 0.4 * u[0])],
        |v| Box::new(mechanics::GimbalStops::new(v)),
    ),
    of_clock(beside(
        "axes beside this one",
        "moving_elbow",
        &["share", "hz", "phase_rad", "inertia"],
        |c, s, u| vec![0.6 * s.min(1.0), beside_hz(c, u), phase(u), c.inertia],
        |v| Box::new(mechanics::Elbow([v[0], v[1], v[2], v[3]])),
    )),
    of_clock(beside(
        "axes beside this one",
        "rolling_ship",
        &["amplitude", "hz", "phase_rad", "order", "roll_rad"],
        |c, s, u| vec![s * c.torque, beside_hz(c, u), phase(u), order(c, u), 0.4 + 0.8 * u[2]],
        |v| Box::new(mechanics::RollingShip([v[0], v[1], v[2], v[3], v[4]])),
    )),
    beside(
        "orders that meet a resonance",
        "crank_shakes_mass",
        &["level", "order", "phase_rad", "time_s", "damping_ratio"],
        |c, s, u| {
            let order = order(c, u);
            vec![s * c.torque, order, phase(u), met_s(c, order, u), 0.05 + 0.15 * u[3]]
        },
        |v| Box::new(mechanics::Shaker::new(v)),
    ),
    beside(
        "orders that meet a resonance",
        "chattering_guide",
        &["level", "order", "phase_rad", "time_s", "damping_ratio"],
        |c, s, u| {
            let order = order(c, u);
            vec![s * c.torque, order, phase(u), met_s(c, order, u), 0.05 + 0.15 * u[3]]
        },
        |v| Box::new(friction::Chatter::new(v)),
    ),
    beside(
        "sensor under load",
        "column_bends",
        &["per_torque", "time_s", "period_s"],
        |c, s, u| vec![0.05 * s * c.travel / c.torque, passing_s(c) * (0.02 + 0.06 * u[0]), c.period_s],
        |v| Box::new(sensor::ColumnBends::new(v)),
    ),
    of_drive(beside(
        "sensor under load",
        "stray_field",
        &["per_torque", "order", "phase_rad"],
        |c, s, u| vec![0.05 * s * c.travel / c.torque, order(c, u), phase(u)],
        |v| Box::new(sensor::StrayField::new(v)),
    )),
    beside(
        "sensor that speaks now and then",
        "told_on_change",
        &["step"],
        |c, s, _| vec![0.1 * s * c.travel],
        |v| Box::new(sensor::OnChange::new(v)),
    ),
    beside(
        "sensor that speaks now and then",
        "dead_reckoning",
        &["share", "interval_s", "period_s"],
        |c, s, u| vec![s.min(1.0), (passing_s(c) * (0.05 + 0.2 * u[0])).max(3.0 * c.period_s), c.period_s],
        |v| Box::new(sensor::DeadReckoning::new(v)),
    ),
    beside(
        "scale in pieces",
        "butted_scales",
        &["step", "at", "width"],
        |c, s, u| vec![sign(u) * 0.1 * s * c.travel, c.travel * (u[0] - 0.5), c.travel * (0.02 + 0.08 * u[1])],
        |v| Box::new(sensor::Butted([v[0], v[1], v[2]])),
    ),
    beside(
        "scale in pieces",
        "marks_off",
        &["amplitude", "pitch", "pattern"],
        |c, s, u| vec![0.05 * s * c.travel, c.travel * (0.08 + 0.2 * u[1]), u[0]],
        |v| Box::new(sensor::MarksOff([v[0], v[1], v[2]])),
    ),
    beside(
        "sensor over angle and speed",
        "speed_voltages",
        &["time_s", "order", "phase_rad", "period_s"],
        |c, s, u| vec![0.1 * s * passing_s(c), order(c, u), phase(u), c.period_s],
        |v| Box::new(sensor::SpeedVoltages::new(v)),
    ),
    beside(
        "sensor over angle and speed",
        "tilting_head",
        &["amplitude", "order", "phase_rad", "half_way"],
        |c, s, u| vec![0.05 * s * c.travel, order(c, u), phase(u), c.travel * (0.02 + 0.08 * u[2])],
        |v| Box::new(sensor::TiltingHead::new(v)),
    ),
    of_fluid(beside(
        "particles that migrate",
        "electrophoresis",
        &["share", "time_s", "way", "field_kv_mm"],
        |c, s, u| {
            let [time_s, way] = [passing_s(c) * (0.1 + 0.3 * u[0]), c.travel * (0.15 + 0.45 * u[1])];
            vec![s.min(0.95), time_s, way, c.field_kv_mm]
        },
        |v| Box::new(fluid::Electrophoresis::new(v)),
    )),
    of_fluid(beside(
        "particles that migrate",
        "spun_out",
        &["share", "speed", "time_s"],
        |c, s, u| vec![s.min(0.95), c.speed * (0.6 + 0.6 * u[0]), passing_s(c) * (0.3 + 1.2 * u[1])],
        |v| Box::new(fluid::SpunOut::new(v)),
    )),
    of_fluid(beside(
        "fluid over strain",
        "strain_builds",
        &["way", "creep"],
        |c, s, u| vec![s * c.travel * (0.2 + 0.8 * u[0]), 0.05 * c.speed],
        |v| Box::new(fluid::StrainBuilds::new(v)),
    )),
    of_fluid(beside(
        "fluid over strain",
        "chains_outlast",
        &["way", "creep"],
        |c, s, u| vec![s * c.travel * (0.2 + 0.8 * u[0]), 0.05 * c.speed],
        |v| Box::new(fluid::Outlast::new(v)),
    )),
    of_fluid(beside(
        "field and shear together",
        "rings_form",
        &["share", "way", "time_s", "half_level"],
        |c, s, u| {
            let [way, time_s] = [c.travel * (0.15 + 0.5 * u[0]), passing_s(c) * (0.05 + 0.15 * u[1])];
            vec![2.0 * s, way, time_s, 0.3 * c.torque]
        },
        |v| Box::new(fluid::Rings::new(v)),
    )),
    of_fluid(beside(
        "field and shear together",
        "charge_pumped",
        &["share", "order", "phase_rad", "time_s"],
        |c, s, u| vec![s.min(0.9), order(c, u), phase(u), passing_s(c) * (0.03 + 0.1 * u[2])],
        |v| Box::new(fluid::ChargePumped::new(v)),
    )),
];
