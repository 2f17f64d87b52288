//! What the columns of somebody else's log probably are, by their names and numbers.

mod names;
mod search;
mod unit;

use super::columns::ROW;
use super::joints::Joints;
use super::nearest::{misspelt, quoted};
use super::units::{self, Quantity};
use super::{AxisKind, Column, MapFlag, MappedColumn, Mapping, Table};
use names::fit;
use search::{Search, dates};
use unit::{is_of, unit_of};

/// One column that was guessed, or given.
#[derive(Debug, Clone, PartialEq)]
pub struct Guess {
    /// The column.
    pub mapped: MappedColumn,
    /// Why, and how sure: a sentence without a full stop.
    pub because: String,
    /// Whether a person should look at it.
    pub unsure: bool,
}

/// What is known of a log before its columns are guessed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Given<'a> {
    /// Columns.
    pub flags: &'a [MapFlag],
    /// The joint, where the log has several.
    pub joint: Option<&'a str>,
    /// The kind of axis.
    pub axis: Option<AxisKind>,
}

/// What the columns of `table` are: those that are given, the others guessed, of one joint. The axis follows what is given, the
/// flags, or the units of the names, and is rotary where none of them tells.
///
/// # Errors
/// A sentence: a flag that cannot be followed, a required column that no name resembles, several joints.
pub fn guess(table: &Table, known: Given<'_>) -> Result<(AxisKind, Vec<Guess>), String> {
    let axis = known.axis.unwrap_or_else(|| told_axis(table, known.flags));
    let fits = |name: &str, column: Column| fit(table, name, column, axis).is_some();
    let mut guesses = Vec::new();
    for flag in known.flags {
        guesses.push(given(table, flag, axis)?);
    }
    let joints = Joints::of(table, fits, known.joint, known.flags)?;
    Mapping::new(guesses.iter().map(|guess| guess.mapped.clone()).collect(), axis)?;
    // The position first: the others are looked for beside it.
    for column in
        [Column::Position, Column::Time, Column::EffortCmd, Column::Reference, Column::Velocity, Column::EffortMeas]
    {
        if guesses.iter().any(|guess| guess.mapped.column == column) {
            continue;
        }
        guesses.extend(Search { table, joints: &joints, axis, taken: &guesses }.column(column)?);
    }
    guesses.sort_by_key(|guess| Column::ALL.iter().position(|column| *column == guess.mapped.column));
    Ok((axis, guesses))
}

/// The unit that a flag gives, or else its column.
fn unit_given(table: &Table, flag: &MapFlag) -> Option<String> {
    let name = table.column(&flag.name).map_or(flag.name.as_str(), |(name, _)| name);
    if flag.unit.is_empty() { table.unit(name) } else { Some(flag.unit.clone()) }
}

/// The kind of axis: that of the position where a flag tells its unit, whatever the effort is called; else linear where any key or
/// unit is.
fn told_axis(table: &Table, flags: &[MapFlag]) -> AxisKind {
    let quantity = |unit: String| units::measure(&unit).map(|measure| measure.quantity);
    let position = flags.iter().find(|flag| flag.column == Column::Position);
    match position.and_then(|flag| unit_given(table, flag)).and_then(quantity) {
        Some(Quantity::Length) => return AxisKind::Linear,
        Some(Quantity::Angle) => return AxisKind::Rotary,
        _ => {}
    }
    let linear_key = |flag: &MapFlag| flag.key != flag.column.key(AxisKind::Rotary);
    let names = table.numbers.iter().filter_map(|(name, _)| table.unit(name));
    let units = flags.iter().map(|flag| flag.unit.clone()).chain(names);
    let linear = |quantity| matches!(quantity, Quantity::Length | Quantity::Force | Quantity::Speed);
    let is_linear = flags.iter().any(linear_key) || units.filter_map(quantity).any(linear);
    if is_linear { AxisKind::Linear } else { AxisKind::Rotary }
}

