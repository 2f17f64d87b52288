//! The list of kinds: what a size of each is, on a machine whose torques, speeds and ways are known.

use std::f64::consts::TAU;

use super::{
    Hidden, Kind, Needs, Put, Scales, Shape, afield, aloft, beyond, drive, fluid, friction, further, later, mechanics,
    sensor, spring, unseen,
};
use crate::catalogue;
use crate::physics::{Physics, Wave};

/// Every kind.
pub fn kinds() -> impl Iterator<Item = &'static Kind> {
    let newer = [later::KINDS, unseen::KINDS, further::KINDS, beyond::KINDS, afield::KINDS, aloft::KINDS];
    KINDS.iter().chain(newer.into_iter().flatten())
}

/// The kind called `id`.
pub fn find(id: &str) -> Option<&'static Kind> {
    kinds().find(|kind| kind.id == id)
}

/// Every family once, in the order of the list.
pub fn families() -> Vec<&'static str> {
    let mut families: Vec<&'static str> = kinds().map(|kind| kind.family).collect();
    families.dedup();
    families
}

pub(super) type Values = fn(&Scales, f64, &Shape) -> Vec<f64>;

pub(super) const fn beside(
    family: &'static str,
    id: &'static str,
    parameters: &'static [&'static str],
    values: Values,
    make: fn(&[f64]) -> Box<dyn Hidden>,
) -> Kind {
    Kind { id, family, parameters, needs: Needs::Nothing, values, put: Put::Beside(make), free_phase: None }
}

const fn number(
    family: &'static str,
    id: &'static str,
    parameters: &'static [&'static str],
    values: Values,
    put: fn(&mut Physics, &[f64]),
) -> Kind {
    Kind { id, family, parameters, needs: Needs::Nothing, values, put: Put::Number(put), free_phase: None }
}

pub(super) const fn of_fluid(kind: Kind) -> Kind {
    Kind { needs: Needs::Fluid, ..kind }
}

/// Of the drive: a torque that was measured shows nothing of it.
pub(super) const fn of_drive(kind: Kind) -> Kind {
    Kind { needs: Needs::Command, ..kind }
}

/// As the fixed plan puts it.
fn put(id: &str, physics: &mut Physics, values: &[f64]) {
    if let Some(entry) = catalogue::find(id) {
        entry.put(physics, values);
    }
}

pub(super) fn phase(shape: &Shape) -> f64 {
    TAU * (shape[0] - 0.5)
}

/// Radians of phase for each rad or m: at least one and a half periods in the motion.
pub(super) fn order(scales: &Scales, shape: &Shape) -> f64 {
    (1.5 + 6.0 * shape[1]) * TAU / (2.0 * scales.travel)
}

/// A whole number of periods a revolution, as long as it gives that many; the same on a linear axis.
fn whole_order(scales: &Scales, shape: &Shape) -> f64 {
    order(scales, shape).round().max(1.0)
}

pub(super) fn power(scales: &Scales) -> f64 {
    scales.torque * scales.speed
}

fn heat(scales: &Scales, share: f64, shape: &Shape) -> Vec<f64> {
    let time_s = scales.duration_s * (0.1 + 0.4 * shape[0]);
    vec![share, power(scales) * time_s, 2.0 * time_s]
}

