//! MCAP: what is written opens elsewhere, what robots log is read, and a bad file is a message.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::Path;

use byteorder::{BigEndian, ByteOrder, LittleEndian};
use mcap::records::MessageHeader;
use recording::output::mark;
use recording::{AxisKind, Column, Given, MappedColumn, Mapping, Recording, Table, guess};

/// `sensor_msgs/msg/JointState`.
#[derive(serde::Serialize)]
struct JointState {
    sec: i32,
    nanosec: u32,
    frame_id: String,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

const BEGIN_NS: u64 = 1_700_000_000_000_000_000;

/// A robot of two joints, logged every 2 ms and 1 ms late, in CDR of either order of bytes.
fn robot<Order: ByteOrder>(second_byte: u8) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut file).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", b"").unwrap();
    let joints = writer.add_channel(schema, "/joint_states", "cdr", &BTreeMap::new()).unwrap();
    let image = writer.add_schema("sensor_msgs/msg/Image", "ros2msg", b"").unwrap();
    let camera = writer.add_channel(image, "/camera", "cdr", &BTreeMap::new()).unwrap();
    for tick in 0..50 {
        let ns = BEGIN_NS + tick * 2_000_000;
        let value = f64::from(u32::try_from(tick).unwrap());
        let state = JointState {
            sec: i32::try_from(ns / 1_000_000_000).unwrap(),
            nanosec: u32::try_from(ns % 1_000_000_000).unwrap(),
            frame_id: "base".to_owned(),
            name: vec!["shoulder".to_owned(), "elbow".to_owned()],
            position: vec![0.5 * value, -0.25 * value],
            velocity: Vec::new(),
            effort: vec![1.0, value],
        };
        let data = [vec![0, second_byte, 0, 0], cdr_encoding::to_vec::<_, Order>(&state).unwrap()].concat();
        let times = |channel_id| MessageHeader { channel_id, sequence: 0, log_time: ns + 1_000_000, publish_time: ns };
        writer.write_to_known_channel(&times(joints), &data).unwrap();
        writer.write_to_known_channel(&times(camera), &[0, 1, 0, 0, 7]).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

fn elbow() -> Mapping {
    let column = |column, name| MappedColumn::new(column, AxisKind::Rotary, name, "", None).unwrap();
    let columns = vec![
        column(Column::Time, "elbow.stamp_s"),
        column(Column::Position, "elbow.position"),
        column(Column::EffortCmd, "elbow.effort"),
    ];
    Mapping::new(columns, AxisKind::Rotary).unwrap()
}

fn read(bytes: &[u8]) -> Result<Recording, String> {
    Recording::from_bytes(Path::new("a.mcap"), bytes, AxisKind::Rotary, &elbow()).map_err(|error| error.to_string())
}

/// The records of a file and where each begins: what it is, its content.
fn records(bytes: &[u8]) -> Vec<(u8, &[u8])> {
    let mut rest = &bytes[8..bytes.len() - 8];
    let mut records = Vec::new();
    while let Some((kind, after)) = rest.split_first() {
        let (length, after) = after.split_at(8);
        let (body, after) = after.split_at(usize::try_from(LittleEndian::read_u64(length)).unwrap());
        records.push((*kind, body));
        rest = after;
    }
    records
}

/// The same file with its chunks packed.
fn packed(bytes: &[u8], name: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    const CHUNK: u8 = 6;
    let mut file = bytes[..8].to_vec();
    for (kind, body) in records(bytes) {
        let mut body = body.to_vec();
        if kind == CHUNK {
            // Times, size and sum of what is packed, an empty name, the packed size, content.
            let content = pack(&body[28 + 4 + 8..]);
            body.truncate(28);
            body.extend(u32::try_from(name.len()).unwrap().to_le_bytes());
            body.extend(name.as_bytes());
            body.extend((content.len() as u64).to_le_bytes());
            body.extend(content);
        }
        file.push(kind);
        file.extend((body.len() as u64).to_le_bytes());
        file.extend(body);
    }
    file.extend(&bytes[..8]);
    file
}

#[test]
fn a_written_recording_opens_by_the_readers_of_mcap() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    let text = "t_s,position_rad,torque_cmd_nm,mode,seq,note\n5,1e-3,2,off,7,x\n5.0005,2e-3,0.1,brake,8,y\n";
    fs::write(&file, text).unwrap();
    let recording = Recording::read(&file, None).unwrap();
    let file = folder.path().join("a.mcap");
    recording.write(&file).unwrap();
    assert!(mark::is_marked(&file).unwrap(), "it is replaced without --force");
    let bytes = fs::read(&file).unwrap();
    let messages: Vec<mcap::Message<'_>> = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap).collect();
    assert_eq!(messages.len(), 2);
    assert_eq!((messages[0].log_time, messages[1].log_time), (0, 500_000));
    let channel = &messages[1].channel;
    let schema = channel.schema.as_ref().unwrap();
    assert_eq!((channel.message_encoding.as_str(), schema.encoding.as_str()), ("json", "jsonschema"));
    let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
    assert_eq!((&schema["type"], &schema["properties"]["position_rad"]["type"]), (&"object".into(), &"number".into()));
    let row: serde_json::Value = serde_json::from_slice(&messages[1].data).unwrap();
    let expected = serde_json::json!({
        "t_s": 5.0005, "position_rad": 2e-3, "torque_cmd_nm": 0.1, "mode": "brake", "seq": 8, "note": "y"
    });
    assert_eq!(row, expected);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, 2);
    let back = Recording::read(&file, None).unwrap();
    assert_eq!(Recording { name: recording.name.clone(), ..back }, recording);
    assert_eq!(Table::read(&file).unwrap().column("position_rad").unwrap().1, [1e-3, 2e-3]);
}

