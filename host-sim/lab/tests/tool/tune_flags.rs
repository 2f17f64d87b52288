//! The flags of `tune`.

#[test]
fn a_flag_outside_its_range_is_refused_by_name() {
    for (flag, value) in [("--gain-margin", "1"), ("--uncertainty-percent", "nan"), ("--small-mrad", "0")] {
        let output = assert_cmd::Command::cargo_bin("servo-lab").unwrap().args(["tune", flag, value]).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(message.contains(flag) && message.lines().count() == 1, "{message}");
    }
}
