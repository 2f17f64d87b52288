//! Which case a seed is: the plan is a list that seeds walk through again and again.

use conceal::catalogue::ENTRIES;

use super::Arm;

/// Clean cases in one round of the plan.
const CLEAN: usize = 20;
/// Fractions of the clear size of each single effect.
const SIZES: [f64; 3] = [1.0, 0.5, 0.25];

/// Pairs that do not act on the same number of the machine.
const PAIRS: [[&str; 2]; 12] = [
    ["coulomb_friction", "field_lag"],
    ["viscous_friction", "torque_offset"],
    ["inertia", "stribeck_friction"],
    ["torque_delay", "coulomb_friction"],
    ["cogging", "viscous_friction"],
    ["er_strength", "inertia"],
    ["field_dead_time", "spring_load"],
    ["gravity_load", "torque_lag"],
    ["sensor_latency", "quadratic_drag"],
    ["vibration", "coulomb_friction"],
    ["compliance", "torque_offset"],
    ["friction_asymmetry", "er_drift"],
];

/// How the log misleads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decoy {
    /// The position is logged with 12 bits a revolution.
    TwelveBits,
    /// Control periods are uneven by up to 20 us.
    Jitter,
}

/// What a case is before anything is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Blueprint {
    /// Arm.
    pub arm: Arm,
    /// Effects to conceal.
    pub effects: Vec<&'static str>,
    /// Fraction of their clear size.
    pub size: f64,
    /// How the log misleads, if it does.
    pub decoy: Option<Decoy>,
}

impl Blueprint {
    fn new(arm: Arm, effects: &[&'static str], size: f64) -> Self {
        Self { arm, effects: effects.to_vec(), size, decoy: None }
    }

    /// The blueprint of a seed.
    pub fn of(seed: u64) -> Self {
        let mut plan = plan();
        let index = (seed % plan.len() as u64) as usize;
        plan.swap_remove(index)
    }
}

/// One round of the plan; seed s is case s modulo its length.
pub fn plan() -> Vec<Blueprint> {
    let ids = |inside: bool| ENTRIES.iter().filter(move |entry| entry.in_vocabulary == inside).map(|entry| entry.id);
    let mut plan = vec![Blueprint::new(Arm::Clean, &[], 0.0); CLEAN];
    for decoy in [Decoy::TwelveBits, Decoy::Jitter] {
        plan.extend(vec![Blueprint { decoy: Some(decoy), ..Blueprint::new(Arm::Decoy, &[], 0.0) }; 4]);
    }
    plan.extend(SIZES.iter().flat_map(|&size| ids(true).map(move |id| Blueprint::new(Arm::Single, &[id], size))));
    // A nominal parameter that is 5 % off is an effect like any other, only small.
    plan.extend(["inertia", "torque_gain", "coulomb_friction", "er_strength"].map(|id| {
        let clear = match id {
            "inertia" => 0.12,
            "torque_gain" => 0.1,
            "coulomb_friction" => 0.3 / 0.763,
            _ => 0.25,
        };
        Blueprint::new(Arm::Single, &[id], 0.05 / clear)
    }));
    plan.extend(PAIRS.iter().map(|pair| Blueprint::new(Arm::Pair, pair, 0.7)));
    plan.extend(ids(true).map(|id| Blueprint::new(Arm::Removed, &[id], 1.0)));
    plan.extend(ids(false).map(|id| Blueprint::new(Arm::Outside, &[id], 1.0)));
    plan.extend(vec![Blueprint::new(Arm::Controller, &[], 1.0); 4]);
    plan
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::vocabulary::EFFECTS;

    #[test]
    fn every_effect_of_the_vocabulary_is_a_single_case_and_seeds_repeat_the_plan() {
        let plan = plan();
        for effect in EFFECTS {
            let single = |case: &Blueprint| case.arm == Arm::Single && case.effects == [effect.id];
            assert!(plan.iter().filter(|case| single(case)).count() >= SIZES.len(), "{}", effect.id);
        }
        for pair in PAIRS.iter().flatten() {
            assert!(conceal::catalogue::find(pair).is_some(), "{pair}");
        }
        assert_eq!(Blueprint::of(7 + 3 * plan.len() as u64), plan[7]);
    }
}
