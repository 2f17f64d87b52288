//! MCAP in Protobuf: joint states of Foxglove in the forms of its schemas, read by the descriptors in the file.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use mcap::records::MessageHeader;
use prost_reflect::prost::Message as _;
use prost_reflect::prost_types::field_descriptor_proto::{Label, Type};
use prost_reflect::prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, Value};
use recording::Table;

const BEGIN_NS: u64 = 1_700_000_000_000_000_000;

fn field(name: &str, number: i32, kind: Type, label: Label) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.to_owned()),
        number: Some(number),
        label: Some(label as i32),
        r#type: Some(kind as i32),
        ..FieldDescriptorProto::default()
    }
}

fn message_field(name: &str, number: i32, of: &str, label: Label) -> FieldDescriptorProto {
    FieldDescriptorProto { type_name: Some(of.to_owned()), ..field(name, number, Type::Message, label) }
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto { name: Some(name.to_owned()), field, ..DescriptorProto::default() }
}

fn file(name: &str, package: &str, message_type: Vec<DescriptorProto>) -> FileDescriptorProto {
    FileDescriptorProto {
        name: Some(name.to_owned()),
        package: Some(package.to_owned()),
        message_type,
        syntax: Some("proto3".to_owned()),
        ..FileDescriptorProto::default()
    }
}

/// Descriptors of a message `foxglove.State` of these fields, with what they refer to.
fn descriptors(fields: Vec<FieldDescriptorProto>) -> Vec<u8> {
    let timestamp = message(
        "Timestamp",
        vec![field("seconds", 1, Type::Int64, Label::Optional), field("nanos", 2, Type::Int32, Label::Optional)],
    );
    let optional = |name, number| FieldDescriptorProto {
        proto3_optional: Some(true),
        oneof_index: Some(number - 2),
        ..field(name, number, Type::Double, Label::Optional)
    };
    let mut joint = message(
        "Joint",
        vec![field("name", 1, Type::String, Label::Optional), optional("position", 2), optional("effort", 3)],
    );
    joint.oneof_decl = ["_position", "_effort"]
        .map(|name| prost_reflect::prost_types::OneofDescriptorProto { name: Some(name.to_owned()), options: None })
        .into();
    let mut own = file("state.proto", "foxglove", vec![message("State", fields), joint]);
    own.dependency = vec!["google/protobuf/timestamp.proto".to_owned()];
    let times = file("google/protobuf/timestamp.proto", "google.protobuf", vec![timestamp]);
    FileDescriptorSet { file: vec![times, own] }.encode_to_vec()
}

fn dynamic(form: &MessageDescriptor, fields: Vec<(&str, Value)>) -> DynamicMessage {
    let mut message = DynamicMessage::new(form.clone());
    fields.into_iter().for_each(|(name, value)| message.set_field_by_name(name, value));
    message
}

/// Ten messages, one every 2 ms, each logged 1 ms late.
fn log(descriptors: &[u8], fields: impl Fn(&DescriptorPool, f64) -> Vec<(&'static str, Value)>) -> Vec<u8> {
    let pool = DescriptorPool::decode(descriptors).unwrap();
    let of = |name: &str| pool.get_message_by_name(name).unwrap();
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut file).unwrap();
    let schema = writer.add_schema("foxglove.State", "protobuf", descriptors).unwrap();
    let channel_id = writer.add_channel(schema, "/joints", "protobuf", &BTreeMap::new()).unwrap();
    for tick in 0..10_u32 {
        let ns = BEGIN_NS + u64::from(tick) * 2_000_000;
        let seconds = Value::I64(i64::try_from(ns / 1_000_000_000).unwrap());
        let nanos = Value::I32(i32::try_from(ns % 1_000_000_000).unwrap());
        let stamp = dynamic(&of("google.protobuf.Timestamp"), vec![("seconds", seconds), ("nanos", nanos)]);
        let mut all = vec![("timestamp", Value::Message(stamp))];
        all.extend(fields(&pool, f64::from(tick)));
        let header = MessageHeader { channel_id, sequence: 0, log_time: ns + 1_000_000, publish_time: ns };
        let data = dynamic(&of("foxglove.State"), all).encode_to_vec();
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

/// The values of a column.
fn column(bytes: &[u8], name: &str) -> Option<Vec<f64>> {
    let table = Table::from_bytes(Path::new("a.mcap"), bytes).unwrap();
    table.column(name).map(|(_, values)| values.to_vec())
}

#[test]
fn joints_that_are_messages_are_read_by_their_names() {
    let descriptors = descriptors(vec![
        message_field("timestamp", 1, ".google.protobuf.Timestamp", Label::Optional),
        message_field("joints", 2, ".foxglove.Joint", Label::Repeated),
    ]);
    let bytes = log(&descriptors, |pool, value| {
        let joint = pool.get_message_by_name("foxglove.Joint").unwrap();
        let of = |name: &str, position: f64| {
            let fields = vec![("name", Value::String(name.to_owned())), ("position", Value::F64(position))];
            Value::Message(dynamic(&joint, fields))
        };
        vec![("joints", Value::List(vec![of("shoulder", 0.0), of("elbow", 0.5 * value)]))]
    });
    assert_eq!(column(&bytes, "/joints.elbow.position").unwrap()[..3], [0.0, 0.5, 1.0]);
    assert_eq!(column(&bytes, "/joints.elbow.effort"), None, "never set");
    let stamps_s = column(&bytes, "/joints.elbow.timestamp_s").unwrap();
    assert!((stamps_s[1] - stamps_s[0] - 0.002).abs() < 1e-9, "{stamps_s:?}");
}

#[test]
fn joints_that_are_arrays_are_read_by_their_names() {
    let descriptors = descriptors(vec![
        message_field("timestamp", 1, ".google.protobuf.Timestamp", Label::Optional),
        field("name", 2, Type::String, Label::Repeated),
        field("position", 3, Type::Double, Label::Repeated),
        field("effort", 5, Type::Double, Label::Repeated),
    ]);
    let bytes = log(&descriptors, |_, value| {
        let names = ["shoulder", "elbow"].map(|name| Value::String(name.to_owned()));
        let efforts = [1.0, value].map(Value::F64);
        let positions = [0.0, -0.25 * value].map(Value::F64);
        vec![
            ("name", Value::List(names.to_vec())),
            ("position", Value::List(positions.to_vec())),
            ("effort", Value::List(efforts.to_vec())),
        ]
    });
    assert_eq!(column(&bytes, "/joints.elbow.position").unwrap()[..3], [0.0, -0.25, -0.5]);
    assert_eq!(column(&bytes, "/joints.elbow.effort").unwrap()[..3], [0.0, 1.0, 2.0]);
}

#[test]
fn a_message_that_is_cut_short_is_told_with_its_form() {
    let descriptors = descriptors(vec![field("position", 3, Type::Double, Label::Repeated)]);
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut file).unwrap();
    let schema = writer.add_schema("foxglove.State", "protobuf", &descriptors).unwrap();
    let channel_id = writer.add_channel(schema, "/joints", "protobuf", &BTreeMap::new()).unwrap();
    let header = MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &[0x1a, 8, 0, 0]).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let error = Table::from_bytes(Path::new("a.mcap"), &file.into_inner()).unwrap_err().to_string();
    assert!(error.starts_with("a.mcap: a message of `/joints`: is no foxglove.State:"), "{error}");
}
