//! JSON of WPILib's SysId up to 2023: tests such as `slow-forward`, each rows of time, voltage, position and velocity.
//!
//! The tests follow one another as one recording, in the order they were made; between two is a gap. Positions are in turns of the
//! mechanism; where its unit is a length, they become metres. Later versions write WPILOG.

use serde_json::{Map, Value};

use super::topics::{Series, Topic};

/// Tests whose clock began anew are put this long after the one before, s: longer than any sample period, so that it is a gap.
const BETWEEN_S: f64 = 1.0;
/// Columns of the log of one motor: time, voltage, position, velocity.
const ONE: usize = 4;
/// Columns of the log of a drivetrain: time, and voltage, position and velocity of two sides, angle and its rate.
const DRIVETRAIN: usize = 9;
/// One of a unit in metres; 1 m is 1 / 0.3048 ft.
const LENGTHS_M: [(&str, f64); 3] = [("meters", 1.0), ("feet", 0.3048), ("inches", 0.0254)];

/// The topic of a SysId file, of which there is one; the message says what is wrong.
pub(crate) fn topic(log: &Map<String, Value>) -> Result<Topic, String> {
    let mut tests = Vec::new();
    for (name, value) in log {
        if let Value::Array(rows) = value {
            let rows = rows.iter().enumerate().map(|(row, value)| numbers_of(name, row, value));
            tests.push(rows.collect::<Result<Vec<_>, _>>()?);
        }
    }
    tests.retain(|rows| !rows.is_empty());
    tests.sort_by(|one, other| one[0][0].total_cmp(&other[0][0]));
    let Some(width) = tests.first().map(|rows| rows[0].len()) else { return Err("it holds no test".to_owned()) };
    let names = names(log, width)?;
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); width];
    for rows in &tests {
        let last_s = columns[0].last().copied();
        let later_s = last_s.map_or(0.0, |last_s| (last_s + BETWEEN_S - rows[0][0]).max(0.0));
        for row in rows {
            if row.len() != width {
                return Err(format!("a row has {} numbers, others have {width}", row.len()));
            }
            for (index, ((column, value), (_, factor))) in columns.iter_mut().zip(row).zip(&names).enumerate() {
                column.push(if index == 0 { value + later_s } else { value * factor });
            }
        }
    }
    let columns = names.into_iter().zip(columns).map(|((name, _), values)| (name, Series::Numbers(values)));
    Ok(Topic { logged_ns: Vec::new(), columns: columns.collect() })
}

/// The numbers of a list; none of what is no list of numbers alone.
pub(crate) fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

fn numbers_of(test: &str, row: usize, value: &Value) -> Result<Vec<f64>, String> {
    let numbers = numbers(value).filter(|numbers| !numbers.is_empty());
    numbers.ok_or_else(|| format!("{test}: row {} is not a list of numbers", row + 1))
}

/// The name of each column with its unit, and the factor to that unit.
fn names(log: &Map<String, Value>, width: usize) -> Result<Vec<(String, f64)>, String> {
    let unit = log.get("units").and_then(Value::as_str).unwrap_or_default().to_lowercase();
    let per_turn = log.get("unitsPerRotation").and_then(Value::as_f64).filter(|number| number.is_finite());
    let length = LENGTHS_M.iter().find(|(name, _)| *name == unit).zip(per_turn);
    let (position, velocity, factor) = match length {
        Some(((_, metres), per_turn)) => ("position_m", "velocity_m_s", metres * per_turn),
        None => ("position_rev", "velocity_rev_s", 1.0),
    };
    let side = |side: &str, name: &str| format!("{side}{name}");
    let columns = match width {
        ONE => [("time_s", 1.0), ("voltage_v", 1.0), (position, factor), (velocity, factor)]
            .map(|(name, factor)| (name.to_owned(), factor))
            .to_vec(),
        DRIVETRAIN => vec![
            ("time_s".to_owned(), 1.0),
            (side("left.", "voltage_v"), 1.0),
            (side("right.", "voltage_v"), 1.0),
            (side("left.", position), factor),
            (side("right.", position), factor),
            (side("left.", velocity), factor),
            (side("right.", velocity), factor),
            ("heading_rad".to_owned(), 1.0),
            ("heading_rate_rad_s".to_owned(), 1.0),
        ],
        _ => {
            return Err(format!("its rows have {width} numbers; SysId writes {ONE} or, of a drivetrain, {DRIVETRAIN}"));
        }
    };
    Ok(columns)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn object(text: &str) -> Map<String, Value> {
        serde_json::from_str(text).unwrap()
    }

    fn columns(text: &str) -> Vec<(String, Vec<f64>)> {
        let numbers = |(name, series)| match series {
            Series::Numbers(values) => (name, values),
            Series::Texts(_) => unreachable!(),
        };
        topic(&object(text)).unwrap().columns.into_iter().map(numbers).collect()
    }

    #[test]
    fn tests_follow_one_another() {
        let text = r#"{"sysid": true, "test": "Simple", "units": "Feet", "unitsPerRotation": 2.0,
                       "fast-forward": [[20.0, 7.0, 1.0, 0.5]], "slow-forward": [[10.0, 0.1, 0.0, 0.0], [10.5, 0.2, 0.5, 1.0]]}"#;
        let found = columns(text);
        assert_eq!(found[0], ("time_s".to_owned(), vec![10.0, 10.5, 20.0]));
        assert_eq!(found[1], ("voltage_v".to_owned(), vec![0.1, 0.2, 7.0]));
        assert_eq!(found[2], ("position_m".to_owned(), vec![0.0, 0.3048, 0.6096]));
        let again = text.replace("20.0", "10.2");
        assert_eq!(columns(&again)[0].1, [10.0, 10.5, 11.5], "a clock that began anew");
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, message) in [
            ("{\"sysid\": true}", "it holds no test"),
            ("{\"sysid\": true, \"slow-forward\": [[1, \"x\"]]}", "slow-forward: row 1 is not a list of numbers"),
            ("{\"sysid\": true, \"slow-forward\": [[1, 2]]}", "its rows have 2 numbers"),
        ] {
            let error = topic(&object(text)).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }
}
