//! What is said of data before any science: nothing of good recordings, and each fault by its name.

use std::path::Path;

use crate::servo::{PERIOD_S, field, paper, setup, shared};
use analysis::simulate::{Reference, Setup, record, run};
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use lab::precheck::{Finding, Problem, Purpose, Severity, check, warnings};
use lab::read::{Machine, Recording};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, Normal};

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\n\
                       resolution = 1.2783173e-5\n[plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30\n\
                       torque_delay_s = 0.005\n[plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\nlag_s = 0.003\n";

fn machine() -> Machine {
    Machine::from_bytes(Path::new("m.toml"), MACHINE.as_bytes()).unwrap()
}

/// The closed loop of the paper under an experiment of six seconds.
fn simulated(shape: Shape) -> Recording {
    let reference = Reference::Experiment(Experiment { shape, duration_s: 6.0 });
    let setup = Setup { torque_noise_nm: 0.05, ..setup(paper(field(0.002, 0.003)), Config::default()) };
    record("run.csv", &run(&setup, reference.positions(PERIOD_S).unwrap()).unwrap())
}

fn steps() -> Recording {
    simulated(Shape::Steps { amplitude_rad: 0.4, dwell_s: 0.25, seed: 1 })
}

/// Every n-th row of the columns that are looked at.
fn decimated(recording: &Recording, n: usize) -> Recording {
    let take = |values: &[f64]| values.iter().copied().step_by(n).collect::<Vec<f64>>();
    Recording {
        t_s: take(&recording.t_s),
        position: take(&recording.position),
        effort_cmd: take(&recording.effort_cmd),
        field_cmd_kv_mm: recording.field_cmd_kv_mm.as_deref().map(take),
        reference: None,
        mode: None,
        velocity: None,
        gaps: Vec::new(),
        mended: Vec::new(),
        ..recording.clone()
    }
}

fn of(machine: &Machine, recording: &Recording) -> Vec<Finding> {
    check(machine, std::slice::from_ref(recording), &[], Purpose::Diagnose)
}

#[test]
fn nothing_is_said_of_the_real_machines() {
    let Some(data) = shared("data") else { return };
    let sets: [(&str, &[&str], &[&str]); 5] = [
        ("emps", &["machine"], &["train", "pulses"]),
        (
            "odrive_cogging",
            &["machine"],
            &["slow2_comp_0", "slow2_nocomp_0", "slow2_nocomp_1", "slow2_slower_comp_0", "slow2_slower_nocomp_0"],
        ),
        (
            "dfki",
            &["heavy_full", "heavy_no_friction", "heavy_no_gravity", "heavy_none"],
            &["ddp", "dircol", "energy", "ilqr"],
        ),
        ("weigand", &["j1_full", "j1_no_coulomb", "j1_no_friction"], &["j1_A", "j1_B", "j1_C"]),
        ("weigand", &["j6_full", "j6_no_coulomb", "j6_no_friction"], &["j6_A", "j6_B", "j6_C"]),
    ];
    let mut said = Vec::new();
    for (folder, machines, recordings) in sets {
        for machine in machines {
            let machine = Machine::read(&data.join(folder).join(format!("{machine}.toml"))).unwrap();
            for name in recordings {
                let recording = Recording::read(&data.join(folder).join(format!("{name}.csv")), None).unwrap();
                let mean_s = recording.t_s[recording.rows() - 1] / recording.rows() as f64;
                // Slower logs of the same machines, as far as they can be worked on.
                for n in [1, 2, 4, 8].into_iter().filter(|n| *n as f64 * mean_s < 0.045) {
                    let findings = of(&machine, &decimated(&recording, n));
                    said.extend(findings.iter().map(|finding| format!("{folder} {n}: {finding}")));
                }
            }
        }
    }
    assert!(said.is_empty(), "{said:#?}");
}

#[test]
fn the_real_machines_with_a_fault_are_named() {
    let Some(data) = shared("data") else { return };
    for (folder, machine, name) in
        [("emps", "machine", "train"), ("dfki", "heavy_full", "ddp"), ("weigand", "j1_full", "j1_C")]
    {
        let machine = Machine::read(&data.join(folder).join(format!("{machine}.toml"))).unwrap();
        let recording = Recording::read(&data.join(folder).join(format!("{name}.csv")), None).unwrap();
        let scaled = |position: f64, effort: f64| {
            let mut scaled = recording.clone();
            scaled.position.iter_mut().for_each(|value| *value *= position);
            scaled.effort_cmd.iter_mut().for_each(|value| *value *= effort);
            of(&machine, &scaled)
        };
        let flipped = scaled(1.0, -1.0);
        assert!(matches!(flipped[..], [Finding { problem: Problem::SignFlipped { .. }, .. }]), "{folder}: {flipped:?}");
        let far = |findings: &[Finding]| findings.iter().any(|found| matches!(found.problem, Problem::Inertia { .. }));
        let thousandfold = scaled(1000.0, 1.0);
        let step = |found: &Finding| matches!(found.problem, Problem::OtherStep { .. });
        assert!(far(&thousandfold) || thousandfold.iter().any(step), "{folder}: {thousandfold:?}");
        assert!(!thousandfold.iter().any(|found| found.severity == Severity::Error), "{folder}: {thousandfold:?}");
        assert!(far(&scaled(1.0, 12.0)), "{folder}: {:?}", scaled(1.0, 12.0));
        assert!(far(&scaled(1.0, 1.0 / 12.0)), "{folder}: {:?}", scaled(1.0, 1.0 / 12.0));
    }
}

#[test]
fn nothing_is_said_of_simulated_runs() {
    let multisine = Shape::Multisine { amplitude_rad: 0.3, low_hz: 0.2, high_hz: 6.0, tones: 12 };
    let chirp = Shape::Chirp { amplitude_rad: 0.2, from_hz: 0.2, to_hz: 6.0 };
    let slow = Shape::Chirp { amplitude_rad: 0.35, from_hz: 0.3, to_hz: 0.3 };
    let ramp = Shape::Ramp { speed_rad_s: 1.0, travel_rad: 0.5 };
    let steps = Shape::Steps { amplitude_rad: 0.4, dwell_s: 0.25, seed: 1 };
    for shape in [steps, multisine, chirp, slow, ramp] {
        let recording = simulated(shape);
        for n in [1, 2, 8] {
            assert_eq!(of(&machine(), &decimated(&recording, n)), [], "{shape:?}, every {n}th row");
        }
    }
}

/// Two drawn machines, whose fluid or friction went against the acceleration, had been refused.
#[test]
fn a_sign_is_wrong_for_certain_where_nothing_speaks_against_it() {
    let (machine, good) = (machine(), steps());
    let mut flipped = good.clone();
    flipped.effort_cmd.iter_mut().for_each(|u| *u = -*u);
    flipped.name = "flipped.csv".into();
    let severity = |machine: &Machine, fitted: &[Recording]| {
        let findings = check(machine, fitted, &[], Purpose::Diagnose);
        let turned = |found: &&Finding| matches!(found.problem, Problem::SignFlipped { .. });
        findings.iter().find(turned).map(|found| found.severity)
    };
    assert_eq!(severity(&machine, std::slice::from_ref(&flipped)), Some(Severity::Error));
    assert_eq!(
        severity(&machine, &[good, flipped.clone()]),
        Some(Severity::Warning),
        "another recording has the right sign"
    );
    let mut heavy = machine;
    heavy.plant.inertia *= 10.0;
    assert_eq!(severity(&heavy, &[flipped]), Some(Severity::Warning), "what is turned is not the inertia");
}

/// The one finding after a change of a good recording.
fn finding(machine: &Machine, change: impl Fn(&mut Recording)) -> Finding {
    let mut recording = steps();
    change(&mut recording);
    let findings = of(machine, &recording);
    let [finding] = &findings[..] else { panic!("{findings:?}") };
    finding.clone()
}

#[test]
fn each_fault_of_a_recording_is_named() {
    let machine = machine();
    let said = |change: &dyn Fn(&mut Recording), severity: Severity, message: &str| {
        let finding = finding(&machine, change);
        assert_eq!(finding.severity, severity, "{finding}");
        assert!(finding.to_string().contains(message), "{finding} lacks {message:?}");
    };
    said(
        &|r| r.position.fill(1.0),
        Severity::Error,
        "run.csv: position_rad: the axis never moves (0.0e0 rad from end to end)",
    );
    // Noise alone, over which torques that something holds explain it as well as any.
    let noise = |r: &mut Recording| {
        let (mut draw, normal) = (StdRng::seed_from_u64(1), Normal::new(0.3, 1e-4).unwrap());
        r.position.fill_with(|| normal.sample(&mut draw));
    };
    said(
        &noise,
        Severity::Error,
        "rad from end to end), beyond the steps and the noise of its sensor; record a motion",
    );
    said(&|r| r.effort_cmd.fill(0.0), Severity::Warning, "torque_cmd_nm: the torque is 0 N m in every row");
    said(&|r| r.position[7] = -1e300, Severity::Error, "position_rad: -1.0e300 is a value of no machine");
    said(&|r| r.effort_cmd[7] = 1e200, Severity::Error, "torque_cmd_nm: 1.0e200 is a value of no machine");
    said(&|r| r.field_cmd_kv_mm.as_mut().unwrap()[7] = 1e200, Severity::Error, "field_cmd_kv_mm: 1.0e200 is a value");
    said(&|r| r.effort_cmd.fill(1.5), Severity::Warning, "torque_cmd_nm: the torque is 1.5 N m in every row");
    said(
        &|r| r.effort_cmd.iter_mut().for_each(|u| *u = -*u),
        Severity::Error,
        "torque_cmd_nm: torque and acceleration have opposite signs",
    );
    said(
        &|r| r.t_s.iter_mut().for_each(|t| *t *= 1e3),
        Severity::Error,
        "t_s: rows are 0.5 s apart, at most 0.05 s can be",
    );
    said(&|r| r.t_s.iter_mut().for_each(|t| *t *= 1e3), Severity::Error, "is the time in ms?");
    said(&|r| *r = decimated(r, 2000), Severity::Error, "apart");
    let cut = |r: &mut Recording| {
        r.t_s.truncate(300);
        r.position.truncate(300);
        r.effort_cmd.truncate(300);
        r.field_cmd_kv_mm.as_mut().unwrap().truncate(300);
    };
    said(
        &|r| r.gaps = (0..r.rows() - 1).step_by(10).collect(),
        Severity::Error,
        "t_s: rows are missing in 1200 places, and after each what was commanded meanwhile still acts: 0.000 s are left",
    );
    said(&cut, Severity::Error, "run.csv: 0.149 s is too short, at least 0.8 s is needed; record longer");
    let error = warnings(&machine, &[finding_of(&cut)], &[], Purpose::Diagnose).unwrap_err();
    assert_eq!((error.exit_code(), error.to_string().lines().count()), (2, 1));
    said(
        &|r| r.effort_cmd.iter_mut().for_each(|u| *u *= 1e3),
        Severity::Warning,
        "and that of the machine file is 0.075; is the torque in mN m?",
    );
}

fn finding_of(change: &dyn Fn(&mut Recording)) -> Recording {
    let mut recording = steps();
    change(&mut recording);
    recording
}

#[test]
fn a_position_in_degrees_and_a_model_far_off_are_named() {
    let machine = machine();
    let mut degrees = steps();
    degrees.position.iter_mut().for_each(|q| *q = q.to_degrees());
    let said: Vec<String> = of(&machine, &degrees).iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|text| text.contains("is the position in degrees?")), "{said:?}");
    assert!(said.iter().any(|text| text.contains("the position moves in steps of 7.3")), "{said:?}");
    for factor in [0.1, 10.0] {
        let mut other = machine.clone();
        other.plant.inertia *= factor;
        let finding = finding(&other, |_| ());
        assert!(
            matches!(finding.problem, Problem::Inertia { low, high, .. } if low < 0.08 && high > 0.07),
            "{finding}"
        );
    }
    let mut fine = machine.clone();
    fine.axis.resolution *= 20.0;
    assert!(matches!(finding(&fine, |_| ()).problem, Problem::OtherStep { .. }));
}

