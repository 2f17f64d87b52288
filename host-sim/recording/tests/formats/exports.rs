//! CSV as other programs export it: titles, units, separators at the end of lines, quotes, blanks, text of Windows.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use recording::{AxisKind, Given, MapFlag, Mapping, Recording, Table, guess};

fn table(bytes: &[u8]) -> Result<Table, String> {
    Table::from_bytes(Path::new("a.csv"), bytes).map_err(|error| error.to_string())
}

/// The columns and what is read by them, as `init` and every later command do.
fn read(bytes: &[u8], flags: &[&str]) -> Result<(Vec<String>, Recording), String> {
    let flags: Vec<MapFlag> = flags.iter().map(|flag| flag.parse().unwrap()).collect();
    let (axis, guesses) = guess(&table(bytes)?, Given { flags: &flags, ..Given::default() })?;
    let columns = guesses.iter().map(|guess| guess.mapped.to_toml(axis)).collect();
    let mapping = Mapping::new(guesses.into_iter().map(|guess| guess.mapped).collect(), axis)?;
    let recording = Recording::from_bytes(Path::new("a.csv"), bytes, axis, &mapping);
    Ok((columns, recording.map_err(|error| error.to_string())?))
}

fn refused(bytes: &[u8], flags: &[&str]) -> String {
    read(bytes, flags).expect_err("must be refused")
}

/// What every export below holds.
fn holds(bytes: &[u8], flags: &[&str]) -> Vec<String> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let (columns, recording) = read(bytes, flags).unwrap_or_else(|error| panic!("{error}:\n{text}"));
    let close = |found: &[f64], expected: [f64; 3], factor: f64| {
        assert_eq!(found.len(), 3, "{text}");
        let close = |(one, other): (&f64, f64)| (one - factor * other).abs() < 1e-12;
        assert!(found.iter().zip(expected).all(close), "{found:?}, not {expected:?} x {factor}:\n{text}");
    };
    close(&recording.t_s, [0.0, 0.001, 0.002], 1.0);
    close(&recording.position, [0.5, 1.25, -2.0], 1f64.to_radians());
    close(&recording.effort_cmd, [0.1, 0.2, -0.3], 1.0);
    columns
}

const FLAGS: &[&str] = &["time=t:s", "position=pos:deg", "torque=i:A*1"];
const ROWS: &str = "0,0.5,0.1\n0.001,1.25,0.2\n0.002,-2,-0.3\n";

#[test]
fn lines_above_the_header_are_left_out() {
    for above in [
        "Bench 3\n",
        "Bench 3, axis 2\nOperator,Meyer\nSamples,3\n\n",
        "\"Exported \"\"today\"\"\"\r\nDate;2024-05-01\r\n",
        "Name,Value\nSample time,0.001\n,,\n",
        "# a comment\nBench 3\n# another\n",
    ] {
        holds(format!("{above}t,pos,i\n{ROWS}").as_bytes(), FLAGS);
        holds(format!("{above}t;pos;i\n{ROWS}").replace(',', ";").as_bytes(), FLAGS);
    }
    assert_eq!(table(format!("Bench 3\nOperator,Meyer\n\nt,pos,i\n{ROWS}").as_bytes()).unwrap().rows_above, 2);
    let bad = format!("Bench 3\n\nt,pos,i\n{ROWS}0.003,#N/A,1\n");
    assert_eq!(
        refused(bad.as_bytes(), FLAGS),
        "--map position=pos: the column holds cells that are no finite numbers, the first `#N/A` in line 7; mend the log, or give \
         another column"
    );
}

#[test]
fn rows_of_numbers_are_never_above_a_header() {
    for (text, line) in [
        ("t,pos,i\n0,1\nt,pos,i\n0,1,2\n1,2,3\n", 2),
        ("t,pos,i\n0\nt,pos,i\n0,1,2\n1,2,3\n", 2),
        ("t,pos\n0,1\nt,pos,i\n0,1,2\n1,2,3\n", 3),
        ("Bench\n0,1,2\nt,pos,i\n0,1,2\n", 2),
        ("t,pos,i\n0,1,2\nt,pos,i\nBench\n0,1,2\n1,2,3\n", 4),
    ] {
        let error = table(text.as_bytes()).unwrap_err();
        assert!(error.starts_with(&format!("a.csv:{line}: the row has ")), "{text:?} gave {error}");
    }
    let error = table(b"Bench\n0,1,2\n").unwrap_err();
    assert!(error.ends_with("lines above a header must begin with #, or hold no numbers"), "{error}");
}

