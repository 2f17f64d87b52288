//! The image's log: defmt frames over RTT, with their strings in the ELF file of the very same image.

use defmt_decoder::{DecodeError, StreamDecoder, Table};
use er_servo::parameters::TABLE;
use er_servo::{Config, FRAME_BYTES, FRAME_SCHEMA, Frame, State};
use object::{Object, ObjectSection, ObjectSymbol};

/// Where in the note the hash begins, and how much of it the image tells.
const BUILD_ID_AT: usize = 16;
const BUILD_ID_BYTES: usize = 8;

/// How the message starts that begins a recording.
const BEGIN: &str = "recording run ";

/// Which image.
pub type Build = [u8; BUILD_ID_BYTES];

/// Why a log cannot be decoded.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum Error {
    /// The file is not an ELF file of this image.
    #[error("not the ELF file of an er-servo image: {0}")]
    Elf(String),
    /// The log was written by another image.
    #[error(
        "the log was written by build {}, the ELF file is build {}: decode it with the file that was flashed",
        hex(log),
        hex(elf)
    )]
    OtherBuild {
        /// Build the log names.
        log: Build,
        /// Build of the ELF file.
        elf: Build,
    },
    /// Most of the log is no message of this image.
    #[error(
        "{malformed} of {messages} messages are none of this image: the log was written by another build, or is not an \
         RTT log"
    )]
    NotThisImage {
        /// Messages that could not be decoded.
        malformed: usize,
        /// All of them.
        messages: usize,
    },
    /// The layout of the frames is another one.
    #[error("the recording has frames of schema {0}, this tool reads {FRAME_SCHEMA}")]
    Schema(u8),
    /// A message of the recording does not hold what it must.
    #[error("message {at} of the log: {message}")]
    Message {
        /// Which, from 1.
        at: usize,
        /// What is wrong with it.
        message: String,
    },
}

/// One message of the log.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// Something a person reads.
    Event(String),
    /// A recording begins.
    Begin(Box<Begin>),
    /// One tick.
    Frame(Box<Frame>),
    /// The recording was ended.
    End,
    /// Bytes that are no message: the reader was too slow and lost some.
    Damaged,
}

/// What a recording begins with.
#[derive(Debug, Clone, PartialEq)]
pub struct Begin {
    /// Number the user gave it.
    pub run: u32,
    /// Image that wrote it.
    pub build: Build,
    /// Its first tick.
    pub tick: u32,
    /// State of the law before that tick.
    pub state: State,
    /// Every parameter.
    pub config: Config,
}

/// One recording of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Its begin.
    pub begin: Begin,
    /// Its ticks, in order; a tick that was lost is missing.
    pub frames: Vec<Frame>,
    /// Bytes that were no message in between, occurrences.
    pub damaged: usize,
}

impl Recording {
    /// Ticks that are missing between the first and the last one that is there.
    pub fn lost(&self) -> u32 {
        let first = self.begin.tick;
        let Some(last) = self.frames.last() else { return 0 };
        last.seq.wrapping_sub(first).saturating_add(1).saturating_sub(self.frames.len() as u32)
    }
}

/// The ELF file of an image, as far as the log needs it.
pub struct Image {
    table: Table,
    build: Build,
}

impl Image {
    /// Reads the ELF file's bytes.
    ///
    /// # Errors
    ///
    /// [`Error::Elf`].
    pub fn parse(elf: &[u8]) -> Result<Self, Error> {
        let table = Table::parse(elf).map_err(|error| Error::Elf(error.to_string()))?;
        let table = table.ok_or_else(|| Error::Elf("it has no defmt strings".to_owned()))?;
        let build = build_of(elf).ok_or_else(|| Error::Elf("it has no build id".to_owned()))?;
        Ok(Self { table, build })
    }

    /// Build of the ELF file.
    pub fn build(&self) -> Build {
        self.build
    }

    /// Every message of the log, in order.
    ///
    /// # Errors
    ///
    /// A log of another image, or a recording that contradicts itself.
    pub fn decode(&self, log: &[u8]) -> Result<Vec<Entry>, Error> {
        let mut stream = self.stream();
        let entries = stream.push(log)?;
        stream.finish()?;
        Ok(entries)
    }

