//! What `init` and `doctor` say of logs with the faults and gaps of real ones.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use assert_cmd::Command;

fn lab(folder: &Path, words: &[&str]) -> String {
    let output = Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(folder: &Path, words: &[&str]) -> String {
    let output = Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{words:?}");
    String::from_utf8(output.stderr).unwrap()
}

const PERIOD_S: f64 = 0.002;
const ROWS: usize = 5000;

/// Position, speed and acceleration of three sines, the slowest of this amplitude, at a time in s.
fn motion(amplitude: f64, t_s: f64) -> [f64; 3] {
    let sine = |size: f64, rate: f64| {
        [size * (rate * t_s).sin(), size * rate * (rate * t_s).cos(), -size * rate * rate * (rate * t_s).sin()]
    };
    let parts = [sine(amplitude, 2.0), sine(0.2 * amplitude, 11.0), sine(0.05 * amplitude, 31.0)];
    [0, 1, 2].map(|place| parts.iter().map(|part| part[place]).sum())
}

/// A log in which the torque follows the motion by this law of position, speed, acceleration; the position in steps of 1e-4.
fn log(columns: &str, amplitude: f64, row: impl Fn([f64; 3], [f64; 3]) -> Vec<f64>) -> String {
    let mut text = format!("time_s,{columns}\n");
    for index in 0..ROWS {
        let t_s = PERIOD_S * index as f64;
        let cells = row(motion(amplitude, t_s), motion(amplitude, t_s - 0.008));
        let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:.7}")).collect();
        let _ = writeln!(text, "{t_s:.4},{}", cells.join(","));
    }
    text
}

fn stepped(position: f64) -> f64 {
    (position * 1e4).round() * 1e-4
}

/// Dry and viscous friction, a body, gravity.
fn torque([position, speed, acceleration]: [f64; 3]) -> f64 {
    0.02 * acceleration + 0.2 * speed.signum() + 0.05 * speed + 0.5 * position.sin()
}

fn machine(folder: &Path) -> String {
    fs::read_to_string(folder.join("machine.toml")).unwrap()
}

#[test]
fn a_column_that_is_given_is_never_turned() {
    let folder = tempfile::tempdir().unwrap();
    let text = log("position_rad,torque_nm", 1.5, |now, _| vec![stepped(now[0]), -torque(now)]);
    fs::write(folder.path().join("a.csv"), &text).unwrap();
    let printed = lab(folder.path(), &["init", "a.csv", "--map", "torque=torque_nm"]);
    assert!(printed.contains("pushes against the acceleration: turn its sign with *-1"), "{printed}");
    assert!(!machine(folder.path()).contains("scale = -1"), "{printed}");
    let guessed = lab(folder.path(), &["init", "a.csv", "-o", "guessed.toml"]);
    assert!(guessed.contains("sign turned"), "{guessed}");
}

#[test]
fn a_body_that_looks_like_negative_inertia_turns_no_sign() {
    let folder = tempfile::tempdir().unwrap();
    // What an elbow that swings does to a shoulder.
    let law = |[_, speed, acceleration]: [f64; 3]| -0.01 * acceleration + 0.2 * speed.signum() + 0.05 * speed;
    let text = log("position_rad,torque_nm", 1.5, |now, _| vec![stepped(now[0]), law(now)]);
    fs::write(folder.path().join("a.csv"), &text).unwrap();
    let printed = lab(folder.path(), &["init", "a.csv"]);
    assert!(!printed.contains("sign turned") && !printed.contains("turn its sign"), "{printed}");
}

#[test]
fn a_position_that_wraps_is_said_and_unwrapped() {
    let folder = tempfile::tempdir().unwrap();
    let law = |[_, speed, acceleration]: [f64; 3]| 0.02 * acceleration + 0.2 * speed.signum() + 0.05 * speed;
    let row = |now: [f64; 3], _: [f64; 3]| vec![stepped(now[0] - 25.0 * (now[0] / 25.0).round()), law(now)];
    fs::write(folder.path().join("a.csv"), log("position_rad,torque_nm", 20.0, row)).unwrap();
    let looked = lab(folder.path(), &["doctor", "a.csv"]);
    assert!(looked.contains("BAD   wrap") && looked.contains("it jumps by 25.0 rad in"), "{looked}");
    let printed = lab(folder.path(), &["init", "a.csv"]);
    assert!(machine(folder.path()).contains("wrap = 25.0"), "{printed}");
    let looked = lab(folder.path(), &["doctor", "--machine", "machine.toml", "a.csv"]);
    assert!(!looked.contains("BAD") && looked.contains("travels 4"), "{looked}");
}

