//! Recordings as MCAP: JSON messages with a schema, which Foxglove, PlotJuggler and others open.

use std::collections::BTreeMap;
use std::io::Write;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapResult, WriteOptions};
use serde_json::{Map, Value, json};

use super::mark;
use crate::mcap_file::OWN_SCHEMA;
use crate::{Cells, Recording};

/// The topic of a recording.
const TOPIC: &str = "recording";

/// Writes the recording as one topic, with the mark of this tool as the library that wrote it; logged at `t_s` from the first
/// row on.
pub(super) fn write(recording: &Recording, to: impl Write) -> McapResult<()> {
    let columns = recording.columns();
    // A pipe cannot be sought in; chunks are kept in memory until they are full.
    let options = WriteOptions::new().compression(None).library(mark::WORDS).disable_seeking(true);
    let mut writer = options.create(NoSeek::new(to))?;
    let schema = writer.add_schema(OWN_SCHEMA, "jsonschema", schema(&columns).to_string().as_bytes())?;
    let channel_id = writer.add_channel(schema, TOPIC, "json", &BTreeMap::new())?;
    let begin_s = recording.t_s.first().copied().unwrap_or(0.0);
    for (row, t_s) in recording.t_s.iter().enumerate() {
        let fields: Map<String, Value> =
            columns.iter().map(|(name, cells)| ((*name).to_owned(), value(cells, row))).collect();
        // Time rises, so this is 0 or more.
        let time_ns = (1e9 * (t_s - begin_s)).round() as u64;
        let header = MessageHeader { channel_id, sequence: row as u32, log_time: time_ns, publish_time: time_ns };
        writer.write_to_known_channel(&header, Value::Object(fields).to_string().as_bytes())?;
    }
    writer.finish().map(drop)
}

fn schema(columns: &[(&str, Cells<'_>)]) -> Value {
    let kind = |cells: &Cells<'_>| match cells {
        Cells::Real(_) => "number",
        Cells::Seq(_) | Cells::Fault(_) | Cells::Counts(_) => "integer",
        Cells::Mode(_) | Cells::Text(_) => "string",
    };
    let properties: Map<String, Value> =
        columns.iter().map(|(name, cells)| ((*name).to_owned(), json!({ "type": kind(cells) }))).collect();
    json!({ "type": "object", "properties": properties })
}

fn value(cells: &Cells<'_>, row: usize) -> Value {
    match cells {
        Cells::Real(values) => json!(values[row]),
        Cells::Mode(values) => json!(values[row].name()),
        Cells::Seq(values) => json!(values[row]),
        Cells::Fault(values) => json!(values[row]),
        Cells::Counts(values) => json!(values[row]),
        Cells::Text(values) => json!(values[row]),
    }
}
