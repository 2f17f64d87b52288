//! A machine that is not the paper's, found by experiments on its drive.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use plant::{Er, FieldResponse, FluidResponse, Model};

use crate::far::Far;
use crate::{fails, printed};

/// Heavier, stiffer, slower, with another fluid that falls slower than it rises.
pub fn machine() -> Model {
    let response = FluidResponse::Field(FieldResponse {
        dead_time_s: 0.0015,
        slew_kv_mm_s: None,
        rise_s: 0.003,
        fall_s: 0.006,
        ..FieldResponse::default()
    });
    Model {
        inertia: 0.09,
        coulomb: 0.9,
        viscous: 0.05,
        torque_offset: 0.1,
        torque_delay_s: 0.006,
        er: Some(Er { response, ..Er::new(0.06, 0.55, 0.0, 0.0) }),
        ..Model::paper()
    }
}

/// What the machine is, as the command prints it: name, truth in the printed unit, and how far off the value may be, as a share.
const TRUTH: [(&str, f64, f64); 11] = [
    ("inertia", 0.09, 0.001),
    ("torque delay", 6.0, 0.001),
    ("c, dry friction", 0.9, 0.002),
    ("viscous friction", 0.05, 0.03),
    ("torque offset", 0.1, 0.01),
    ("a", 0.06, 0.01),
    ("b", 0.55, 0.005),
    // a E^2 + b E at 3.2725 of 3.5 kV/mm is Q w at 0.11902 rad/s.
    ("constant of (5)", 4.073_547, 0.001),
    ("field dead time", 1.5, 0.005),
    ("field rises in", 3.0, 0.003),
    ("field falls in", 6.0, 0.003),
];

/// Value and interval of a line of the table.
fn found(said: &str, name: &str) -> (f64, f64, f64) {
    let line =
        said.lines().find(|line| line.starts_with(&format!("{name:<22} "))).unwrap_or_else(|| panic!("{name}: {said}"));
    let words: Vec<&str> = line[23..].split_whitespace().collect();
    let number = |word: &str| word.parse::<f64>().unwrap();
    (number(words[0]), number(words[words.len() - 3]), number(words[words.len() - 1]))
}

#[test]
fn a_machine_is_found_by_experiments_and_its_drive_gets_it() {
    let far = Far::fast(machine());
    let folder = tempfile::tempdir().unwrap();
    let before = printed(folder.path(), &far.line("get kp_nm_rad off_speed_rad_s er_enabled near_rad"));
    let said = printed(folder.path(), &far.line("identify --out found --apply"));
    println!("{said}\n{:<22} {:>10} {:>10}   95 % interval", "", "truth", "found");
    let mut held = 0;
    for (name, truth, share) in TRUTH {
        let (value, low, high) = found(&said, name);
        let holds = low <= truth && truth <= high;
        println!(
            "{name:<22} {truth:>10.5} {value:>10.5}   {low:.5} to {high:.5}{}",
            if holds { "" } else { "  misses" }
        );
        assert!((value / truth - 1.0).abs() < share, "{name}: {value}, not {truth}");
        held += usize::from(holds);
    }
    assert!(said.contains("er_q1_s_rad and er_q2_s2_rad2 stay as they were"), "{said}");
    // Of eleven intervals of 95 %, fewer than nine hold the truth once in a hundred times.
    assert!(held >= 9, "{held} of {} intervals hold the truth", TRUTH.len());
    let text = fs::read_to_string(folder.path().join("found/machine.toml")).unwrap();
    assert!(text.contains("# inertia") && text.contains(" to "), "the intervals are in the file: {text}");
    let file: toml::Table = text.parse().unwrap();
    let value = |section: &toml::Value, key: &str| section[key].as_float().unwrap();
    let (plant, lags) = (&file["plant"], &file["effects"][0]);
    let to_output_s = value(plant, "sample_to_output_s");
    assert_eq!(to_output_s, f64::from(er_servo::SAMPLE_TO_OUTPUT_NS) / 1e9, "as the drive says");
    for (there, name) in [
        (value(plant, "inertia"), "inertia"),
        (1e3 * (to_output_s + value(plant, "torque_delay_s")), "torque delay"),
        (value(&plant["er"], "a"), "a"),
        (1e3 * (to_output_s + value(&plant["er"], "dead_time_s")), "field dead time"),
        (1e3 * value(lags, "rise_s"), "field rises in"),
        (1e3 * value(lags, "fall_s"), "field falls in"),
        (value(&file["controller"], "inertia_kg_m2"), "inertia"),
        (value(&file["controller"], "er_q0"), "constant of (5)"),
    ] {
        let printed = found(&said, name).0;
        assert!((there - printed).abs() < 2e-5, "{name}: {there} in the file, {printed} printed");
    }
    // Every experiment is there, and the law has back what the experiments changed.
    assert_eq!(fs::read_dir(folder.path().join("found")).unwrap().count(), 14);
    assert_eq!(printed(folder.path(), &far.line("get kp_nm_rad off_speed_rad_s er_enabled near_rad")), before);
    let applied = printed(folder.path(), &far.line("get er_b er_q0"));
    assert!(applied.contains("er_b = 0.5") && !applied.contains("er_q0 = 4.01 "), "{applied}");
    assert!(printed(folder.path(), &far.line("status")).contains("parameters   flash"));
}