#[test]
fn a_velocity_that_contradicts_the_position_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let row = |factor: f64| move |now: [f64; 3], _: [f64; 3]| vec![stepped(now[0]), factor * now[1], torque(now)];
    let columns = "position_rad,velocity_rad_s,torque_nm";
    fs::write(folder.path().join("right.csv"), log(columns, 1.5, row(1.0))).unwrap();
    fs::write(folder.path().join("half.csv"), log(columns, 1.5, row(0.5))).unwrap();
    let looked = lab(folder.path(), &["doctor", "right.csv"]);
    assert!(!looked.contains("velocity"), "{looked}");
    let looked = lab(folder.path(), &["doctor", "half.csv"]);
    assert!(looked.contains("BAD   velocity") && looked.contains("moves 2.0"), "{looked}");
    // A shake that is over within a stretch, of which little is left on average.
    let shake = |now: [f64; 3], _: [f64; 3]| {
        let phase = 100.0 * now[0];
        vec![stepped(0.02 * phase.sin()), 0.02 * 100.0 * now[1] * phase.cos(), now[2]]
    };
    fs::write(folder.path().join("shake.csv"), log(columns, 0.3, shake)).unwrap();
    let looked = lab(folder.path(), &["doctor", "shake.csv"]);
    assert!(!looked.contains("velocity"), "{looked}");
    let printed = lab(folder.path(), &["init", "half.csv"]);
    assert!(printed.contains("note: half.csv: the position moves 2.0"), "{printed}");
}

#[test]
fn a_delay_is_told_where_it_explains_much_and_only_there() {
    let folder = tempfile::tempdir().unwrap();
    // The motion of now answers the torque of 8 ms ago, so the torque of now belongs to the motion 8 ms later.
    let late = |now: [f64; 3], before: [f64; 3]| vec![stepped(before[0]), torque(now)];
    fs::write(folder.path().join("late.csv"), log("position_rad,torque_nm", 1.5, late)).unwrap();
    let looked = lab(folder.path(), &["doctor", "late.csv"]);
    assert!(looked.contains("% less of the balance is left: state torque_delay_s"), "{looked}");
    // Left out, the delay would be noise, and nothing would show.
    assert!(
        line(&looked, "shows").contains("inertia") && line(&looked, "shows").contains("coulomb_friction"),
        "{looked}"
    );
    // Friction that the balance has not: a shift fits it somewhat better, and means nothing.
    let law =
        |[position, speed, _]: [f64; 3]| 0.3 * speed.signum() * (1.0 + 0.5 * (7.0 * position).sin()) + 0.05 * speed;
    let rough = |now: [f64; 3], _: [f64; 3]| vec![stepped(now[0]), law(now)];
    fs::write(folder.path().join("rough.csv"), log("position_rad,torque_nm", 1.5, rough)).unwrap();
    let looked = lab(folder.path(), &["doctor", "rough.csv"]);
    assert!(looked.contains("torque and motion go together"), "{looked}");
}

#[test]
fn motion_in_one_direction_and_a_test_signal_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("time_s,position_rad,torque_nm\n");
    // A motor of 1e-4 kg m2 with friction 0.03 N m and 1e-4 N m s/rad that is stepped from 0.05 to 0.06 N m.
    let (mut position, mut speed) = (0.0, 200.0);
    for row in 0..8000 {
        let torque = if row < 4000 { 0.05 } else { 0.06 };
        let _ = writeln!(text, "{:.3},{:.6},{torque}", 1e-3 * f64::from(row), stepped(position));
        speed += 1e-3 * (torque - 0.03 - 1e-4 * speed) / 1e-4;
        position += 1e-3 * speed;
    }
    fs::write(folder.path().join("a.csv"), text).unwrap();
    let looked = lab(folder.path(), &["doctor", "a.csv"]);
    assert!(looked.contains("a test signal of 2 levels") && !looked.contains("a limit?"), "{looked}");
    assert!(looked.contains("in one direction only"), "{looked}");
    let printed = lab(folder.path(), &["init", "a.csv"]);
    assert!(printed.contains("friction and offset cannot be told apart"), "{printed}");
}

