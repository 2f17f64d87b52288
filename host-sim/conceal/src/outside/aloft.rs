//! The list of kinds written after round 290000 of the drawn plan, by somebody who tunes no judge: families that none was tuned beside.

mod drive;
mod fluid;
#[cfg(test)]
mod laws;
mod loads;
mod moments;
mod once;
mod sensor;

use std::f64::consts::TAU;

use super::kinds::{beside, of_drive, of_fluid, phase, power};
use super::later::{passing_s, sign};
use super::unseen::{of_clock, top_hz};
use super::{Kind, Scales, Shape};

/// Share, Hz and damping ratio of a load behind a coupling, the inertia of all, and the twist at which the coupling gives way; what is stiffer
/// is damped less.
fn coupled(scales: &Scales, size: f64, shape: &Shape, stiff: f64) -> [f64; 5] {
    let hz = top_hz(scales) * (0.15 + 0.3 * shape[0]) * stiff;
    // Where the axis gains speed about as fast as it usually does.
    let twist = (0.4 + 0.4 * shape[2]) * stiff.sqrt() * usual_gain(scales) / (TAU * hz).powi(2);
    [0.6 * size.min(1.0), hz, (0.15 + 0.15 * shape[1]) / stiff.powi(2), scales.inertia, twist]
}

/// Share and Hz of a weight on a rope, and the inertia of all.
fn hanging(scales: &Scales, size: f64, shape: &Shape) -> [f64; 3] {
    [0.6 * size.min(1.0), top_hz(scales) * (0.3 + 0.4 * shape[0]), scales.inertia]
}

/// Gain of speed that the usual torque gives, rad/s2 or m/s2.
fn usual_gain(scales: &Scales) -> f64 {
    scales.torque / scales.inertia
}

/// Hz of a tone.
fn tone_hz(scales: &Scales, shape: &Shape) -> f64 {
    top_hz(scales) * (0.2 + 0.5 * shape[1])
}

