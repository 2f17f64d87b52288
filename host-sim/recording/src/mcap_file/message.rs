//! One message of an MCAP file as rows of numbers and texts.

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::topics::Field;

/// More elements of an array than this are no joints and no axes, but a picture or a point cloud.
const MOST_ELEMENTS: usize = 64;

/// What a message says of one joint, or of everything where it names none.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Row {
    pub(super) joint: Option<String>,
    pub(super) fields: Vec<(String, Field)>,
}

/// `sensor_msgs/msg/JointState` of ROS 2.
#[derive(Debug, Deserialize)]
struct JointState {
    sec: i32,
    nanosec: u32,
    _frame_id: String,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

/// s from one time in ns to another, either way.
pub(super) fn since_s(ns: u64, begin_ns: u64) -> f64 {
    let magnitude = 1e-9 * ns.abs_diff(begin_ns) as f64;
    if ns < begin_ns { -magnitude } else { magnitude }
}

/// A row of a recording this tool wrote.
pub(super) fn own(data: &[u8]) -> Result<Vec<Row>, String> {
    let fields: Map<String, Value> = serde_json::from_slice(data).map_err(|error| format!("is not JSON: {error}"))?;
    let field = |(name, value): (String, Value)| match value {
        Value::Number(number) => Some((name, Field::Number(number.as_f64()?))),
        Value::String(text) => Some((name, Field::Text(text))),
        _ => None,
    };
    Ok(vec![Row { joint: None, fields: fields.into_iter().filter_map(field).collect() }])
}

/// Any JSON: every number and text by its path; joints apart where the message has the form of a joint state of ROS
/// (`name`, `position`, ... as arrays) or of Foxglove (`joints`, each with its `name`).
pub(super) fn json(data: &[u8], begin_ns: u64) -> Result<Vec<Row>, String> {
    let value: Value = serde_json::from_slice(data).map_err(|error| format!("is not JSON: {error}"))?;
    Ok(rows_of(&value, begin_ns))
}

/// The same of a message in JSON's terms.
pub(super) fn rows_of(value: &Value, begin_ns: u64) -> Vec<Row> {
    let Some(fields) = value.as_object() else {
        let mut row = Row::default();
        flatten("value", value, begin_ns, &mut row.fields);
        return vec![row];
    };
    let mut rows = joints_by_arrays(fields).or_else(|| joints_by_objects(fields)).unwrap_or_default();
    let mut shared = Vec::new();
    for (name, value) in fields {
        // What tells of the joints stands in their rows.
        if rows.is_empty() || !matches!(value, Value::Array(_)) {
            flatten(name, value, begin_ns, &mut shared);
        }
    }
    if rows.is_empty() {
        rows.push(Row::default());
    }
    rows.iter_mut().for_each(|row| row.fields.extend(shared.iter().cloned()));
    rows
}

fn joints_by_arrays(fields: &Map<String, Value>) -> Option<Vec<Row>> {
    let names = fields.get("name")?.as_array()?.iter().map(Value::as_str).collect::<Option<Vec<&str>>>()?;
    fields.get("position")?.as_array()?;
    let row = |(index, name): (usize, &&str)| {
        let field = |what: &str| Some((what.to_owned(), Field::Number(fields.get(what)?.get(index)?.as_f64()?)));
        let fields = ["position", "velocity", "effort"].into_iter().filter_map(field).collect();
        Row { joint: Some((*name).to_owned()), fields }
    };
    Some(names.iter().take(MOST_ELEMENTS).enumerate().map(row).collect())
}

fn joints_by_objects(fields: &Map<String, Value>) -> Option<Vec<Row>> {
    let row = |joint: &Value| {
        let joint = joint.as_object()?;
        let number = |(what, value): (&String, &Value)| Some((what.clone(), Field::Number(value.as_f64()?)));
        let name = joint.get("name")?.as_str()?.to_owned();
        Some(Row { joint: Some(name), fields: joint.iter().filter_map(number).collect() })
    };
    fields.get("joints")?.as_array()?.iter().take(MOST_ELEMENTS).map(row).collect()
}

/// Every number and text below a value by its path; a time of seconds and nanoseconds is one number.
pub(crate) fn flatten(path: &str, value: &Value, begin_ns: u64, to: &mut Vec<(String, Field)>) {
    match value {
        Value::Number(number) => to.extend(number.as_f64().map(|number| (path.to_owned(), Field::Number(number)))),
        Value::Bool(flag) => to.push((path.to_owned(), Field::Number(f64::from(u8::from(*flag))))),
        Value::String(text) => to.push((path.to_owned(), Field::Text(text.clone()))),
        Value::Array(values) if values.len() <= MOST_ELEMENTS => {
            for (index, value) in values.iter().enumerate() {
                flatten(&format!("{path}[{index}]"), value, begin_ns, to);
            }
        }
        Value::Object(fields) => {
            let part = |names: &[&str]| names.iter().find_map(|name| fields.get(*name)?.as_u64());
            let (sec, ns) = (part(&["sec", "secs"]), part(&["nsec", "nsecs", "nanosec"]));
            if let (2, Some(sec), Some(ns)) = (fields.len(), sec, ns) {
                let stamp_ns = sec.saturating_mul(1_000_000_000).saturating_add(ns);
                let name = if path == "header.stamp" { "stamp" } else { path };
                to.push((format!("{name}_s"), Field::Number(since_s(stamp_ns, begin_ns))));
                return;
            }
            fields.iter().for_each(|(name, value)| flatten(&format!("{path}.{name}"), value, begin_ns, to));
        }
        Value::Array(_) | Value::Null => {}
    }
}

/// A joint state of ROS 2 in CDR, a row for each joint.
pub(super) fn joint_state(data: &[u8], begin_ns: u64) -> Result<Vec<Row>, String> {
    let (header, body) = data.split_at_checked(4).ok_or("is cut short")?;
    // The second byte of the encapsulation tells the order of bytes (DDSI-RTPS 2.5, section 10).
    let decoded = match header[1] {
        0 => cdr_encoding::from_bytes::<JointState, byteorder::BigEndian>(body),
        1 => cdr_encoding::from_bytes::<JointState, byteorder::LittleEndian>(body),
        other => return Err(format!("is in the representation {other} of CDR, which is not read")),
    };
    let (state, _) = decoded.map_err(|error| format!("is no JointState: {error}"))?;
    let stamp_ns = u64::try_from(state.sec).unwrap_or(0) * 1_000_000_000 + u64::from(state.nanosec);
    let row = |(index, name): (usize, String)| {
        let stamp = ("stamp_s".to_owned(), Field::Number(since_s(stamp_ns, begin_ns)));
        let of = |(what, values): (&str, &Vec<f64>)| Some((what.to_owned(), Field::Number(*values.get(index)?)));
        let measured = [("position", &state.position), ("velocity", &state.velocity), ("effort", &state.effort)];
        Row { joint: Some(name), fields: std::iter::once(stamp).chain(measured.into_iter().filter_map(of)).collect() }
    };
    Ok(state.name.iter().take(MOST_ELEMENTS).cloned().enumerate().map(row).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn rows(text: &str) -> Vec<String> {
        let text_of = |field: &Field| match field {
            Field::Number(number) => format!("{number}"),
            Field::Text(text) => text.clone(),
        };
        let row = |row: Row| {
            let fields: Vec<String> =
                row.fields.iter().map(|(name, field)| format!("{name}={}", text_of(field))).collect();
            format!("{}: {}", row.joint.unwrap_or_default(), fields.join(" "))
        };
        json(text.as_bytes(), 1_000_000_000).unwrap().into_iter().map(row).collect()
    }

    #[test]
    fn json_of_any_form_becomes_rows() {
        let ros = r#"{"header": {"stamp": {"sec": 1, "nanosec": 500000000}, "frame_id": "base"},
                      "name": ["a", "b"], "position": [0.5, 1.5], "velocity": [], "effort": [2, 3]}"#;
        assert_eq!(
            rows(ros),
            [
                "a: position=0.5 effort=2 header.frame_id=base stamp_s=0.5",
                "b: position=1.5 effort=3 header.frame_id=base stamp_s=0.5"
            ]
        );
        let foxglove = r#"{"timestamp": {"sec": 3, "nsec": 0}, "joints": [{"name": "a", "position": 1, "effort": 2}]}"#;
        assert_eq!(rows(foxglove), ["a: effort=2 position=1 timestamp_s=2"]);
        let motor = r#"{"motor": {"pos_deg": 3.5, "on": true}, "axes": [1, 2], "state": "run"}"#;
        assert_eq!(rows(motor), [": axes[0]=1 axes[1]=2 motor.on=1 motor.pos_deg=3.5 state=run"]);
        assert_eq!(rows("4"), [": value=4"]);
        assert!(json(b"{\"a\": 1", 0).unwrap_err().starts_with("is not JSON"));
    }
}
