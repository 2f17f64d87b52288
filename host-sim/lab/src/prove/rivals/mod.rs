//! What a competent engineer's script makes of the same files: torque residual by a Savitzky-Golay filter, columns of
//! candidate effects, and five ways to choose among them. None of them can abstain otherwise than by naming nothing.

mod choose;
mod columns;
mod smooth;

use std::path::Path;

use conceal::seal::Truth;

use self::choose::{Criterion, Gram};
use self::columns::Table;
use super::judge::RivalAnswer;
use crate::Error;
use crate::read::{Machine, Recording};

/// Names of the rivals, as in the score.
pub const RIVALS: [&str; 5] = ["3 % held out", "BIC", "AIC", "sparse", "richest friction"];

/// The friction model with everything in it, whatever the data says.
const RICHEST: [&str; 5] =
    ["coulomb_friction", "viscous_friction", "stribeck_friction", "friction_asymmetry", "torque_offset"];

/// Runs the rivals on the files of a case. An effect taken out of the tool's library is taken out of theirs.
///
/// # Errors
/// Files that cannot be read.
pub fn answers(
    folder: &Path,
    machine: &str,
    fitted: &[&str],
    held_out: &str,
    truth: &Truth,
) -> Result<Vec<RivalAnswer>, Error> {
    let machine = Machine::read(&folder.join(machine))?;
    let read = |name: &str| Recording::read(&folder.join(name), Some(machine.axis.kind));
    let removed: Vec<&str> = match truth.arm {
        conceal::plan::Arm::Removed => truth.effects.iter().map(|effect| effect.id.as_str()).collect(),
        _ => Vec::new(),
    };
    let mut table = Table::default();
    for name in fitted {
        table.add(&machine, &read(name)?);
    }
    let mut unseen = Table::default();
    unseen.add(&machine, &read(held_out)?);
    Ok(chosen(&table, &unseen, &removed))
}

fn chosen(table: &Table, unseen: &Table, removed: &[&str]) -> Vec<RivalAnswer> {
    let gram = Gram::of(table);
    let keeps = |id: &str| !removed.contains(&id);
    let groups: Vec<usize> = (0..table.groups.len()).filter(|&group| keeps(table.groups[group].id)).collect();
    let richest = || groups.iter().copied().filter(|&group| RICHEST.contains(&table.groups[group].id)).collect();
    let choices = [
        gram.by_prediction(table, unseen, &groups),
        gram.forward(table, &groups, Criterion::Bayes),
        gram.forward(table, &groups, Criterion::Akaike),
        gram.sparse(table, &groups),
        richest(),
    ];
    let answer = |(rival, groups): (&str, Vec<usize>)| {
        let mut named: Vec<String> = Vec::new();
        for group in &groups {
            let id = table.groups[*group].id;
            if !named.iter().any(|other| other == id) {
                named.push(id.to_owned());
            }
        }
        let columns = table.columns_of(&groups);
        let heldout_share =
            gram.fit(&columns).map_or(1.0, |weights| unseen.rms_after(&columns, &weights) / unseen.rms());
        RivalAnswer { rival: rival.to_owned(), named, heldout_share }
    };
    RIVALS.into_iter().zip(choices).map(answer).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use conceal::case::{Case, FITTED, HELD_OUT, MACHINE};
    use conceal::plan::{Arm, Blueprint, Sizes};

    fn named(effects: &[&'static str]) -> Vec<RivalAnswer> {
        let sizes = Sizes { high: 1.0, low: 1.0 };
        let case = Case::of(
            5,
            Blueprint { arm: Arm::Single, effects: effects.to_vec(), sizes, decoy: None, held_kv_mm: None },
        );
        let folder = tempfile::tempdir().unwrap();
        case.write(folder.path()).unwrap();
        answers(folder.path(), MACHINE, &FITTED, HELD_OUT, &case.truth).unwrap()
    }

    #[test]
    fn clear_viscous_friction_comes_first_by_both_criteria_and_lowers_the_held_out_residual() {
        let found = named(&["viscous_friction"]);
        for rival in &found[..3] {
            assert_eq!(rival.named[0], "viscous_friction", "{rival:?}");
            assert!(rival.heldout_share < 0.9, "{rival:?}");
        }
        assert!(found[3].named.iter().any(|id| id == "viscous_friction"), "{:?}", found[3]);
        assert_eq!(found[4].named.len(), RICHEST.len());
    }

    #[test]
    fn the_balance_of_torques_itself_is_no_explanation() {
        for rival in named(&[]) {
            let both = ["inertia", "torque_gain"].iter().all(|id| rival.named.iter().any(|name| name == id));
            assert!(!both && rival.heldout_share > 0.3, "{rival:?}");
        }
    }

    #[test]
    fn an_effect_that_was_taken_out_is_named_by_none() {
        let sizes = Sizes { high: 1.0, low: 1.0 };
        let blueprint =
            Blueprint { arm: Arm::Removed, effects: vec!["spring_load"], sizes, decoy: None, held_kv_mm: None };
        let case = Case::of(6, blueprint);
        let folder = tempfile::tempdir().unwrap();
        case.write(folder.path()).unwrap();
        for rival in answers(folder.path(), MACHINE, &FITTED, HELD_OUT, &case.truth).unwrap() {
            assert!(rival.named.iter().all(|id| id != "spring_load"), "{rival:?}");
        }
    }
}
