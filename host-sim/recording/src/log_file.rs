//! Logs of any format: what is in a file is told by its first bytes, by its name where they do not tell.

use std::fs::{self, File};
use std::io::{self, Cursor, Read, Seek};
use std::path::Path;
use std::sync::OnceLock;

use bytes::Bytes;

use super::columns::{Header, Wanted};
use super::topics::{self, Topic};
use super::values::Values;
use super::{csv_file, hdf5_file, json_file, mat_file, mcap_file, parquet_file, ulog_file};
use crate::Error;

/// Formats that are read, and what of each becomes a column: for messages, help and `docs/formats.md`, which a test compares.
pub const FORMATS: &[(&str, &str)] = &[
    (
        "CSV",
        "each column; separated by commas, `;`, tabs or blanks, with decimal points or decimal commas, in UTF-8 or as Windows writes it",
    ),
    ("Parquet", "each plain column; packed with snappy, zstd, gzip, lz4 or not at all"),
    (
        "MCAP (JSON, Protobuf, joint states of ROS 2 and Foxglove)",
        "of messages in JSON or Protobuf each number by its path, `/motor.state.position`; of joint states \
         (`sensor_msgs/JointState` in CDR or JSON, Foxglove's in JSON or Protobuf) each joint by its name, \
         `/joint_states.elbow.position`. `log_time_s` is when a message was logged, `stamp_s` the time in its header, both from the \
         first message on. Chunks may be packed with zstd or lz4",
    ),
    (
        "MATLAB .mat (versions 5 to 7.3)",
        "each vector; of a matrix each column, `log[2]`; of a structure each field, `run.motor.pos`. Tables, timetables and \
         timeseries only MATLAB reads: a file of nothing else is refused with the command that saves their values",
    ),
    (
        "HDF5",
        "each data set of numbers by its path, `motor.current`: vectors, columns of matrices, numeric fields of tables; packed with \
         deflate, shuffled, with sums",
    ),
    ("PX4 ULog", "each field of each logged message, `actuator_motors.control[0]`"),
    (
        "JSON (also an object a line; WPILib's SysId to 2023)",
        "of a list of objects each number by its path, `motor.position`; of an object each list of objects, `entries.position`, and each list \
         of numbers, `run.q`; of SysId time, voltage, position and velocity, its tests one after another with a gap between two",
    ),
];

/// The names of [`FORMATS`], for a message.
pub fn readable() -> String {
    let names: Vec<&str> = FORMATS.iter().map(|(name, _)| *name).collect();
    format!("{}, each also as .gz", names.join(", "))
}

/// A log that unpacks to more is taken for a corrupt one, bytes.
const MOST_UNPACKED: u64 = 1 << 32;
/// First bytes that tell a format, and whether a file is text.
const HEAD: usize = 512;

/// What a log holds.
pub(crate) enum Log {
    /// One table.
    Columns(Header, Vec<Values>),
    /// Several, each with its own rows.
    Topics(Vec<Topic>),
}

impl Log {
    /// The columns of a recording.
    pub(crate) fn columns(self, file: &Path, wanted: Wanted<'_>) -> Result<(Header, Vec<Values>), Error> {
        match self {
            Self::Columns(header, values) => Ok((header, values)),
            Self::Topics(topics) => topics::columns(file, &topics, wanted),
        }
    }
}

/// Reads `file` as it stands: topics apart, with the columns of a table that are wanted; `-` is standard input.
pub(crate) fn read(file: &Path, wanted: Wanted<'_>) -> Result<Log, Error> {
    let failed = |error: io::Error| Error::input(file, None, "", format!("cannot open: {error}"));
    let input = Input::open(file).map_err(failed)?;
    read_input(file, input, wanted)
}

/// Reads bytes as [`read`] does a file; `file` names them in messages.
pub(crate) fn read_bytes(file: &Path, bytes: &[u8], wanted: Wanted<'_>) -> Result<Log, Error> {
    read_input(file, Input::Memory(Bytes::copy_from_slice(bytes)), wanted)
}