/// A carriage of 2 kg under a force, 5 s at 1 kHz, with an encoder of 50 um.
fn carriage() -> (Machine, Recording) {
    let machine = "schema = 1\nname = \"m\"\n[axis]\nkind = \"linear\"\nsample_period_s = 1e-3\nresolution = 5e-5\n\
                   [plant]\ninertia = 2.0\n";
    let machine = Machine::from_bytes(Path::new("m.toml"), machine.as_bytes()).unwrap();
    let t_s: Vec<f64> = (0..5000).map(|row| f64::from(row) * 1e-3).collect();
    // Two tones: of one, the acceleration is that of a spring.
    let tones = [(0.1, 6.0), (0.02, 17.0_f64)];
    let sum = |of: &dyn Fn(f64, f64) -> f64| tones.iter().map(|&(size, rate)| of(size, rate)).sum::<f64>();
    let position = t_s.iter().map(|t| (sum(&|size, rate| size * (rate * t).sin()) / 5e-5).round() * 5e-5).collect();
    let effort_cmd = t_s.iter().map(|t| -2.0 * sum(&|size, rate| size * rate * rate * (rate * t).sin())).collect();
    let recording =
        Recording { name: "run.csv".to_owned(), t_s, position, effort_cmd, ..Recording::empty(machine.axis.kind) };
    (machine, recording)
}