/// The kinds.
pub(super) static KINDS: &[Kind] = &[
    of_drive(beside(
        "torque that rises otherwise than it falls",
        "diode_falls",
        &["time_s"],
        |c, s, u| vec![s * passing_s(c) * (0.2 + 0.4 * u[0])],
        |v| Box::new(drive::DiodeFalls::new(v)),
    )),
    of_drive(beside(
        "torque that rises otherwise than it falls",
        "orifice_fills",
        &["time_s", "torque"],
        |c, s, u| vec![s * passing_s(c) * (0.2 + 0.4 * u[0]), c.torque],
        |v| Box::new(drive::OrificeFills::new(v)),
    )),
    of_drive(beside(
        "torque that rises otherwise than it falls",
        "booster_lags",
        &["time_s", "torque"],
        |c, s, u| vec![s * passing_s(c) * (0.3 + 0.5 * u[0]), c.torque * (0.4 + 0.6 * u[1])],
        |v| Box::new(drive::BoosterLags::new(v)),
    )),
    of_drive(beside(
        "valves that stick",
        "spool_sticks",
        &["band"],
        |c, s, _| vec![2.0 * s * c.torque],
        |v| Box::new(drive::SpoolSticks::new(v)),
    )),
    of_drive(beside(
        "valves that stick",
        "spool_silts",
        &["most", "time_s", "washes"],
        |c, s, u| vec![3.0 * s * c.torque, passing_s(c) * (0.1 + 0.4 * u[0]), c.torque * (0.05 + 0.1 * u[1])],
        |v| Box::new(drive::SpoolSilts::new(v)),
    )),
    of_drive(of_clock(beside(
        "commands that come late",
        "frames_lost",
        &["share", "while_s", "pattern_rad"],
        |c, s, u| vec![s.min(0.95), passing_s(c) * (0.2 + 0.5 * u[1]), phase(u)],
        |v| Box::new(drive::FramesLost::new(v)),
    ))),
    of_drive(beside(
        "commands that come late",
        "busy_loop",
        &["delay_s", "speed"],
        |c, s, u| vec![s * passing_s(c) * (0.05 + 0.1 * u[0]), c.speed * (0.8 + 0.6 * u[1])],
        |v| Box::new(drive::BusyLoop::new(v)),
    )),
    beside(
        "couplings that skip",
        "magnet_coupling",
        &["share", "hz", "damping_ratio", "inertia", "poles"],
        |c, s, u| {
            let [share, hz, damping_ratio, inertia, twist] = coupled(c, s, u, 1.0);
            vec![share, hz, damping_ratio, inertia, 1.0 / twist]
        },
        |v| Box::new(loads::MagnetCoupling::new(v)),
    ),
    beside(
        "couplings that skip",
        "ball_detent",
        &["share", "hz", "damping_ratio", "inertia", "twist"],
        |c, s, u| coupled(c, s, u, 2.5).to_vec(),
        |v| Box::new(loads::BallDetent::new(v)),
    ),
    beside(
        "loads that lose contact",
        "weight_jumps",
        &["share", "hz", "inertia", "falls"],
        |c, s, u| [&hanging(c, s, u)[..], &[usual_gain(c) * (0.15 + 0.35 * u[2])]].concat(),
        |v| Box::new(loads::WeightJumps::new(v)),
    ),
    beside(
        "loads that lose contact",
        "weight_lands",
        &["share", "hz", "inertia", "falls", "down"],
        |c, s, u| {
            let [falls, down] = [usual_gain(c) * (0.6 + 0.6 * u[2]), c.travel * (0.05 + 0.35 * u[1])];
            [&hanging(c, s, u)[..], &[falls, down]].concat()
        },
        |v| Box::new(loads::WeightLands::new(v)),
    ),
    beside(
        "a base that moves",
        "feet_slide",
        &["share", "level"],
        |c, s, u| vec![s, c.torque * (0.5 + 0.5 * u[0])],
        |v| Box::new(loads::FeetSlide::new(v)),
    ),
    beside(
        "a base that moves",
        "raft_turns",
        &["share", "drag"],
        |c, s, u| vec![s, 1.0 / (c.torque * (passing_s(c) * (0.025 + 0.075 * u[0])).powi(2))],
        |v| Box::new(loads::RaftTurns::new(v)),
    ),
    beside(
        "a drive without torque",
        "shorted_when_idle",
        &["viscous", "torque"],
        |c, s, u| vec![3.0 * s * c.torque / c.speed, c.torque * (0.2 + 0.3 * u[0])],
        |v| Box::new(moments::ShortedIdle([v[0], v[1]])),
    ),
    beside(
        "a drive without torque",
        "holding_brake",
        &["level", "torque", "time_s"],
        |c, s, u| vec![2.0 * s * c.torque, c.torque * (0.3 + 0.4 * u[1]), passing_s(c) * (0.03 + 0.1 * u[0])],
        |v| Box::new(moments::HoldingBrake::new(v)),
    ),
    beside(
        "what lets go once",
        "spring_unhooks",
        &["level", "stiffness"],
        |c, s, u| vec![s * c.torque * (0.7 + 0.3 * u[0]), s * c.torque / c.travel],
        |v| Box::new(once::SpringUnhooks::new(v)),
    ),
    beside(
        "what lets go once",
        "peg_shears",
        &["share", "torque", "time_s"],
        |c, s, u| vec![0.8 * s.min(1.0), c.torque, c.duration_s * (0.4 + 0.7 * u[0])],
        |v| Box::new(once::PegShears::new(v)),
    ),
    of_drive(beside(
        "what lets go once",
        "fuse_trips",
        &["share", "energy", "time_s"],
        |c, s, u| vec![s.min(0.9), c.torque * c.torque * c.duration_s * (0.25 + 0.4 * u[0]), 0.05 * passing_s(c)],
        |v| Box::new(once::FuseTrips::new(v)),
    )),
    of_clock(beside(
        "what comes and goes by itself",
        "neighbours_air",
        &["level", "while_s", "pattern_rad"],
        |c, s, u| vec![s * c.torque, passing_s(c) * (1.0 + 3.0 * u[1]), phase(u)],
        |v| Box::new(moments::Telegraph([v[0], v[1], v[2]])),
    )),
    of_clock(beside(
        "what comes and goes by itself",
        "topped_up_balance",
        &["level", "between_s", "phase_rad"],
        |c, s, u| vec![s * c.torque, passing_s(c) * (2.0 + 4.0 * u[1]), phase(u)],
        |v| Box::new(moments::ToppedUp([v[0], v[1], v[2]])),
    )),
    beside(
        "tones that a motion starts",
        "squeals_when_slow",
        &["level", "hz", "speed"],
        |c, s, u| vec![2.0 * s * c.torque, tone_hz(c, u), c.speed * (0.4 + 0.4 * u[0])],
        |v| Box::new(moments::Squeals::new(v)),
    ),
    beside(
        "tones that a motion starts",
        "cut_chatters",
        &["level", "hz", "power_w"],
        |c, s, u| vec![2.0 * s * c.torque, tone_hz(c, u), power(c) * (0.2 + 0.3 * u[0])],
        |v| Box::new(moments::CutChatters::new(v)),
    ),
    of_fluid(beside(
        "gap under a thrust",
        "thrust_squeezes",
        &["share", "torque"],
        |c, s, u| vec![s.min(0.95), c.torque * (0.4 + 0.6 * u[0])],
        |v| Box::new(fluid::ThrustSqueezes([v[0], v[1]])),
    )),
    of_fluid(beside(
        "gap under a thrust",
        "thrust_moves",
        &["share", "torque"],
        |c, s, u| vec![sign(u) * s.min(0.95), c.torque * (0.4 + 0.6 * u[0])],
        |v| Box::new(fluid::ThrustMoves([v[0], v[1]])),
    )),
    of_fluid(beside(
        "high voltage from the bus",
        "bus_sags",
        &["share", "power_w"],
        |c, s, u| vec![s.min(0.95), power(c) * (0.2 + 0.5 * u[0])],
        |v| Box::new(fluid::BusSags([v[0], v[1]])),
    )),
    of_fluid(beside(
        "high voltage from the bus",
        "bus_pumped",
        &["share", "energy_j", "time_s"],
        |c, s, u| {
            let energy_j = power(c) * passing_s(c) * (0.03 + 0.1 * u[0]);
            vec![3.0 * s, energy_j, passing_s(c) * (0.2 + 0.6 * u[1])]
        },
        |v| Box::new(fluid::BusPumped::new(v)),
    )),
    beside(
        "readings that are smoothed",
        "adaptive_smoothing",
        &["time_s", "speed", "period_s"],
        |c, s, u| vec![0.2 * s * passing_s(c), c.speed * (0.3 + 0.4 * u[0]), c.period_s],
        |v| Box::new(sensor::AdaptiveSmoothing::new(v)),
    ),
    beside(
        "readings that are smoothed",
        "slewed_reading",
        &["share", "speed", "period_s"],
        |c, s, u| vec![s.min(1.0), c.speed * (0.8 + 0.4 * u[0]), c.period_s],
        |v| Box::new(sensor::SlewedReading::new(v)),
    ),
    beside(
        "sensor that puts itself right",
        "index_resets",
        &["share", "mark"],
        |c, s, u| vec![0.2 * s, 0.5 * c.travel * (u[0] - 0.5)],
        |v| Box::new(sensor::IndexResets::new(v)),
    ),
    beside(
        "sensor that puts itself right",
        "rest_updates",
        &["bias", "speed", "time_s", "period_s"],
        |c, s, u| {
            let speed = c.speed * (0.02 + 0.1 * u[1]);
            vec![sign(u) * 0.1 * s * c.speed, speed, passing_s(c) * (0.05 + 0.2 * u[0]), c.period_s]
        },
        |v| Box::new(sensor::RestUpdates::new(v)),
    ),
];