fn read_input(file: &Path, input: Input, wanted: Wanted<'_>) -> Result<Log, Error> {
    let failed = |error: io::Error| Error::input(file, None, "", format!("cannot open: {error}"));
    let (input, head) = input.unpacked().map_err(failed)?;
    let columns = match (format(file, &head)?, input) {
        (Format::Csv, Input::File(input)) => csv_file::read(file, input, wanted),
        (Format::Csv, Input::Memory(bytes)) => csv_file::read(file, Cursor::new(bytes), wanted),
        (Format::Parquet, Input::File(input)) => parquet_file::read(file, input, wanted),
        (Format::Parquet, Input::Memory(bytes)) => parquet_file::read(file, bytes, wanted),
        (of_topics, input) => {
            let bytes = input.bytes().map_err(failed)?;
            let topics = match of_topics {
                Format::Mat => mat_file::read(file, &bytes),
                Format::Hdf5 => hdf5_file::read(file, &bytes),
                Format::Ulog => ulog_file::read(file, &bytes),
                Format::Json => json_file::read(file, &bytes),
                Format::Mcap | Format::Csv | Format::Parquet => mcap_file::read(file, &bytes),
            };
            return topics.map(Log::Topics);
        }
    };
    columns.map(|(header, values)| Log::Columns(header, values))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Parquet,
    Mcap,
    Mat,
    Hdf5,
    Ulog,
    Json,
}

/// What a file is opened as.
enum Input {
    /// As it stands.
    File(File),
    /// Standard input, a pipe, or what was unpacked.
    Memory(Bytes),
}

impl Input {
    fn open(file: &Path) -> io::Result<Self> {
        if file.as_os_str() == "-" {
            return standard_input().map(Self::Memory);
        }
        let opened = File::open(file)?;
        if fs::metadata(file)?.is_file() { Ok(Self::File(opened)) } else { Ok(Self::Memory(Bytes::from(all(opened)?))) }
    }

    /// The input unpacked where it is packed, and its first bytes.
    fn unpacked(mut self) -> io::Result<(Self, Vec<u8>)> {
        let mut head = self.head()?;
        if head.starts_with(&[0x1f, 0x8b]) {
            let unpacked = match &self {
                Self::File(packed) => all(flate2::read::MultiGzDecoder::new(packed)),
                Self::Memory(packed) => all(flate2::read::MultiGzDecoder::new(&packed[..])),
            };
            let damaged =
                |error: io::Error| io::Error::other(format!("the gzip file is damaged or cut short: {error}"));
            self = Self::Memory(Bytes::from(unpacked.map_err(damaged)?));
            head = self.head()?;
        }
        Ok((self, head))
    }

    /// All of it.
    fn bytes(self) -> io::Result<Bytes> {
        match self {
            Self::File(file) => all(file).map(Bytes::from),
            Self::Memory(bytes) => Ok(bytes),
        }
    }

    fn head(&mut self) -> io::Result<Vec<u8>> {
        match self {
            Self::File(file) => {
                let mut head = Vec::new();
                file.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
                file.rewind()?;
                Ok(head)
            }
            Self::Memory(bytes) => Ok(bytes[..bytes.len().min(HEAD)].to_vec()),
        }
    }
}

/// Standard input, which can be read once and is wanted several times: for its columns, then for its numbers.
fn standard_input() -> io::Result<Bytes> {
    static READ: OnceLock<Bytes> = OnceLock::new();
    if let Some(bytes) = READ.get() {
        return Ok(bytes.clone());
    }
    let bytes = Bytes::from(all(io::stdin().lock())?);
    Ok(READ.get_or_init(|| bytes).clone())
}

fn all(input: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    input.take(MOST_UNPACKED).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == MOST_UNPACKED { Err(io::Error::other("it holds more than 4 GB")) } else { Ok(bytes) }
}

