//! Recordings as CSV: what is read, and that each kind of bad input is one message with file, line and column.

use std::fs;
use std::path::PathBuf;

use recording::{AxisKind, Mode, Recording};

fn read_as(name: &str, bytes: &[u8], axis: Option<AxisKind>) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    Recording::read(&file, axis).map_err(|error| {
        assert_eq!(error.exit_code(), 2);
        let message = error.to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
        message.replace(&format!("{}/", folder.path().display()), "")
    })
}

fn read(text: &str) -> Result<Recording, String> {
    read_as("a.csv", text.as_bytes(), None)
}

const HEADER: &str = "t_s,position_rad,torque_cmd_nm\n";

#[test]
fn every_known_column_finds_its_place() {
    let recording = read(
        "seq,t_s,reference_rad,position_rad,torque_cmd_nm,field_cmd_kv_mm,mode,velocity_rad_s,torque_meas_nm,\
         field_meas_kv_mm,temperature_c,fault,counts,note\n\
         7,0,0.5,-1e-3,0.25,1,off,2,3,4,25.5,0,-17,\"a, b\"\n\
         8,5e-4,0.5,0,0.5,3,brake,2,3,4,25.5,4294967295,18,\n",
    )
    .unwrap();
    assert_eq!(recording.name, "a.csv");
    assert_eq!(recording.axis, AxisKind::Rotary);
    assert_eq!(recording.t_s, [0.0, 5e-4]);
    assert_eq!(recording.position, [-1e-3, 0.0]);
    assert_eq!(recording.effort_cmd, [0.25, 0.5]);
    assert_eq!(recording.mode, Some(vec![Mode::Off, Mode::Brake]));
    assert_eq!(recording.seq, Some(vec![7, 8]));
    assert_eq!(recording.fault, Some(vec![0, u32::MAX]));
    assert_eq!(recording.counts, Some(vec![-17, 18]));
    assert_eq!(recording.extra, [("note".to_owned(), vec!["a, b".to_owned(), String::new()])]);
    assert!(recording.gaps.is_empty());
}

#[test]
fn a_byte_order_mark_and_windows_line_ends_are_read() {
    let recording = read("\u{feff}t_s,position_m,force_cmd_n\r\n0,1,2\r\n1,3,4\r\n").unwrap();
    assert_eq!(recording.axis, AxisKind::Linear);
    assert_eq!(recording.position, [1.0, 3.0]);
}

#[test]
fn unknown_columns_and_gaps_are_reported() {
    let recording =
        read("t_s,position_rad,torque_cmd_nm,torque_mes_nm,seq\n0,0,0,0,1\n1,0,0,0,2\n2,0,0,0,5\n").unwrap();
    assert_eq!(recording.gaps, [1]);
    assert_eq!(
        recording.notes(),
        [
            "a.csv: column `torque_mes_nm` is not one of the format and is not used; is `torque_meas_nm` meant?",
            "a.csv: rows are missing in 1 place, the first after row 2, 1.000 s after the start"
        ]
    );
}

#[test]
fn bad_rows_are_named_by_line_and_column() {
    let cases = [
        ("0,0,abc\n", "a.csv:2: torque_cmd_nm: `abc` is not a number"),
        ("0,0,1,5\n", "a.csv:2: the row has 4 cells where the header has 3"),
        ("0,,1\n", "a.csv:2: position_rad: the cell is empty"),
        ("0,0,0\n1,NaN,0\n", "a.csv:3: position_rad: NaN is not a finite number"),
        ("0,0,0\n1,0,-inf\n", "a.csv:3: torque_cmd_nm: -inf is not a finite number"),
        ("0,0,0\n1,0,1e999\n", "a.csv:3: torque_cmd_nm: inf is not a finite number"),
        ("0,0,0\n1,0,0\n0.5,0,0\n", "a.csv:4: t_s: time runs back from 1 to 0.5; a file must hold one run only"),
        ("0,0,0\n0,0,0\n", "a.csv:3: t_s: time 0 repeats"),
        ("0,0,0\nt_s,position_rad,torque_cmd_nm\n0,0,0\n", "a.csv:3: t_s: the header is repeated here"),
        ("0,0,0\n1,0\n", "a.csv:3: the row has 2 cells where the header has 3"),
        ("0,0,0\n1,0,0.12", "a.csv:3: the file ends within this line: it was cut short"),
        ("0,0,0\n\n1,0,x\n", "a.csv:4: torque_cmd_nm: `x` is not a number"),
        ("0,\"0,0\n1,0,0\n", "a.csv:2: the row has 2 cells where the header has 3"),
        ("0;0;0\n", "a.csv:2: the row has 1 cells where the header has 3"),
        ("0,1,1\u{a0}000\n", "a.csv:2: torque_cmd_nm: "),
    ];
    for (rows, expected) in cases {
        let message = read(&format!("{HEADER}{rows}")).expect_err(rows);
        assert!(message.starts_with(expected), "{rows:?} gave {message:?}");
    }
}

