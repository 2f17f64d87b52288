#![allow(clippy::unwrap_used, clippy::panic)]
use conceal::case::Case;
use conceal::plan::{Arm, Blueprint, Sizes};

use super::formula;
use crate::decide::testing::{machine, recording};
use crate::effects::{Harmonic, Physics};
use crate::read::{AxisKind, Machine, Recording};
use crate::report::Formula;
use crate::screen::{Motion, Problem, Search};

/// The formula from two recordings and one held out, where no effect of the vocabulary was tried.
fn of_recordings(machine: &Machine, recordings: &[Recording]) -> Option<Formula> {
    let nominal = Physics::nominal(machine);
    let motions = recordings.iter().map(|recorded| Motion::new(recorded, &nominal, machine.axis.resolution));
    let problem = Problem::new(motions.collect(), 2, nominal);
    let outcome = Search::new(&problem, &[], false).run(&[]);
    formula(&problem, &outcome, AxisKind::Rotary)
}

/// Of a machine of the own plant with something the nominal one lacks.
fn simulated(change: impl Fn(&mut Physics)) -> Option<Formula> {
    let machine = machine();
    let mut truth = Physics::nominal(&machine);
    change(&mut truth);
    let recordings: Vec<Recording> = (1..=3).map(|seed| recording(&truth, 0.02, 6.0, seed)).collect();
    of_recordings(&machine, &recordings)
}

/// Of a machine with an effect from outside the vocabulary, simulated by other numerics than the tool's; and the
/// parameters of that effect.
fn concealed(id: &'static str) -> (Option<Formula>, Vec<f64>) {
    let sizes = Sizes { high: 1.0, low: 1.0 };
    let case = Case::of(7, Blueprint { arm: Arm::Outside, effects: vec![id], sizes, decoy: None, held_kv_mm: None });
    let folder = tempfile::tempdir().unwrap();
    case.write(folder.path()).unwrap();
    let machine = Machine::read(&folder.path().join("machine.toml")).unwrap();
    let recordings = ["a.csv", "b.csv", "c.csv"].map(|name| Recording::read(&folder.path().join(name), None).unwrap());
    let parameters = case.truth.effects[0].parameters.iter().map(|(_, value)| *value).collect();
    (of_recordings(&machine, &recordings), parameters)
}

#[test]
fn friction_that_depends_on_position_is_said_to_be_that() {
    let (found, truth) = concealed("friction_over_position");
    let found = found.unwrap();
    let wave = format!("sign(w) \u{b7} sin({} x + phase)", truth[1]);
    assert_eq!((found.terms.len(), &found.terms[0].text), (1, &wave), "{}", found.text);
    let amplitude = &found.terms[0].parameters[0];
    // A share of the Coulomb friction of the default machine.
    let true_nm = 0.763 * truth[0];
    assert!((amplitude.value / true_nm - 1.0).abs() < 0.02 && amplitude.unit == "N m", "{true_nm}: {}", found.text);
    assert!(found.excess_explained > 0.8, "{found:?}");
}

#[test]
fn a_spring_that_stiffens_is_a_cube_of_the_position() {
    let (found, truth) = concealed("nonlinear_spring");
    let found = found.unwrap();
    assert_eq!((found.terms.len(), found.terms[0].text.as_str()), (1, "x\u{b3}"), "{}", found.text);
    let stiffness = &found.terms[0].parameters[0];
    assert!((stiffness.value / -truth[0] - 1.0).abs() < 0.02, "{truth:?}: {}", found.text);
    assert_eq!(stiffness.unit, "N m/rad\u{b3}");
}

#[test]
fn cogging_of_a_simulated_machine_is_a_wave_with_its_phase() {
    let teeth = Harmonic { order: 7.0, sine: 0.2, cosine: 0.2 };
    let found = simulated(|machine| machine.cogging.push(teeth)).unwrap();
    assert_eq!((found.terms.len(), found.terms[0].text.as_str()), (1, "sin(7 x + phase)"), "{}", found.text);
    let [amplitude, phase] = found.terms[0].parameters.as_slice() else { panic!("{found:?}") };
    assert!((amplitude.value - 0.2 * 2.0_f64.sqrt()).abs() < 0.01, "{found:?}");
    assert!((phase.value - std::f64::consts::FRAC_PI_4).abs() < 0.05 && phase.low < phase.high, "{found:?}");
}

#[test]
fn what_is_clean_has_no_formula() {
    assert_eq!(simulated(|_| ()), None);
}

#[test]
#[ignore = "prints the formula for each effect from outside the vocabulary"]
fn table() {
    for entry in conceal::catalogue::ENTRIES.iter().filter(|entry| !entry.in_vocabulary) {
        let (found, truth) = concealed(entry.id);
        println!("{}: {truth:.3?}", entry.id);
        match found {
            None => println!("  no formula"),
            Some(found) => {
                let (gain, explained) = (100.0 * found.heldout_gain, 100.0 * found.excess_explained);
                println!("  {}\n  held-out error {gain:.0} % less, excess explained {explained:.1} %", found.text);
                for p in found.terms.iter().flat_map(|term| &term.parameters) {
                    println!("    {} {:.4} ({:.4} to {:.4}) {}", p.id, p.value, p.low, p.high, p.unit);
                }
            }
        }
    }
}
