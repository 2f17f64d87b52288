//! `servo-lab stability` as a user runs it.

use assert_cmd::Command;

fn stability(flags: &[&str]) -> std::process::Output {
    Command::cargo_bin("servo-lab").unwrap().arg("stability").args(flags).output().unwrap()
}

#[test]
fn the_default_case_is_inside_with_its_margins_and_area() {
    let output = stability(&["--json", "-"]);
    assert!(output.status.success());
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["inside"], true);
    assert_eq!(answer["methods"]["agree"], true);
    assert!((answer["area"].as_f64().unwrap() / 0.40 - 1.0).abs() < 0.02);
    assert!(answer["margins"]["gain"].as_f64().unwrap() > 1.5);
    assert!((answer["gains"]["k_p_nm_rad"].as_f64().unwrap() - 240.0).abs() < 1e-9);
}

#[test]
fn flags_reach_the_loop() {
    let without = ["--model", "none", "--q0", "0", "--q1", "0", "--json", "-"];
    let answer: serde_json::Value = serde_json::from_slice(&stability(&without).stdout).unwrap();
    assert!((answer["margins"]["phase_deg"].as_f64().unwrap() / 42.5 - 1.0).abs() < 0.02);
    assert!((answer["margins"]["delay_factor"].as_f64().unwrap() / 2.51 - 1.0).abs() < 0.02);
    let outside = ["--q0", "0", "--q1", "17", "--json", "-"];
    let answer: serde_json::Value = serde_json::from_slice(&stability(&outside).stdout).unwrap();
    assert_eq!((&answer["inside"], &answer["margins"]), (&false.into(), &serde_json::Value::Null));
}

#[test]
fn delays_of_a_machine_file_count_from_its_outputs() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.toml");
    let machine = "schema = 1\nname = \"drive\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1e-5\n\
                   [plant]\ninertia = 0.075\nsample_to_output_s = 1e-4\ntorque_delay_s = 0.005\n\
                   [plant.er]\na = 0.07\nb = 0.47\ndead_time_s = 0.002\n";
    std::fs::write(&file, machine).unwrap();
    let output = stability(&["--machine", file.to_str().unwrap()]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("L 5.100 ms") && text.lines().next().unwrap().contains("2.1"), "{text}");
}

#[test]
fn a_machine_without_a_damper_has_no_viscosity_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.toml");
    let machine = "schema = 1\nname = \"drive\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1e-5\n\
                   [plant]\ninertia = 0.075\ntorque_delay_s = 0.005\n";
    let damper = "[plant.er]\na = 0.07\nb = 0.47\ndead_time_s = 0.005\n";
    let gain_margin = |machine: &str| {
        std::fs::write(&file, machine).unwrap();
        let output = stability(&["--machine", file.to_str().unwrap(), "--json", "-"]);
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        answer["margins"]["gain"].as_f64().unwrap()
    };
    // 3.11 without viscosity (control.md).
    let off = format!("{machine}{damper}[controller]\ner_enabled = false\n");
    for without in [machine, &off] {
        assert!((gain_margin(without) / 3.11 - 1.0).abs() < 0.01, "{}", gain_margin(without));
    }
    assert!(gain_margin(&format!("{machine}{damper}")) < 2.5);
}

#[test]
fn the_figure_and_the_file_are_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let (figure, json) = (folder.path().join("fig9.svg"), folder.path().join("answer.json"));
    let output = stability(&["--plot", figure.to_str().unwrap(), "--json", json.to_str().unwrap()]);
    assert!(output.status.success() && String::from_utf8(output.stdout).unwrap().contains("inside the region"));
    let svg = std::fs::read_to_string(figure).unwrap();
    assert!(svg.contains("K_p* = K_P L^2 / J (1)") && svg.trim_end().ends_with("</svg>"));
    assert!(serde_json::from_str::<serde_json::Value>(&std::fs::read_to_string(json).unwrap()).is_ok());
}

#[test]
fn bad_flags_are_refused_with_a_reason() {
    for (flags, reason) in [
        (["--delay-ms", "0"], "torque delay"),
        (["--kp", "nan"], "K_P"),
        (["--q1", "1e12"], "stiff"),
        (["--machine", "no-such-machine.toml"], "no-such-machine.toml"),
    ] {
        let output = stability(&flags);
        assert_eq!(output.status.code(), Some(2), "{flags:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(reason), "{flags:?}: {message}");
    }
}