    /// A decoder of a log that comes in pieces.
    pub fn stream(&self) -> Stream<'_> {
        Stream { decoder: self.table.new_stream_decoder(), build: self.build, messages: 0, malformed: 0 }
    }

    /// Address of the RTT control block on the MCU, for a probe.
    ///
    /// # Errors
    ///
    /// [`Error::Elf`].
    pub fn rtt_address(elf: &[u8]) -> Result<u64, Error> {
        let file = object::File::parse(elf).map_err(|error| Error::Elf(error.to_string()))?;
        let block = file.symbols().find(|symbol| symbol.name() == Ok("_SEGGER_RTT"));
        block.map(|symbol| symbol.address()).ok_or_else(|| Error::Elf("it has no RTT control block".to_owned()))
    }
}

/// Messages of a live log that must have come before it is judged to be another image's.
const JUDGED_AFTER: usize = 200;

/// Decodes a log as it comes.
pub struct Stream<'a> {
    decoder: Box<dyn StreamDecoder + Send + Sync + 'a>,
    build: Build,
    messages: usize,
    malformed: usize,
}

impl Stream<'_> {
    /// The messages that end in `bytes`.
    ///
    /// # Errors
    ///
    /// A log of another image, or a recording that contradicts itself.
    pub fn push(&mut self, bytes: &[u8]) -> Result<Vec<Entry>, Error> {
        self.decoder.received(bytes);
        let mut entries = Vec::new();
        loop {
            let decoded = self.decoder.decode().map(|message| message.display_message().to_string());
            if matches!(decoded, Err(DecodeError::UnexpectedEof)) {
                return Ok(entries);
            }
            self.messages += 1;
            entries.push(match decoded {
                Ok(text) => self.entry(&text)?.unwrap_or(Entry::Damaged),
                Err(_) => {
                    self.malformed += 1;
                    Entry::Damaged
                }
            });
            if self.messages >= JUDGED_AFTER {
                self.judge()?;
            }
        }
    }

    /// Says whether what came was a log of this image at all.
    ///
    /// # Errors
    ///
    /// [`Error::NotThisImage`].
    pub fn finish(self) -> Result<(), Error> {
        self.judge()
    }

    fn judge(&self) -> Result<(), Error> {
        let (malformed, messages) = (self.malformed, self.messages);
        if malformed * 2 > messages { Err(Error::NotThisImage { malformed, messages }) } else { Ok(()) }
    }

    fn entry(&self, text: &str) -> Result<Option<Entry>, Error> {
        // Before anything else of a begin is believed: another build may have another number of parameters.
        if let Some(log) = build_in(text)
            && log != self.build
        {
            return Err(Error::OtherBuild { log, elf: self.build });
        }
        entry(text).map_err(|message| Error::Message { at: self.messages, message })
    }
}

/// The recordings of a log, in order; frames before the first begin belong to none and are left out.
pub fn recordings(entries: &[Entry]) -> Vec<Recording> {
    let mut recordings: Vec<Recording> = Vec::new();
    for entry in entries {
        match (entry, recordings.last_mut()) {
            (Entry::Begin(begin), _) => {
                recordings.push(Recording { begin: (**begin).clone(), frames: Vec::new(), damaged: 0 });
            }
            (Entry::Frame(frame), Some(recording)) => recording.frames.push(**frame),
            (Entry::Damaged, Some(recording)) => recording.damaged += 1,
            _ => {}
        }
    }
    recordings
}

/// A message as what it means; a frame that was damaged on the way is `None`.
fn entry(text: &str) -> Result<Option<Entry>, String> {
    if let Some(bytes) = text.strip_prefix("frame ") {
        let bytes: [u8; FRAME_BYTES] =
            list(bytes)?.try_into().map_err(|bytes: Vec<u8>| format!("a frame of {} bytes", bytes.len()))?;
        return Ok(Frame::decode(&bytes).ok().map(|frame| Entry::Frame(Box::new(frame))));
    }
    if text.starts_with(BEGIN) {
        return begin(text).map(|begin| Some(Entry::Begin(Box::new(begin))));
    }
    Ok(Some(if text == "recording ended" { Entry::End } else { Entry::Event(text.to_owned()) }))
}