#[test]
fn experiments_that_end_early_leave_the_drive_stopped_with_its_parameters() {
    let far = Far::fast(machine());
    let folder = tempfile::tempdir().unwrap();
    let before = printed(folder.path(), &far.line("get"));
    let unchanged = |state: &str| {
        let status = printed(folder.path(), &far.line("status"));
        assert!(status.contains(state) && status.contains("parameters   link"), "{status}");
        assert_eq!(printed(folder.path(), &far.line("get")), before);
    };
    // Ctrl-C as soon as it runs.
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("servo-lab"))
        .current_dir(folder.path())
        .args(far.line("identify").split_whitespace())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(told.any(|line| line.unwrap().starts_with("ramp-")));
    thread::sleep(Duration::from_millis(300));
    let interrupted = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupted.success());
    assert!(told.last().unwrap().unwrap().contains("interrupted"));
    assert_eq!(child.wait().unwrap().code(), Some(2));
    unchanged("ready");
    // The interlock opens.
    far.strings.interlock_open.store(true, Ordering::Relaxed);
    let refused = fails(folder.path(), &far.line("identify --force"), 3);
    assert!(refused.contains("interlock"), "{refused}");
    unchanged("ready");
    // What the axis may not do is refused before it moves.
    far.strings.interlock_open.store(false, Ordering::Relaxed);
    printed(folder.path(), &far.line("home"));
    printed(folder.path(), &far.line("set position_max_rad=0.5"));
    let refused = fails(folder.path(), &far.line("identify --force"), 2);
    assert!(refused.contains("position_max_rad"), "{refused}");
    printed(folder.path(), &far.line("set position_max_rad=25000 er_enabled=false"));
    let refused = fails(folder.path(), &far.line("identify --force"), 2);
    assert!(refused.contains("er_enabled is false"), "{refused}");
}

#[test]
fn a_drive_is_commissioned_in_one_command_and_its_step_is_better_after() {
    let far = Far::fast(machine());
    let folder = tempfile::tempdir().unwrap();
    // Gains that a careful user begins with: the drive creeps.
    printed(folder.path(), &far.line("set kp_nm_rad=100 kd_nm_s_rad=5 near_rad=0.05"));
    let said = printed(folder.path(), &format!("commission --tcp {} --out done --save", far.link));
    println!("{said}");
    assert!(said.contains("Nothing is missing from the model beyond the noise"), "{said}");
    assert!(said.contains("The drive has the tuned parameters, in flash too."), "{said}");
    let report = fs::read_to_string(folder.path().join("done/report.md")).unwrap();
    let settling = report.lines().find(|line| line.starts_with("| settling, ms")).unwrap();
    let times: Vec<f64> = settling.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
    assert!(times.len() == 2 && times[1] < 0.8 * times[0], "{settling}");
    // The drive has what the machine file says, in flash too, and the verifying step replays with it.
    let file: toml::Table = fs::read_to_string(folder.path().join("done/machine.toml")).unwrap().parse().unwrap();
    let gain = file["controller"]["kp_nm_rad"].as_float().unwrap() as f32;
    assert!(printed(folder.path(), &far.line("get kp_nm_rad")).starts_with(&format!("kp_nm_rad = {gain} ")));
    assert!(printed(folder.path(), &far.line("status")).contains("parameters   flash"));
    let replayed = printed(folder.path(), "replay --machine done/machine.toml done/step-after.csv");
    assert!(replayed.contains("identical"), "{replayed}");
}