#[test]
fn a_log_that_no_diagnosis_takes_is_told_so_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = log("position_rad,torque_nm", 1.0, |now, _| vec![stepped(now[0]), torque(now)]);
    // One row in 42 of them: 84 ms.
    let slow: Vec<&str> =
        text.lines().enumerate().filter(|(at, _)| *at == 0 || at % 42 == 1).map(|(_, row)| row).collect();
    fs::write(folder.path().join("a.csv"), slow.join("\n") + "\n").unwrap();
    let printed = lab(folder.path(), &["init", "a.csv"]);
    assert!(
        printed.ends_with("next: a.csv: 11.9 Hz is too slow for any window of a motion: log at 20 Hz or more\n"),
        "{printed}"
    );
}

#[test]
fn a_period_that_no_machine_file_has_is_told_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    // Microseconds, taken for milliseconds.
    let mut text = String::from("ts,pos,i\n");
    for row in 0..ROWS {
        let now = motion(0.012, PERIOD_S * row as f64);
        let _ = writeln!(text, "{},{:.4},{:.5}", 2000 * row, 1e3 * now[0], now[2]);
    }
    fs::write(folder.path().join("lin.csv"), text).unwrap();
    let words = ["init", "lin.csv", "--map", "time=ts:ms", "--map", "position=pos:mm", "--map", "torque=i:A*1"];
    let message = refused(folder.path(), &words);
    assert!(
        message.contains("rows are 2 s apart, the median of 4999 steps") && message.contains("is at most 1 s"),
        "{message}"
    );
    assert!(!folder.path().join("machine.toml").exists());
    let message = refused(folder.path(), &["init", "lin.csv", "--map", "position=pso:mm"]);
    assert!(message.contains("--map position=pso: the column is not in the log; is `pos` meant?"), "{message}");
}

#[test]
fn a_log_that_is_too_short_is_told_so_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = log("position_rad,torque_nm", 1.0, |now, _| vec![stepped(now[0]), torque(now)]);
    let short: Vec<&str> = text.lines().take(61).collect();
    fs::write(folder.path().join("short.csv"), short.join("\n") + "\n").unwrap();
    let printed = lab(folder.path(), &["init", "short.csv"]);
    assert!(
        printed.contains("next: short.csv: 0.118 s is too short, at least 0.8 s is needed; record longer"),
        "{printed}"
    );
}

#[test]
fn an_export_with_a_title_and_units_goes_all_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let text = log("pos,torque", 1.5, |now, _| vec![stepped(now[0]).to_degrees(), torque(now)]);
    let body = text.split_once('\n').unwrap().1.replace(',', ";").replace('.', ",").replace('\n', ";\r\n");
    let head = "Bench 3\r\nOperator;Meyer\r\n\r\ntime;pos;torque;\r\ns;\u{b0};N\u{b7}m;\r\n";
    let bytes: Vec<u8> = (head.to_owned() + &body).chars().map(|letter| u32::from(letter) as u8).collect();
    fs::write(folder.path().join("export.csv"), bytes).unwrap();
    let printed = lab(folder.path(), &["init", "export.csv"]);
    assert!(printed.contains("note: export.csv: 2 rows above the header are left out"), "{printed}");
    assert!(printed.contains("`pos` in \u{b0}; by its name; unit: by the row below the header"), "{printed}");
    assert!(printed.ends_with("servo-lab diagnose --machine machine.toml export.csv\n"), "{printed}");
    let looked = lab(folder.path(), &["doctor", "--machine", "machine.toml", "export.csv"]);
    assert!(!looked.contains("BAD"), "{looked}");
    lab(folder.path(), &["convert", "export.csv", "--machine", "machine.toml", "-o", "out.csv"]);
    let converted = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    assert_eq!(converted.lines().count(), ROWS + 1);
}

