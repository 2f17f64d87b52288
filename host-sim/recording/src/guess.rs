//! What the columns of somebody else's log probably are, by their names and numbers.

use super::nearest::quoted;
use super::units::{self, Quantity};
use super::{AxisKind, Column, MapFlag, MappedColumn, Mapping, Table};

/// Words of names, in small letters, by what they mean; the likeliest first. A stamp is of the machine, other times may be
/// when it was logged.
const TIME: &[&str] = &["stamp", "t", "time", "timestamp", "ts", "seconds", "sec", "clock", "zeit"];
const POSITION: &[&str] = &["position", "pos", "angle", "theta", "q", "x", "enc", "encoder", "phi", "q1", "winkel"];
const VELOCITY: &[&str] = &["velocity", "vel", "speed", "omega", "qd", "dq", "w", "v"];
const EFFORT: &[&str] =
    &["torque", "force", "tau", "effort", "trq", "current", "cur", "iq", "i", "u", "f", "voltage", "strom"];
/// Words that make a position the one that is wanted,
const WANTED: &[&str] =
    &["reference", "ref", "setpoint", "set", "target", "des", "desired", "demand", "goal", "sp", "cmd", "command"];
/// and an effort one that was measured, not commanded.
const MEASURED: &[&str] = &["meas", "measured", "act", "actual", "fb", "feedback", "est", "estimated"];

/// Sample periods of drives, s; a clock whose steps are outside is in another unit.
const PERIODS_S: std::ops::Range<f64> = 2e-5..5e-2;

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

/// What the columns of `table` are: those of `flags` as given, the others guessed. The axis follows `axis`, the flags, or the
/// units of the names, and is rotary where none of them tells.
///
/// # Errors
/// A sentence: a flag that cannot be followed, a required column that no name resembles.
pub fn guess(table: &Table, flags: &[MapFlag], axis: Option<AxisKind>) -> Result<(AxisKind, Vec<Guess>), String> {
    let axis = axis.unwrap_or_else(|| told_axis(table, flags));
    let mut guesses = Vec::new();
    for flag in flags {
        guesses.push(given(table, flag, axis)?);
    }
    Mapping::new(guesses.iter().map(|guess| guess.mapped.clone()).collect(), axis)?;
    for column in
        [Column::Time, Column::Position, Column::EffortCmd, Column::Reference, Column::Velocity, Column::EffortMeas]
    {
        if guesses.iter().any(|guess| guess.mapped.column == column) {
            continue;
        }
        guesses.extend(guessed(table, column, axis, &guesses)?);
    }
    guesses.sort_by_key(|guess| Column::ALL.iter().position(|column| *column == guess.mapped.column));
    Ok((axis, guesses))
}

fn told_axis(table: &Table, flags: &[MapFlag]) -> AxisKind {
    let linear_key = |flag: &MapFlag| Column::by_key(&flag.key, AxisKind::Rotary).is_none();
    let names = table.numbers.iter().filter_map(|(name, _)| units::told(name));
    let mut units = flags.iter().map(|flag| flag.unit.clone()).chain(names);
    let linear = |unit: String| {
        let measure = units::measure(&unit);
        measure.is_some_and(|measure| matches!(measure.quantity, Quantity::Length | Quantity::Force | Quantity::Speed))
    };
    if flags.iter().any(linear_key) || units.any(linear) { AxisKind::Linear } else { AxisKind::Rotary }
}

/// A column that a flag gives.
fn given(table: &Table, flag: &MapFlag, axis: AxisKind) -> Result<Guess, String> {
    let wrong = |message: String| format!("--map {}={}: {message}", flag.key, flag.name);
    let Some(column) = Column::by_key(&flag.key, axis) else {
        let keys = Column::ALL.map(|column| column.key(axis)).join(", ");
        return Err(wrong(format!("a {} axis has no such column; it has {keys}", axis.name())));
    };
    let Some(values) = table.column(&flag.name) else {
        if column == Column::Mode && table.others.contains(&flag.name) {
            let mapped = MappedColumn::new(column, axis, &flag.name, &flag.unit, flag.scale).map_err(wrong)?;
            return Ok(Guess { mapped, because: "given".to_owned(), unsure: false });
        }
        let what = if table.others.contains(&flag.name) { "is not a column of numbers" } else { "is not in the log" };
        return Err(wrong(format!("the column {what}; {}", has(table))));
    };
    let (unit, unit_because, unsure) = if flag.unit.is_empty() && flag.scale.is_none() {
        unit_of(column, axis, &flag.name, values)
    } else {
        (flag.unit.clone(), "given".to_owned(), false)
    };
    let mapped = MappedColumn::new(column, axis, &flag.name, &unit, flag.scale).map_err(wrong)?;
    Ok(Guess { mapped, because: format!("given; unit: {unit_because}"), unsure })
}

