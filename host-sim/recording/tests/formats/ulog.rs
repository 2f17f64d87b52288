//! ULog of PX4: what is logged becomes columns, and a bad file is a message.

use std::path::Path;

use recording::{Column, Given, Table, guess};

fn message(kind: u8, content: &[u8]) -> Vec<u8> {
    let size = u16::try_from(content.len()).unwrap().to_le_bytes();
    [&size[..], &[kind], content].concat()
}

/// As https://docs.px4.io/main/en/dev_log/ulog_file_format.html has it: header, flags, format, subscription, rows.
fn log() -> Vec<u8> {
    let mut log = b"ULog\x01\x12\x35\x01".to_vec();
    log.extend(0_u64.to_le_bytes());
    log.extend(message(b'B', &[0; 40]));
    log.extend(message(b'F', b"servo:uint64_t timestamp;float position;float torque;int16_t[2] raw;"));
    log.extend(message(b'A', b"\x00\x07\x00servo"));
    for row in 0..4_u8 {
        let mut data = 7_u16.to_le_bytes().to_vec();
        data.extend((1_000_000 + 2000 * u64::from(row)).to_le_bytes());
        data.extend((0.5 * f32::from(row)).to_le_bytes());
        data.extend((-f32::from(row)).to_le_bytes());
        data.extend([row, 0, 0xff, 0xff]);
        log.extend(message(b'D', &data));
    }
    log
}

#[test]
fn what_is_logged_becomes_columns() {
    let table = Table::from_bytes(Path::new("a.ulg"), &log()).unwrap();
    assert_eq!(table.column("servo.timestamp_us").unwrap().1, [1e6, 1.002e6, 1.004e6, 1.006e6]);
    assert_eq!(table.column("servo.torque").unwrap().1, [0.0, -1.0, -2.0, -3.0]);
    assert_eq!(table.column("servo.raw[1]").unwrap().1, [-1.0; 4]);
    let (_, guesses) = guess(&table, Given::default()).unwrap();
    let names: Vec<_> = guesses.iter().map(|guess| (guess.mapped.column, guess.mapped.unit.as_str())).collect();
    assert_eq!(names, [(Column::Time, "us"), (Column::Position, "rad"), (Column::EffortCmd, "N m")]);
}

#[test]
fn a_file_that_is_cut_short_or_damaged_is_a_message() {
    let whole = log();
    let row = message(b'D', &[0; 22]).len();
    for length in 7..whole.len() {
        let read = Table::from_bytes(Path::new("a.ulg"), &whole[..length]);
        // Between two messages a file ends as any.
        assert!(read.is_err() || (whole.len() - length).is_multiple_of(row), "{length}");
    }
    for place in 7..whole.len() {
        let mut bent = whole.clone();
        bent[place] ^= 0xa5;
        drop(Table::from_bytes(Path::new("a.ulg"), &bent));
    }
}