#[test]
fn a_row_of_units_tells_the_units() {
    for units in ["s,deg,A", "[s],[deg],[A]", "s,\u{b0},A", "(s), (deg) ,A"] {
        let columns = holds(format!("t,pos,i\n{units}\n{ROWS}").as_bytes(), &["torque=i:A*1"]);
        assert!(columns[1].contains("unit = \"deg\"") || columns[1].contains("unit = \"\u{b0}\""), "{columns:?}");
    }
    // Units tell the kind of axis, and a flag says more than they do.
    let linear = "Slide\nts;pos;f\nms;mm;N\n0;1;2\n1;2;3\n";
    let (columns, recording) = read(linear.as_bytes(), &[]).unwrap();
    assert_eq!(recording.axis, AxisKind::Linear);
    assert_eq!(columns[1], r#"position = { name = "pos", unit = "mm" }"#);
    assert_eq!((recording.t_s[1], recording.position), (1e-3, vec![1e-3, 2e-3]));
    let (columns, _) = read(linear.as_bytes(), &["position=pos:cm"]).unwrap();
    assert_eq!(columns[1], r#"position = { name = "pos", unit = "cm" }"#);
    // Columns of the format have the units of their names.
    let own = |units: &str| {
        let text = format!("t_s,position_rad,torque_cmd_nm\n{units}\n0,1,2\n1,2,3\n");
        Recording::from_csv_bytes(Path::new("a.csv"), text.as_bytes(), None).map_err(|error| error.to_string())
    };
    assert_eq!(own("s,rad,Nm").unwrap().position, [1.0, 2.0]);
    assert!(own("s,deg,Nm").unwrap_err().starts_with("a.csv:2: position_rad: the row of units says `deg`"));
    // Names of groups of columns are a title.
    holds(format!("Clock,Motor,Motor\nt,pos,i\n{ROWS}").as_bytes(), FLAGS);
    // A row of other words is data that is wrong.
    assert!(refused(b"t,pos,i\nfoo,bar,baz\n0,1,2\n1,2,3\n", &[]).ends_with("`t` holds `foo` in line 2"));
}

#[test]
fn a_separator_at_the_end_of_lines_is_no_column() {
    let ended = ROWS.replace(',', ";").replace('\n', ";\n");
    holds(format!("t;pos;i;\n{ended}").as_bytes(), FLAGS);
    holds(format!("Bench;;;\nt;pos;i;\ns;deg;A;\n{ended}").as_bytes(), FLAGS);
    holds(format!("t;pos;i\n{ended}").as_bytes(), FLAGS);
    let error = table(format!("t;pos;i;\n{ended}0.003;1;2;3\n").as_bytes()).unwrap_err();
    assert_eq!(error, "a.csv:5: column 4 has no name, but holds a cell here");
    let error = table(format!("t;pos;i;\n{ended}0.003;1;2\n").as_bytes()).unwrap_err();
    assert!(error.starts_with("a.csv:5: the row has 3 cells where the header has 4"), "{error}");
}

#[test]
fn quoted_numbers_have_decimal_commas_where_that_is_certain() {
    let quoted = "t,pos,i\n0,\"0,5\",\"0,1\"\n\"0,001\",\"1,25\",\"0,2\"\n\"0,002\",-2,\"-0,3\"\n";
    holds(quoted.as_bytes(), FLAGS);
    // Thousands, or nobody knows.
    for (row, cell) in [("1,\"1,234\",3\n", "1,234"), ("1,\"1,234\",0.5\n", "1,234"), ("1,\"12,5\",0.5\n", "12,5")] {
        let error = read(format!("t_s,position_rad,torque_cmd_nm\n0,1,2\n{row}").as_bytes(), &[]).unwrap_err();
        assert!(error.contains(&format!("no finite numbers, the first `{cell}` in line 3")), "{error}");
        let own = Recording::from_csv_bytes(
            Path::new("a.csv"),
            format!("t_s,position_rad,torque_cmd_nm\n0,1,2\n{row}").as_bytes(),
            None,
        );
        let error = own.unwrap_err().to_string();
        assert!(error.ends_with("its comma may be a decimal one or of thousands: write a decimal point"), "{error}");
    }
}

#[test]
fn blanks_separate_cells_where_nothing_else_does() {
    let blanks = "  t   pos\ti\n 0      0.5   0.1\n 0.001  1.25  0.2  \n 0.002 -2    -0.3\n";
    let even = blanks.replace("0.2  \n", "0.2\n");
    holds(even.as_bytes(), FLAGS);
    holds(even.replace('.', ",").as_bytes(), FLAGS);
    holds(format!("Bench 3, run 2\n\n{even}").as_bytes(), FLAGS);
    holds(even.replace("pos\ti", "pos\ti\n   s deg  A").replace('\n', "\r\n").as_bytes(), FLAGS);
    // As numpy.savetxt writes it.
    let numpy = "# t pos i\n0.0e+00 5.0e-01 1.0e-01\n1.0e-03 1.25e+00 2.0e-01\n2.0e-03 -2.0e+00 -3.0e-01\n";
    holds(numpy.as_bytes(), FLAGS);
    let error = table(even.replace("0.2", "0.2 7").as_bytes()).unwrap_err();
    assert!(error.starts_with("a.csv:3: the row has 4 cells where the header has 3"), "{error}");
    let bad = even.replace("1.25", "#N/A");
    assert!(refused(bad.as_bytes(), FLAGS).contains("`#N/A` in line 3"), "{bad}");
}

#[test]
fn text_of_windows_is_read() {
    let text = format!("t,Winkel [\u{b0}],i\n{ROWS}");
    let windows: Vec<u8> = text.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect();
    assert!(std::str::from_utf8(&windows).is_err());
    assert_eq!(table(&windows).unwrap(), table(text.as_bytes()).unwrap());
    holds(&windows, &["torque=i:A*1"]);
}

#[test]
fn dates_and_bad_cells_are_told_with_their_line() {
    let dates = "timestamp,pos,torque\n2024-05-01T12:00:00.001,1,2\n2024-05-01T12:00:00.002,1,2\n";
    let error = refused(dates.as_bytes(), &[]);
    let first = "`timestamp` holds cells that are no finite numbers, the first `2024-05-01T12:00:00.001` in line 2, and is `time`";
    assert!(error.starts_with(first), "{error}");
    assert!(error.contains("dates are not read: add a column of seconds, in Python"), "{error}");
    assert!(refused(dates.as_bytes(), &["time=timestamp:s"]).contains("dates are not read"));
    for cell in ["nan", "#N/A", "", "inf"] {
        let text = format!("t,note,pos,torque\n0,x,1,2\n\n# pause\n1,y,{cell},2\n2,z,1,2\n");
        let error = refused(text.as_bytes(), &[]);
        assert!(
            error.starts_with(&format!("`pos` holds cells that are no finite numbers, the first `{cell}` in line 5")),
            "{error}"
        );
        assert!(!error.contains("dates"), "{error}");
    }
    assert_eq!(table(b"# x\nt,pos\n").unwrap_err(), "a.csv:2: the file holds a header but no rows");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("words.csv"), "t,pos\n").unwrap();
    let words = Table::words(&folder.path().join("words.csv")).unwrap();
    assert_eq!(words, [("t".to_owned(), vec![]), ("pos".to_owned(), vec![])], "a table of words may have no rows");
    let error = table(b"a,b\nx,y\n").unwrap_err();
    assert_eq!(error, "a.csv: the file holds no column of numbers: `a` holds `x` in line 2");
}

#[test]
fn bytes_of_no_format_are_refused_with_what_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["noise.csv", "noise.bin", "noise"] {
        let file = folder.path().join(name);
        let noise: Vec<u8> = (0..2000_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
        fs::write(&file, noise).unwrap();
        let error = Table::read(&file).unwrap_err().to_string();
        assert!(error.contains("is not of a known format; can be read: CSV"), "{error}");
    }
}

/// Pieces of exports, in any order.
fn piece() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("t,pos,i\n".to_owned()),
        Just("s,deg,A\n".to_owned()),
        Just("Bench 3\n".to_owned()),
        Just("\"".to_owned()),
        Just("# note\n".to_owned()),
        "[0-9]{1,3},[0-9],[0-9]{1,2}\n",
        "[0-9]{1,3};[0-9],[0-9];[0-9];\n",
        " [0-9]{1,3}  [0-9] [0-9]\n",
        "[\\x00-\\xff]{0,6}",
    ]
}

