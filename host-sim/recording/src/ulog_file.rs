//! ULog of PX4: a topic for each message that is logged, its fields as columns: `actuator_motors.control[0]`.
//!
//! Times are `timestamp_us`, of the vehicle's clock. A second instance of a message is `name[1]`.

use std::collections::BTreeMap;
use std::path::Path;

use px4_ulog::full_parser::FlattenedFieldType;
use px4_ulog::stream_parser::{DataMessage, LittleEndianParser, LogParser};

use super::quiet;
use super::topics::{Field, Topic};
use crate::Error;

/// The topics of a ULog.
pub(crate) fn read(file: &Path, bytes: &[u8]) -> Result<Vec<Topic>, Error> {
    // The crate asserts on some damaged files.
    let read = quiet::caught(|| topics(bytes)).unwrap_or_else(|| Err(damaged("damaged data")));
    read.map_err(|message| Error::input(file, None, "", message.replace('\n', " ")))
}

fn damaged(reason: impl std::fmt::Display) -> String {
    format!("is not a ULog that can be read, or was cut short: {reason}")
}

fn topics(bytes: &[u8]) -> Result<Vec<Topic>, String> {
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    let mut wrong = None;
    let mut take = |message: &DataMessage<'_>| {
        if wrong.is_none() {
            wrong = row(message, &mut topics).err();
        }
    };
    let mut parser = LogParser::default();
    parser.set_data_message_callback(&mut take);
    parser.consume_bytes(bytes).map_err(damaged)?;
    if parser.has_leftover() || !parser.header_complete() {
        return Err(damaged("it ends within a message"));
    }
    drop(parser);
    if let Some(wrong) = wrong {
        return Err(wrong);
    }
    let mut topics: Vec<Topic> = topics.into_values().collect();
    if topics.is_empty() {
        return Err("it holds no messages with a timestamp".to_owned());
    }
    topics.iter_mut().for_each(Topic::sort);
    Ok(topics)
}

fn row(message: &DataMessage<'_>, topics: &mut BTreeMap<u16, Topic>) -> Result<(), String> {
    let format = message.flattened_format;
    let Some(timestamp) = &format.timestamp_field else { return Ok(()) };
    let too_short = || damaged(format!("a message {} is too short", format.message_name));
    let us: u64 = number(message.data, timestamp.offset).ok_or_else(too_short)?;
    let before = match message.multi_id.value() {
        0 => format.message_name.clone(),
        instance => format!("{}[{instance}]", format.message_name),
    };
    let mut fields = vec![(format!("{before}.timestamp_us"), Field::Number(us as f64))];
    for field in format.fields.iter().filter(|field| field.offset != timestamp.offset) {
        let value = real(message.data, field.offset, &field.field_type).ok_or_else(too_short)?;
        fields.push((format!("{before}.{}", field.flattened_field_name), Field::Number(value)));
    }
    let wrong = |message: String| format!("{before} {message}");
    topics.entry(message.msg_id).or_default().push(us.saturating_mul(1000), fields).map_err(wrong)
}

/// The number at `offset`; none behind the end.
fn number<T: LittleEndianParser>(data: &[u8], offset: u16) -> Option<T> {
    let bytes = data.get(usize::from(offset)..)?.get(..size_of::<T>())?;
    Some(T::parse(bytes))
}

fn real(data: &[u8], offset: u16, kind: &FlattenedFieldType) -> Option<f64> {
    Some(match kind {
        FlattenedFieldType::Int8 => number::<i8>(data, offset)?.into(),
        FlattenedFieldType::UInt8 | FlattenedFieldType::Bool | FlattenedFieldType::Char => {
            number::<u8>(data, offset)?.into()
        }
        FlattenedFieldType::Int16 => number::<i16>(data, offset)?.into(),
        FlattenedFieldType::UInt16 => number::<u16>(data, offset)?.into(),
        FlattenedFieldType::Int32 => number::<i32>(data, offset)?.into(),
        FlattenedFieldType::UInt32 => number::<u32>(data, offset)?.into(),
        FlattenedFieldType::Int64 => number::<i64>(data, offset)? as f64,
        FlattenedFieldType::UInt64 => number::<u64>(data, offset)? as f64,
        FlattenedFieldType::Float => number::<f32>(data, offset)?.into(),
        FlattenedFieldType::Double => number::<f64>(data, offset)?,
    })
}