#[test]
fn what_the_logs_do_not_tell_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    // A weight that is lifted slowly, and hardly lowered: offset, friction and gravity look alike.
    let mut text = String::from("time_s,position_rad,torque_nm\n");
    for row in 0..1200 {
        let t_s = 0.005 * f64::from(row);
        let position = 0.45 * (1.0 - (1.05 * t_s).cos());
        let noise = 0.01 * (f64::from(row * row % 97) / 48.0 - 1.0);
        let _ = writeln!(text, "{t_s:.3},{:.5},{:.5}", stepped(position), 0.5 * position.sin() + 0.03 + noise);
    }
    fs::write(folder.path().join("a.csv"), text).unwrap();
    let printed = lab(folder.path(), &["init", "a.csv"]);
    let machine = machine(folder.path());
    for key in ["coulomb", "viscous", "torque_offset"] {
        let line = machine.lines().find(|line| line.starts_with(key)).unwrap();
        let value: f64 = line.split([' ', '#']).nth(2).unwrap().parse().unwrap();
        assert!(value.abs() < 0.6, "no more than the torque there is: {printed}");
        assert!(!line.contains("UNSURE") || value == 0.0, "{printed}");
    }
}

#[test]
fn a_current_without_a_scale_has_its_own_unit() {
    let folder = tempfile::tempdir().unwrap();
    let text = log("position_rad,motor_current_a", 1.5, |now, _| vec![stepped(now[0]), torque(now)]);
    fs::write(folder.path().join("a.csv"), &text).unwrap();
    let printed = lab(folder.path(), &["init", "a.csv", "--map", "torque=motor_current_a:A*1"]);
    assert!(printed.contains("A s2/rad") && printed.contains("how many N m one A makes is not known"), "{printed}");
    assert!(!machine(folder.path()).contains("kg m2"), "{printed}");
    let looked = lab(folder.path(), &["doctor", "--machine", "machine.toml", "a.csv"]);
    assert!(looked.contains("A s2/rad") && !looked.contains("N m"), "{looked}");
}

#[test]
fn the_resolution_of_a_fast_axis_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = log("position_rad,torque_nm", 20.0, |now, _| vec![stepped(now[0]), torque(now)]);
    fs::write(folder.path().join("a.csv"), &text).unwrap();
    let printed = lab(folder.path(), &["init", "a.csv"]);
    assert!(printed.contains("resolution       0.0001 rad; step of the position"), "{printed}");
}

#[test]
fn the_columns_of_a_slide_are_given_as_the_first_help_has_them() {
    let folder = tempfile::tempdir().unwrap();
    // A slide of 12 mm amplitude, microseconds, and a motor of which one ampere makes 0.12 N.
    let mut text = String::from("ts,pos,i\n");
    for row in 0..ROWS {
        let t_s = PERIOD_S * row as f64;
        let now = motion(0.012, t_s);
        let force = 0.5 * now[2] + 0.3 * now[1].signum();
        let _ = writeln!(text, "{:.0},{:.4},{:.5}", 1e6 * t_s, 1e3 * now[0], force / 0.12);
    }
    fs::write(folder.path().join("LOG"), &text).unwrap();
    let line = "init LOG --map position=pos:mm --map torque=i:A*0.12 --map time=ts:us -o machine.toml";
    let printed = lab(folder.path(), &line.split(' ').collect::<Vec<_>>());
    let machine = machine(folder.path());
    assert!(machine.contains("kind = \"linear\""), "{machine}");
    assert!(machine.contains(r#"force = { name = "i", unit = "A", scale = 0.12 }"#), "{machine}");
    let inertia = machine.lines().find(|line| line.starts_with("inertia")).unwrap();
    let value: f64 = inertia.split([' ', '#']).nth(2).unwrap().parse().unwrap();
    assert!((value / 0.5 - 1.0).abs() < 0.05, "{inertia}: {printed}");
}

/// The line of `doctor` that begins so.
fn line<'a>(looked: &'a str, what: &str) -> &'a str {
    let found = looked.lines().find(|line| line.get(6..).is_some_and(|line| line.starts_with(what)));
    found.unwrap_or_else(|| panic!("no line {what}: {looked}"))
}