/// A column that a flag gives.
fn given(table: &Table, flag: &MapFlag, axis: AxisKind) -> Result<Guess, String> {
    let wrong = |message: String| format!("--map {}={}: {message}", flag.key, flag.name);
    let column = flag.column;
    let Some((name, values)) = table.column(&flag.name) else {
        if column == Column::Mode && table.others.contains(&flag.name) {
            let mapped = MappedColumn::new(column, axis, &flag.name, &flag.unit, flag.scale).map_err(wrong)?;
            return Ok(Guess { mapped, because: "given".to_owned(), unsure: false });
        }
        if column == Column::Time && flag.name == ROW {
            return row_time(flag, axis).map_err(wrong);
        }
        return Err(wrong(unknown(table, flag)));
    };
    let (unit, unit_because, unsure) = if flag.unit.is_empty() && flag.scale.is_none() {
        unit_of(table, column, axis, (name, values))
    } else {
        (flag.unit.clone(), "given".to_owned(), false)
    };
    let mapped = MappedColumn::new(column, axis, name, &unit, flag.scale).map_err(wrong)?;
    let mut because = format!("given; unit: {unit_because}");
    let other = table.unit(name).filter(|unit| !is_of(column, axis, unit));
    if let Some(other) = &other {
        because += &format!(", though the log tells {other}");
    }
    Ok(Guess { mapped, because, unsure: unsure || other.is_some() })
}

/// The time of a log that has no column of it: its rows are evenly apart, and the flag says how far.
fn row_time(flag: &MapFlag, axis: AxisKind) -> Result<Guess, String> {
    if flag.unit.is_empty() && flag.scale.is_none() {
        return Err("say how far the rows are apart, as in --map \"time=[0]:ms*5\"".to_owned());
    }
    let mapped = MappedColumn::new(Column::Time, axis, ROW, &flag.unit, flag.scale)?;
    Ok(Guess { mapped, because: "given; the number of the row".to_owned(), unsure: false })
}

/// Why a flag names no column of numbers, and which may be meant.
fn unknown(table: &Table, flag: &MapFlag) -> String {
    if let Some(cell) = table.not_number(&flag.name) {
        let dates = if flag.column == Column::Time { dates(cell) } else { "" };
        return format!(
            "the column holds cells that are no finite numbers, the first {cell}{dates}; mend the log, or give another column"
        );
    }
    let names = table.numbers.iter().map(|(name, _)| name).chain(&table.others);
    match misspelt(&flag.name, names.map(String::as_str)) {
        Some(near) => format!("the column is not in the log; is {} meant?", quoted(near)),
        None => format!("the column is not in the log; {}", has(table)),
    }
}

