//! Messages in Protobuf, read by the descriptors that an MCAP file carries for them (the well-known encoding `protobuf` of its
//! specification), whatever version of a schema wrote them: Foxglove's joint states are arrays in one and objects in another.

use prost_reflect::{DescriptorPool, DynamicMessage, Kind, MessageDescriptor, ReflectMessage as _, Value as Read};
use serde_json::{Map, Value, json};

use super::message::{Row, rows_of};

/// The form of a message called `name` among the descriptors of a file (a `FileDescriptorSet`); none where they do not hold it.
pub(super) fn described(descriptors: &[u8], name: &str) -> Option<MessageDescriptor> {
    DescriptorPool::decode(descriptors).ok()?.get_message_by_name(name)
}

/// A message of that form.
///
/// # Errors
/// What is wrong with its bytes.
pub(super) fn rows(form: &MessageDescriptor, data: &[u8], begin_ns: u64) -> Result<Vec<Row>, String> {
    let message =
        DynamicMessage::decode(form.clone(), data).map_err(|error| format!("is no {}: {error}", form.full_name()))?;
    Ok(rows_of(&in_json(&message), begin_ns))
}

/// In JSON's terms: a time as seconds and nanoseconds, an enumeration by its name; nothing where a field was not set that may be.
fn in_json(message: &DynamicMessage) -> Value {
    let form = message.descriptor();
    if form.full_name() == "google.protobuf.Timestamp" {
        let part = |name: &str| {
            message.get_field_by_name(name).and_then(|value| value.as_i64().or(value.as_i32().map(i64::from)))
        };
        return json!({ "sec": part("seconds"), "nsec": part("nanos") });
    }
    let set = form.fields().filter(|field| !field.supports_presence() || message.has_field(field));
    let fields = set.map(|field| (field.name().to_owned(), value(&message.get_field(&field), &field.kind())));
    Value::Object(fields.collect::<Map<String, Value>>())
}

fn value(read: &Read, kind: &Kind) -> Value {
    match read {
        Read::Bool(flag) => Value::Bool(*flag),
        Read::I32(number) => Value::from(*number),
        Read::I64(number) => Value::from(*number),
        Read::U32(number) => Value::from(*number),
        Read::U64(number) => Value::from(*number),
        Read::F32(number) => Value::from(*number),
        Read::F64(number) => Value::from(*number),
        Read::String(text) => Value::String(text.clone()),
        Read::EnumNumber(number) => {
            let named = kind.as_enum().and_then(|names| names.get_value(*number));
            named.map_or_else(|| Value::from(*number), |value| Value::String(value.name().to_owned()))
        }
        Read::Message(message) => in_json(message),
        Read::List(values) => values.iter().map(|one| value(one, kind)).collect(),
        Read::Map(_) | Read::Bytes(_) => Value::Null,
    }
}