/// Formats that are told by their first bytes.
const READ: &[(&[u8], Format)] = &[
    (b"PAR1", Format::Parquet),
    (b"\x89MCAP0", Format::Mcap),
    (b"MATLAB 5.0 MAT", Format::Mat),
    // HDF5 behind a header of MATLAB.
    (b"MATLAB 7.3 MAT", Format::Hdf5),
    (b"\x89HDF\r\n", Format::Hdf5),
    (b"ULog\x01\x12\x35", Format::Ulog),
];

/// Formats that are not read, by their first bytes; what they are, and what to do.
const NOT_READ: &[(&[u8], &str)] = &[
    (b"\xff\xfe", "is UTF-16 text; save it as UTF-8"),
    (b"\xfe\xff", "is UTF-16 text; save it as UTF-8"),
    (b"#ROSBAG", "is a bag of ROS 1; convert it with: mcap convert log.bag log.mcap"),
    (b"SQLite format 3", "is a bag of ROS 2 as SQLite; convert it with: mcap convert log.db3 log.mcap"),
    (b"WPILOG", "is a WPILOG of WPILib; export it as CSV with AdvantageScope or the DataLogTool"),
    (
        b"ARROW1",
        "is an Arrow file; save it as Parquet, in Python: pandas.read_feather('log').to_parquet('log.parquet')",
    ),
    (b"MDF     ", "is an MDF file; convert it with asammdf: asammdf.MDF('log.mf4').export('csv')"),
    (b"TDSm", "is a TDMS file of LabVIEW; in Python: nptdms.TdmsFile('log.tdms').as_dataframe().to_csv('log.csv')"),
    (b"\x93NUMPY", "is an array of NumPy; in Python: numpy.savetxt('log.csv', numpy.load('log.npy'), delimiter=',')"),
    (b"PK\x03\x04", "is a ZIP archive or a spreadsheet; unpack it, or save the sheet as CSV"),
    (b"\x28\xb5\x2f\xfd", "is packed with zstd; unpack it with: unzstd"),
    (b"BZh", "is packed with bzip2; unpack it with: bunzip2"),
    (b"\xfd7zXZ", "is packed with xz; unpack it with: unxz"),
];

/// Of ZIP archives NumPy's are told by their name only.
const NPZ: &str = "is an archive of NumPy arrays; in Python: scipy.io.savemat('log.mat', dict(numpy.load('log.npz')))";

/// The format of a file with these first bytes.
fn format(file: &Path, head: &[u8]) -> Result<Format, Error> {
    let name = file.to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    if let Some((_, format)) = READ.iter().find(|(first, _)| head.starts_with(first)) {
        return Ok(*format);
    }
    if name.ends_with(".parquet") {
        return Ok(Format::Parquet);
    }
    let other = |what: &str| Err(Error::input(file, None, "", format!("{what}; can be read: {}", readable())));
    if name.ends_with(".npz") && head.starts_with(b"PK\x03\x04") {
        return other(NPZ);
    }
    if let Some((_, what)) = NOT_READ.iter().find(|(first, _)| head.starts_with(first)) {
        return other(what);
    }
    let text = head.trim_ascii_start();
    if text.starts_with(b"{") || text.strip_prefix(b"[").is_some_and(|list| list.trim_ascii_start().starts_with(b"{")) {
        return Ok(Format::Json);
    }
    // Text has no signs of control but those of its lines; the end of text of old editors is let pass.
    let is_text = |byte: &u8| *byte >= b' ' || matches!(byte, b'\t' | b'\n' | b'\r' | b'\x0c' | b'\x1a');
    if head.iter().all(is_text) {
        return Ok(Format::Csv);
    }
    other("is not of a known format")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_docs_list_the_same_formats() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/formats.md");
        let docs = fs::read_to_string(docs).unwrap();
        let rows: Vec<&str> = docs.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
        assert_eq!(rows.len(), FORMATS.len(), "{rows:?}");
        for (row, (name, columns)) in rows.into_iter().zip(FORMATS) {
            assert!(row.starts_with(&format!("| {name} | {columns}")), "{row}\nis not\n| {name} | {columns}");
        }
    }
}
