//! HDF5, and with it MATLAB `.mat` of version 7.3: vectors, columns of matrices and fields of tables, by their paths with dots.

use std::path::Path;

use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use super::topics::Topic;
use super::{quiet, vectors};
use crate::Error;

/// Groups within groups beyond this depth are none that a log has: links may go in circles.
const DEEPEST: usize = 16;
/// Groups and data sets that are looked into, for the same reason.
const MOST_OBJECTS: usize = 10_000;
/// Deflate shrinks no data to less than a part of this (RFC 1951: 258 bytes in 2 bits): what claims to be more is not in the file.
const MOST_PACKED: usize = 1032;
/// What holds more is taken for a corrupt file, bytes.
const MOST_UNPACKED: usize = 1 << 31;
/// Classes of MATLAB that are numbers.
const NUMBERS: [&str; 11] =
    ["double", "single", "logical", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"];
/// Classes of MATLAB that are passed over.
const PASSED_OVER: [&str; 4] = ["char", "cell", "struct", "function_handle"];

/// The vectors of an HDF5 file, those of one length together.
pub(crate) fn read(file: &Path, bytes: &[u8]) -> Result<Vec<Topic>, Error> {
    // What a reader of this size does with a damaged file nobody knows for certain.
    let read = quiet::caught(|| topics(bytes)).unwrap_or_else(|| Err(damaged("damaged data")));
    read.map_err(|message| Error::input(file, None, "", message.replace('\n', " ")))
}

fn damaged(reason: impl std::fmt::Display) -> String {
    format!("is not an HDF5 file that can be read, or was cut short: {reason}")
}

fn topics(bytes: &[u8]) -> Result<Vec<Topic>, String> {
    let most = bytes.len().saturating_mul(MOST_PACKED).min(MOST_UNPACKED);
    let options = OpenOptions::default().with_max_read_bytes(most).with_max_chunk_bytes(most);
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(damaged)?;
    if file.superblock().eof_address > bytes.len() as u64 {
        return Err(damaged("it ends before its last data"));
    }
    let mut found = Found { left: most, ..Found::default() };
    found.group(&file.root_group().map_err(damaged)?, "", 0)?;
    let topics = vectors::topics(found.vectors);
    if topics.is_empty() {
        return Err(format!("it holds no vectors of numbers{}", vectors::only_in_matlab(&found.objects)));
    }
    Ok(topics)
}

/// What was found so far.
#[derive(Default)]
struct Found {
    vectors: Vec<(String, Vec<f64>)>,
    /// Objects of MATLAB, by name.
    objects: Vec<String>,
    /// Groups and data sets that were looked into.
    count: usize,
    /// Bytes that may still be unpacked.
    left: usize,
}

impl Found {
    fn group(&mut self, group: &Group, before: &str, depth: usize) -> Result<(), String> {
        if depth == DEEPEST {
            return Err(damaged("its groups go too deep"));
        }
        let (groups, sets) = group.members().map_err(damaged)?;
        for set in sets {
            self.counted()?;
            self.set(&set, format!("{before}{}", set.name()))?;
        }
        for group in groups {
            self.counted()?;
            // What MATLAB keeps for its own objects; a sparse matrix has places among its numbers.
            let is_own = group.name().starts_with('#') || group.attribute("MATLAB_sparse").is_ok();
            if !is_own {
                self.group(&group, &format!("{before}{}.", group.name()), depth + 1)?;
            }
        }
        Ok(())
    }

    fn counted(&mut self) -> Result<(), String> {
        self.count += 1;
        if self.count > MOST_OBJECTS { Err(damaged(format!("more than {MOST_OBJECTS} objects"))) } else { Ok(()) }
    }

    fn set(&mut self, set: &Dataset, name: String) -> Result<(), String> {
        match matlab(set) {
            Matlab::Numbers => {}
            Matlab::Other => return Ok(()),
            Matlab::Object => {
                self.objects.push(name);
                return Ok(());
            }
        }
        let columns = columns(set.dtype(), name);
        // Sides of one are none: MATLAB has no vectors, but matrices of one column.
        let sides: Vec<usize> = set
            .shape()
            .iter()
            .filter(|side| **side != 1)
            .map(|side| usize::try_from(*side).unwrap_or(usize::MAX))
            .collect();
        let dimensions = match sides[..] {
            [rows] => [rows, 1],
            // Row by row in the file.
            [rows, columns] => [columns, rows],
            _ => return Ok(()),
        };
        if columns.is_empty() {
            return Ok(());
        }
        self.left = set
            .raw_byte_len()
            .ok()
            .and_then(|length| self.left.checked_sub(length))
            .ok_or_else(|| damaged("it claims more data than it can hold"))?;
        let (bytes, element) = (set.read_native_bytes().map_err(damaged)?, set.raw_element_size().map_err(damaged)?);
        for Column { name, offset, number } in columns {
            let one = |element: &[u8]| element.get(offset..).and_then(number);
            let values: Option<Vec<f64>> = bytes.chunks(element.max(1)).map(one).collect();
            self.vectors.extend(vectors::series(name, &dimensions, values.ok_or_else(|| damaged("a short element"))?));
        }
        Ok(())
    }
}

/// What a data set is to MATLAB.
enum Matlab {
    /// Numbers, as all data sets of other programs.
    Numbers,
    /// A table, a timetable, a time series: what only MATLAB reads.
    Object,
    /// Text, cells, nothing.
    Other,
}

fn matlab(set: &Dataset) -> Matlab {
    let class = set.attribute("MATLAB_class").ok().and_then(|class| class.read_string().ok());
    match class.as_deref() {
        None => Matlab::Numbers,
        // An empty matrix holds its size.
        Some(class) if NUMBERS.contains(&class) && set.attribute("MATLAB_empty").is_err() => Matlab::Numbers,
        Some(class) if NUMBERS.contains(&class) || PASSED_OVER.contains(&class) => Matlab::Other,
        Some(_) => Matlab::Object,
    }
}

/// A number within each element of a data set.
struct Column {
    name: String,
    /// Its place in the element, bytes.
    offset: usize,
    number: Number,
}

/// The number that begins some bytes in the order of this machine; none where they are too few.
type Number = fn(&[u8]) -> Option<f64>;

/// The numbers of each element: itself, or those of its fields that are numbers; none of text, references and others.
fn columns(kind: &Datatype, name: String) -> Vec<Column> {
    match kind {
        Datatype::Compound { fields, .. } => fields
            .iter()
            .filter_map(|field| {
                let (name, offset) = (format!("{name}.{}", field.name), usize::try_from(field.byte_offset).ok()?);
                Some(Column { name, offset, number: number(&field.datatype)? })
            })
            .collect(),
        // A truth is one of two.
        Datatype::Enum { base, .. } => columns(base, name),
        other => number(other).map(|number| Column { name, offset: 0, number }).into_iter().collect(),
    }
}

/// How a number of this kind is read; none for what is no number.
fn number(kind: &Datatype) -> Option<Number> {
    macro_rules! read {
        ($number:ty) => {
            |bytes: &[u8]| Some(<$number>::from_ne_bytes(*bytes.first_chunk()?) as f64)
        };
    }
    Some(match kind {
        Datatype::FloatingPoint { size: 4, .. } => read!(f32),
        Datatype::FloatingPoint { size: 8, .. } => read!(f64),
        Datatype::FixedPoint { size: 1, signed: true, .. } => read!(i8),
        Datatype::FixedPoint { size: 1, signed: false, .. } => read!(u8),
        Datatype::FixedPoint { size: 2, signed: true, .. } => read!(i16),
        Datatype::FixedPoint { size: 2, signed: false, .. } => read!(u16),
        Datatype::FixedPoint { size: 4, signed: true, .. } => read!(i32),
        Datatype::FixedPoint { size: 4, signed: false, .. } => read!(u32),
        Datatype::FixedPoint { size: 8, signed: true, .. } => read!(i64),
        Datatype::FixedPoint { size: 8, signed: false, .. } => read!(u64),
        _ => return None,
    })
}