/// The kinds of the first rounds. Those that are numbers of the machine are the nine of the fixed plan.
static KINDS: &[Kind] = &[
    number(
        "friction over position",
        "friction_over_position",
        &["share", "order", "phase_rad"],
        |c, s, u| vec![s * c.torque / c.coulomb, whole_order(c, u), phase(u)],
        |p, v| p.friction.over_position = Some(Wave { amplitude: v[0], order_per_rev: v[1], phase_rad: v[2] }),
    ),
    beside(
        "friction over position",
        "rub_zone",
        &["level", "from", "width"],
        |c, s, u| vec![s * c.torque, c.travel * (u[0] - 0.5), 0.05 * c.travel],
        |v| Box::new(friction::RubZone([v[0], v[1], v[2]])),
    ),
    number(
        "friction over load",
        "friction_by_load",
        &["share"],
        |_, s, _| vec![0.9 * s],
        |p, v| put("friction_by_load", p, v),
    ),
    beside(
        "friction over load",
        "viscous_by_load",
        &["share_per_speed"],
        |c, s, _| vec![s / c.speed],
        |v| Box::new(friction::ViscousByLoad(v[0])),
    ),
    beside(
        "friction over temperature",
        "dry_friction_warms",
        &["share", "energy_j", "cooling_s"],
        |c, s, u| heat(c, s.min(0.95), u),
        |v| Box::new(friction::DryWarms::new(v)),
    ),
    beside(
        "friction over temperature",
        "grease_warms",
        &["viscous", "energy_j", "cooling_s"],
        |c, s, u| heat(c, s * c.torque / c.speed, u),
        |v| Box::new(friction::GreaseWarms::new(v)),
    ),
    number(
        "friction over rest",
        "stiction_by_rest",
        &["excess", "time_s"],
        |c, s, u| vec![2.0 * s * c.torque, 0.02 + 0.1 * u[0]],
        |p, v| put("stiction_by_rest", p, v),
    ),
    beside(
        "friction over rest",
        "grip_after_rest",
        &["level", "way"],
        |c, s, u| vec![2.0 * s * c.torque, c.travel * (0.02 + 0.2 * u[0])],
        |v| Box::new(friction::Grip::new(v)),
    ),
    beside(
        "friction over time",
        "run_in",
        &["level", "way"],
        |c, s, u| vec![s * c.torque, c.speed * c.duration_s * (0.1 + 0.3 * u[0])],
        |v| Box::new(friction::RunIn::new(v)),
    ),
    beside(
        "friction over time",
        "seal_seats",
        &["level", "at_s", "width_s"],
        |c, s, u| vec![s * c.torque, c.duration_s * (0.3 + 0.4 * u[0]), 0.02 * c.duration_s],
        |v| Box::new(friction::Seats([v[0], v[1], v[2]])),
    ),
    beside(
        "friction over speed",
        "film",
        &["share", "speed"],
        |c, s, u| vec![s.min(0.95), c.speed * (0.3 + u[0])],
        |v| Box::new(friction::Film([v[0], v[1]])),
    ),
    beside(
        "friction over speed",
        "root_drag",
        &["coefficient", "least_speed"],
        |c, s, _| vec![s * c.torque / c.speed.sqrt(), 0.01 * c.speed],
        |v| Box::new(friction::RootDrag([v[0], v[1]])),
    ),
    beside(
        "friction over speed",
        "late_stribeck",
        &["level", "speed", "lag_s"],
        |c, s, u| vec![s * c.torque, c.speed * (0.1 + 0.4 * u[0]), 0.02 + 0.06 * u[1]],
        |v| Box::new(friction::LateStribeck::new(v)),
    ),
    number(
        "springs that harden",
        "nonlinear_spring",
        &["stiffness_cubic"],
        |c, s, _| vec![s * c.torque / c.travel.powi(3)],
        |p, v| put("nonlinear_spring", p, v),
    ),
    beside(
        "springs that harden",
        "end_stop",
        &["stiffness", "at"],
        |c, s, u| vec![20.0 * s * c.torque / c.travel, c.travel * (0.3 + 0.4 * u[0])],
        |v| Box::new(spring::EndStop([v[0], v[1]])),
    ),
    beside(
        "springs with memory",
        "spring_with_play",
        &["stiffness", "half_play"],
        |c, s, u| vec![2.0 * s * c.torque / c.travel, c.travel * (0.3 + 0.3 * u[0])],
        |v| Box::new(spring::GappedSpring([v[0], v[1]])),
    ),
    beside(
        "springs with memory",
        "creeping_spring",
        &["stiffness", "time_s"],
        |c, s, u| vec![s * c.torque / c.travel, (0.1 + 0.5 * u[0]) * c.travel / c.speed],
        |v| Box::new(spring::CreepingSpring::new(v)),
    ),
    of_drive(beside(
        "torque ripple",
        "torque_ripple",
        &["share", "order", "phase_rad"],
        |c, s, u| vec![s.min(0.9), whole_order(c, u), phase(u)],
        |v| Box::new(drive::Ripple([v[0], v[1], v[2]])),
    )),
    of_drive(beside(
        "torque ripple",
        "commutation_dips",
        &["share", "order", "phase_rad"],
        |c, s, u| vec![s.min(0.9), whole_order(c, u), phase(u)],
        |v| Box::new(drive::Dips([v[0], v[1], v[2]])),
    )),
    of_drive(number(
        "torque hysteresis",
        "torque_memory",
        &["share", "half_width"],
        |c, s, u| vec![s.min(0.95), c.torque * (0.2 + u[0])],
        |p, v| put("torque_memory", p, v),
    )),
    of_drive(beside(
        "torque hysteresis",
        "torque_creep",
        &["share", "time_s"],
        |_, s, u| vec![0.8 * s.min(1.0), 0.05 + 0.2 * u[0]],
        |v| Box::new(drive::Creep::new(v)),
    )),
    of_drive(number(
        "torque curve",
        "magnetic_saturation",
        &["level"],
        |c, s, _| vec![c.torque / s],
        |p, v| put("magnetic_saturation", p, v),
    )),
    of_drive(beside(
        "torque curve",
        "gain_by_sign",
        &["difference"],
        |_, s, u| vec![if u[0] < 0.5 { s.min(0.9) } else { -s.min(0.9) }],
        |v| Box::new(drive::GainBySign(v[0])),
    )),
    of_drive(beside(
        "torque over supply",
        "gain_fades",
        &["share", "energy", "cooling_s"],
        |c, s, u| {
            let time_s = c.duration_s * (0.1 + 0.4 * u[0]);
            vec![s.min(0.9), c.torque * c.torque * time_s, 2.0 * time_s]
        },
        |v| Box::new(drive::Fades::new(v)),
    )),
    of_drive(beside(
        "torque over supply",
        "supply_sags",
        &["share", "power_w"],
        |c, s, u| vec![s.min(0.9), power(c) * (0.3 + u[0])],
        |v| Box::new(drive::Sag([v[0], v[1]])),
    )),
    beside(
        "sensor nonlinearity",
        "bent_scale",
        &["curvature"],
        |c, s, _| vec![0.2 * s / c.travel],
        |v| Box::new(sensor::Bent(v[0])),
    ),
    beside(
        "sensor nonlinearity",
        "loose_sensor",
        &["half_play"],
        |c, s, _| vec![0.1 * s * c.travel],
        |v| Box::new(sensor::LooseSensor::new(v)),
    ),
    beside(
        "sensor nonlinearity",
        "sawtooth_error",
        &["amplitude", "order", "offset"],
        |c, s, u| vec![0.1 * s * c.travel, order(c, u), u[0]],
        |v| Box::new(sensor::Sawtooth([v[0], v[1], v[2]])),
    ),
    beside(
        "several loads",
        "two_resonances",
        &["share", "first_hz", "second_hz", "damping_ratio", "inertia"],
        |c, s, u| {
            let top_hz = (0.12 / c.period_s).min(60.0);
            vec![0.4 * s.min(1.0), top_hz * (0.2 + 0.2 * u[0]), top_hz * (0.6 + 0.4 * u[1]), 0.05, c.inertia]
        },
        |v| Box::new(mechanics::TwoResonances::new(v)),
    ),
    beside(
        "several loads",
        "slipping_load",
        &["share", "level", "creep", "inertia"],
        |c, s, u| vec![0.7 * s.min(1.0), c.torque * s.min(1.0) * (0.1 + 0.3 * u[0]), 0.02 * c.speed, c.inertia],
        |v| Box::new(mechanics::Clutch::new(v)),
    ),
    number(
        "changing inertia",
        "load_change",
        &["inertia", "from_s"],
        |c, s, u| vec![c.inertia * (1.0 + s), c.duration_s * (0.3 + 0.4 * u[0])],
        |p, v| p.load_change = Some((v[1], v[0])),
    ),
    beside(
        "changing inertia",
        "linkage",
        &["share", "order", "phase_rad", "inertia"],
        |c, s, u| vec![s.min(0.8), order(c, u).min(3.0 / c.travel), phase(u), c.inertia],
        |v| Box::new(mechanics::Linkage([v[0], v[1], v[2], v[3]])),
    ),
    of_fluid(number(
        "fluid hysteresis",
        "warmth_with_hysteresis",
        &["share", "energy_j", "cooling_s", "half_width"],
        |c, s, u| [heat(c, s.min(0.95), u), vec![0.1]].concat(),
        |p, v| put("warmth_with_hysteresis", p, v),
    )),
    of_fluid(beside(
        "fluid hysteresis",
        "remanence",
        &["half_width_kv_mm"],
        |c, s, _| vec![0.9 * s.min(1.0) * c.field_kv_mm],
        |v| Box::new(fluid::Remanence::new(v)),
    )),
    of_fluid(number(
        "fluid memory",
        "field_leakage",
        &["share", "time_s"],
        |_, s, u| vec![s.min(0.95), 0.03 + 0.2 * u[0]],
        |p, v| put("field_leakage", p, v),
    )),
    of_fluid(beside(
        "fluid memory",
        "fluid_sets",
        &["share", "time_s", "speed"],
        |c, s, u| vec![2.0 * s, 0.05 + 0.2 * u[0], 0.1 * c.speed],
        |v| Box::new(fluid::Sets::new(v)),
    )),
    of_fluid(beside(
        "fluid over angle and shear",
        "eccentric_gap",
        &["share", "order", "phase_rad"],
        |c, s, u| vec![s.min(0.95), order(c, u), phase(u)],
        |v| Box::new(fluid::EccentricGap([v[0], v[1], v[2]])),
    )),
    of_fluid(beside(
        "fluid over angle and shear",
        "shear_thinning",
        &["share", "speed"],
        |c, s, u| vec![s.min(0.95), c.speed * (0.3 + u[0])],
        |v| Box::new(fluid::Thins([v[0], v[1]])),
    )),
    of_fluid(beside(
        "fluid over angle and shear",
        "field_saturates",
        &["level_kv_mm"],
        |c, s, _| vec![c.field_kv_mm / s],
        |v| Box::new(fluid::Saturates(v[0])),
    )),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::NAMED_SINCE;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn there_are_enough_kinds_in_families_that_stand_together() {
        let ids: BTreeSet<&str> = kinds().map(|kind| kind.id).collect();
        let unique: BTreeSet<&str> = families().into_iter().collect();
        println!("{} kinds in {} families", ids.len(), unique.len());
        assert!(ids.len() == kinds().count() && ids.len() >= 25 && unique.len() == families().len());
        for entry in catalogue::ENTRIES.iter().filter(|entry| !entry.in_vocabulary) {
            assert!(find(entry.id).is_some(), "{}", entry.id);
        }
        let named = |entry: &&catalogue::Entry| entry.in_vocabulary && find(entry.id).is_some();
        for entry in catalogue::ENTRIES.iter().filter(named) {
            assert!(NAMED_SINCE.iter().any(|(kind, _)| *kind == entry.id), "{}", entry.id);
        }
    }
}