/// All that is said after a change of the carriage's recording.
fn said_of_carriage(change: impl Fn(&mut Recording)) -> Vec<String> {
    let (machine, mut recording) = carriage();
    change(&mut recording);
    of(&machine, &recording).iter().map(ToString::to_string).collect()
}

#[test]
fn units_of_a_linear_axis_that_are_wrong_by_a_thousand_are_named() {
    assert_eq!(said_of_carriage(|_| ()), Vec::<String>::new());
    let scaled = |factor: f64| said_of_carriage(move |r| r.position.iter_mut().for_each(|x| *x *= factor));
    let millimetres = scaled(1e3);
    for part in [
        "position_m: speeds of ",
        "those of no such machine (at most 5e1); is the position in mm?",
        "steps of 5.000e-2 m, and `resolution` of the machine file is 5.000e-5",
        "ask for an inertia of ",
        "that of the machine file is 2; is the position in mm?",
    ] {
        assert!(millimetres.iter().any(|text| text.contains(part)), "{part}: {millimetres:?}");
    }
    let fast = scaled(1e4);
    assert!(fast.iter().any(|text| text.contains("position_m: accelerations of")), "{fast:?}");
    let (mut machine, recording) = carriage();
    machine.axis.sample_period_s = 1e-6;
    let other_clock: Vec<String> = of(&machine, &recording).iter().map(ToString::to_string).collect();
    let period =
        "t_s: rows are 1.000e-3 s apart, and `sample_period_s` of the machine file is 0.000001; is the time in ms?";
    assert!(other_clock.iter().any(|text| text.contains(period)), "{other_clock:?}");
}

#[test]
fn a_still_recording_among_others_and_a_short_one_held_out_are_warnings() {
    let (mut still, mut short) = (steps(), decimated(&steps(), 1));
    still.position.fill(0.0);
    for column in [&mut short.t_s, &mut short.position, &mut short.effort_cmd] {
        column.truncate(500);
    }
    let findings = check(&machine(), &[steps(), still.clone()], &[short], Purpose::Diagnose);
    assert_eq!(findings.len(), 2, "{findings:?}");
    assert!(findings.iter().all(|finding| finding.severity == Severity::Warning), "{findings:?}");
    let compared = check(&machine(), &[still], &[], Purpose::Compare);
    assert!(
        matches!(compared[..], [Finding { severity: Severity::Warning, .. }]),
        "a model may move where the axis does not"
    );
}
