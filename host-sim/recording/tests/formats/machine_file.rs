//! Machine files: what is read, and that each kind of bad input is one message with file, line and key.

use std::path::Path;

use recording::{AxisKind, Machine};

const MACHINE: &str = r#"schema = 1
name = "er-dd-servo"
[axis]
kind = "rotary"
sample_period_s = 0.0005
resolution = 1.2783173e-5
[plant]
inertia = 0.075
coulomb = 0.763
torque_limit = 30
torque_delay_s = 0.005
[plant.er]
a = 0.0704
b = 0.470
dead_time_s = 0.002
lag_s = 0.003
"#;

fn parse(text: &str) -> Result<Machine, String> {
    Machine::from_bytes(Path::new("m.toml"), text.as_bytes()).map_err(|error| {
        assert_eq!(error.exit_code(), 2);
        let message = error.to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
        message
    })
}

/// The message after replacing one piece of the good file.
fn broken(from: &str, to: &str) -> String {
    assert_eq!(MACHINE.matches(from).count(), 1, "{from}");
    parse(&MACHINE.replace(from, to)).expect_err(to)
}

#[test]
fn the_example_of_the_specification_is_read() {
    let machine = parse(MACHINE).unwrap();
    assert_eq!((machine.name.as_str(), machine.axis.kind), ("er-dd-servo", AxisKind::Rotary));
    assert_eq!(machine.axis.resolution, 1.278_317_3e-5);
    assert_eq!((machine.plant.viscous, machine.plant.torque_gain), (0.0, 1.0));
    assert_eq!(machine.plant.torque_limit, Some(30.0));
    let er = machine.plant.er.unwrap();
    assert_eq!((er.a, er.b, er.dead_time_s, er.lag_s), (0.0704, 0.470, 0.002, 0.003));
    assert!(machine.controller.is_none() && machine.effects.is_empty());
    assert_eq!(machine.plant.sample_to_output_s, 0.0);
    let told = parse(&MACHINE.replace("torque_limit = 30", "sample_to_output_s = 9.4e-6")).unwrap();
    assert_eq!(told.plant.sample_to_output_s, 9.4e-6);
    assert!(told.to_toml().unwrap().contains("sample_to_output_s = 0.0000094"));
    assert!(parse(&format!("\u{feff}{}", MACHINE.replace('\n', "\r\n"))).is_ok(), "as written on Windows");
}

#[test]
fn each_mistake_is_one_message_with_line_and_key() {
    let cases = [
        ("coulomb", "coulom", "m.toml:9: plant.coulom: unknown key; the nearest key is `coulomb`"),
        ("lag_s = 0.003", "lag = 0.003", "m.toml:16: plant.er.lag: unknown key; the nearest key is `lag_s`"),
        ("[plant.er]", "[plant.re]", "m.toml:12: plant.re: unknown key; the nearest key is `er`"),
        ("0.075", "-0.075", "m.toml:8: plant.inertia: -0.075 is not allowed; must be a finite number above 0"),
        (
            "0.075",
            "5e-324",
            "m.toml:8: plant.inertia: 5e-324 is not allowed; must be a finite number above 0, of a size from 1e-15 to 1e15",
        ),
        (
            "0.763",
            "1.7e308",
            "m.toml:9: plant.coulomb: 1.7e308 is not allowed; must be a finite number of 0 or more, of a size",
        ),
        ("0.075", "nan", "m.toml:8: plant.inertia: nan is not allowed; must be a finite number above 0"),
        ("0.763", "+inf", "m.toml:9: plant.coulomb: +inf is not allowed; must be a finite number of 0 or more"),
        ("0.763", "\"0.763\"", "m.toml:9: plant.coulomb: `0.763` is not allowed; must be a finite number of 0 or more"),
        ("0.763", "1e999", "m.toml:9: plant.coulomb: 1e999 is not allowed; must be a finite number of 0 or more"),
        ("= 30", "= 0", "m.toml:10: plant.torque_limit: 0 is not allowed; must be a finite number above 0"),
        (
            "0.005\n[plant.er]",
            "5\n[plant.er]",
            "m.toml:11: plant.torque_delay_s: 5 is not allowed; must be a number from 0 to 1",
        ),
        ("rotary", "rotery", "m.toml:4: axis.kind: `rotery` is not allowed; must be \"rotary\" or \"linear\""),
        (
            "sample_period_s = 0.0005\n",
            "",
            "m.toml:3: axis.sample_period_s: is missing; must be a number above 0, at most 1",
        ),
        ("schema = 1", "schema = 2", "m.toml:1: schema: 2 is not allowed; must be 1"),
        ("inertia = 0.075\n", "", "m.toml:7: plant.inertia: is missing; must be a finite number above 0"),
        ("[plant.er]", "[plant.er", "m.toml:12: is not TOML: "),
        ("coulomb = 0.763", "inertia = 1", "m.toml:9: is not TOML: duplicate key"),
    ];
    for (from, to, expected) in cases {
        let message = broken(from, to);
        assert!(message.starts_with(expected), "{to:?} gave {message:?}");
    }
    assert_eq!(parse("schema = 1\nname = \"a\"\n").unwrap_err(), "m.toml: section [axis] is missing");
    assert!(parse("").unwrap_err().starts_with("m.toml:1: schema: is missing"));
    let error = Machine::from_bytes(Path::new("m.toml"), b"schema = 1\nname = \"\xff\"\n").unwrap_err();
    assert_eq!(error.to_string(), "m.toml:2: is not UTF-8 text");
}

