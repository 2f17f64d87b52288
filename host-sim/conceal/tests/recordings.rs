//! Every effect in closed loop: the drive does not trip, the machine differs from the clean one, the same seed repeats.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use conceal::catalogue::{ENTRIES, for_recording};
use conceal::closed_loop::{Row, Run};
use conceal::physics::Physics;
use conceal::reference::{Family, RICH};
use er_servo::Config;
use rand::SeedableRng;
use rand::rngs::StdRng;

fn rows(physics: &Physics, duration_s: f64) -> Vec<Row> {
    let reference = Family::Steps.draw(duration_s, 0.0005, &mut StdRng::seed_from_u64(3));
    let config = Config::default();
    Run { physics, config: &config, jitter_s: 0.0, held_kv_mm: None, asked_viscosity: false, seed: 5 }
        .follow(&reference)
        .unwrap()
}

#[test]
fn every_effect_moves_the_machine_without_tripping_the_drive() {
    let clean = rows(&Physics::nominal(), 1.5);
    assert_eq!(clean, rows(&Physics::nominal(), 1.5));
    for (index, entry) in ENTRIES.iter().enumerate() {
        let mut random = StdRng::seed_from_u64(index as u64);
        let mut physics = Physics::nominal();
        // Warmth thins only what is there.
        let warms = entry.id == "temperature_viscosity";
        physics.friction.viscous_nm_s_rad = if warms { 0.3 } else { 0.0 };
        let without = if warms { rows(&physics, 1.5) } else { clean.clone() };
        let concealed = entry.conceal(1.0, &mut physics, &mut random);
        // A push or a change of load later than this short run is moved into it.
        if let Some(pulse) = &mut physics.pulse {
            pulse.start_s = 0.2;
        }
        if let Some((from_s, _)) = &mut physics.load_change {
            *from_s = 0.2;
        }
        let physics = for_recording(&physics, 0, &mut random);
        let changed = rows(&physics, 1.5);
        let largest = without.iter().zip(&changed).map(|(a, b)| (a.position.0 - b.position.0).abs()).max().unwrap();
        println!("{:24} {:?} {largest} counts", entry.id, concealed.parameters);
        assert!(largest >= 5, "{}", entry.id);
    }
}

#[test]
fn time_of_an_eight_second_recording_is_printed() {
    let started = std::time::Instant::now();
    let made = rows(&Physics::nominal(), 8.0);
    println!("{} rows in {:.2} s", made.len(), started.elapsed().as_secs_f64());
}

#[test]
fn no_effect_trips_the_drive_under_any_family() {
    for entry in ENTRIES {
        for (index, family) in RICH.into_iter().chain([Family::SlowSine]).enumerate() {
            let mut random = StdRng::seed_from_u64(index as u64);
            let mut physics = Physics::nominal();
            entry.conceal(1.0, &mut physics, &mut random);
            let reference = family.draw(1.2, 0.0005, &mut random);
            let run = Run {
                physics: &physics,
                config: &Config::default(),
                jitter_s: 20e-6,
                held_kv_mm: None,
                asked_viscosity: false,
                seed: 1,
            };
            assert!(run.follow(&reference).is_ok(), "{} {family:?}", entry.id);
        }
    }
}

#[test]
fn a_case_is_the_same_files_every_time_and_keeps_its_gaps() {
    use conceal::case::{Case, HELD_OUT, MACHINE};
    use conceal::plan::{Decoy, plan};
    let seed = plan().iter().position(|case| case.decoy == Some(Decoy::Gaps)).unwrap() as u64;
    let read = || {
        let folder = tempfile::tempdir().unwrap();
        Case::draw(seed).write(folder.path()).unwrap();
        [MACHINE, "a.csv", HELD_OUT].map(|name| std::fs::read_to_string(folder.path().join(name)).unwrap())
    };
    let files = read();
    assert_eq!(files, read());
    let seq: Vec<u64> = files[1].lines().skip(1).map(|row| row.rsplit(',').next().unwrap().parse().unwrap()).collect();
    assert!(seq.windows(2).all(|two| two[1] > two[0]) && seq.windows(2).any(|two| two[1] > two[0] + 1));
    let nominal: Vec<_> = plan().into_iter().filter(|case| case.decoy == Some(Decoy::Nominal)).collect();
    let case = Case::of(3, nominal[0].clone());
    assert_eq!(case.truth.effects[0].id, "inertia");
}

#[test]
fn a_held_field_is_what_the_log_shows_and_what_brakes() {
    use conceal::case::{Case, MACHINE};
    use conceal::plan::plan;
    let seed = plan().iter().position(|case| case.held_kv_mm.is_some()).unwrap() as u64;
    let folder = tempfile::tempdir().unwrap();
    Case::draw(seed).write(folder.path()).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(!read(MACHINE).contains("[controller]"));
    let rows = read("a.csv");
    assert!(rows.lines().skip(1).all(|row| row.contains(",1.5,brake,")), "{}", rows.lines().nth(1).unwrap());
    let reference = Family::SlowSine.draw(2.0, 0.0005, &mut StdRng::seed_from_u64(3));
    let travelled = |held_kv_mm| {
        let run = Run {
            physics: &Physics::nominal(),
            config: &Config::default(),
            jitter_s: 0.0,
            held_kv_mm,
            asked_viscosity: false,
            seed: 5,
        };
        let rows = run.follow(&reference).unwrap();
        rows.iter().map(|row| f64::from(row.torque_nm).abs()).sum::<f64>() / rows.len() as f64
    };
    let (free, held) = (travelled(Some(0.0)), travelled(Some(1.5)));
    assert!(held > free + 0.5, "{free} {held} N m");
}