proptest! {
    #[test]
    fn any_export_is_a_table_or_a_message(pieces in prop::collection::vec(piece(), 0..12)) {
        let text = pieces.concat();
        if let Ok(table) = table(text.as_bytes()) {
            let rows = table.numbers[0].1.len();
            prop_assert!(table.numbers.iter().all(|(_, values)| values.len() == rows));
            prop_assert_eq!(table.units.len(), table.numbers.len());
        }
        let _ = read(text.as_bytes(), &[]);
    }

    /// Whatever is cut out of a file, no row of numbers before its end is left out.
    #[test]
    fn no_row_of_numbers_is_left_out(rows in 3..30_usize, cut in 0..30_usize, cells in 0..3_usize) {
        let mut text = String::from("t,pos,i\n");
        for row in 0..rows {
            let whole = format!("{row},1,2");
            let kept = if row == cut { whole.splitn(4, ',').take(cells).collect::<Vec<_>>().join(",") } else { whole };
            text += &format!("{kept}\n");
        }
        match table(text.as_bytes()) {
            // A row without cells is a blank line.
            Ok(table) => prop_assert_eq!(table.numbers[0].1.len(), rows - usize::from(cut < rows && cells == 0)),
            Err(error) => {
                let expected = format!("a.csv:{}: the row has {cells} cells", cut + 2);
                prop_assert!(error.starts_with(&expected), "{}", error);
            }
        }
    }
}
