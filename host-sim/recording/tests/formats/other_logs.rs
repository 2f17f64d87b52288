//! Logs of other machines: separators, decimal commas, packed files, and columns that a machine file names.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use recording::{AxisKind, Error, Machine, Recording};

const PLANT: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 1e-3\nresolution = 0.0\n\
                     [plant]\ninertia = 1.0\n";
const COLUMNS: &str = "[columns]\ntime = { name = \"ts\", unit = \"us\" }\n\
                       position = { name = \"enc\", unit = \"counts(3600)\" }\n\
                       torque = { name = \"i\", unit = \"A\", scale = -0.5 }\n";

fn machine(columns: &str) -> Result<Machine, Error> {
    Machine::from_bytes(Path::new("m.toml"), format!("{PLANT}{columns}").as_bytes())
}

fn read(name: &str, bytes: &[u8], machine: &Machine) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    fs::write(&file, bytes).unwrap();
    Recording::of(&file, machine)
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-12), "{found:?}, not {expected:?}");
}

#[test]
fn a_machine_file_names_columns_units_and_scales() {
    let machine = machine(COLUMNS).unwrap();
    let log = "note;ts;enc;i\nfoo;1000000;10;1,5\nbar;1001000;20;-2\n";
    let recording = read("a.csv", log.as_bytes(), &machine).unwrap();
    assert_eq!(recording.axis, AxisKind::Rotary);
    close(&recording.t_s, &[0.0, 1e-3]);
    close(&recording.position, &[10f64.to_radians() / 10.0, 20f64.to_radians() / 10.0]);
    close(&recording.effort_cmd, &[-0.75, 1.0]);
    assert!(recording.extra.is_empty(), "columns that are not named are not read");
    // Tabs, quotes, a decimal point, Windows' line ends.
    let tabs = "\"ts\"\tenc\ti\r\n1000000\t10\t1.5\r\n1001000\t20\t-2\r\n";
    assert_eq!(read("a.csv", tabs.as_bytes(), &machine).unwrap(), recording);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(log.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    let unpacked = read("a.csv.gz", &packed, &machine).unwrap();
    assert_eq!(unpacked.effort_cmd, recording.effort_cmd);
    let error = read("a.csv.gz", &packed[..packed.len() - 9], &machine).unwrap_err();
    assert!(error.starts_with("a.csv.gz: cannot open: the gzip file is damaged or cut short"), "{error}");
    // What this tool writes has its own columns.
    let own = read("b.csv", b"t_s,position_rad,torque_cmd_nm\n0,1,2\n", &machine).unwrap();
    assert_eq!((own.position, own.effort_cmd), (vec![1.0], vec![2.0]));
}

#[test]
fn what_is_wrong_with_a_log_is_named() {
    let machine = machine(COLUMNS).unwrap();
    let error = read("a.csv", b"ts;encoder;i\n0;0;0\n", &machine).unwrap_err();
    assert_eq!(
        error,
        "a.csv:1: enc: column is missing, which [columns] of the machine file names as `position`; the file has `ts`, `encoder`, `i`"
    );
    let error = read("a.csv", b"ts;enc;i\n0;0;1.000,5\n", &machine).unwrap_err();
    assert_eq!(error, "a.csv:2: i: `1.000,5` is not a number");
    let error = read("a.bin", b"\x01\x02\x03\0\0\0", &machine).unwrap_err();
    assert!(error.starts_with("a.bin: is not of a known format; can be read: CSV"), "{error}");
    let error = read("a.xlsx", b"PK\x03\x04\0\0\0", &machine).unwrap_err();
    assert!(
        error.starts_with("a.xlsx: is a ZIP archive or a spreadsheet; unpack it, or save the sheet as CSV"),
        "{error}"
    );
    let error = read("a.mcap", b"\x89MCAP0\r\n\x01\xff\xff", &machine).unwrap_err();
    assert!(error.starts_with("a.mcap: is not an MCAP file that can be read, or was cut short"), "{error}");
    let error = read("a.mat", b"MATLAB 7.3 MAT-file, Platform", &machine).unwrap_err();
    assert!(error.starts_with("a.mat: is not an HDF5 file that can be read, or was cut short"), "{error}");
    let error = read("a.mat", b"MATLAB 5.0 MAT-file, cut", &machine).unwrap_err();
    assert!(error.starts_with("a.mat: is not a .mat file that can be read, or was cut short"), "{error}");
}

#[test]
fn what_is_wrong_with_columns_is_named() {
    for (columns, message) in [
        ("[columns]\ntime = { name = \"t\" }\n", "columns.position: is missing; [columns] must have"),
        (
            "[columns]\ntime = { name = \"t\" }\nposition = { name = \"q\", unit = \"mm\" }\n",
            "`mm` is not a unit of `position` on a rotary axis; allowed are",
        ),
        (
            "[columns]\ntime = { name = \"t\" }\nposition = { name = \"q\" }\ntorque = { name = \"i\", unit = \"A\" }\n",
            "`A` needs a scale: how many N m one A makes",
        ),
        ("[columns]\ntme = { name = \"t\" }\n", "columns.tme: unknown key; the nearest key is `time`"),
        ("[columns]\ntime = \"t\"\n", "columns.time: `t` is not allowed; must be a section"),
    ] {
        let error = machine(columns).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_machine_with_columns_reads_back() {
    let machine = machine(COLUMNS).unwrap();
    let text = machine.to_toml().unwrap();
    assert_eq!(Machine::from_bytes(Path::new("m.toml"), text.as_bytes()).unwrap(), machine, "{text}");
}

const BY_NUMBER: &str = "[columns]\ntime = { name = \"[1]\" }\nposition = { name = \"[3]\", wrap = 25.0 }\n\
                         torque = { name = \"[2]\" }\n";

#[test]
fn columns_without_a_header_have_numbers() {
    let machine = machine(BY_NUMBER).unwrap();
    let recording = read("a.txt", b"0;1,5;12\n0,001;2,5;-12,5\n", &machine).unwrap();
    close(&recording.effort_cmd, &[1.5, 2.5]);
    close(&recording.position, &[12.0, 12.5]);
    let table = recording::Table::from_bytes(Path::new("a.txt"), b"0,1\n1,2\n").unwrap();
    assert_eq!(table.numbers, [("[1]".to_owned(), vec![0.0, 1.0]), ("[2]".to_owned(), vec![1.0, 2.0])]);
    let error = read("a.csv", b"0,1\n0.001,2\n", &machine).unwrap_err();
    assert!(error.contains("[3]: column is missing") && error.contains("names as `position`"), "{error}");
    let error = Recording::from_csv_bytes(Path::new("a.csv"), b"0,1,2\n1,2,3\n", None).unwrap_err().to_string();
    assert!(error.contains("header row is missing") && error.contains("--map position=[2]:rad"), "{error}");
    // Its machine file reads back.
    let again = Machine::from_bytes(Path::new("m.toml"), machine.to_toml().unwrap().as_bytes()).unwrap();
    assert_eq!(again.columns, machine.columns);
}

#[test]
fn rows_without_a_time_are_evenly_apart() {
    let machine = machine(
        "[columns]\ntime = { name = \"[0]\", unit = \"ms\", scale = 5.0 }\nposition = { name = \"q\" }\n\
         torque = { name = \"tau\" }\n",
    )
    .unwrap();
    for (name, log) in [
        ("a.csv", "q,tau\n0,1\n0.5,2\n1,1\n"),
        ("a.json", r#"[{"q":0,"tau":1},{"q":0.5,"tau":2},{"q":1,"tau":1}]"#),
        // A column of the log of that name is the time.
        ("b.csv", "[0],q,tau\n10,0,1\n11,0.5,2\n12,1,1\n"),
    ] {
        let recording = read(name, log.as_bytes(), &machine).unwrap();
        close(&recording.t_s, &[0.0, 0.005, 0.010]);
        close(&recording.position, &[0.0, 0.5, 1.0]);
    }
    // Logs that servo-lab writes keep their own time.
    let own = read("c.csv", b"t_s,position_rad,torque_cmd_nm\n0,0,1\n0.001,1,2\n", &machine).unwrap();
    close(&own.t_s, &[0.0, 0.001]);
}

#[test]
fn a_name_that_is_there_twice_is_told_apart_by_its_column() {
    let log = "ts,,enc,i,status,status\n1000000,7,10,1.5,0,1\n1001000,7,20,-2,0,1\n";
    let recording = read("a.csv", log.as_bytes(), &machine(COLUMNS).unwrap()).unwrap();
    close(&recording.effort_cmd, &[-0.75, 1.0]);
    let twice = COLUMNS.replace("\"enc\"", "\"enc (column 3)\"");
    let log = "ts,enc,enc,i\n1000000,9,10,1.5\n1001000,9,20,-2\n";
    let recording = read("a.csv", log.as_bytes(), &machine(&twice).unwrap()).unwrap();
    close(&recording.position, &[10f64.to_radians() / 10.0, 20f64.to_radians() / 10.0]);
    let error = read("a.csv", log.as_bytes(), &machine(COLUMNS).unwrap()).unwrap_err();
    assert!(error.contains("enc: column is missing") && error.contains("`enc (column 2)`"), "{error}");
}

#[test]
fn comments_are_left_out_and_the_last_may_name_the_columns() {
    let machine = machine(COLUMNS).unwrap();
    let log = "# Bench 3, 24 V\n#ts\tenc\ti\n1000000\t10\t1.5\n# here it was pushed\n1001000\t20\t-2\n";
    let recording = read("a.txt", log.as_bytes(), &machine).unwrap();
    close(&recording.effort_cmd, &[-0.75, 1.0]);
    // A header below a comment.
    let log = "# a note\nts,enc,i\n1000000,10,1.5\n# x\n1001000,20,z\n";
    let error = read("a.txt", log.as_bytes(), &machine).unwrap_err();
    assert!(error.contains("a.txt:5: i: `z` is not a number"), "{error}");
    // A comment with another count of words names nothing.
    let table = recording::Table::from_bytes(Path::new("a.txt"), b"# a, b, c\n0,1\n1,2\n").unwrap();
    assert_eq!(table.numbers[1].0, "[2]");
}

#[test]
fn arrays_of_numpy_are_refused_with_what_to_do() {
    let machine = machine(COLUMNS).unwrap();
    let error = read("a.npz", b"PK\x03\x04\x2d\0\0\0\0\0\0\0\0\0\0\0", &machine).unwrap_err();
    assert!(error.contains("is an archive of NumPy arrays") && error.contains("numpy.load"), "{error}");
    let error = read("a.npy", b"\x93NUMPY\x01\0\0\0\0\0\0\0\0\0", &machine).unwrap_err();
    assert!(error.contains("is an array of NumPy"), "{error}");
}