#[test]
fn what_a_motion_can_show_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    // Noise of 10 mN m from end to end, as good as random, of the same law in both logs.
    let noisy = |now: [f64; 3]| torque(now) + 0.01 * (((1e4 * now[0]).sin() * 1e4).fract() - 0.5);
    let rich = |now: [f64; 3], _: [f64; 3]| vec![stepped(now[0]), noisy(now)];
    fs::write(folder.path().join("rich.csv"), log("position_rad,torque_nm", 1.5, rich)).unwrap();
    // One way, at 0.2 rad/s that change by a tenth over 10 s.
    let slow = |now: [f64; 3], _: [f64; 3]| {
        let t_s = now[0];
        let (rate, swing) = (0.6, 0.02);
        let at = [
            0.2 * t_s + swing / rate * (rate * t_s).sin(),
            0.2 + swing * (rate * t_s).cos(),
            -swing * rate * (rate * t_s).sin(),
        ];
        vec![stepped(at[0]), noisy(at)]
    };
    let mut text = String::from("time_s,position_rad,torque_nm\n");
    for row in 0..ROWS {
        let t_s = PERIOD_S * row as f64;
        let cells = slow([t_s, 0.0, 0.0], [0.0; 3]);
        let _ = writeln!(text, "{t_s:.4},{:.7},{:.7}", cells[0], cells[1]);
    }
    fs::write(folder.path().join("slow.csv"), text).unwrap();
    let has = |line: &str, id: &str| line.split([' ', ',', ':', ';']).any(|word| word == id);
    let looked = lab(folder.path(), &["doctor", "rich.csv"]);
    let shows = line(&looked, "shows");
    assert!(["inertia", "coulomb_friction", "gravity_load"].iter().all(|id| has(shows, id)), "{looked}");
    let looked = lab(folder.path(), &["doctor", "slow.csv"]);
    assert!(has(line(&looked, "cannot show"), "inertia") && !has(line(&looked, "shows"), "inertia"), "{looked}");
    assert!(has(line(&looked, "shows"), "coulomb_friction"), "{looked}");
    // One way, friction and an offset are the same.
    let alike = line(&looked, "not told");
    assert!(has(alike, "coulomb_friction") && has(alike, "torque_offset"), "{looked}");
}

#[test]
fn jitter_gaps_and_a_limit_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("time_s,position_rad,torque_nm\n");
    let limited = |t_s: f64| {
        let now = motion(1.5, t_s);
        (stepped(now[0]), torque(now).clamp(-0.6, 0.6))
    };
    // Every third row is 0.8 ms late of 2 ms, and ten rows are gone after 3 s.
    for row in (0..ROWS).filter(|row| !(1500..1510).contains(row)) {
        let t_s = PERIOD_S * row as f64 + if row % 3 == 0 { 8e-4 } else { 0.0 };
        let (position, torque) = limited(t_s);
        let _ = writeln!(text, "{t_s:.4},{position:.4},{torque:.6}");
    }
    fs::write(folder.path().join("bad.csv"), text).unwrap();
    let looked = lab(folder.path(), &["doctor", "bad.csv"]);
    let jitter = line(&looked, "jitter");
    assert!(jitter.starts_with("note") && jitter.contains("40.0 % in nine steps of ten"), "{looked}");
    assert!(jitter.contains("better than those of the host"), "{looked}");
    let gaps = line(&looked, "gaps");
    assert!(gaps.starts_with("note") && gaps.contains("in 1 place, the first after row 1500"), "{looked}");
    let limit = line(&looked, "saturation");
    assert!(limit.starts_with("note") && limit.contains("from -0.6000 to 0.6000 N m"), "{looked}");
    assert!(limit.contains("a limit? then state torque_limit"), "{looked}");
    fs::write(
        folder.path().join("good.csv"),
        log("position_rad,torque_nm", 1.5, |now, _| vec![stepped(now[0]), torque(now)]),
    )
    .unwrap();
    let looked = lab(folder.path(), &["doctor", "good.csv"]);
    for what in ["jitter", "gaps", "saturation"] {
        assert!(line(&looked, what).starts_with("ok"), "{looked}");
    }
}

#[test]
fn without_a_log_the_computer_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    // Nothing is on the path: what is not there is needed for some things only, and is said.
    let output =
        Command::cargo_bin("servo-lab").unwrap().current_dir(folder.path()).env("PATH", "").arg("doctor").output();
    let looked = String::from_utf8(output.unwrap().stdout).unwrap();
    for (what, says) in [
        ("compiler", "no rustc; needed to build the image only"),
        ("target", "rustup target add thumbv7em-none-eabihf"),
        ("probe-rs", "cargo install probe-rs-tools"),
    ] {
        let line = line(&looked, what);
        assert!(line.starts_with("note") && line.contains(says), "{looked}");
    }
    for what in ["probe ", "serial"] {
        line(&looked, what);
    }
    assert_eq!(looked.lines().count(), 5, "{looked}");
}
