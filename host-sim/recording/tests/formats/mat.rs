//! MATLAB files of other programs: vectors, matrices, structures, packed and not; a bad file is a message.

use std::fs;
use std::path::Path;

use matrw::{MatFile, MatVariable, MatlabType, NumericArray, matvar};
use recording::{AxisKind, Column, Error, Given, Mapping, Recording, Table, guess};

fn matrix(rows: usize, columns: usize, values: MatlabType) -> MatVariable {
    MatVariable::NumericArray(NumericArray::new(vec![rows, columns], values, None).unwrap())
}

fn written(mat: MatFile, packed: bool) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mat");
    matrw::save_matfile_v7(file.to_str().unwrap(), mat, packed).unwrap();
    fs::read(file).unwrap()
}

fn read(bytes: &[u8]) -> Result<Table, String> {
    Table::from_bytes(Path::new("a.mat"), bytes).map_err(|error: Error| error.to_string())
}

fn column<'a>(table: &'a Table, name: &str) -> &'a [f64] {
    table.column(name).unwrap_or_else(|| panic!("{name} is not there: {:?}", table.numbers)).1
}

/// Vectors, a matrix, whole numbers, text, a number alone.
fn vectors(packed: bool) -> Vec<u8> {
    let mut mat = MatFile::new();
    mat.insert("t", matrix(3, 1, MatlabType::F64(vec![0.0, 0.5, 1.0])));
    mat.insert("pos_mm", matrix(1, 3, MatlabType::F32(vec![1.5, -2.5, 3.5])));
    mat.insert("counts", matrix(3, 1, MatlabType::I32(vec![-70_000, 0, 70_000])));
    mat.insert("log", matrix(3, 2, MatlabType::F64(vec![0.25, 1.25, 2.25, 10.0, 20.0, 30.0])));
    mat.insert("gain", matvar!(4.0));
    mat.insert("comment", matvar!("step 3"));
    written(mat, packed)
}

#[test]
fn vectors_and_columns_of_matrices_are_columns() {
    for packed in [false, true] {
        let table = read(&vectors(packed)).unwrap();
        assert_eq!(column(&table, "t"), [0.0, 0.5, 1.0]);
        assert_eq!(column(&table, "pos_mm"), [1.5, -2.5, 3.5]);
        assert_eq!(column(&table, "counts"), [-70_000.0, 0.0, 70_000.0]);
        assert_eq!(column(&table, "log[2]"), [10.0, 20.0, 30.0]);
        assert_eq!(table.numbers.len(), 5, "neither text nor a number alone: {:?}", table.numbers);
    }
}

#[test]
fn structures_are_names_with_dots() {
    let inner = matvar!({ pos: matrix(2, 1, MatlabType::F64(vec![0.1, 0.2])), u: matrix(2, 1, MatlabType::F64(vec![1.0, 2.0])) });
    let run = matvar!({ time: matrix(2, 1, MatlabType::F64(vec![0.0, 0.001])), motor: inner });
    let mut mat = MatFile::new();
    mat.insert("run", run);
    let table = read(&written(mat, true)).unwrap();
    assert_eq!(column(&table, "run.time"), [0.0, 0.001]);
    assert_eq!(column(&table, "run.motor.u"), [1.0, 2.0]);
    let (axis, guesses) = guess(&table, Given::default()).unwrap();
    let names: Vec<_> = guesses.iter().map(|guess| (guess.mapped.column, guess.mapped.name.as_str())).collect();
    let expected =
        [(Column::Time, "run.time"), (Column::Position, "run.motor.pos"), (Column::EffortCmd, "run.motor.u")];
    assert_eq!((axis, names.as_slice()), (AxisKind::Rotary, &expected[..]));
}

#[test]
fn vectors_of_other_lengths_are_told() {
    let mut mat = MatFile::new();
    mat.insert("t_s", matrix(3, 1, MatlabType::F64(vec![0.0, 0.5, 1.0])));
    mat.insert("position_rad", matrix(3, 1, MatlabType::F64(vec![0.0, 0.1, 0.2])));
    mat.insert("torque_cmd_nm", matrix(2, 1, MatlabType::F64(vec![1.0, 2.0])));
    let bytes = written(mat, false);
    let error = Recording::from_bytes(Path::new("a.mat"), &bytes, AxisKind::Rotary, &Mapping::default()).unwrap_err();
    assert_eq!(error.to_string(), "a.mat: torque_cmd_nm: it has 2 rows, but the position has 3");
}

/// Written by SciPy 1.x: `savemat('scipy.mat', {'log': {'t': t, 'angle_deg': a, 'current': i}, 'T': 3.0}, do_compression=True)`
/// with five rows; its header is not quite MATLAB's.
#[test]
fn a_structure_of_scipy_is_read() {
    let table = Table::read(Path::new("tests/data/scipy.mat")).unwrap();
    assert_eq!(column(&table, "log.t"), [0.0, 0.001, 0.002, 0.003, 0.004]);
    assert_eq!(column(&table, "log.angle_deg"), [0.0, 1.5, 3.0, 4.5, 6.0]);
    assert_eq!(column(&table, "log.current"), [-1.0, -1.0, 0.0, 1.0, 1.0]);
}

#[test]
fn a_file_that_is_cut_short_or_damaged_is_a_message() {
    let whole = vectors(false);
    let mut shorter = 0;
    for length in 16..whole.len() {
        match read(&whole[..length]) {
            Err(error) => {
                assert!(error.contains("or was cut short") || error.contains("holds no vectors"), "{length}: {error}")
            }
            // Between two variables a file ends as any.
            Ok(_) => shorter += 1,
        }
    }
    assert!(shorter < 6, "{shorter} lengths are read, there are six variables");
    for bytes in [whole, vectors(true)] {
        for place in 16..bytes.len() {
            let mut bent = bytes.clone();
            bent[place] ^= 0xa5;
            drop(read(&bent));
        }
    }
    let packed = vectors(true);
    let error = read(&packed[..packed.len() - 5]).unwrap_err();
    assert!(error.contains("or was cut short"), "{error}");
}

/// An element: type, size, bytes padded to eight.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut element = [kind.to_le_bytes(), u32::try_from(data.len()).unwrap().to_le_bytes()].concat();
    element.extend(data);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}

#[test]
fn structures_without_fields_are_none_however_many_are_claimed() {
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let (flags, dimensions) = (element(6, &words(&[2, 0])), element(5, &words(&[u32::MAX, u32::MAX >> 1])));
    // Names of 32 bytes each, and five bytes of them.
    let fields = [element(5, &words(&[32])), element(1, b"field")].concat();
    let content = [flags, dimensions, element(1, b"run"), fields].concat();
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend(b"\0\x01IM");
    file.extend(element(14, &content));
    assert_eq!(read(&file).unwrap_err(), "a.mat: it holds no vectors of numbers");
}
