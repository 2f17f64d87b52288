//! The drawn plan: any machine, effects in sizes of what its motion can tell.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};

use conceal::case::{FITTED, HELD_OUT, MACHINE};
use conceal::drawn::Case;
use conceal::plan::{Arm, Drawn, ROUND};

/// Numbers of every cell that is one, by column.
fn numbers(csv: &str) -> BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for row in reader.records() {
        for (name, cell) in header.iter().zip(row.unwrap().iter()) {
            if name != "mode" {
                columns.entry(name.clone()).or_default().push(cell.parse().unwrap());
            }
        }
    }
    columns
}

fn written(case: &Case) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    case.write(folder.path()).unwrap();
    let files = [MACHINE].into_iter().chain(FITTED).chain([HELD_OUT]);
    files.map(|name| std::fs::read_to_string(folder.path().join(name)).unwrap()).collect()
}

#[test]
fn any_stretch_of_seeds_has_machines_of_all_kinds_finite_and_the_same_again() {
    let cases: Vec<Case> = (0..24).map(|seed| Case::draw(seed).unwrap()).collect();
    let mut arms = BTreeSet::new();
    for case in &cases {
        let started = std::time::Instant::now();
        let machine = case.truth.machine.clone().unwrap();
        let files = written(case);
        let columns = numbers(&files[1]);
        let rows = columns["t_s"].len();
        let effects: Vec<String> =
            case.truth.effects.iter().map(|e| format!("{} x{:.1} {:?}", e.id, e.size, e.parameters)).collect();
        println!(
            "{:3} {:10} {:6.0} Hz J {:8.5} u {:8.4} {} {rows} rows {:.1} s: {}",
            case.seed,
            case.truth.arm,
            1.0 / machine.period_s,
            machine.inertia,
            machine.torque_rms,
            if machine.linear {
                "linear"
            } else if machine.flashed_law {
                "servo"
            } else {
                "rotary"
            },
            started.elapsed().as_secs_f64(),
            effects.join(", ")
        );
        assert!(columns.values().flatten().all(|value| value.is_finite()) && rows > 1000, "{}", case.seed);
        arms.insert(case.truth.arm);
    }
    assert!(arms.len() >= 6, "{arms:?}");
    for case in &cases[..4] {
        let again = Case::draw(case.seed).unwrap();
        assert_eq!((&again.truth, written(&again)), (&case.truth, written(case)));
    }
}
