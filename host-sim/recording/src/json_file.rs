//! Logs in JSON: a list of objects, an object a line, or an object of lists; and the JSON of WPILib's SysId.

use std::path::Path;

use serde_json::{Deserializer, Value};

use super::mcap_file::message::flatten;
use super::sysid_file::{self, numbers};
use super::topics::{Series, Topic};
use crate::Error;

/// Lists deeper within one another than this hold no log.
const DEEPEST: usize = 8;

/// The topics of a file in JSON: one for each list of rows in it.
pub(crate) fn read(file: &Path, bytes: &[u8]) -> Result<Vec<Topic>, Error> {
    topics(bytes).map_err(|message| Error::input(file, None, "", message))
}

fn topics(bytes: &[u8]) -> Result<Vec<Topic>, String> {
    let values = Deserializer::from_slice(bytes).into_iter::<Value>().collect::<Result<Vec<Value>, _>>();
    let mut values = values.map_err(|error| format!("is not JSON that can be read, or was cut short: {error}"))?;
    let log = if values.len() == 1 { values.remove(0) } else { Value::Array(values) };
    if let Some(sysid) = log.as_object().filter(|log| log.get("sysid") == Some(&Value::Bool(true))) {
        return sysid_file::topic(sysid).map(|topic| vec![topic]);
    }
    let mut found = Vec::new();
    look("", &log, DEEPEST, &mut found)?;
    if found.is_empty() {
        return Err("is JSON, but holds no rows: a list of objects, an object a line, or lists of numbers".to_owned());
    }
    Ok(found)
}

/// Adds what of a value is rows; `path` is where it is.
fn look(path: &str, value: &Value, deepest: usize, to: &mut Vec<Topic>) -> Result<(), String> {
    match value {
        Value::Array(rows) if !rows.is_empty() && rows.iter().all(Value::is_object) => to.push(of_objects(path, rows)?),
        Value::Array(rows) if !rows.is_empty() => to.extend(of_lists(path, rows)),
        Value::Object(members) if deepest > 0 => {
            let mut plain: Vec<(String, Vec<f64>)> = Vec::new();
            for (name, value) in members {
                match numbers(value) {
                    Some(values) if !values.is_empty() => plain.push((below(path, name), values)),
                    _ => look(&below(path, name), value, deepest - 1, to)?,
                }
            }
            // Lists of one length are columns of one table.
            while let Some((_, first)) = plain.first() {
                let rows = first.len();
                let (columns, others) = plain.into_iter().partition(|(_, values)| values.len() == rows);
                to.push(of_columns(columns));
                plain = others;
            }
        }
        _ => {}
    }
    Ok(())
}

/// A row for each object, with all that is in it by its path.
fn of_objects(path: &str, rows: &[Value]) -> Result<Topic, String> {
    let mut topic = Topic::default();
    for row in rows {
        let mut fields = Vec::new();
        for (name, value) in row.as_object().into_iter().flatten() {
            flatten(&below(path, name), value, 0, &mut fields);
        }
        topic.push(0, fields)?;
    }
    topic.logged_ns.clear();
    Ok(topic)
}

/// A row for each list of numbers, where they are of one length; none where they are not.
fn of_lists(path: &str, rows: &[Value]) -> Option<Topic> {
    let rows = rows.iter().map(numbers).collect::<Option<Vec<_>>>()?;
    let width = rows.first()?.len();
    if width < 2 || rows.iter().any(|row| row.len() != width) {
        return None;
    }
    let column = |index: usize| (format!("{path}[{}]", index + 1), rows.iter().map(|row| row[index]).collect());
    Some(of_columns((0..width).map(column).collect()))
}

fn of_columns(columns: Vec<(String, Vec<f64>)>) -> Topic {
    let columns = columns.into_iter().map(|(name, values)| (name, Series::Numbers(values))).collect();
    Topic { logged_ns: Vec::new(), columns }
}

/// The path of a member.
fn below(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Names of each topic, with the last cell.
    fn found(text: &str) -> Vec<Vec<String>> {
        let last = |(name, cells): &(String, Series)| match cells {
            Series::Numbers(values) => format!("{name}={}", values.last().unwrap()),
            Series::Texts(values) => format!("{name}={}", values.last().unwrap()),
        };
        let topics = topics(text.as_bytes()).unwrap();
        topics.iter().map(|topic| topic.columns.iter().map(last).collect()).collect()
    }

    #[test]
    fn rows_are_objects_lines_or_lists() {
        let rows = r#"{"t": 0, "motor": {"pos": 1.5}}"#;
        let expected = [["motor.pos=2.5", "t=1"]];
        let next = r#"{"t": 1, "motor": {"pos": 2.5}}"#;
        assert_eq!(found(&format!("[{rows}, {next}]")), expected);
        assert_eq!(found(&format!("{rows}\n{next}\n")), expected, "an object a line");
        let entries =
            r#"{"mass": 0.5, "entries": [{"timestamp": 0.0, "position": 1}, {"timestamp": 0.1, "position": 2}]}"#;
        assert_eq!(found(entries), [["entries.position=2", "entries.timestamp=0.1"]]);
        assert_eq!(found(r#"{"run": {"t": [0, 1], "q": [3, 4], "gains": [1, 2, 3]}}"#).len(), 2);
        assert_eq!(found(r#"{"log": [[0, 1], [2, 3]]}"#), [["log[1]=2", "log[2]=3"]]);
        assert_eq!(found(r#"{"sysid": true, "slow-forward": [[1, 2, 3, 4]]}"#)[0].len(), 4);
    }

    #[test]
    fn what_holds_no_rows_is_refused() {
        for (text, message) in [
            ("{\"a\": 1}", "holds no rows"),
            ("[]", "holds no rows"),
            ("[[1, 2], [3]]", "holds no rows"),
            ("{\"a\": ", "or was cut short"),
            ("{\"sysid\": true}", "it holds no test"),
        ] {
            let error = topics(text.as_bytes()).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }
}
