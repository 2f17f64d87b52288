//! Memory of a diagnosis. Each test by its name alone, so that the peak is its own:
//! `cargo test --release -p lab --test diagnosis size::ten_minutes -- --ignored --nocapture`

use analysis::simulate::{Reference, Setup, record, run};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use lab::conclude::{Request, diagnose};
use lab::read::Recording;
use lab::report::Verdict;

use crate::cases::{COUNT_RAD, answer, machine, recordings};

/// Peak resident memory of this process so far, MB; none where the system does not say.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

#[test]
#[ignore = "measures the process: cargo test --release -p lab --test diagnosis size::three -- --ignored --nocapture"]
fn three_recordings_of_eight_seconds_take_less_than_500_mb() {
    let files = recordings(&|physics| physics.model.coulomb = 0.95, 12, 0.05);
    let begun = std::time::Instant::now();
    let answer = answer(&files, "");
    let Some(peak_mb) = peak_mb() else {
        println!("skipped: the system does not say what a process takes");
        return;
    };
    println!("{:?} in {:.1} s, at most {peak_mb:.0} MB", answer.verdict, begun.elapsed().as_secs_f64());
    assert!(peak_mb < 500.0, "{peak_mb:.0} MB");
}

/// Ten minutes at 2 kHz of a machine with more friction than its model.
fn ten_minutes_long() -> Recording {
    let mut truth = Physics::nominal(&machine(COUNT_RAD), &[]);
    truth.model.coulomb = 0.95;
    let setup = Setup {
        model: truth.model_of(0),
        config: Config::default(),
        disturbances: Vec::new(),
        sensor_noise_rad: 0.0,
        torque_noise_nm: 0.05,
        seed: 1,
    };
    let shape = Shape::Steps { amplitude_rad: 0.9, dwell_s: 0.5, seed: 1 };
    let reference = Reference::Experiment(Experiment { shape, duration_s: 600.0 });
    record("long.csv", &run(&setup, reference.positions(5e-4).unwrap()).unwrap())
}

#[test]
#[ignore = "takes a minute: cargo test --release -p lab --test diagnosis size::ten_minutes -- --ignored --nocapture"]
fn ten_minutes_take_bounded_memory() {
    let machine = machine(COUNT_RAD);
    let recordings = [ten_minutes_long()];
    let before_mb = peak_mb().unwrap_or(0.0);
    let begun = std::time::Instant::now();
    let request = Request { machine: &machine, recordings: &recordings, holdout: &[], vocabulary: &VOCABULARY };
    let diagnosis = diagnose(&request).unwrap();
    let (took_s, rows) = (begun.elapsed().as_secs_f64(), recordings[0].rows());
    let peak_mb = peak_mb().unwrap_or(0.0);
    println!("{rows} rows: {:?} in {took_s:.1} s", diagnosis.answer.verdict);
    println!("{before_mb:.0} MB before, at most {peak_mb:.0} MB");
    for (stage, took) in diagnosis.stages.taken() {
        println!("    {stage:24} {:6.3} s", took.as_secs_f64());
    }
    assert_eq!(diagnosis.answer.verdict, Verdict::Named, "{:?}", diagnosis.answer.effects);
    // What is looked at does not grow beyond five minutes; the recording itself takes 12 MB a minute.
    assert!(peak_mb - before_mb < 600.0, "{before_mb:.0} MB before, {peak_mb:.0} MB");
}