/// The build that the begin of a recording names; none in any other text.
fn build_in(text: &str) -> Option<Build> {
    text.starts_with(BEGIN).then(|| list(field(text, "build").ok()?).ok()?.try_into().ok())?
}

/// What stands behind a name in the begin of a recording.
fn field<'a>(text: &'a str, name: &str) -> Result<&'a str, String> {
    let missing = || format!("the begin of the recording has no {name}");
    let rest = text.split_once(&format!("{name} ")).ok_or_else(missing)?.1;
    let end = if rest.starts_with('[') { rest.find(']').map(|at| at + 1) } else { rest.find(' ') };
    rest.get(..end.unwrap_or(rest.len())).ok_or_else(missing)
}

fn begin(text: &str) -> Result<Begin, String> {
    let field = |name: &str| field(text, name);
    let number = |name: &str| field(name)?.parse::<u32>().map_err(|error| format!("{name}: {error}"));
    let schema = number("schema")?;
    if schema != u32::from(FRAME_SCHEMA) {
        return Err(Error::Schema(schema as u8).to_string());
    }
    let build = list(field("build")?)?.try_into().map_err(|_| "build: not 8 bytes".to_owned())?;
    let state = State::decode(&list(field("state")?)?).map_err(|error| error.to_string())?;
    let values = list(field("parameters")?)?;
    if values.len() != 4 * TABLE.len() {
        return Err(format!("{} parameters, this tool knows {}", values.len() / 4, TABLE.len()));
    }
    let mut config = Config::default();
    for (parameter, value) in TABLE.iter().zip(values.as_chunks::<4>().0) {
        (parameter.set)(&mut config, f32::from_le_bytes(*value));
    }
    Ok(Begin { run: number("run")?, build, tick: number("tick")?, state, config })
}

/// `[1, 2, 3]` as bytes.
fn list(text: &str) -> Result<Vec<u8>, String> {
    let inner = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).ok_or("no list of bytes")?;
    inner.split(", ").map(|byte| byte.parse::<u8>().map_err(|error| format!("{byte}: {error}"))).collect()
}

fn build_of(elf: &[u8]) -> Option<Build> {
    let note = object::File::parse(elf).ok()?.section_by_name(".build_id")?.data().ok()?.to_vec();
    note.get(BUILD_ID_AT..BUILD_ID_AT + BUILD_ID_BYTES)?.try_into().ok()
}

fn hex(build: &Build) -> String {
    build.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_begin_of_a_recording_is_read_back() {
        let config = Config { kp_nm_rad: 300.0, ..Config::default() };
        let values: Vec<u8> = TABLE.iter().flat_map(|parameter| (parameter.get)(&config).to_le_bytes()).collect();
        let state = State::running_at(er_servo::Counts(5000));
        let text = format!(
            "recording run 7 schema {FRAME_SCHEMA} build [1, 2, 3, 4, 5, 6, 7, 8] tick 99 state {:?} parameters {:?}",
            state.encode(),
            values
        );
        let read = begin(&text).unwrap();
        assert_eq!(read, Begin { run: 7, build: [1, 2, 3, 4, 5, 6, 7, 8], tick: 99, state, config });
        assert!(begin(&text.replace("schema 1", "schema 9")).unwrap_err().contains("schema 9"));
        assert!(begin(&text[..60]).is_err());
    }

    #[test]
    fn the_build_is_read_even_where_the_rest_cannot_be() {
        assert_eq!(
            build_in("recording run 7 schema 9 build [1, 2, 3, 4, 5, 6, 7, 8] tick"),
            Some([1, 2, 3, 4, 5, 6, 7, 8])
        );
        assert_eq!(build_in("er-servo 0.1.0, build [1, 2, 3, 4, 5, 6, 7, 8]"), None);
    }

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(matches!(Image::parse(b"no ELF file"), Err(Error::Elf(_))));
    }
}