fn has(table: &Table) -> String {
    let names: Vec<String> = table.numbers.iter().take(20).map(|(name, _)| quoted(name)).collect();
    let more = table.numbers.len().saturating_sub(names.len());
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("it has the columns {}{more}", names.join(", "))
}

/// How well a name fits a column; none where it does not.
fn fit(name: &str, column: Column, axis: AxisKind) -> Option<u32> {
    let words = words(name);
    let any = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let rank = |list: &[&str]| {
        list.iter().position(|known| words.iter().any(|word| word == known)).map(|place| (list.len() - place) as u32)
    };
    let quantity = units::told(name).and_then(|unit| units::measure(&unit)).map(|measure| measure.quantity);
    let by_word = match column {
        Column::Time => rank(TIME).filter(|_| !any(POSITION) && !any(EFFORT)),
        Column::Position => rank(POSITION).filter(|_| !any(WANTED) && !any(VELOCITY)),
        Column::Reference => rank(POSITION).filter(|_| any(WANTED)).or_else(|| {
            // `reference_rad`, `setpoint [mm]`: of which quantity the unit tells, and nothing else does.
            rank(WANTED)
                .filter(|_| quantity.is_some_and(|quantity| column.quantities(axis)[0] == quantity) && !any(EFFORT))
        }),
        Column::Velocity => rank(VELOCITY).filter(|_| !any(WANTED)),
        Column::EffortCmd => rank(EFFORT).filter(|_| !any(MEASURED)),
        Column::EffortMeas => rank(EFFORT).filter(|_| any(MEASURED)),
        _ => None,
    }?;
    match quantity {
        // A unit of another kind says more than the name.
        Some(quantity) => column.quantities(axis).contains(&quantity).then_some(by_word + 100),
        None => Some(by_word),
    }
}

