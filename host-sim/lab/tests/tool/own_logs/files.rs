//! Logs as other machines and programs write them, of rows of time in s, position and effort.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use byteorder::LittleEndian;
use matrw::{MatFile, MatVariable, MatlabType, NumericArray, matvar};

/// A drive's export in a country with a decimal comma: ms, degrees, amperes of a motor with 0.12 N m/A.
pub fn csv(rows: &[[f64; 3]]) -> String {
    let mut text = String::from("Zeit [ms];Winkel [deg];Motor Current [A]\n");
    for [t_s, position, effort] in rows {
        let line = format!("{:.3};{:.4};{:.5}", 1e3 * t_s, position.to_degrees(), effort / 0.12);
        writeln!(text, "{}", line.replace('.', ",")).unwrap();
    }
    text
}

/// `sensor_msgs/msg/JointState` of ROS 2.
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

/// A robot as ROS 2 logs it: the elbow as given, and a wrist that rests.
pub fn write_mcap(file: &Path, rows: &[[f64; 3]]) {
    let options = mcap::WriteOptions::new().compression(None);
    let mut writer = options.create(fs::File::create(file).unwrap()).unwrap();
    let schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", b"").unwrap();
    let channel_id = writer.add_channel(schema, "/joint_states", "cdr", &BTreeMap::new()).unwrap();
    for [t_s, position, effort] in rows {
        let ns = 1_700_000_000_000_000_000 + (t_s * 1e9).round() as u64;
        let state = JointState {
            sec: (ns / 1_000_000_000) as i32,
            nanosec: (ns % 1_000_000_000) as u32,
            frame_id: "base".to_owned(),
            name: vec!["elbow".to_owned(), "wrist".to_owned()],
            position: vec![*position, 0.3],
            velocity: Vec::new(),
            effort: vec![*effort, 0.0],
        };
        let data = [vec![0, 1, 0, 0], cdr_encoding::to_vec::<_, LittleEndian>(&state).unwrap()].concat();
        // The host logs late and unevenly.
        let log_time = ns + 1_000_000 + ns / 7 % 200_000;
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time: ns };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
}

/// A linear axis as a script of MATLAB saves it: ms, mm, N, in a structure.
pub fn write_mat(file: &Path, rows: &[[f64; 3]]) {
    let vector = |index: usize, factor: f64| {
        let values: Vec<f64> = rows.iter().map(|row| factor * row[index]).collect();
        let numbers = NumericArray::new(vec![values.len(), 1], MatlabType::F64(values), None);
        MatVariable::NumericArray(numbers.unwrap())
    };
    let run = matvar!({ time_ms: vector(0, 1e3), pos_mm: vector(1, 1e3), force_N: vector(2, 1.0) });
    let mut mat = MatFile::new();
    mat.insert("run", run);
    matrw::save_matfile_v7(file.to_str().unwrap(), mat, true).unwrap();
}
