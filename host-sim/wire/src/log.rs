//! What the image writes over RTT, events in one ring and recordings in another: messages of defmt, with their strings in the ELF
//! file of the very same image.

use defmt_decoder::{DecodeError, Encoding, StreamDecoder, Table};
use er_servo::parameters::TABLE;
use er_servo::{Config, FRAME_SCHEMA, Frame, State};
use object::{Object, ObjectSection, ObjectSymbol};

mod text;
mod ticks;

pub use ticks::Ticks;

/// Where in the note the hash begins, and how much of it the image tells.
const BUILD_ID_AT: usize = 16;
const BUILD_ID_BYTES: usize = 8;

/// How the first message after a reset starts.
const BOOTED: &str = "er-servo ";

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
    Schema(u32),
    /// The drive has other parameters.
    #[error("the recording has {count} parameters, this tool knows {}: use the tool of the flashed release", TABLE.len())]
    Parameters {
        /// How many.
        count: usize,
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
    /// Bytes that are no message, or one whose check does not match: the reader was too slow and lost some.
    Damaged,
}

impl Entry {
    /// Whether no frame after this one is of the recording before it: it was ended, or the drive was reset.
    pub fn ends_recording(&self) -> bool {
        match self {
            Self::End | Self::Begin(_) => true,
            Self::Event(text) => text.starts_with(BOOTED),
            Self::Frame(_) | Self::Damaged => false,
        }
    }
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
    /// Messages in between that were damaged or of another time, occurrences.
    pub damaged: usize,
    ticks: Ticks,
    is_open: bool,
}

impl Recording {
    fn new(begin: &Begin) -> Self {
        let ticks = Ticks::from(begin.tick);
        Self { begin: begin.clone(), frames: Vec::new(), damaged: 0, ticks, is_open: true }
    }

    /// Ticks that are missing before the last one that is there.
    pub fn lost(&self) -> u64 {
        self.ticks.lost
    }

    fn take(&mut self, entry: &Entry) {
        match entry {
            Entry::Frame(frame) if self.ticks.take(frame.seq) => self.frames.push(**frame),
            Entry::Frame(_) | Entry::Damaged => self.damaged += 1,
            _ => self.is_open &= !entry.ends_recording(),
        }
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
        if table.encoding() != Encoding::Rzcobs {
            return Err(Error::Elf("its log is not encoded by rzCOBS".to_owned()));
        }
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
    /// A log of another image.
    pub fn decode(&self, log: &[u8]) -> Result<Vec<Entry>, Error> {
        let mut stream = self.stream();
        let entries = stream.push(log)?;
        stream.finish()?;
        Ok(entries)
    }

    /// A decoder of a log that comes in pieces.
    pub fn stream(&self) -> Stream<'_> {
        let decoder = self.table.new_stream_decoder();
        Stream { decoder, build: self.build, messages: 0, malformed: 0, unfinished: 0 }
    }

    /// Address of the control block of the recordings on the MCU, for a probe.
    ///
    /// # Errors
    ///
    /// [`Error::Elf`].
    pub fn frames_address(elf: &[u8]) -> Result<u64, Error> {
        let file = object::File::parse(elf).map_err(|error| Error::Elf(error.to_string()))?;
        let block = file.symbols().find(|symbol| symbol.name() == Ok("ER_SERVO_FRAMES"));
        block
            .map(|symbol| symbol.address())
            .ok_or_else(|| Error::Elf("it has no control block of recordings, ER_SERVO_FRAMES".to_owned()))
    }
}

/// Bytes handed to the decoder at a time; its work for a message grows with the bytes that wait behind it.
const CHUNK_BYTES: usize = 1024;
/// Bytes without the zero that ends a message after which they are none; the longest is a quarter of this.
const LONGEST_BYTES: usize = 2048;
/// Messages of a live log that must have come before it is judged to be another image's.
const JUDGED_AFTER: usize = 200;

/// Decodes a log as it comes.
pub struct Stream<'a> {
    decoder: Box<dyn StreamDecoder + Send + Sync + 'a>,
    build: Build,
    messages: usize,
    malformed: usize,
    /// Bytes since the last zero.
    unfinished: usize,
}

impl Stream<'_> {
    /// The messages that end in `bytes`.
    ///
    /// # Errors
    ///
    /// A log of another image.
    pub fn push(&mut self, bytes: &[u8]) -> Result<Vec<Entry>, Error> {
        let mut entries = Vec::new();
        for chunk in bytes.chunks(CHUNK_BYTES) {
            self.decoder.received(chunk);
            self.unfinished = match chunk.iter().rposition(|byte| *byte == 0) {
                Some(zero) => chunk.len() - zero - 1,
                None => self.unfinished + chunk.len(),
            };
            if self.unfinished > LONGEST_BYTES {
                self.decoder.received(&[0]);
                self.unfinished = 0;
            }
            self.drain(&mut entries)?;
        }
        Ok(entries)
    }

    fn drain(&mut self, entries: &mut Vec<Entry>) -> Result<(), Error> {
        loop {
            let decoded = self.decoder.decode().map(|message| message.display_message().to_string());
            if matches!(decoded, Err(DecodeError::UnexpectedEof)) {
                return Ok(());
            }
            self.messages += 1;
            let entry = decoded.ok().map(|text| self.entry(&text)).transpose()?.flatten();
            self.malformed += usize::from(entry.is_none());
            entries.push(entry.unwrap_or(Entry::Damaged));
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
        if let Some(log) = text::build_in(text)
            && log != self.build
        {
            return Err(Error::OtherBuild { log, elf: self.build });
        }
        text::entry(text)
    }
}

/// The recordings of a log, in order; frames that no begin precedes belong to none and are left out.
pub fn recordings(entries: &[Entry]) -> Vec<Recording> {
    let mut recordings: Vec<Recording> = Vec::new();
    for entry in entries {
        if let Entry::Begin(begin) = entry {
            recordings.push(Recording::new(begin));
        } else if let Some(open) = recordings.last_mut().filter(|recording| recording.is_open) {
            open.take(entry);
        }
    }
    recordings
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
    fn what_is_no_image_is_refused() {
        assert!(matches!(Image::parse(b"no ELF file"), Err(Error::Elf(_))));
    }
}