#[test]
fn a_joint_of_a_robot_is_read_however_it_is_packed() {
    let plain = robot::<LittleEndian>(1);
    let recording = read(&plain).unwrap();
    assert_eq!((recording.rows(), recording.position[3], recording.effort_cmd[3]), (50, -0.75, 3.0));
    assert!((recording.t_s[49] - 0.098).abs() < 1e-9, "{}", recording.t_s[49]);
    assert_eq!(read(&robot::<BigEndian>(0)).unwrap(), recording);
    let zstd = |plain: &[u8]| ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest);
    assert_eq!(read(&packed(&plain, "zstd", zstd)).unwrap(), recording);
    let lz4 = |plain: &[u8]| {
        let mut packer = lz4_flex::frame::FrameEncoder::new(Vec::new());
        packer.write_all(plain).unwrap();
        packer.finish().unwrap()
    };
    assert_eq!(read(&packed(&plain, "lz4", lz4)).unwrap(), recording);
    let error = read(&packed(&plain, "snappy", <[u8]>::to_vec)).unwrap_err();
    assert_eq!(error, "a.mcap: its chunks are packed with `snappy`; known are zstd and lz4");
}

#[test]
fn the_joint_is_asked_for_with_the_list() {
    let table = Table::from_bytes(Path::new("a.mcap"), &robot::<LittleEndian>(1)).unwrap();
    let error = guess(&table, Given::default()).unwrap_err();
    assert!(error.ends_with("give --joint with one of `elbow`, `shoulder`"), "{error}");
    let (_, guesses) = guess(&table, Given { joint: Some("shoulder"), ..Given::default() }).unwrap();
    let names: Vec<&str> = guesses.iter().map(|guess| guess.mapped.name.as_str()).collect();
    let expected =
        ["/joint_states.shoulder.stamp_s", "/joint_states.shoulder.position", "/joint_states.shoulder.effort"];
    assert_eq!(names, expected, "the machine's own clock, not when it was logged");
}

#[test]
fn topics_that_are_not_read_are_named() {
    let mut file = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().compression(None).create(&mut file).unwrap();
    let schema = writer.add_schema("foxglove.JointStates", "protobuf", b"").unwrap();
    let channel_id = writer.add_channel(schema, "/joints", "protobuf", &BTreeMap::new()).unwrap();
    let header = MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, &[1]).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let error = read(&file.into_inner()).unwrap_err();
    assert_eq!(
        error,
        "a.mcap: it holds no messages in JSON or Protobuf and no sensor_msgs/JointState in CDR; it has `/joints` \
         (foxglove.JointStates in protobuf)",
        "a schema that does not describe it"
    );
}

#[test]
fn a_file_that_is_cut_short_or_damaged_is_a_message() {
    let whole = robot::<LittleEndian>(1);
    for length in 8..whole.len() {
        let error = read(&whole[..length]).unwrap_err();
        assert!(error.contains("or was cut short") && error.contains("mcap recover"), "{length}: {error}");
    }
    let mut right = 0;
    for place in 8..whole.len() {
        let mut bent = whole.clone();
        bent[place] ^= 0x55;
        // Either refused, or in what is not used.
        right += usize::from(read(&bent).is_ok_and(|recording| recording.position[3] == -0.75));
    }
    let (_, chunk) = records(&whole).into_iter().find(|(kind, _)| *kind == 6).unwrap();
    assert!(right <= whole.len() - chunk.len(), "the checksum tells damage within the chunk");
}
