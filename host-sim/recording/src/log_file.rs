//! Logs of any format: what is in a file is told by its first bytes, by its name where they do not tell.

use std::fs::{self, File};
use std::io::{self, Cursor, Read, Seek};
use std::path::Path;
use std::sync::OnceLock;

use bytes::Bytes;

use super::columns::{Header, Wanted};
use super::values::Values;
use super::{csv_file, parquet_file};
use crate::Error;

/// Formats that are read, for messages and help.
pub const READABLE: &str =
    "CSV (separated by commas, `;` or tabs, decimal point or comma) and Parquet, each also as .gz";

/// A log that unpacks to more is taken for a corrupt one, bytes.
const MOST_UNPACKED: u64 = 1 << 32;
/// First bytes that tell a format.
const HEAD: usize = 16;

/// Reads the columns of `file`; `-` is standard input.
pub(crate) fn read(file: &Path, wanted: Wanted<'_>) -> Result<(Header, Vec<Values>), Error> {
    let failed = |error: io::Error| Error::input(file, None, "", format!("cannot open: {error}"));
    let (input, head) = Input::open(file).map_err(failed)?;
    match (format(file, &head)?, input) {
        (Format::Csv, Input::File(input)) => csv_file::read(file, input, wanted),
        (Format::Csv, Input::Memory(bytes)) => csv_file::read(file, Cursor::new(bytes), wanted),
        (Format::Parquet, Input::File(input)) => parquet_file::read(file, input, wanted),
        (Format::Parquet, Input::Memory(bytes)) => parquet_file::read(file, bytes, wanted),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Parquet,
}

/// What a file is opened as.
enum Input {
    /// As it stands.
    File(File),
    /// Standard input, a pipe, or what was unpacked.
    Memory(Bytes),
}

impl Input {
    /// Opens a file and gives its first bytes, unpacked.
    fn open(file: &Path) -> io::Result<(Self, Vec<u8>)> {
        let mut input = if file.as_os_str() == "-" {
            Self::Memory(standard_input()?)
        } else {
            let opened = File::open(file)?;
            if fs::metadata(file)?.is_file() { Self::File(opened) } else { Self::Memory(Bytes::from(all(opened)?)) }
        };
        let mut head = input.head()?;
        if head.starts_with(&[0x1f, 0x8b]) {
            let unpacked = match &input {
                Self::File(packed) => all(flate2::read::MultiGzDecoder::new(packed)),
                Self::Memory(packed) => all(flate2::read::MultiGzDecoder::new(&packed[..])),
            };
            let damaged =
                |error: io::Error| io::Error::other(format!("the gzip file is damaged or cut short: {error}"));
            input = Self::Memory(Bytes::from(unpacked.map_err(damaged)?));
            head = input.head()?;
        }
        Ok((input, head))
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

/// The format of a file with these first bytes.
fn format(file: &Path, head: &[u8]) -> Result<Format, Error> {
    let name = file.to_string_lossy().to_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    if head.starts_with(b"PAR1") || name.ends_with(".parquet") {
        return Ok(Format::Parquet);
    }
    let other = |what: &str| Err(Error::input(file, None, "", format!("{what}; can be read: {READABLE}")));
    if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
        return other("is UTF-16 text; save it as UTF-8");
    }
    if head.starts_with(b"\x89MCAP0") {
        return other("is an MCAP file; export the topic as CSV, as PlotJuggler and Foxglove do");
    }
    if head.starts_with(b"MATLAB 5.0 MAT") {
        return other("is a .mat file; in MATLAB: writetable(table(t, position, torque), 'log.csv')");
    }
    if head.starts_with(b"MATLAB 7.3 MAT") {
        return other("is a .mat file of version 7.3; in MATLAB: writetable(table(t, position, torque), 'log.csv')");
    }
    if head.starts_with(b"\x89HDF\r\n") {
        return other("is an HDF5 file; export the columns as CSV");
    }
    if head.starts_with(b"ULog\x01\x12\x35") {
        return other("is a PX4 ULog; convert it with ulog2csv of pyulog, which writes a CSV for each topic");
    }
    if head.starts_with(b"#ROSBAG") {
        return other("is a bag of ROS 1; convert it with: mcap convert");
    }
    if head.starts_with(b"SQLite format 3") {
        return other("is a bag of ROS 2 as SQLite; convert it to MCAP with ros2 bag convert");
    }
    let is_text = head.is_empty() || !head.contains(&0);
    if is_text || name.ends_with(".csv") {
        return Ok(Format::Csv);
    }
    other("is not of a known format")
}
