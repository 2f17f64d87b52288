//! Which case a seed is: the plan is a list that seeds walk through again and again.

mod drawn;
mod ledger;
mod steps;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::catalogue::ENTRIES;

pub use self::drawn::{Drawn, ROUND};
pub(crate) use self::ledger::kinds_of;
pub use self::ledger::{LEDGER, TUNING, families_of};
pub use self::steps::plan as plan_of_steps;

/// What kind of question a case asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Arm {
    /// Nothing is concealed: nothing may be named.
    Clean,
    /// The log misleads (coarse, uneven, with gaps) or a nominal parameter is 5 % off, alone or beside a clear effect.
    Decoy,
    /// One effect of the vocabulary, from clear to invisible.
    Single,
    /// Two effects of the vocabulary.
    Pair,
    /// Three.
    Triple,
    /// One effect whose name is taken out of the library.
    Removed,
    /// One effect the library never knew.
    Outside,
    /// One effect under a motion that cannot tell it, before and after the experiment the tool proposes.
    Poor,
    /// The law that ran is not the one in the machine file.
    Controller,
    /// The paper's own experiment: single steps, and a delay of the fluid.
    Steps,
}

impl Arm {
    /// Every arm, in the order of the report.
    pub const ALL: [Self; 10] = [
        Self::Clean,
        Self::Decoy,
        Self::Single,
        Self::Pair,
        Self::Triple,
        Self::Removed,
        Self::Outside,
        Self::Poor,
        Self::Controller,
        Self::Steps,
    ];

    /// As in commands and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Decoy => "decoy",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Triple => "triple",
            Self::Removed => "removed",
            Self::Outside => "outside",
            Self::Poor => "poor",
            Self::Controller => "controller",
            Self::Steps => "steps",
        }
    }
}

impl FromStr for Version {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "fixed" => Ok(Self::Fixed),
            "drawn" => Ok(Self::Drawn),
            "steps" => Ok(Self::Steps),
            _ => Err(format!("there is no plan `{text}`; there are fixed, drawn and steps")),
        }
    }
}

impl fmt::Display for Arm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Arm {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names: Vec<&str> = Self::ALL.map(Self::name).to_vec();
        let found = Self::ALL.into_iter().find(|arm| arm.name() == text);
        found.ok_or_else(|| format!("there is no arm `{text}`; there are {}", names.join(", ")))
    }
}

/// How the log or the machine file misleads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decoy {
    /// The position is logged with 12 bits a revolution.
    TwelveBits,
    /// Control periods are uneven by up to 20 us.
    Jitter,
    /// Rows are missing here and there.
    Gaps,
    /// The machine file has a parameter 5 % off; that parameter is an effect to be named, only small.
    Nominal,
}

/// Range of sizes a case may have, as fractions of the clear size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Largest.
    pub high: f64,
    /// Smallest; as large as the largest for a size that is not drawn.
    pub low: f64,
}

/// What a case is before anything is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Blueprint {
    /// Arm.
    pub arm: Arm,
    /// Effects to conceal.
    pub effects: Vec<&'static str>,
    /// Their size.
    pub sizes: Sizes,
    /// How the log misleads, if it does.
    pub decoy: Option<Decoy>,
    /// Field that a bench supply holds in place of the law's, kV/mm. Such a machine comes without a controller to check.
    pub held_kv_mm: Option<f32>,
}