/// The words of a name: parted by signs and by capitals, without its unit.
fn words(name: &str) -> Vec<String> {
    let name = name.split(['[', '(']).next().unwrap_or(name);
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for letter in name.chars() {
        if !letter.is_alphanumeric() {
            words.push(String::new());
        } else {
            if words.is_empty() || (letter.is_uppercase() && before.is_lowercase()) {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(letter.to_lowercase());
            }
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The column by its name; an error where a required one is not found.
fn guessed(table: &Table, column: Column, axis: AxisKind, taken: &[Guess]) -> Result<Option<Guess>, String> {
    let free = || table.numbers.iter().filter(|(name, _)| !taken.iter().any(|guess| guess.mapped.name == *name));
    let rises = |values: &[f64]| values.windows(2).all(|pair| pair[1] > pair[0]);
    let fits = |column: Column| {
        let fitting = free().filter(|(_, values)| column != Column::Time || rises(values));
        let mut fitting: Vec<_> =
            fitting.filter_map(|(name, values)| Some((fit(name, column, axis)?, name, values))).collect();
        fitting.sort_by_key(|(score, ..)| std::cmp::Reverse(*score));
        fitting
    };
    let mut fitting = fits(column);
    let mut because = "by its name".to_owned();
    if fitting.is_empty() && column == Column::EffortCmd {
        fitting = fits(Column::EffortMeas);
        "a measured one, there is no commanded one".clone_into(&mut because);
    }
    if fitting.is_empty() && column == Column::Time {
        if let Some(broken) = broken_time(table) {
            return Err(broken);
        }
        fitting = free().filter(|(_, values)| rises(values)).map(|(name, values)| (0, name, values)).take(1).collect();
        "the first that always rises".clone_into(&mut because);
    }
    let Some((score, name, values)) = fitting.first().copied() else {
        return if Column::REQUIRED.contains(&column) { Err(missing(table, column, axis)) } else { Ok(None) };
    };
    let rivals: Vec<_> =
        fitting[1..].iter().filter(|(other, ..)| *other == score).map(|(_, name, _)| quoted(name)).collect();
    if !rivals.is_empty() {
        because += &format!(", as well as {}", rivals.join(", "));
    }
    let (unit, unit_because, unit_unsure) = unit_of(column, axis, name, values);
    let needs_scale =
        units::measure(&unit).is_some_and(|measure| matches!(measure.quantity, Quantity::Current | Quantity::Voltage));
    let own = column.unit(axis);
    if needs_scale {
        let key = column.key(axis);
        because += &format!("; scale 1 {own}/{unit} is NOT KNOWN, give --map \"{key}={name}:{unit}*SCALE\"");
    }
    let mapped = MappedColumn::new(column, axis, name, &unit, needs_scale.then_some(1.0))?;
    let unsure = unit_unsure || needs_scale || !rivals.is_empty() || score == 0;
    Ok(Some(Guess { mapped, because: format!("{because}; unit: {unit_because}"), unsure }))
}

/// What is wrong with the column that is the time by its unit: another that rises in its place, as a counter of rows does, would
/// mislead.
fn broken_time(table: &Table) -> Option<String> {
    let is_time = |name: &str| fit(name, Column::Time, AxisKind::Rotary).is_some_and(|score| score > 100);
    let advice = "mend the log, or give another column as --map \"time=NAME:s\"";
    if let Some((name, values)) = table.numbers.iter().find(|(name, _)| is_time(name)) {
        let row = values.windows(2).position(|pair| pair[1] <= pair[0])?;
        let (from, to, name) = (values[row], values[row + 1], quoted(name));
        return Some(format!("{name} does not rise from {from} to {to}, rows {} and {}; {advice}", row + 1, row + 2));
    }
    let name = table.others.iter().find(|name| is_time(name))?;
    Some(format!("{} holds cells that are no finite numbers; {advice}", quoted(name)))
}

fn missing(table: &Table, column: Column, axis: AxisKind) -> String {
    let (key, unit) = (column.key(axis), column.unit(axis));
    let what = if column == Column::Time { "no column always rises" } else { "no name tells" };
    format!("which column is `{key}`? {what}; {}; give it as --map \"{key}=NAME:{unit}\"", has(table))
}

/// The unit of a column, why, and whether that is unsure.
fn unit_of(column: Column, axis: AxisKind, name: &str, values: &[f64]) -> (String, String, bool) {
    let told = units::told(name)
        .filter(|unit| units::measure(unit).is_some_and(|measure| column.quantities(axis).contains(&measure.quantity)));
    if let Some(unit) = told {
        return (unit, "by its name".to_owned(), false);
    }
    let own = column.unit(axis);
    if column == Column::Time && values.len() > 1 {
        let step = (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64;
        let found = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
        let unit = found.into_iter().find(|(_, factor)| PERIODS_S.contains(&(step * factor)));
        let Some((unit, _)) = unit else {
            return (own.to_owned(), format!("not told, and rows {step} apart fit none"), true);
        };
        return (unit.to_owned(), format!("rows are {step:.6} apart"), unit != "s");
    }
    let words = words(name);
    if matches!(column, Column::EffortCmd | Column::EffortMeas) {
        let any = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
        if any(&["current", "cur", "iq", "i", "strom"]) {
            return ("A".to_owned(), "a current by its name".to_owned(), true);
        }
        if any(&["voltage"]) {
            return ("V".to_owned(), "a voltage by its name".to_owned(), true);
        }
    }
    (own.to_owned(), format!("NOT TOLD, taken as {own}"), column != Column::Time)
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
        Table { numbers: names.iter().map(column).collect(), others: vec!["note".to_owned()] }
    }

    fn found(names: &[&str], flags: &[&str]) -> Result<Vec<String>, String> {
        let flags: Vec<MapFlag> = flags.iter().map(|flag| flag.parse().unwrap()).collect();
        let (axis, guesses) = guess(&table(names), &flags, None)?;
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
        let error = found(&["t", "pos", "c"], &["torque=c", "position=pos:mm"]).unwrap_err();
        assert!(error.contains("a linear axis has no such column"), "{error}");
    }
}
