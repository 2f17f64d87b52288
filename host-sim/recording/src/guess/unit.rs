//! The unit of a column, by its name, the row below the header, or its numbers.

use crate::units;
use crate::words::{CURRENT, is_one_of, telling, words};
use crate::{AxisKind, Column, Table};

/// Sample periods of drives, s; a clock whose steps are outside is in another unit.
const PERIODS_S: std::ops::Range<f64> = 2e-5..5e-2;

/// Whether a unit is one of such a column.
pub(super) fn is_of(column: Column, axis: AxisKind, unit: &str) -> bool {
    units::measure(unit).is_some_and(|measure| column.quantities(axis).contains(&measure.quantity))
}

/// The unit of a column, why, and whether that is unsure.
pub(super) fn unit_of(
    table: &Table,
    column: Column,
    axis: AxisKind,
    (name, values): (&str, &[f64]),
) -> (String, String, bool) {
    let told = table.unit(name).filter(|unit| is_of(column, axis, unit));
    let told_by = if units::told(name).is_some() { "by its name" } else { "by the row below the header" };
    if column == Column::Time && values.len() > 1 {
        let step = (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64;
        return time_unit(told, told_by, step);
    }
    if let Some(unit) = told {
        return (unit, told_by.to_owned(), false);
    }
    let words = words(telling(name));
    if matches!(column, Column::EffortCmd | Column::EffortMeas) {
        let any = |list: &[&str]| words.iter().any(|word| is_one_of(word, list));
        if any(CURRENT) {
            return ("A".to_owned(), "a current by its name".to_owned(), true);
        }
        if any(&["voltage"]) {
            return ("V".to_owned(), "a voltage by its name".to_owned(), true);
        }
    }
    (column.unit(axis).to_owned(), not_told(column, axis, name), column != Column::Time)
}

/// The unit of times that rise by `step` from row to row.
fn time_unit(told: Option<String>, told_by: &str, step: f64) -> (String, String, bool) {
    if let Some(unit) = told {
        let step_s = step * units::measure(&unit).map_or(1.0, |measure| measure.factor);
        if PERIODS_S.contains(&step_s) {
            return (unit, told_by.to_owned(), false);
        }
        return (unit, format!("{told_by}, but rows are then {step_s:e} s apart"), true);
    }
    let found = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
    match found.into_iter().find(|(_, factor)| PERIODS_S.contains(&(step * factor))) {
        Some((unit, _)) => (unit.to_owned(), format!("rows are {step:.6} apart"), unit != "s"),
        None => ("s".to_owned(), format!("not told, and rows {step} apart fit none"), true),
    }
}

/// That nothing tells the unit, and how to give it where the name tells that it is none of the format.
fn not_told(column: Column, axis: AxisKind, name: &str) -> String {
    let own = column.unit(axis);
    let ask = |what: &str, unit: &str| {
        let key = column.key(axis);
        format!("{what} by its name, how large is NOT KNOWN and taken as 1 {own}: give --map \"{key}={name}:{unit}\"")
    };
    match column {
        Column::Position | Column::Reference if holds(name, COUNTS) => {
            let around = if axis == AxisKind::Rotary { "REVOLUTION" } else { "METRE" };
            ask("a count", &format!("counts(NUMBER IN A {around})"))
        }
        Column::EffortCmd | Column::EffortMeas if name.contains('%') || holds(name, SHARES) => {
            ask("a share of something rated", &format!("{own}*ONE OF IT"))
        }
        _ => format!("NOT TOLD, taken as {own}"),
    }
}

/// What encoders' counts are called.
const COUNTS: &[&str] = &["inc", "incr", "increments", "count", "counts", "cnt", "cnts", "tick", "ticks", "pulses"];
/// What drives' shares of a rated torque or current are called.
const SHARES: &[&str] = &["percent", "permille", "promille"];

/// Whether one of these words is in a name, its unit included.
fn holds(name: &str, list: &[&str]) -> bool {
    let lower = name.to_lowercase();
    lower.split(|letter: char| !letter.is_alphanumeric()).any(|word| list.contains(&word))
}
