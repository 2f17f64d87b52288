//! The binary as a user runs it: exit codes, and messages on standard error.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;

use assert_cmd::Command;

fn servo_lab() -> Command {
    Command::cargo_bin("servo-lab").unwrap()
}

#[test]
fn bad_input_is_one_line_and_code_2() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.csv"), "t_s,position_rad,torque_cmd_nm\n0,0,zero\n").unwrap();
    let ran = servo_lab().current_dir(&folder).args(["check", "a.csv"]).assert().code(2);
    let output = ran.get_output();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "error: a.csv:2: torque_cmd_nm: `zero` is not a number\n");
    assert!(output.stdout.is_empty());
}

#[test]
fn wrong_flags_are_code_2_and_help_is_code_0() {
    servo_lab().assert().code(2);
    servo_lab().args(["check", "--nonsense"]).assert().code(2);
    servo_lab().arg("--help").assert().success();
}

#[test]
fn good_files_are_summarised() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.csv"), "t_s,position_m,force_cmd_n,x\n0,0,0,0\n0.5,0,0,0\n").unwrap();
    let ran = servo_lab().current_dir(&folder).args(["check", "a.csv"]).assert().success();
    assert_eq!(
        String::from_utf8_lossy(&ran.get_output().stdout),
        "a.csv: linear axis, 2 rows over 0.500 s, 0 gaps\n  a.csv: column `x` is not one of the format and is not used\n"
    );
}