impl Blueprint {
    fn new(arm: Arm, effects: &[&'static str], size: f64) -> Self {
        Self { arm, effects: effects.to_vec(), sizes: Sizes { high: size, low: size }, decoy: None, held_kv_mm: None }
    }

    /// The blueprint of a seed in the plan of single steps.
    pub fn of_steps(seed: u64) -> Self {
        let mut plan = plan_of_steps();
        let index = (seed % plan.len() as u64) as usize;
        plan.swap_remove(index)
    }

    fn misled(effects: &[&'static str], decoy: Decoy) -> Self {
        Self { decoy: Some(decoy), ..Self::new(Arm::Decoy, effects, 1.0) }
    }

    /// The blueprint of a seed.
    pub fn of(seed: u64) -> Self {
        let mut plan = plan();
        let index = (seed % plan.len() as u64) as usize;
        plan.swap_remove(index)
    }
}

/// Clean cases in one round: one wrong name is the 1 % that is allowed.
const CLEAN: usize = 100;
/// Strata of size of each single effect, each half of the one before; a round draws one size within each.
const STRATA: i32 = 5;

/// Effects that do not act on the same number of the machine.
const PAIRS: [[&str; 2]; 20] = [
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
    ["backlash", "viscous_friction"],
    ["torque_deadband", "field_gain"],
    ["disturbance_pulse", "inertia"],
    ["presliding", "torque_gain"],
    ["field_slew_limit", "cogging"],
    ["resolver_eccentricity", "coulomb_friction"],
    ["viscosity_lag", "viscous_friction"],
    ["sensor_glitch", "gravity_load"],
];

const TRIPLES: [[&str; 3]; 8] = [
    ["coulomb_friction", "field_lag", "torque_offset"],
    ["viscous_friction", "inertia", "cogging"],
    ["er_strength", "torque_delay", "gravity_load"],
    ["stribeck_friction", "torque_lag", "spring_load"],
    ["vibration", "friction_asymmetry", "field_dead_time"],
    ["compliance", "coulomb_friction", "er_drift"],
    ["sensor_latency", "viscous_friction", "torque_offset"],
    ["disturbance_pulse", "quadratic_drag", "inertia"],
];

/// What one slow sine cannot tell from something else, or carries no trace of, with the field that a bench supply holds
/// meanwhile, kV/mm; without one the law commands the field.
const CONFOUNDED: [(&str, Option<f32>); 12] = [
    ("coulomb_friction", HELD),
    ("er_strength", HELD),
    ("field_gain", HELD),
    ("field_lag", None),
    ("field_dead_time", None),
    ("inertia", None),
    ("torque_gain", HELD),
    ("torque_delay", None),
    ("viscous_friction", HELD),
    ("spring_load", None),
    ("friction_asymmetry", HELD),
    ("sensor_latency", None),
];

/// A field that more than doubles the dry friction, kV/mm.
const HELD: Option<f32> = Some(1.5);

/// Clear effects that a misleading log must not hide.
const BESIDE_DECOYS: [&str; 4] = ["coulomb_friction", "viscous_friction", "torque_offset", "gravity_load"];

/// Parameters the machine file may have 5 % off.
pub(crate) const NOMINAL: [&str; 4] = ["inertia", "torque_gain", "coulomb_friction", "er_strength"];

/// One round of the plan; seed s is case s modulo its length.
pub fn plan() -> Vec<Blueprint> {
    let fixed = || ENTRIES.iter().filter(|entry| entry.in_fixed_plan);
    let ids = |inside: bool| fixed().filter(move |entry| entry.in_vocabulary == inside).map(|entry| entry.id);
    let mut plan = vec![Blueprint::new(Arm::Clean, &[], 0.0); CLEAN];
    for decoy in [Decoy::TwelveBits, Decoy::Jitter, Decoy::Gaps] {
        plan.extend(
            BESIDE_DECOYS.iter().flat_map(|id| [Blueprint::misled(&[], decoy), Blueprint::misled(&[id], decoy)]),
        );
    }
    plan.extend(NOMINAL.iter().flat_map(|id| vec![Blueprint::misled(&[id], Decoy::Nominal); 2]));
    for stratum in 0..STRATA {
        let high = 0.5_f64.powi(stratum);
        let sizes = Sizes { high, low: 0.5 * high };
        plan.extend(ids(true).map(|id| Blueprint { sizes, ..Blueprint::new(Arm::Single, &[id], 1.0) }));
    }
    plan.extend(PAIRS.iter().map(|pair| Blueprint::new(Arm::Pair, pair, 0.7)));
    plan.extend(TRIPLES.iter().map(|triple| Blueprint::new(Arm::Triple, triple, 0.7)));
    plan.extend(ids(true).map(|id| Blueprint::new(Arm::Removed, &[id], 1.0)));
    plan.extend(
        [1.0, 0.5].iter().flat_map(|&size| ids(false).map(move |id| Blueprint::new(Arm::Outside, &[id], size))),
    );
    plan.extend(
        CONFOUNDED.iter().map(|&(id, held_kv_mm)| Blueprint { held_kv_mm, ..Blueprint::new(Arm::Poor, &[id], 1.0) }),
    );
    plan.extend(vec![Blueprint::new(Arm::Controller, &[], 1.0); 4]);
    plan
}

/// Which plan a seed is read by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Version {
    /// One machine and lists of effects, the same in every round: every round so far.
    Fixed,
    /// Machines, effects and sizes drawn.
    Drawn,
    /// The paper's servo after single steps: delays of the fluid, their sizes and the steps drawn.
    Steps,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::catalogue::find;

    #[test]
    fn every_arm_has_cases_every_effect_exists_and_seeds_repeat_the_plan() {
        let plan = plan();
        println!("{} cases in a round", plan.len());
        for arm in Arm::ALL {
            assert!(plan.iter().chain(&plan_of_steps()).any(|case| case.arm == arm), "{arm}");
            assert_eq!(arm.name().parse::<Arm>().unwrap(), arm);
        }
        for id in plan.iter().flat_map(|case| &case.effects) {
            assert!(find(id).is_some(), "{id}");
        }
        assert_eq!(Blueprint::of(7 + 3 * plan.len() as u64), plan[7]);
    }
}