fn has(table: &Table) -> String {
    let names: Vec<String> = table.numbers.iter().take(20).map(|(name, _)| quoted(name)).collect();
    let more = table.numbers.len().saturating_sub(names.len());
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("it has the columns {}{more}", names.join(", "))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn table(names: &[&str]) -> Table {
        let column = |name: &&str| {
            let step = if name.contains("stamp_us") || *name == "ts" { 500.0 } else { 5e-4 };
            ((*name).to_owned(), (0..50).map(|row| f64::from(row) * step).collect())
        };
        let topics = vec![0; names.len()];
        Table {
            numbers: names.iter().map(column).collect(),
            topics,
            others: vec!["note".to_owned()],
            ..Table::default()
        }
    }

    fn found(names: &[&str], flags: &[&str]) -> Result<Vec<String>, String> {
        let flags: Vec<MapFlag> = flags.iter().map(|flag| flag.parse().unwrap()).collect();
        found_of(names, Given { flags: &flags, ..Given::default() })
    }

    fn found_of(names: &[&str], given: Given<'_>) -> Result<Vec<String>, String> {
        let (axis, guesses) = guess(&table(names), given)?;
        Ok(guesses.iter().map(|guess| guess.mapped.to_toml(axis)).collect())
    }

    #[test]
    fn names_and_units_of_other_logs_are_understood() {
        let cases: &[(&[&str], &[&str])] = &[
            (
                &["Time [ms]", "Angle [deg]", "Target angle [deg]", "Motor Current [A]"],
                &[
                    r#"time = { name = "Time [ms]", unit = "ms" }"#,
                    r#"reference = { name = "Target angle [deg]", unit = "deg" }"#,
                    r#"position = { name = "Angle [deg]", unit = "deg" }"#,
                    r#"torque = { name = "Motor Current [A]", unit = "A", scale = 1.0 }"#,
                ],
            ),
            (
                &["ts", "pos_mm", "force"],
                &[
                    r#"time = { name = "ts", unit = "us" }"#,
                    r#"position = { name = "pos_mm", unit = "mm" }"#,
                    r#"force = { name = "force", unit = "N" }"#,
                ],
            ),
            (
                &["/js.stamp_s", "/js.elbow.position", "/js.elbow.velocity", "/js.elbow.effort"],
                &[
                    r#"time = { name = "/js.stamp_s", unit = "s" }"#,
                    r#"position = { name = "/js.elbow.position", unit = "rad" }"#,
                    r#"torque = { name = "/js.elbow.effort", unit = "N m" }"#,
                    r#"velocity = { name = "/js.elbow.velocity", unit = "rad/s" }"#,
                ],
            ),
        ];
        for (names, expected) in cases {
            assert_eq!(&found(names, &[]).unwrap(), expected);
        }
    }

    #[test]
    fn flags_come_first_and_what_is_missing_is_asked_for() {
        let given = found(&["a", "b", "c"], &["time=a:s", "position=b:counts(4096)", "torque=c:A*0.12"]).unwrap();
        assert_eq!(given[2], r#"torque = { name = "c", unit = "A", scale = 0.12 }"#);
        let error = found(&["t", "pos", "c"], &[]).unwrap_err();
        assert!(
            error.starts_with("which column is `torque`?") && error.contains("--map \"torque=NAME:N m\""),
            "{error}"
        );
        let error = found(&["t", "pos", "c"], &["torque=d"]).unwrap_err();
        assert!(
            error.starts_with("--map torque=d: the column is not in the log; it has the columns `t`, `pos`, `c`"),
            "{error}"
        );
    }

    #[test]
    fn the_time_of_a_log_without_one_is_the_number_of_the_row() {
        let (names, flags) = (["[1]", "[2]"], ["position=[1]:rad", "torque=[2]:N m", "time=[0]:ms*5"]);
        assert_eq!(found(&names, &flags).unwrap()[0], r#"time = { name = "[0]", unit = "ms", scale = 5.0 }"#);
        let error = found(&names, &["position=[1]:rad", "torque=[2]:N m", "time=[0]"]).unwrap_err();
        assert!(error.starts_with("--map time=[0]: say how far the rows are apart"), "{error}");
        let error = found(&["pos", "torque"], &["position=[0]"]).unwrap_err();
        assert!(error.contains("the column is not in the log"), "{error}");
        let mut falls = table(&["pos", "torque"]);
        falls.numbers.iter_mut().for_each(|(_, values)| values.reverse());
        let error = guess(&falls, Given::default()).unwrap_err();
        assert!(error.ends_with("rows are evenly apart, say how far: --map \"time=[0]:ms*5\""), "{error}");
    }

    #[test]
    fn counts_and_shares_are_asked_for() {
        let because = |names: &[&str], flags: &[&str], at: usize| -> (String, bool) {
            let flags: Vec<MapFlag> = flags.iter().map(|flag| flag.parse().unwrap()).collect();
            let (_, guesses) = guess(&table(names), Given { flags: &flags, ..Given::default() }).unwrap();
            (guesses[at].because.clone(), guesses[at].unsure)
        };
        let names = ["t", "position_actual_value [inc]", "torque [%]"];
        let (position, unsure) = because(&names, &[], 1);
        let asked = "give --map \"position=position_actual_value [inc]:counts(NUMBER IN A REVOLUTION)\"";
        assert!(unsure && position.contains("how large is NOT KNOWN") && position.ends_with(asked), "{position}");
        let (torque, unsure) = because(&names, &[], 2);
        assert!(unsure && torque.ends_with("give --map \"torque=torque [%]:N m*ONE OF IT\""), "{torque}");
        let (position, unsure) = because(&["t", "speed_rad_s", "torque"], &["position=speed_rad_s:rad"], 1);
        assert!(unsure && position.ends_with("though the log tells rad/s"), "{position}");
        let (time, unsure) = because(&["time_ms", "pos", "torque"], &[], 0);
        assert!(unsure && time.ends_with("but rows are then 5e-7 s apart"), "{time}");
    }

    #[test]
    fn an_effort_may_be_called_torque_or_force_on_any_axis() {
        let linear = found(&["ts", "pos", "i"], &["position=pos:mm", "torque=i:A*0.12", "time=ts:us"]).unwrap();
        let expected = [
            r#"time = { name = "ts", unit = "us" }"#,
            r#"position = { name = "pos", unit = "mm" }"#,
            r#"force = { name = "i", unit = "A", scale = 0.12 }"#,
        ];
        assert_eq!(linear, expected);
        let rotary =
            found(&["t", "a", "i", "im"], &["position=a:deg", "force=i:A*2", "force_measured=im:A*2"]).unwrap();
        assert_eq!(rotary[2], r#"torque = { name = "i", unit = "A", scale = 2.0 }"#);
        assert_eq!(rotary[3], r#"torque_measured = { name = "im", unit = "A", scale = 2.0 }"#);
        let unsaid = found(&["t", "pos", "f"], &["force=f"]).unwrap();
        assert_eq!(unsaid[1], r#"position = { name = "pos", unit = "m" }"#, "nothing else tells the axis");
        let error = found(&["t", "pos", "c"], &["position=pos:mm", "torque=c:N m"]).unwrap_err();
        assert!(error.contains("`N m` is not a unit of `force` on a linear axis"), "{error}");
    }

    #[test]
    fn of_several_joints_one_is_asked_for() {
        let names = [
            "/js.q1.stamp_s",
            "/js.q1.position",
            "/js.q1.effort",
            "/js.wrist.stamp_s",
            "/js.wrist.position",
            "/js.wrist.effort",
        ];
        let error = found(&names, &[]).unwrap_err();
        assert_eq!(
            error,
            "the log has 2 joints (or runs), and a machine file is of one; give --joint with one of `q1`, `wrist`"
        );
        let q1 = [
            r#"time = { name = "/js.q1.stamp_s", unit = "s" }"#,
            r#"position = { name = "/js.q1.position", unit = "rad" }"#,
            r#"torque = { name = "/js.q1.effort", unit = "N m" }"#,
        ];
        assert_eq!(found_of(&names, Given { joint: Some("q1"), ..Given::default() }).unwrap(), q1);
        assert_eq!(found(&names, &["torque=q1.effort:N m"]).unwrap(), q1, "a column tells the joint");
        let error = found_of(&names, Given { joint: Some("wist"), ..Given::default() }).unwrap_err();
        assert!(error.contains("no such joint; the log has `q1`, `wrist`; is `wrist` meant?"), "{error}");
    }

    #[test]
    fn joints_may_be_told_by_numbers() {
        let names = [
            "timestamp",
            "target_q_0",
            "target_q_1",
            "actual_q_0",
            "actual_q_1",
            "actual_current_0",
            "actual_current_1",
        ];
        let error = found(&names, &[]).unwrap_err();
        assert!(error.ends_with("give --joint with one of `0`, `1`"), "{error}");
        let expected = [
            r#"time = { name = "timestamp", unit = "s" }"#,
            r#"reference = { name = "target_q_1", unit = "rad" }"#,
            r#"position = { name = "actual_q_1", unit = "rad" }"#,
            r#"torque = { name = "actual_current_1", unit = "A", scale = 1.0 }"#,
        ];
        assert_eq!(found_of(&names, Given { joint: Some("1"), ..Given::default() }).unwrap(), expected);
        let currents =
            found_of(&["t", "q1", "q2", "iq1", "iq2"], Given { joint: Some("2"), ..Given::default() }).unwrap();
        assert_eq!(
            currents[2], r#"torque = { name = "iq2", unit = "A", scale = 1.0 }"#,
            "a current, whatever its joint"
        );
        let named = ["t", "lift_joint_position", "arm_1_joint_position", "lift_joint_effort", "arm_1_joint_effort"];
        let lift = found(&named, &["position=lift_joint_position:m"]).unwrap();
        assert_eq!(lift[2], r#"force = { name = "lift_joint_effort", unit = "N" }"#, "of the joint of the position");
        // All that is needed is given.
        let given = found(&names, &["position=actual_q_1:rad", "torque=actual_current_0:A*2"]).unwrap();
        assert_eq!(given[2], expected[2]);
    }

    #[test]
    fn a_position_of_joints_is_of_as_many_as_an_effort() {
        let arrays = [("ee_pos", 2), ("q", 3), ("qd", 3), ("tau", 3)];
        let columns = arrays.iter().flat_map(|(array, many)| (1..=*many).map(move |nth| format!("{array}[{nth}]")));
        let names: Vec<String> = std::iter::once("time".to_owned()).chain(columns).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let found = found_of(&names, Given { joint: Some("2"), ..Given::default() }).unwrap();
        assert_eq!(found[1], r#"position = { name = "q[2]", unit = "rad" }"#);
    }

    #[test]
    fn columns_are_looked_for_beside_the_position() {
        let mut table = table(&["/imu.stamp_s", "/imu.x", "/motor.log_time_s", "/motor.angle", "/motor.torque"]);
        table.topics = vec![0, 0, 1, 1, 1];
        let (_, guesses) = guess(&table, Given::default()).unwrap();
        let names: Vec<&str> = guesses.iter().map(|guess| guess.mapped.name.as_str()).collect();
        assert_eq!(names, ["/motor.log_time_s", "/motor.angle", "/motor.torque"]);
    }
}