#[test]
fn lines_are_counted_as_an_editor_counts_them() {
    for (text, line) in [
        ("t_s,position_rad,torque_cmd_nm\r\n0,0,0\r\n1,0,x\r\n", 3),
        ("\n\r\nt_s,position_rad,torque_cmd_nm\n\n0,0,0\n\n\n1,0,x\n", 8),
        ("\u{feff}t_s,position_rad,torque_cmd_nm,note\n0,0,0,\"two\nlines\"\n1,0,x,\n", 4),
    ] {
        assert!(read(text).unwrap_err().starts_with(&format!("a.csv:{line}: torque_cmd_nm: `x`")), "{text:?}");
    }
}

#[test]
fn bad_words_and_whole_numbers_are_refused() {
    let cases = [
        ("mode", "dampr", "`dampr` is not a mode; allowed are off, damper, brake; is `damper` meant?"),
        ("mode", "Off", "`Off` is not a mode"),
        ("seq", "1.5", "`1.5` is not a whole number"),
        ("seq", "-1", "`-1` is not a whole number"),
        ("fault", "4294967296", "`4294967296` is not a whole number of this column's 32 bits"),
        ("counts", "0x10", "`0x10` is not a whole number"),
    ];
    for (column, cell, expected) in cases {
        let message = read(&format!("t_s,position_rad,torque_cmd_nm,{column}\n0,0,0,{cell}\n")).expect_err(cell);
        assert!(message.starts_with(&format!("a.csv:2: {column}: {expected}")), "{message}");
    }
    let message = read("t_s,position_rad,torque_cmd_nm,seq\n0,0,0,5\n1,0,0,4\n").unwrap_err();
    assert_eq!(message, "a.csv:3: seq: the sequence number runs back from 5 to 4; a file must hold one run only");
}

#[test]
fn files_without_a_recording_are_refused() {
    assert_eq!(read("").unwrap_err(), "a.csv: the file is empty");
    assert_eq!(read("\n\n").unwrap_err(), "a.csv: the file is empty");
    assert_eq!(read(HEADER).unwrap_err(), "a.csv:1: the file holds a header but no rows");
    assert!(read("t_s,position_rad\n").unwrap_err().starts_with("a.csv:1: torque_cmd_nm: required column is missing"));
    assert!(read_as("a.csv", b"\xff\xfet\0_\0", None).unwrap_err().contains("UTF-16 text"));
    let message = read_as("a.csv", &[HEADER.as_bytes(), b"0,\xff,1\n"].concat(), None).unwrap_err();
    assert_eq!(message, "a.csv:2: position_rad: `ÿ` is not a number", "no UTF-8 is read as text of Windows");
    let binary = read_as("a.csv", b"\x01\xff\x80\x02binary", None).unwrap_err();
    assert!(binary.starts_with("a.csv: is not of a known format; can be read: CSV"), "{binary}");
    assert_eq!(read_as("a.txt", b"", None).unwrap_err(), "a.txt: the file is empty");
    let message = Recording::read(&PathBuf::from("nowhere/a.csv"), None).unwrap_err().to_string();
    assert!(message.starts_with("nowhere/a.csv: cannot open: "), "{message}");
    let folder = tempfile::Builder::new().suffix(".csv").tempdir().unwrap();
    assert!(Recording::read(folder.path(), None).is_err(), "a folder is not a recording");
}

#[test]
fn the_axis_of_the_machine_must_be_that_of_the_recording() {
    let message = read_as("a.csv", format!("{HEADER}0,0,0\n").as_bytes(), Some(AxisKind::Linear)).unwrap_err();
    assert_eq!(message, "a.csv:1: position_rad: the column is of a rotary axis, but the axis of the machine is linear");
}
