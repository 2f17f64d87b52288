//! However much there is to search, a diagnosis ends after the work it is allowed. Counted, so that it holds on every machine.

use crate::common::{Making, PLAIN, STEP_RAD, three};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::{Conclusion, Named, diagnose};
use diagnosis::problem::Problem;
use diagnosis::search::LEVEL_OF_A_STEP;
use plant::effects::Harmonic;
use plant::{Er, Model};

/// Three recordings of a machine with much that its model lacks, after this much work.
fn spent(allowed: u64) -> (Conclusion, u64) {
    let nominal = Model {
        coulomb: 0.3,
        torque_delay_s: 0.005,
        er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)),
        ..Model::new(0.075)
    };
    let real = Model {
        coulomb: 0.5,
        viscous: 0.05,
        torque_gain: 1.1,
        cogging: vec![Harmonic { amplitude: 0.3, order: 7.0, phase_rad: 0.4 }],
        spring_stiffness: 1.0,
        ..nominal.clone()
    };
    let torque = |t_s: f64, phase: f64| 3.0 * (5.0 * t_s + phase).sin() + 2.0 * (31.0 * t_s).sin();
    let making = Making { torque, seconds: 1.5, noise_nm: 0.02, step_rad: STEP_RAD, ..PLAIN };
    let recordings = three(&real, making);
    let problem = Problem::new(Physics::new(nominal), recordings, 2, STEP_RAD, false).allowing(allowed);
    let conclusion = diagnose(&problem, &VOCABULARY).unwrap();
    (conclusion, problem.work())
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_search_ends_after_the_work_it_is_allowed_and_says_so() {
    let (whole, needed) = spent(u64::MAX / 2);
    assert!(!whole.cut_short && !whole.effects.is_empty(), "{needed}: {:?}", whole.effects);
    // A tenth is 800 passes over all rows; of the longest recordings that are looked at there are twice as many.
    for allowed in [needed / 2, needed / 5, needed / 10, needed / 20] {
        let (conclusion, work) = spent(allowed);
        println!("allowed {allowed}: {work} spent, {} effects", conclusion.effects.len());
        assert!(conclusion.cut_short, "{work} of {allowed}");
        assert!(work <= allowed, "{work} of {allowed}");
        // However little it is, what it has begun is looked at.
        assert!(!conclusion.effects.is_empty(), "{allowed}");
        // What is told was found by a test, whichever of them was the last.
        let told = |one: &Named| one.p_value <= LEVEL_OF_A_STEP && one.gain > 0.0;
        assert!(conclusion.effects.iter().all(told), "{:?}", conclusion.effects);
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_search_that_is_cut_short_is_the_same_however_many_threads() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (conclusion, work) = pool.install(|| spent(20_000_000));
        let found: Vec<_> = conclusion.effects.iter().map(|one| (one.effect.id, one.entry.values.clone())).collect();
        (found, work)
    };
    assert_eq!(with(1), with(4));
}
