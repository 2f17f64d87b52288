//! MCAP: messages in JSON and Protobuf, and joint states of ROS 2 in CDR.
//!
//! A column is called after its topic and field, an element of an array with its index, a joint's with its name:
//! `/joint_states.elbow.position`. What this tool wrote keeps its own names. Two more columns tell the time, s since the first
//! message: `log_time_s`, when it was logged, and `stamp_s`, the machine's own clock, where messages have a `header.stamp`.

pub(crate) mod message;
mod protobuf;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use mcap::records::{Channel, ChunkHeader, Record, SchemaHeader};
use prost_reflect::MessageDescriptor;

use super::nearest::quoted;
use super::quiet;
use super::topics::{Field, Topic};
use crate::Error;
use message::Row;

/// The name of the schema of a recording this tool wrote.
pub(crate) const OWN_SCHEMA: &str = "servo_lab.Recording";
/// A chunk that unpacks to more is taken for a corrupt one, bytes; writers make chunks of some megabytes.
const MOST_CHUNK: u64 = 1 << 30;
/// Topics that are not read are listed up to this many.
const MOST_LISTED: usize = 8;

/// How the messages of a channel are written.
#[derive(Debug, Clone, PartialEq)]
enum Encoding {
    Json,
    /// As the schema in the file describes it.
    Protobuf(MessageDescriptor),
    /// Of a recording this tool wrote.
    Own,
    JointState,
}

/// Name of a message's form, and what describes it where that is in Protobuf's own terms.
#[derive(Debug)]
struct Schema {
    name: String,
    protobuf: Option<MessageDescriptor>,
}

#[derive(Debug, Default)]
struct Log {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, (String, Option<Encoding>)>,
    topics: BTreeMap<String, Topic>,
    /// When the first message was logged, ns.
    begin_ns: Option<u64>,
    /// Topics in an encoding that is not read.
    unread: Vec<String>,
}

/// The topics of an MCAP file.
pub(crate) fn read(file: &Path, bytes: &[u8]) -> Result<Vec<Topic>, Error> {
    // The crate panics on an attachment that is too short.
    let read = quiet::caught(|| records(bytes)).unwrap_or_else(|| Err(damaged("a record is too short")));
    read.and_then(Log::finish).map_err(|message| Error::input(file, None, "", message.replace('\n', " ")))
}

fn damaged(reason: impl std::fmt::Display) -> String {
    format!(
        "is not an MCAP file that can be read, or was cut short: {reason}; `mcap recover` saves what is whole of it"
    )
}

fn records(bytes: &[u8]) -> Result<Log, String> {
    let mut log = Log::default();
    for record in mcap::read::LinearReader::new(bytes).map_err(damaged)? {
        match record.map_err(damaged)? {
            Record::Chunk { header, data } => {
                let plain = unpacked(&header, &data)?;
                for record in mcap::read::LinearReader::sans_magic(&plain) {
                    log.take(record.map_err(damaged)?)?;
                }
            }
            record => log.take(record)?,
        }
    }
    Ok(log)
}

/// A chunk's content, checked. Unpacked here by ports to Rust: those the crate comes with are libraries in C.
fn unpacked<'a>(header: &ChunkHeader, data: &'a [u8]) -> Result<Cow<'a, [u8]>, String> {
    let read = |input: &mut dyn Read| {
        let mut plain = Vec::new();
        let most = header.uncompressed_size.min(MOST_CHUNK);
        input.take(most).read_to_end(&mut plain).map_err(|error| damaged(format!("a chunk: {error}")))?;
        Ok::<_, String>(Cow::Owned(plain))
    };
    let plain = match header.compression.as_str() {
        "" => Cow::Borrowed(data),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(Cursor::new(data));
            read(&mut decoder.map_err(|error| damaged(format!("a chunk: {error}")))?)?
        }
        "lz4" => read(&mut lz4_flex::frame::FrameDecoder::new(Cursor::new(data)))?,
        other => return Err(format!("its chunks are packed with {}; known are zstd and lz4", quoted(other))),
    };
    let mut sum = flate2::Crc::new();
    sum.update(&plain);
    let right = header.uncompressed_crc == 0 || header.uncompressed_crc == sum.sum();
    if plain.len() as u64 != header.uncompressed_size || !right {
        return Err(damaged("the checksum of a chunk is wrong"));
    }
    Ok(plain)
}

impl Log {
    fn take(&mut self, record: Record<'_>) -> Result<(), String> {
        match record {
            Record::Schema { header: SchemaHeader { id, name, encoding }, data } => {
                let protobuf = if encoding == "protobuf" { protobuf::described(&data, &name) } else { None };
                self.schemas.insert(id, Schema { name, protobuf });
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => {
                let begin_ns = *self.begin_ns.get_or_insert(header.log_time);
                let Some((topic, Some(encoding))) = self.channels.get(&header.channel_id) else { return Ok(()) };
                let rows = match encoding {
                    Encoding::Own => message::own(&data),
                    Encoding::Json => message::json(&data, begin_ns),
                    Encoding::Protobuf(form) => protobuf::rows(form, &data, begin_ns),
                    Encoding::JointState => message::joint_state(&data, begin_ns),
                };
                let wrong = |message: String| format!("a message of {}: {message}", quoted(topic));
                for Row { joint, mut fields } in rows.map_err(wrong)? {
                    let mut before = String::new();
                    if *encoding != Encoding::Own {
                        before = joint.map_or_else(|| topic.clone(), |joint| format!("{topic}.{joint}"));
                        fields.iter_mut().for_each(|(name, _)| *name = format!("{before}.{name}"));
                        let logged_s = message::since_s(header.log_time, begin_ns);
                        fields.push((format!("{before}.log_time_s"), Field::Number(logged_s)));
                    }
                    self.topics.entry(before).or_default().push(header.log_time, fields).map_err(wrong)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn channel(&mut self, Channel { id, schema_id, topic, message_encoding, .. }: Channel) {
        let schema = self.schemas.get(&schema_id);
        let protobuf = schema.and_then(|schema| schema.protobuf.clone());
        let schema = schema.map_or("", |schema| schema.name.as_str());
        let encoding = match message_encoding.as_str() {
            "json" if schema == OWN_SCHEMA => Some(Encoding::Own),
            "json" => Some(Encoding::Json),
            "cdr" if matches!(schema, "sensor_msgs/msg/JointState" | "sensor_msgs/JointState") => {
                Some(Encoding::JointState)
            }
            "protobuf" => protobuf.map(Encoding::Protobuf),
            _ => None,
        };
        let unread = format!("{} ({schema} in {message_encoding})", quoted(&topic));
        if encoding.is_none() && !self.unread.contains(&unread) {
            self.unread.push(unread);
        }
        self.channels.insert(id, (topic, encoding));
    }

    fn finish(self) -> Result<Vec<Topic>, String> {
        let mut topics: Vec<Topic> = self.topics.into_values().filter(|topic| !topic.columns.is_empty()).collect();
        if topics.is_empty() {
            let listed = self.unread.iter().take(MOST_LISTED).map(String::as_str).collect::<Vec<_>>().join(", ");
            let has = if listed.is_empty() { String::new() } else { format!("; it has {listed}") };
            return Err(format!("it holds no messages in JSON or Protobuf and no sensor_msgs/JointState in CDR{has}"));
        }
        topics.iter_mut().for_each(Topic::sort);
        Ok(topics)
    }
}