#[test]
fn effects_are_checked_against_the_vocabulary() {
    let with = |effects: &str| parse(&format!("{MACHINE}{effects}"));
    let machine = with(
        "[[effects]]\nid = \"cogging\"\namplitude_nm = 0.1\norder_per_rev = 7\nphase_rad = -1\n\
         [[effects]]\nid = \"cogging\"\namplitude_nm = 0.2\norder_per_rev = 14\nphase_rad = 0\n\
         [[effects]]\nid = \"field_lag\"\nrecording = \"a.csv\"\nlag_s = 0.005\n\
         [[effects]]\nid = \"field_lag\"\nrecording = \"b.csv\"\nlag_s = 0.006\n",
    )
    .unwrap();
    assert_eq!(machine.effects.len(), 4);
    assert_eq!(machine.effects[2].recording.as_deref(), Some("a.csv"));
    assert_eq!(machine.effects[2].parameters, [("lag_s".to_owned(), 0.005)]);
    let cases = [
        (
            "id = \"field_leg\"\nlag_s = 1",
            ":18: effects[1].id: `field_leg` is not an effect; the nearest is `field_lag`",
        ),
        ("id = \"field_lag\"\nlag = 1", ":19: effects[1].lag: unknown key; the nearest key is `lag_s`"),
        ("id = \"field_lag\"\nlag_s = -1", ":19: effects[1].lag_s: -1 is not allowed; must be a number from 0 to 1"),
        ("id = \"field_lag\"", ":17: effects[1].lag_s: is missing; must be a number from 0 to 1"),
        ("lag_s = 1", ":17: effects[1].id: is missing"),
        (
            "id = \"presliding\"\nstiffness_n_m = 1",
            ":19: effects[1].stiffness_n_m: unknown key; the nearest key is `stiffness_nm_rad`",
        ),
        ("id = \"controller\"", ":18: effects[1].id: `controller` is a finding, not a part of a model"),
        (
            "id = \"disturbance_pulse\"\nstart_s = 1\nduration_s = 1\namplitude_nm = 1",
            ":17: effects[1].recording: is missing",
        ),
        (
            "id = \"field_lag\"\nlag_s = 0\n[[effects]]\nid = \"field_lag\"\nlag_s = 1",
            ":20: effects[2].id: field_lag is there already, as effects[1]",
        ),
    ];
    for (effect, expected) in cases {
        let message = with(&format!("[[effects]]\n{effect}\n")).expect_err(effect);
        assert!(message.starts_with(&format!("m.toml{expected}")), "{effect:?} gave {message:?}");
    }
}
